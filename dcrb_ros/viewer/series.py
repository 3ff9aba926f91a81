"""Plots over time in Rerun: waveform, forces, speeds, features, indicators.

With ``fixed`` false, names and colours are not logged again; this is for later parts of the same plot.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import rerun as rr
from rerun.components import AggregationPolicy

from dcrb_ros.messages.topics.lubrication_state import RACEWAYS, arrays_of
from dcrb_ros.schema.arrays import Floats, Samples
from dcrb_ros.stream.block import Truth
from dcrb_ros.stream.states import FRICTION_SOURCES
from dcrb_ros.viewer import columns, palette
from dcrb_ros.viewer.columns import TIMELINE
from dcrb_ros.viewer.content import Content, Motion, Series, TimedWaveform, Times, Verdict

KILO, MICRO = 1e-3, 1e6
DEGREES = " [deg C]"
"""End of the names of temperatures in the ground truth."""


def log_waveform(waveform: TimedWaveform, *, fixed: bool = True) -> None:
    """Log all samples of the waveform, the first two axes [m/s^2]."""
    colours = [palette.WAVEFORM_X, palette.WAVEFORM]
    log_lines("waveform", waveform.time_ns, waveform.acceleration[:, :2], ["ax", "ay"], colours, width=1.0, fixed=fixed)


def log_lines(
    path: str,
    time_ns: Times,
    values: Floats | Samples,
    names: Sequence[str],
    colours: Sequence[palette.Colour],
    *,
    width: float = 1.5,
    fixed: bool = True,
) -> None:
    """Log several lines over time as one entity; values of shape (times, names), the last name is drawn on top."""
    if fixed:
        # The default policy draws the mean of the samples in a pixel, which hides peaks.
        policy, widths = AggregationPolicy.MinMax, [width] * len(names)
        look = rr.SeriesLines(names=list(names), colors=list(colours), widths=widths, aggregation_policy=policy)
        rr.log(path, look, static=True)
    columns.send(path, time_ns, columns.scalars(values))


def log_motion(content: Content, motion: Motion, *, fixed: bool = True) -> None:
    """Log normal forces [kN] and spins [rad/s] of the rollers, speeds of the cages [rad/s], and their slip [%]."""
    rows, count = content.bodies.rows, content.bodies.rollers_per_row
    names = [f"roller {i + 1}" for i in range(count)]
    colours = palette.wheel(count)
    for row in range(rows):
        rollers = slice(row * count, (row + 1) * count)
        log_lines(f"forces/row{row + 1}", motion.time_ns, motion.force[:, rollers] * KILO, names, colours, fixed=fixed)
        log_lines(f"spins/row{row + 1}", motion.time_ns, motion.speed[:, rollers], names, colours, fixed=fixed)
    cages = [f"cage {row + 1}" for row in range(rows)]
    speeds = motion.speed[:, rows * count : rows * count + rows]
    log_lines("cages", motion.time_ns, speeds, cages, palette.ROWS[:rows], fixed=fixed)


def log_truth(content: Content, *, fixed: bool = True) -> None:
    """Log speed [rad/s] and load [kN] of the ground truth."""
    if content.truths:
        times = np.array([truth.time_ns for truth in content.truths])
        values = np.array([[truth.speed, np.hypot(*truth.load) * KILO] for truth in content.truths])
        log_lines("operating", times, values, ["speed [rad/s]", "load [kN]"], [palette.BRIGHT, palette.LOAD], fixed=fixed)
        log_temperatures(content.truths, fixed=fixed)


def log_tacho(tacho: Series, *, fixed: bool = True) -> None:
    """Log the speed from the pulses of the tacho [rad/s], in the plot of speed and load."""
    log_lines("operating/tacho", tacho.time_ns, tacho.values, tacho.names, [palette.WAVEFORM_X], fixed=fixed)


def log_temperatures(truths: Sequence[Truth], *, fixed: bool = True) -> None:
    """Log the temperatures of the ground truth [deg C], where it has any."""
    warm = [truth for truth in truths if truth.thermal]
    if not is_warm(truths):
        return
    names = [name for name in warm[0].thermal if name.endswith(DEGREES)]
    values = np.array([[truth.thermal.get(name, np.nan) for name in names] for truth in warm])
    times, labels = np.array([truth.time_ns for truth in warm]), [name.removesuffix(DEGREES).replace("_", " ") for name in names]
    log_lines("temperatures", times, values, labels, palette.wheel(len(names)), fixed=fixed)


def is_warm(truths: Sequence[Truth]) -> bool:
    """Return whether the ground truth has temperatures."""
    return any(name.endswith(DEGREES) for truth in truths for name in truth.thermal)


def log_series(path: str, series: Series | None, *, fixed: bool = True) -> None:
    """Log each number of a series as an entity of its own, so that a view can select it."""
    if series is None:
        return
    others = palette.wheel(len(series.names))
    for column, name in enumerate(series.names):
        colour = palette.FAULT_LINES.get({"BSF": "2BSF"}.get(name, name), others[column])
        log_lines(f"{path}/{name}", series.time_ns, series.values[:, column : column + 1], [name], [colour], fixed=fixed)


def log_lubrication(lubrication: Series, *, fixed: bool = True) -> None:
    """Log the smallest films of each row [um] with Lambda at the inner raceway, and the friction power of both rows by source [W]."""
    arrays = arrays_of(lubrication.names, lubrication.values)
    if arrays is None:
        return
    rows = arrays["least_film"].shape[1]
    films = np.concatenate([arrays["least_film"][:, :, k] * MICRO for k in range(2)] + [arrays["least_film_ratio"][:, :, 0]], axis=1)
    names = [f"row {row + 1}, {what}" for what in (*(f"{raceway} [um]" for raceway in RACEWAYS), "Lambda") for row in range(rows)]
    log_lines("films", lubrication.time_ns, films, names, palette.wheel(len(names)), fixed=fixed)
    powers = arrays["friction_power"].sum(axis=1)
    log_lines("friction", lubrication.time_ns, powers, FRICTION_SOURCES, palette.wheel(len(FRICTION_SOURCES)), fixed=fixed)


def log_verdicts(verdicts: Sequence[Verdict]) -> None:
    """Log the detector's verdicts as a text log."""
    levels = (rr.TextLogLevel.INFO, rr.TextLogLevel.WARN, rr.TextLogLevel.ERROR)
    for verdict in verdicts:
        rr.set_time(TIMELINE, timestamp=np.datetime64(verdict.time_ns, "ns"))
        text = f"{verdict.title}: {verdict.evidence.get('reason', '')}"
        rr.log("diagnosis/verdict", rr.TextLog(text, level=levels[min(verdict.level, 2)]))
