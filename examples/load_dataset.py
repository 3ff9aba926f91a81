"""A data set of `dcrb sweep` or `dcrb collect` as arrays: python examples/load_dataset.py DIR."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

import dcrb_ros


def main(folder: Path) -> None:
    """Print the number of windows of each class in each split."""
    data_set = dcrb_ros.DataSet(folder)
    for split in data_set.splits:
        x, y = data_set.windows(split).arrays()  # (windows, 2, length) in m/s^2, and the numbers of the classes
        counts = np.bincount(y, minlength=len(data_set.classes))
        shares = ", ".join(f"{count} {name}" for name, count in zip(data_set.classes, counts, strict=True) if count)
        print(f"{split}: {len(x)} windows; {shares}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="folder with a data set of dcrb sweep or dcrb collect")
    try:
        main(parser.parse_args().folder)
    except dcrb_ros.Refusal as refusal:
        parser.error(str(refusal))
