"""What loaders read beside the files: ``dataset.yaml``, and the head of the card from which Hugging Face's ``datasets`` finds them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import yaml

from dcrb_ros.runtime.version import __version__
from dcrb_ros.sweep.table import COLUMNS, LABELS
from dcrb_ros.sweep.windows import COLUMNS as WINDOW_COLUMNS

DESCRIPTION = "dataset.yaml"
SPLITS = ("train", "validation", "test")
VERSION = 1
"""Version of the schema; measured and simulated sets have the same."""
WAVEFORMS = {
    "npz": {"ax": "m/s^2", "ay": "m/s^2", "shaft_angle": "rad", "sampling_rate": "Hz", "first_index": "-"},
    "parquet": {"ax": "m/s^2", "ay": "m/s^2", "shaft_angle": "rad"},
}


def configs(splits: Sequence[str], windows: bool) -> list[dict[str, Any]]:
    """Return the configurations of a data set: its windows by split if they are Parquet, and the table of labels.

    A split without runs has no files, which a loader would refuse.
    """
    windowed: list[dict[str, Any]] = []
    if windows and splits:
        files = [{"split": split, "path": f"windows/{split}/*.parquet"} for split in SPLITS if split in splits]
        windowed.append({"config_name": "windows", "data_files": files, "default": True})
    table: dict[str, Any] = {"config_name": "labels", "data_files": [{"split": "runs", "path": LABELS}]}
    return [*windowed, table if windowed else table | {"default": True}]


def head(title: str, licence: str, splits: Sequence[str], *, windows: bool) -> str:
    """Return the YAML at the head of a card, between lines of three dashes."""
    identifier = licence.lower()
    known = identifier.startswith(("cc-by", "cc0", "apache-2.0", "mit", "bsd"))
    tree: dict[str, Any] = {"license": identifier} if known else {"license": "other", "license_name": licence}
    tree |= {"pretty_name": title, "tags": ["vibration", "bearing", "condition-monitoring"]}
    tree["configs"] = configs(splits, windows)
    return f"---\n{yaml.safe_dump(tree, sort_keys=False, allow_unicode=True, width=120)}---\n\n"


def description(
    title: str,
    licence: str,
    counts: Mapping[str, Mapping[str, int]],
    *,
    measured: bool,
    waveform: str,
    windows: Mapping[str, Any] | None,
    truth: Mapping[str, str],
    source: Mapping[str, Any] | None = None,
) -> str:
    """Return ``dataset.yaml``.

    Args:
        title: name of the data set.
        licence: its licence.
        counts: runs by split and fault.
        measured: whether the runs are measured, not simulated.
        waveform: format of the runs: npz, parquet or bag.
        windows: length, hop and kind of the windows, if there are any.
        truth: meanings of further columns of the labels by name.
        source: what is known of the origin of measured data.
    """
    tree: dict[str, Any] = {
        "schema": VERSION,
        "name": title,
        "licence": licence,
        "measured": measured,
        "made_with": f"dcrb_ros {__version__}",
    }
    if source:
        tree["source"] = dict(source)
    tree["task"] = "classification of faults: the column fault"
    tree["classes"] = sorted({fault for faults in counts.values() for fault in faults}, key=lambda fault: (fault != "healthy", fault))
    tree["splits"] = {split: {"runs": sum(counts[split].values()), "faults": dict(counts[split])} for split in SPLITS if split in counts}
    tree["runs"] = {"files": "runs/RUN/" if waveform == "bag" else f"runs/RUN.{waveform}", "arrays": WAVEFORMS.get(waveform, {})}
    if windows is not None:
        tree["windows"] = {"files": f"windows/SPLIT/RUN.{windows['kind']}", **windows, "columns": dict(WINDOW_COLUMNS)}
    tree["labels"] = {"file": LABELS, "columns": {**COLUMNS, **truth}}
    return str(yaml.safe_dump(tree, sort_keys=False, allow_unicode=True, width=120))
