"""A data set of measured recordings with the schema of a sweep's: the same files, the same columns, the same windows."""

from __future__ import annotations

import hashlib
import math
import os
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from dcrb_ros.bearing.waveform import Waveform
from dcrb_ros.diagnosis.order_tracking import unwrapped_turns
from dcrb_ros.messages.points import packed
from dcrb_ros.runtime.version import __version__
from dcrb_ros.schema.arrays import Integers, Samples
from dcrb_ros.schema.refusal import Refusal, nearest
from dcrb_ros.schema.verdicts import FAULT_CLASSES
from dcrb_ros.sweep.division import in_several, warnings_of
from dcrb_ros.sweep.identity import TRUTH
from dcrb_ros.sweep.label import DONE
from dcrb_ros.sweep.schema import CARD, DESCRIPTION, SPLITS, healthy_first, write_about
from dcrb_ros.sweep.store import Store, StoreFailed
from dcrb_ros.sweep.sums import write_sums
from dcrb_ros.sweep.sweep_file import Windows
from dcrb_ros.sweep.table import LABELS, table_of
from dcrb_ros.sweep.windows import cut_windows, waveform_file, window_starts, windows_file
from dcrb_ros.text.markdown import table
from dcrb_ros.text.writing import check_empty, whole_folder

LONGEST_NAME = 200
"""Longest name of a run [bytes]; with a suffix it is that of a file."""


@dataclass(frozen=True, eq=False)
class MeasuredRun:
    """A measured recording with its fault and its conditions."""

    name: str
    waveform: Waveform
    fault: str
    """One of the fault classes, such as ``outer_ring``."""
    split: str = "test"
    width: float = math.nan
    """Width of the defect [m]; NaN if unknown."""
    depth: float = math.nan
    """Its depth [m]; NaN if unknown."""
    load: float = math.nan
    """Load [N]; NaN if unknown."""
    bearing_id: str = ""
    machine: str = ""
    source: Mapping[str, Any] = field(default_factory=dict)
    """Origin of the recording: title, licence, publisher."""


class RunNames:
    """The names of runs, each of which is checked, also against those before it."""

    def __init__(self) -> None:
        self._runs = set[str]()
        self._split_of = dict[str, str]()

    def add(self, name: str, fault: str, split: str = "test", bearing_id: str = "") -> str:
        """Add a run; return the name of its bearing, by default that of the run.

        Raises:
            Refusal: the name is not one of a file or is that of another run, fault or split are unknown, or the bearing is in two splits.
        """
        if name != Path(name).name or not name or name.startswith(".") or not name.isprintable():  # a * matches no name with a dot
            raise Refusal(f"name = {name!r} is not the name of a file: give the run a name without a path or a dot at its beginning")
        if len(os.fsencode(name)) > LONGEST_NAME:
            raise Refusal(f"name = {name!r} has more than {LONGEST_NAME} bytes, too many for the name of a file: give a shorter one")
        if fault not in FAULT_CLASSES:
            known = ", ".join(FAULT_CLASSES)
            raise Refusal(f"{name}: fault = '{fault}' is unknown{nearest(fault, FAULT_CLASSES)}: give one of {known}")
        if split not in SPLITS:
            raise Refusal(f"{name}: split = '{split}' is unknown: give train, validation or test")
        bearing = bearing_id or name
        if (other := self._split_of.setdefault(bearing, split)) != split:
            raise Refusal(f"{name}: the bearing {bearing} is in the splits {other} and {split}: give one for all of its runs")
        if name in self._runs:
            raise Refusal(f"two runs are called {name}: give them names of their own in the column name")
        self._runs.add(name)
        return bearing


def write_measured_set(
    runs: Iterable[MeasuredRun], folder: Path, *, title: str, licence: str, windows: Windows
) -> Counter[tuple[str, str]]:
    """Write a data set to an empty folder; return the number of its runs by split and fault. The windows are written as Parquet.

    Raises:
        Refusal: the folder is not empty or cannot be made, there is no run, or `RunNames` refuses one.
        StoreFailed: a file in it cannot be written.
    """
    folder = folder.absolute()
    check_empty(folder)
    with whole_folder(folder, LABELS) as written:
        try:
            return _write(runs, Store(str(written)), title, licence, windows)
        except StoreFailed as failure:
            raise StoreFailed(str(failure).replace(str(written), str(folder)).removesuffix(" to continue")) from None  # nothing is kept


