"""Accuracy: forces and waveform of an outer ring defect."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from accuracy_table import JOINTS, STEP, Entry, Floats, percent, print_table, relative_rms

from dcrb_ros.bearing.payload import build_payload, initial_state
from dcrb_ros.core.layout.workspace import workspace
from dcrb_ros.core.solver.step import advance
from dcrb_ros.settings.configuration import Configuration

DURATION = 0.012
FINE_STEP = 5e-7
STEPS = (2e-6, 5e-6, STEP)
BURST = (-0.25e-3, 0.5e-3)
"""Start and end of a burst, relative to a roller at the middle of the defect [s]."""
MOST_FORCE, MOST_WAVEFORM = 0.005, 0.04


class Trace(NamedTuple):
    """The compared quantities of a run."""

    acceleration: Floats
    """Acceleration of the outer ring in X and Y, mean over each step, shape (steps, 2) [m/s^2]."""
    force: Floats
    """Normal forces at the middle of each step, shape (steps, inner and outer raceway, rows, rollers) [N]."""

    @property
    def total(self) -> Floats:
        """Sum of the normal forces on either raceway, shape (steps, 2) [N]."""
        return np.asarray(self.force.sum(axis=(2, 3)))

    def between(self, begin: int, end: int) -> Trace:
        """Return the steps from ``begin`` to ``end`` (exclusive)."""
        return Trace(self.acceleration[begin:end], self.force[begin:end])


def traced(configuration: Configuration, step: float, steps: int) -> Trace:
    """Return the trace of ``steps`` steps of ``step`` [s] from the warm start."""
    payload = build_payload(configuration)._replace(step=step)
    state, work = initial_state(configuration, payload), workspace(payload)
    trace, angle = Trace(np.empty((steps, 2)), np.empty((steps, 2, *state.inner_force.shape))), np.empty(1)
    for n in range(steps):
        advance(payload, state, work, trace.acceleration[n : n + 1], angle)
        trace.force[n, 0], trace.force[n, 1] = state.inner_force, state.outer_force
    return trace


def coarsened(trace: Trace, ratio: int) -> Trace:
    """Return a trace with steps longer by an even ``ratio``: mean accelerations, and forces at the middle of each step."""
    acceleration = trace.acceleration.reshape(-1, ratio, 2).mean(axis=1)
    middle = trace.force.reshape(-1, ratio, *trace.force.shape[1:])[:, ratio // 2 - 1 : ratio // 2 + 1].mean(axis=1)
    return Trace(acceleration, middle)


def outer_defect(joint: str, step: float = STEP, load: float = 1e5, row: int | None = None) -> Configuration:
    """Return a dry bearing at 1200 rpm with a defect of 2 mm across the outer raceway, in one row or in both."""
    defect = {"width": 0.002, "depth": 0.0003, "azimuth": 0.0}
    return Configuration.model_validate(
        {
            "cage": {"joint": joint},
            "operating": {"speed": 125.664, "load": load},
            "simulation": {"step": step},
            "faults": {"outer_1": defect if row is None else defect | {"row": row}},
        }
    )


def passing_period(configuration: Configuration) -> float:
    """Return the time between two rollers at the defect [s]; at the start, a roller is at its middle."""
    payload = build_payload(configuration)
    cage = float(initial_state(configuration, payload).cage_velocity[0, 2])
    return 2.0 * math.pi / (configuration.bearing.rollers_per_row * cage)


def differences(found: Trace, exact: Trace) -> tuple[float, float, float]:
    """Return the relative rms errors of the roller forces, of the total forces on the raceways, and of the waveform [-]."""
    return (
        relative_rms(found.force, exact.force),
        relative_rms(found.total, exact.total),
        relative_rms(found.acceleration, exact.acceleration),
    )


def paths() -> Iterator[Entry]:
    """Yield errors of forces and waveform for both joints, over the whole time and over each burst."""
    for joint in JOINTS:
        configuration = outer_defect(joint)
        for step in STEPS:
            ratio, steps = 2 * round(0.5 * step / FINE_STEP), round(DURATION / step)
            found = traced(configuration, step, steps)
            exact = coarsened(traced(configuration, step / ratio, steps * ratio), ratio)
            yield path_entry(joint, step, "12 ms", differences(found, exact), joint == "revolute" and step == STEP)
            for k, name in enumerate(("first burst", "second burst")):
                middle = k * passing_period(configuration)
                begin, end = (max(0, round((middle + offset) / step)) for offset in BURST)
                yield path_entry(joint, step, name, differences(found.between(begin, end), exact.between(begin, end)), step == STEP)


def path_entry(joint: str, step: float, interval: str, errors: tuple[float, float, float], held: bool) -> Entry:
    """Return a row of `paths`; it has a verdict if ``held``."""
    cells = (joint, f"{1e6 * step:.2f}", interval, *(percent(error) for error in errors))
    return Entry(cells, max(errors[:2]) <= MOST_FORCE and errors[2] <= MOST_WAVEFORM if held else None)


def path_table() -> bool:
    """Print the errors of a defect's forces and waveform."""
    heads = ("joint", "step [us]", "interval", "roller forces", "total forces", "waveform")
    tolerance = (
        f"Relative rms error compared with a step of {1e6 * FINE_STEP:g} us from the same start. Tolerances at the default step: forces "
        f"{100.0 * MOST_FORCE:g} %, waveform {100.0 * MOST_WAVEFORM:g} %, over both bursts and, with `revolute`, over 12 ms. With "
        "`pocket`, idle rollers rattle between the bursts, and no step reproduces their individual paths."
    )
    return print_table("Outer ring defect, forces and waveform", tolerance, heads, paths())
