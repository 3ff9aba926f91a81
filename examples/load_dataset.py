"""A data set of `dcrb sweep` as arrays, using numpy and pandas only: python examples/load_dataset.py DIR."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd

CLASSES = ["healthy", "outer_ring", "inner_ring", "roller", "cage", "sensor", "compound", "lubrication", "overheating"]


def labels(folder: Path, split: str) -> pd.DataFrame:
    """Return the rows of one split: ``train``, ``validation`` or ``test``."""
    table = pd.read_parquet(folder / "labels.parquet")
    return table[(table["split"] == split) & (table["status"] == "done")].reset_index(drop=True)


def waveform(folder: Path, file: str) -> tuple[np.ndarray, np.ndarray]:
    """Return acceleration in X and Y, shape (2, samples) [m/s^2], and the angle of the inner ring, shape (samples,) [rad]."""
    columns = pd.read_parquet(folder / file) if file.endswith(".parquet") else np.load(folder / file)
    return np.stack([columns["ax"], columns["ay"]]), np.asarray(columns["shaft_angle"])


def windows(
    folder: Path, split: str, length: int = 4096, hop: int = 2048, share: tuple[int, int] = (0, 1)
) -> Iterator[tuple[np.ndarray, int]]:
    """Yield windows of shape (2, length) with the index of their class in `CLASSES`; one run at a time is kept in memory.

    ``share`` (k, n) takes the runs k, k + n, k + 2 n ... only, so that n processes can divide the split.
    """
    number, count = share
    for row in labels(folder, split).iloc[number::count].itertuples():
        acceleration, _ = waveform(folder, row.file)
        for begin in range(0, acceleration.shape[1] - length + 1, hop):
            yield acceleration[:, begin : begin + length], CLASSES.index(row.fault)


try:  # PyTorch, if it is installed
    from torch.utils.data import IterableDataset, get_worker_info

    class Windows(IterableDataset):
        """Windows and classes for `torch.utils.data.DataLoader`; its workers divide the runs, so every window occurs once."""

        def __init__(self, folder: Path, split: str) -> None:
            self.folder, self.split = folder, split

        def __iter__(self) -> Iterator[tuple[np.ndarray, int]]:
            worker = get_worker_info()  # None in the main process
            return windows(self.folder, self.split, share=(worker.id, worker.num_workers) if worker else (0, 1))
except ImportError:
    pass


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    for name in ("train", "validation", "test"):
        found = list(windows(folder, name))
        counts = np.bincount([number for _, number in found], minlength=len(CLASSES))
        print(f"{name}: {len(found)} windows; {', '.join(f'{count} {CLASSES[k]}' for k, count in enumerate(counts) if count)}")
