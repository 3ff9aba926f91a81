"""The data card: the description of a data set that is stored with it."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping

from dcrb_ros.recordings.manifest import UNITS, model_fingerprint, software
from dcrb_ros.runtime.version import __version__
from dcrb_ros.schema.parameter_field import ParameterField
from dcrb_ros.settings.files import fields_by_key
from dcrb_ros.sweep.design import GRID, Axes, Choice
from dcrb_ros.sweep.label import DONE
from dcrb_ros.sweep.loader import HEALTHY
from dcrb_ros.sweep.plan import Plan
from dcrb_ros.sweep.schema import SPLITS, healthy_first
from dcrb_ros.sweep.sweep_file import Sweep
from dcrb_ros.sweep.table import COLUMNS, Tally
from dcrb_ros.sweep.vehicles.loader import vehicle_fields
from dcrb_ros.sweep.vehicles.sweep import VehicleSweep
from dcrb_ros.text.markdown import table

SHOWN_VALUES = 20
"""Values of an axis that are listed at most [-]."""


def card(plan: Plan, tally: Tally) -> str:
    """Return the data card in Markdown."""
    sweep, design = plan.sweep, plan.design_text() or _design(plan.sweep)
    sections = (_summary(sweep, tally), _counts(plan, tally), _files(sweep), _columns(plan), design, _reproduction(sweep))
    return "\n\n".join(sections) + "\n"


def _summary(sweep: Sweep, tally: Tally) -> str:
    rate, file = sweep.rate, sweep.file
    planned, done = sum(tally.statuses.values()), tally.statuses[DONE]
    outcomes = ", ".join(f"{count} {status}" for status, count in sorted(tally.statuses.items()))
    result = "and all of them succeeded" if done == planned else f"with the outcomes {outcomes}"
    left_out = f" The first {file.settle:g} s of a run are not recorded." if file.settle else ""
    return f"""# Vibration of a simulated {sweep.subject}

{done} runs of {file.duration:g} s, {tally.seconds:.6g} s in total, made by dcrb_ros {__version__} (model {model_fingerprint()}).
{planned} runs were planned, {result}.

Every waveform is the output of an accelerometer on the outer ring, sampled at {rate} Hz unless `labels.parquet` gives another rate:
`ax` and `ay` [m/s^2], X to the right and Y up, and `shaft_angle` [rad], the angle of the inner ring, 0 to 2 pi.{left_out}
The data are simulated, not measured. The model is planar and its rings are rigid; `base.yaml` has its parameters.

