"""The data card: the description of a data set that is stored with it."""

from __future__ import annotations

import hashlib

from dcrb_ros.recordings.manifest import UNITS, model_fingerprint, software
from dcrb_ros.runtime.version import __version__
from dcrb_ros.sweep.design import GRID, Axes, Choice
from dcrb_ros.sweep.label import DONE
from dcrb_ros.sweep.plan import Plan
from dcrb_ros.sweep.sweep_file import Sweep
from dcrb_ros.sweep.table import COLUMNS, Tally

SPLITS = ("train", "validation", "test")


def card(plan: Plan, tally: Tally) -> str:
    """Return the data card in Markdown."""
    sections = (_summary(plan.sweep, tally), _counts(tally), _files(plan.sweep), _columns(), _design(plan.sweep), _reproduction(plan.sweep))
    return "\n\n".join(sections) + "\n"


def _summary(sweep: Sweep, tally: Tally) -> str:
    rate, file = sweep.base["sensor.sampling_rate"], sweep.file
    made = sum(tally.statuses.values())
    rest = ", ".join(f"{count} {status}" for status, count in sorted(tally.statuses.items()) if status != DONE)
    return f"""# Vibration of a simulated double-row roller bearing

{tally.statuses[DONE]} runs of {file.duration:g} s, {tally.seconds:.6g} s in all,
made by dcrb_ros {__version__} (model {model_fingerprint()}). Of {made} planned runs, {rest or "none was refused or failed"}.

Every waveform is the output of an accelerometer on the outer ring at {rate} Hz (unless `labels.parquet` gives another rate):
`ax` and `ay` [m/s^2], X to the right and Y up, and `shaft_angle` [rad], the rotation of the inner ring within 0 .. 2 pi. The first
{file.settle:g} s of a run are not recorded. The data are simulated with a planar model of a rigid bearing, without lubricant, heat or wear.

Licence of the data: {file.licence}. The licence of the program that made them, Apache-2.0, does not extend to the data."""


def _counts(tally: Tally) -> str:
    faults = sorted({fault for _, fault in tally.classes}, key=lambda fault: (fault != "healthy", fault))
    lines = [f"| split | conditions | {' | '.join(faults)} | runs |", "|---" * (len(faults) + 3) + "|"]
    for split in SPLITS:
        counts = [tally.classes[split, fault] for fault in faults]
        cells = [split, len(tally.conditions.get(split, ())), *counts, sum(counts)]
        lines.append("| " + " | ".join(str(cell) for cell in cells) + " |")
    reasons = "\n".join(f"* {count} x {reason}" for reason, count in tally.reasons.most_common(10))
    return "\n".join(
        [
            "## Runs by split and fault\n",
            *lines,
            "\nA condition (bearing, speed, load) belongs to one split only, with all its seeds, faults and sensors. So do twins, "
            "the runs of one condition\nand seed that differ in the fault only.",
            *([f"\nNot simulated:\n\n{reasons}"] if reasons else []),
        ]
    )


def _files(sweep: Sweep) -> str:
    kind, windows = sweep.file.output, sweep.file.windows
    waveform = {
        "npz": "`runs/RUN.npz`: arrays `ax`, `ay`, `shaft_angle` (float32), `sampling_rate`, `first_index`; `numpy.load`",
        "parquet": "`runs/RUN.parquet`: columns `ax`, `ay`, `shaft_angle` (float32); `pandas.read_parquet`",
        "bag": "`runs/RUN/`: a rosbag2 recording (MCAP) with ground truth; `dcrb info` prints its contents",
    }[kind]
    lines = [
        "## Files\n",
        "* `labels.parquet`: one row per run; `pandas.read_parquet`",
        f"* {waveform}",
        "* `labels/RUN.json`: the label of one run",
        "* `sweep.yaml`: the sweep file; `base.yaml`: its base configuration with all parameters; `sweep.json`: both, with the scenarios",
    ]
    if windows is not None:
        arrays = "array `x` of shape (windows, 2, length)" if windows.kind == "npz" else "columns `ax`, `ay`, lists of `length` samples"
        lines.append(
            f"* `windows/SPLIT/RUN.{windows.kind}`: windows of {windows.length} samples every {windows.hop} samples: {arrays} [m/s^2], "
            "with `start` (sample), `time` [s], `fault`, `width` [m], `speed` [rad/s], `load` [N] and `mixed` "
            "(whether a fault changed within the window) of each window"
        )
    return "\n".join(lines)


def _columns() -> str:
    lines = "\n".join(f"| `{name}` | {meaning} |" for name, meaning in COLUMNS.items())
    units = "; ".join(f"{name} in {unit}" for name, unit in UNITS.items())
    head = f"## Columns of labels.parquet\n\n{units}. Every varied parameter has a column with its own name."
    return f"{head}\n\n| column | meaning |\n|---|---|\n{lines}"


def _design(sweep: Sweep) -> str:
    file = sweep.file
    lines = [f"* design: {file.design}" + ("" if file.design == GRID else f", {file.points} points, seed {file.seed}")]
    lines += [f"* {axis}" for axis in _axes(sweep.vary)]
    for name, axes in sweep.cases.items():
        lines.append(f"* case `{name}`: " + ("; ".join(_axes({k: a for k, a in axes.items() if _changes(k, a, sweep)})) or "no fault"))
    branches = f"the cases of a condition branch from one healthy simulation at {file.branch_at:g} s"
    start = branches if file.branch_at else "every run is simulated from its own start"
    return "## Design\n\n" + "\n".join([*lines, f"* seeds: {file.seeds!r} per condition; {start}"])


def _changes(key: str, axis: object, sweep: Sweep) -> bool:
    """Return whether an axis of a case changes a parameter."""
    return not (isinstance(axis, Choice) and axis.values == (sweep.base.get(key),))


def _axes(axes: Axes) -> list[str]:
    found = []
    for key, axis in axes.items():
        span = ", ".join(str(value) for value in axis.values[:20]) if isinstance(axis, Choice) else f"{axis.low:g} .. {axis.high:g}"
        found.append(f"`{key}`: {span}" + (" (log)" if not isinstance(axis, Choice) and axis.log else ""))
    return found


def _reproduction(sweep: Sweep) -> str:
    text = hashlib.sha256(sweep.text.encode()).hexdigest()
    here = ", ".join(f"{name} {version}" for name, version in software().items())
    return f"""## Reproducing the data set

```sh
dcrb sweep sweep.yaml -o DIR    # dcrb_ros {__version__}
```

`sweep.yaml` has the SHA-256 {text}. The data set was made with {here}. On the same kind of machine the samples are identical bit for bit.
On another kind the last bit may differ; rollers outside the load zone then move differently in detail, with the same statistics."""