def _write(runs: Iterable[MeasuredRun], store: Store, title: str, licence: str, windows: Windows) -> Counter[tuple[str, str]]:
    """Write a data set to an empty store."""
    labels: list[dict[str, Any]] = []
    sources: dict[str, Mapping[str, Any]] = {}
    names = RunNames()
    for position, run in enumerate(runs):
        bearing = names.add(run.name, run.fault, run.split, run.bearing_id)
        sources |= {str(run.source.get("title")): dict(run.source)} if run.source else {}
        labels.append(_written(run, bearing, position, store, windows))
    if not labels:
        raise Refusal("no recording is given: the list is empty")
    counts = Counter((str(label["split"]), str(label["fault"])) for label in labels)
    store.write(LABELS, table_of(labels, TRUTH))
    cut = windows.model_copy(update={"kind": "parquet"})
    shared = {name: in_several((label[name], label["split"]) for label in labels) for name in TRUTH}
    card = _card(title, licence, counts, windows, list(sources), list(warnings_of(shared, remedy=False).values()))
    origins = list(sources.values())
    write_about(store, card, title, licence, counts, measured=True, waveform="npz", windows=cut, truth=TRUTH, sources=origins)
    write_sums(store, [LABELS, CARD, DESCRIPTION])
    return counts


def _written(run: MeasuredRun, bearing: str, position: int, store: Store, windows: Windows) -> dict[str, Any]:
    """Write the files of a run and return its label."""
    waveform = run.waveform
    angle: Samples = np.asarray(waveform.shaft_angle, np.float32)
    acceleration: Samples = np.ascontiguousarray(waveform.acceleration[:, :2], np.float32)
    rate, first = waveform.sampling_rate, int(waveform.index[0])
    shaft = _shaft_frequency(angle, waveform.index, rate)
    speed = 2.0 * math.pi * shaft
    gaps = bool((np.diff(waveform.index) != 1).any())
    data = waveform_file(acceleration, angle, rate, first, "npz", index=waveform.index if gaps else None)
    files = {f"runs/{run.name}.npz": store.write(f"runs/{run.name}.npz", data)}
    starts = window_starts(len(waveform), windows)
    starts = starts[waveform.index[starts + windows.length - 1] - waveform.index[starts] == windows.length - 1]  # without a gap
    cut = cut_windows(acceleration, windows)[np.isin(window_starts(len(waveform), windows), starts)]
    count, width = len(starts), 0.0 if run.fault == "healthy" else run.width
    columns = {
        "start": waveform.index[starts],
        "time": waveform.index[starts] / rate,
        "fault": np.full(count, run.fault),
        "width": np.full(count, width),
        "speed": np.full(count, speed),
        "load": np.full(count, run.load),
        "mixed": np.zeros(count, bool),
    }
    about = {"run": run.name, "case": run.fault, "split": run.split}
    name = f"windows/{run.split}/{run.name}.parquet"
    files[name] = store.write(name, windows_file(cut, columns, about, "parquet"))
    orders = {name: abs(shaft) * getattr(waveform.orders, name) for name in ("ftf", "bpfo", "bpfi", "bsf")}
    label: dict[str, Any] = {
        **about,
        "place": position,
        "twin": bearing,
        "condition": bearing,
        "status": DONE,
        "reason": "",
        "scenario": "",
        "fault": run.fault,
        **{
            name: value if math.isfinite(value) else None  # unknown
            for name, value in {"width": run.width, "depth": run.depth, "load": run.load, "speed": speed, **orders}.items()
        },
        "sampling_rate": rate,
        "first_index": first,
        "samples": len(waveform),
        "windows": count,
        "file": f"runs/{run.name}.npz",
        "files": files,
        "sha256": hashlib.sha256(packed(acceleration, angle)).hexdigest(),
        "dcrb_ros": __version__,
        "bearing_id": bearing,
        "machine": run.machine,
    }
    return label


def _shaft_frequency(angle: Samples, index: Integers, rate: int) -> float:
    """Return the mean frequency of the shaft, signed, from the steps within gapless stretches [Hz]; NaN without an angle."""
    if len(angle) < 2 or not np.isfinite(angle).all():
        return math.nan
    turns, gaps = unwrapped_turns(angle), np.flatnonzero(np.diff(index) != 1)
    steps = len(turns) - 1 - len(gaps)
    return float(turns[-1] - turns[0] - np.diff(turns)[gaps].sum()) * rate / steps if steps else math.nan


def _card(
    title: str, licence: str, counts: Mapping[tuple[str, str], int], windows: Windows, sources: Sequence[str], shared: Sequence[str]
) -> str:
    """Return the data card in Markdown."""
    faults, splits = healthy_first(fault for _, fault in counts), {split for split, _ in counts}
    rows = [(split, *(counts.get((split, fault), 0) for fault in faults)) for split in SPLITS if split in splits]
    origin = "\n".join(f"* {source}" for source in sources) or "* not stated"
    return f"""# {title}

Measured recordings with the schema of a data set of `dcrb sweep`, made by dcrb_ros {__version__}. Licence of the data: {licence}.

{table(("split", *faults), rows)}

{" ".join(["Every bearing is in one split.", *shared])}

Sources:

{origin}

* `labels.parquet`: one row per recording; what is unknown is null
* `runs/RUN.npz`: waveform of one recording, arrays `ax`, `ay` [m/s^2], `shaft_angle` [rad], `sampling_rate` and `first_index`; where
  samples are missing also `index`, that of each sample
* `windows/SPLIT/RUN.parquet`: windows of {windows.length} samples, one every {windows.hop} samples
* `dataset.yaml`: classes, splits, files and columns, for programs
"""
