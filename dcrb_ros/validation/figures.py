"""Figs. 8 to 11 of the paper, drawn from the runs of the validation in the same layout."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from dcrb_ros.bearing.frequencies import characteristic_orders
from dcrb_ros.validation.faults import spectrum
from dcrb_ros.validation.measures import passes
from dcrb_ros.validation.runs import BROKEN_BAR, JOINTS, SETTLED, PaperRun, PaperRuns

BLUE, ORANGE, GREY = "#1f6fb4", "#e07b00", "#8a8a8a"
FAULTS = ("cage fracture", "inner ring defect", "outer ring defect")
TITLES = {
    8: "Rotation of the bearing components from a cold start at 124.8 rad/s",
    9: "Roller and inner raceway at 100 kN and 124.8 rad/s, healthy",
    10: "Contact of a roller with the raceways at 100 kN, without and with faults",
    11: "Acceleration of the outer ring and its envelope spectrum at 124.8 rad/s",
}
SHOWN = 0.5
"""Duration of the waveform in Fig. 11 [s]."""
MOST_POINTS = 5000
"""Number of points of a line in Fig. 8, at most about twice this [-]."""


def write_figures(runs: PaperRuns, folder: Path) -> list[str]:
    """Write the figures for each joint to ``folder``; return their file names."""
    names = []
    for joint in JOINTS:
        for number, draw in ((8, speeds), (9, roller), (10, contacts), (11, vibration)):
            figure = draw(runs, joint)
            figure.suptitle(f"{TITLES[number]}, {joint} (Fig. {number})", fontsize=11)
            name = f"figure_{number}_{joint}.png"
            figure.savefig(folder / name)
            names.append(name)
    return names


def _label(axes: Axes, x: str, y: str, title: str = "") -> None:
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.set_title(title, fontsize=10)
    axes.grid(alpha=0.25)


def speeds(runs: PaperRuns, joint: str) -> Figure:
    """Return Fig. 8: rotation of the inner ring, the cage and a roller from a cold start."""
    run = runs["cold start", joint]
    thin = slice(None, None, max(1, len(run.time) // MOST_POINTS))
    figure = Figure(figsize=(10, 5), dpi=110, layout="constrained")
    whole, start = figure.subplots(1, 2, width_ratios=(3, 2))
    for axes, last in ((whole, float(run.time[-1])), (start, 0.2)):
        axes.axhline(run.configuration.operating.speed, color=GREY, label="inner ring")
        axes.plot(run.time[thin], run.cage_speed[thin, 0], color=ORANGE, lw=1.0, label="cage of row 1")
        axes.plot(run.time[thin], run.relative_spin[thin, 0], color=BLUE, lw=0.8, label="roller 1 of row 1, relative to the cage")
        axes.plot(run.time[thin], run.spin[thin].mean(axis=1), color="black", lw=0.8, ls=":", label="mean of all rollers, absolute")
        axes.set_xlim(0.0, last)
        _label(axes, "time [s]", "rotation [rad/s]")
    whole.legend(loc="center right", fontsize=8)
    start.set_title("the start", fontsize=10)
    return figure


def tracked(run: PaperRun) -> int:
    """Return the column of the roller shown in the figures: the one beside the broken bar, or the first."""
    return run.columns(BROKEN_BAR)[0] if run.configuration.faults.broken_bars else 0


def settled_passes(run: PaperRun) -> list[slice]:
    """Return the complete passes of that roller from -90 to 90 deg, without the start of the run."""
    inside = np.abs(run.azimuth[:, tracked(run)]) < 0.5 * np.pi
    return [stretch for stretch in passes(inside) if run.time[stretch.start] > SETTLED]


def shown_pass(run: PaperRun) -> slice:
    """Return the pass shown in the figures: the last one, or for an inner ring defect the one with the strongest impact."""
    stretches = settled_passes(run)
    if run.spec.name == "inner ring defect":
        force = run.inner_force[:, tracked(run)]
        return max(stretches, key=lambda stretch: float(np.abs(np.diff(force[stretch], 2)).max()))
    return stretches[-1]


def roller(runs: PaperRuns, joint: str) -> Figure:
    """Return Fig. 9: force, friction, slip and spin of a healthy roller over its azimuth."""
    run = runs["healthy", joint]
    stretch, column = shown_pass(run), tracked(run)
    azimuth = np.degrees(run.azimuth[stretch, column])
    figure = Figure(figsize=(10, 7.5), dpi=110, layout="constrained")
    (a, b), (c, d) = figure.subplots(2, 2)
    panels: list[tuple[Axes, Callable[[slice], npt.NDArray[np.floating]], str, str]] = [
        (a, lambda s: run.inner_force[s, column] * 1e-3, "normal force [kN]", "(a) contact force at the inner raceway"),
        (b, lambda s: run.friction[s, column], "friction [N]", "(b) friction at the inner raceway"),
        (c, lambda s: run.slip[s, column], "slip [m/s]", "(c) sliding velocity at the inner ring"),
        (d, lambda s: run.spin[s, column], "spin [rad/s]", "(d) roller rotation, absolute"),
    ]
    for axes, series, y, title in panels:
        for other in settled_passes(run):
            axes.plot(np.degrees(run.azimuth[other, column]), series(other), color=BLUE, lw=0.4, alpha=0.15)
        axes.plot(azimuth, series(stretch), color=BLUE, lw=1.2, label="last pass of one roller; faint: all its passes")
        axes.set_xlim(-90.0, 90.0)
        _label(axes, "azimuth from the load line [deg]", y, title)
    a.plot(azimuth, run.inner_ring_force[stretch] * 1e-3, color=ORANGE, lw=1.0, label="all rollers")
    a.legend(fontsize=8)
    d.axhline(-0.5 * 124.8 * 78.86 / 15.0, color=GREY, lw=0.8, ls="--", label="pure rolling")
    d.legend(fontsize=8)
    return figure


def contacts(runs: PaperRuns, joint: str) -> Figure:
    """Return Fig. 10: total force, and force and friction torque of a roller, without and with each fault."""
    figure = Figure(figsize=(15, 8.5), dpi=110, layout="constrained")
    panels = figure.subplots(3, 4, sharex=True)
    for total in panels[0, 1:]:
        total.sharey(panels[0, 0])
    for letter, name, (total, normal, torque) in zip("abcd", ("healthy", *FAULTS), panels.T, strict=True):
        run = runs[name, joint]
        stretch, column = shown_pass(run), tracked(run)
        azimuth = np.degrees(run.azimuth[stretch, column])
        outer = name == "outer ring defect"
        force = run.outer_force if outer else run.inner_force
        total.plot(azimuth, run.inner_ring_force[stretch] * 1e-3, color=ORANGE, lw=0.9)
        normal.plot(azimuth, force[stretch, column] * 1e-3, color=BLUE, lw=0.9)
        torque.plot(azimuth, run.torque[stretch, column], color=BLUE, lw=0.9)
        _label(total, "", "total force [kN]", f"({letter}) {'defect-free' if name == 'healthy' else name}")
        _label(normal, "", "normal force, outer [kN]" if outer else "normal force, inner [kN]")
        _label(torque, "azimuth from the load line [deg]", "friction torque [N m]")
        torque.set_xlim(-90.0, 90.0)
    return figure


def vibration(runs: PaperRuns, joint: str) -> Figure:
    """Return Fig. 11: acceleration of the outer ring and its envelope spectrum with each fault."""
    figure = Figure(figsize=(15, 7.5), dpi=110, layout="constrained")
    panels = figure.subplots(2, 3)
    lines = (("FTF", 130.0), ("BPFI", 600.0), ("BPFO", 600.0))
    for letter, name, (order, most), (upper, lower) in zip("abc", FAULTS, lines, panels.T, strict=True):
        run = runs[name, joint]
        count = round(SHOWN * run.rate)
        upper.plot(np.arange(count) / run.rate, run.steady_acceleration[:count], color=BLUE, lw=0.4)
        _label(upper, "time [s]", "acceleration of the outer ring, Y [m/s^2]", f"({letter}) {name}")
        envelope = spectrum(run)
        kinematic = characteristic_orders(run.configuration.bearing).frequencies(run.shaft_frequency)[order]
        seen = (envelope.frequency > 1.0) & (envelope.frequency <= most)
        lower.plot(envelope.frequency[seen], envelope.amplitude[seen], color=BLUE, lw=0.8)
        for k in range(1, int(most / kinematic) + 1):
            lower.axvline(
                k * kinematic, color=ORANGE, lw=0.7, ls="--", alpha=0.8, label=f"k {order}, {kinematic:.1f} Hz" if k == 1 else None
            )
        lower.set_xlim(0.0, most)
        _label(lower, "frequency [Hz]", "envelope [m/s^2]")
        lower.legend(fontsize=8)
    return figure
