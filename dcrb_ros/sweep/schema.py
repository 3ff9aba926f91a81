"""The description of a data set for loaders: ``dataset.yaml``, and the head of the card, which Hugging Face's ``datasets`` reads."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from dcrb_ros.runtime.version import __version__
from dcrb_ros.sweep.store import Store
from dcrb_ros.sweep.sweep_file import Windows
from dcrb_ros.sweep.table import COLUMNS, LABELS
from dcrb_ros.sweep.windows import COLUMNS as WINDOW_COLUMNS
from dcrb_ros.text.yaml import yaml_text

DESCRIPTION, CARD = "dataset.yaml", "README.md"
SPLITS = ("train", "validation", "test")
VERSION = 1
"""Version of the schema; measured and simulated sets have the same."""
WAVEFORMS = {
    "npz": {"ax": "m/s^2", "ay": "m/s^2", "shaft_angle": "rad", "sampling_rate": "Hz", "first_index": "-"},
    "parquet": {"ax": "m/s^2", "ay": "m/s^2", "shaft_angle": "rad"},
}


def _head(title: str, licence: str, splits: Sequence[str], *, windows: bool) -> str:
    """Return the YAML at the head of a card, between lines of three dashes.

    Its configurations are the windows by split, if they are Parquet, and the table of labels. A split without runs has no files, which a
    loader would refuse.
    """
    identifier = licence.lower()
    known = identifier.startswith(("cc-by", "cc0", "apache-2.0", "mit", "bsd"))
    tree: dict[str, Any] = {"license": identifier} if known else {"license": "other", "license_name": licence}
    tree |= {"pretty_name": title, "tags": ["vibration", "bearing", "condition-monitoring"]}
    table: dict[str, Any] = {"config_name": "labels", "data_files": [{"split": "runs", "path": LABELS}]}
    if windows and splits:
        files = [{"split": split, "path": f"windows/{split}/*.parquet"} for split in SPLITS if split in splits]
        tree["configs"] = [{"config_name": "windows", "data_files": files, "default": True}, table]
    else:
        tree["configs"] = [table | {"default": True}]
    return f"---\n{yaml_text(tree, unicode=True, width=120)}---\n\n"


def healthy_first(faults: Iterable[str]) -> list[str]:
    """Return fault classes in the order of tables: ``healthy``, then the others by name."""
    return sorted(set(faults), key=lambda fault: (fault != "healthy", fault))


def write_about(
    store: Store,
    card: str,
    title: str,
    licence: str,
    classes: Mapping[tuple[str, str], int],
    *,
    measured: bool,
    waveform: str,
    windows: Windows | None,
    truth: Mapping[str, tuple[type, str]],
    sources: Sequence[Mapping[str, Any]] = (),
) -> None:
    """Write the card in Markdown, below a head for loaders, and ``dataset.yaml``.

    ``classes`` has the number of runs by split and fault, ``waveform`` their format (npz, parquet or bag), ``truth`` type and meaning
    of further columns of the labels, and ``sources`` the origins of measured data.
    """
    counts: dict[str, dict[str, int]] = {}
    for (split, fault), count in sorted(classes.items()):
        counts.setdefault(split, {})[fault] = count
    tree: dict[str, Any] = {
        "schema": VERSION,
        "name": title,
        "licence": licence,
        "measured": measured,
        "made_with": f"dcrb_ros {__version__}",
    }
    if sources:
        tree["source"] = {"sets": [dict(source) for source in sources]}
    tree["task"] = "classification of faults: the column fault"
    tree["classes"] = healthy_first(fault for _, fault in classes)
    tree["splits"] = {split: {"runs": sum(counts[split].values()), "faults": counts[split]} for split in SPLITS if split in counts}
    tree["runs"] = {"files": "runs/RUN/" if waveform == "bag" else f"runs/RUN.{waveform}", "arrays": WAVEFORMS.get(waveform, {})}
    if windows is not None:
        shape = {"kind": windows.kind, "length": windows.length, "hop": windows.hop}
        tree["windows"] = {"files": f"windows/SPLIT/RUN.{windows.kind}", **shape, "columns": dict(WINDOW_COLUMNS)}
    tree["labels"] = {"file": LABELS, "columns": {name: meaning for name, (_, meaning) in {**COLUMNS, **truth}.items()}}
    head = _head(title, licence, list(counts), windows=windows is not None and windows.kind == "parquet")
    store.write(CARD, (head + card).encode())
    store.write(DESCRIPTION, yaml_text(tree, unicode=True, width=120).encode())