Licence of the data: {file.licence}. The licence of the program, Apache-2.0, does not apply to the data."""


def _counts(plan: Plan, tally: Tally) -> str:
    faults, rows = healthy_first(fault for _, fault in tally.classes), []
    for split in SPLITS:
        counts = [tally.classes[split, fault] for fault in faults]
        rows.append((split, len(tally.units.get(split, ())), *counts, sum(counts)))
    reasons = "\n".join(f"* {count} x {reason}" for reason, count in tally.reasons.most_common(10))
    failures = f"\n\nReasons of the runs that were refused or failed:\n\n{reasons}" if reasons else ""
    return f"## Runs by split and fault\n\n{table(('split', f'{plan.unit}s', *faults, 'runs'), rows)}\n\n{plan.split_text}{failures}"


def _files(sweep: Sweep) -> str:
    kind, windows = sweep.file.output, sweep.file.windows
    waveform = {
        "npz": "`runs/RUN.npz`: waveform of one run, arrays `ax`, `ay`, `shaft_angle` (float32), `sampling_rate` and `first_index`; "
        "read it with `numpy.load`",
        "parquet": "`runs/RUN.parquet`: waveform of one run, columns `ax`, `ay` and `shaft_angle` (float32); "
        "read it with `pandas.read_parquet`",
        "bag": "`runs/RUN/`: rosbag2 recording (MCAP) of one run with its ground truth; `dcrb info` prints its contents",
    }[kind]
    lines = [
        "## Files\n",
        "* `labels.parquet`: one row per run; read it with `pandas.read_parquet`",
        f"* {waveform}",
        "* `labels/RUN.json`: label of one run with its digest, and with size and SHA-256 of its files",
        "* `SHA256SUMS`: hashes of the tables and descriptions; `dcrb_ros.DataSet` compares them and reads all files",
        "* `dataset.yaml`: classes, splits, files and columns, for programs",
        "* `sweep.yaml`: the sweep file; `base.yaml`: its base configuration with all parameters; `sweep.json`: both, and the scenarios",
    ]
    if windows is not None:
        arrays = "array `x` of shape (windows, 2, length)" if windows.kind == "npz" else "columns `ax`, `ay`, lists of `length` samples"
        lines.append(
            f"* `windows/SPLIT/RUN.{windows.kind}`: windows of {windows.length} samples, one every {windows.hop} samples: "
            f"{arrays} [m/s^2], and for each window `start` [sample], `time` [s], `fault`, `width` [m], `speed` [rad/s], "
            "`load` [N] and `mixed` "
            "(whether a fault changes within the window)"
        )
    return "\n".join(lines)


def _columns(plan: Plan) -> str:
    columns = ((f"`{name}`", meaning) for name, (_, meaning) in {**COLUMNS, **plan.truth}.items())
    units = "; ".join(f"{name} in {unit}" for name, unit in UNITS.items())
    head = f"## Columns of labels.parquet\n\nUnits: {units}. Every varied parameter has a column with its own name."
    return f"{head}\n\n{table(('column', 'meaning'), columns)}"


def _design(sweep: Sweep) -> str:
    file = sweep.file
    lines = [f"* design: {file.design}" + ("" if file.design == GRID else f", {file.points} points, seed {file.seed}")]
    fields = vehicle_fields() if isinstance(sweep, VehicleSweep) else fields_by_key()
    lines += [f"* {axis}" for axis in _axes(sweep.vary, fields)]
    for name, axes in sweep.cases.items():
        twin = file.twins and name == HEALTHY  # its axes, which the file does not have, remove all faults
        lines.append(f"* case `{name}`: " + ("no fault" if twin else "; ".join(_axes(axes, fields)) or "as the base"))
    branches = f"the cases of a condition branch from one healthy simulation at {file.branch_at:g} s"
    start = branches if file.branch_at else "every run is simulated from its own start"
    seeds = "one seed per condition" if file.seeds == 1 else f"{file.seeds} seeds per condition"
    if isinstance(file.seeds, list):
        seeds = f"seeds: {', '.join(map(str, file.seeds))} in every condition"
    return "## Design\n\n" + "\n".join([*lines, f"* {seeds}; {start}"])


def _axes(axes: Axes, fields: Mapping[str, ParameterField]) -> list[str]:
    """Return each axis with its values and their unit, that of the parameter in ``fields``."""
    lines = []
    for key, axis in axes.items():
        if isinstance(axis, Choice):
            values = [f"`{value}`" if isinstance(value, str) else str(value) for value in axis.values]
            rest = f" and {len(values) - SHOWN_VALUES} more" if len(values) > SHOWN_VALUES else ""
            text = ", ".join(values[:SHOWN_VALUES]) + rest
        else:
            text = f"{axis.low:g} to {axis.high:g}" + (", logarithmic" if axis.log else "")
        unit = fields[key].unit if key in fields else ""
        lines.append(f"`{key}`" + (f" [{unit}]" if unit not in ("", "-") else "") + f": {text}")
    return lines


def _reproduction(sweep: Sweep) -> str:
    text = hashlib.sha256(sweep.text.encode()).hexdigest()
    versions = software()
    machine = versions.pop("machine")
    system = ", ".join(f"{name} {version}" for name, version in versions.items()) + f" on {machine}"
    return f"""## Reproducing the data set

```sh
dcrb sweep sweep.yaml -o DIR    # dcrb_ros {__version__}
```

`sweep.yaml` has the SHA-256 {text}. The data set was made with {system}. With the same software, on the same kind of processor, the
samples are identical bit for bit. Otherwise the last bit may differ; rollers outside the load zone then move differently in detail, with
the same statistics."""
