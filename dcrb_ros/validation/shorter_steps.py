"""Comparisons of runs with the default step and with shorter ones: waveform, statistics, and rings that swing on dry and oiled rollers."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy.stats import kurtosis

from dcrb_ros.bearing.payload import build_payload, initial_state
from dcrb_ros.core.layout.workspace import workspace
from dcrb_ros.core.solver.step import advance
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.validation.formulation import deviation
from dcrb_ros.validation.measures import envelope_spectrum
from dcrb_ros.validation.oiled_runs import EVEN, HEALTHY
from dcrb_ros.validation.report_row import ReportRow, within
from dcrb_ros.validation.runs import JOINTS, QUARTER_STEP, PaperRun, PaperRuns
from dcrb_ros.validation.time_integration import CHAPTER, STEP

SHORT = 0.012
"""Time over which waveforms are compared [s]."""
RATIO = 20
"""Of the default step to that of the exact waveform [-]."""
BURST = (-0.25e-3, 0.5e-3)
"""Start and end of a burst, relative to a roller at the middle of the defect [s]."""
MOST_FORCE, MOST_WAVEFORM = {"revolute": 0.001, "pocket": 0.004}, {"revolute": 0.015, "pocket": 0.04}
"""Accepted relative RMS errors by joint [-]."""


class Trace(NamedTuple):
    """The compared quantities of a run."""

    acceleration: Floats
    """Acceleration of the outer ring in X and Y, mean over each step, shape (steps, 2) [m/s^2]."""
    force: Floats
    """Normal forces at the middle of each step, shape (steps, inner and outer raceway, rows, rollers) [N]."""


def traced(configuration: Configuration, ratio: int) -> Trace:
    """Return the trace of a run from the warm start with a step shorter by ``ratio``, as means over default steps."""
    payload = build_payload(configuration)._replace(step=STEP / ratio)
    state, work, steps = initial_state(configuration, payload), workspace(payload), ratio * round(SHORT / STEP)
    acceleration, force, angle = np.empty((steps, 2)), np.empty((steps, 2, *state.inner_force.shape)), np.empty(1)
    for n in range(steps):
        advance(payload, state, work, acceleration[n : n + 1], angle)
        force[n] = state.inner_force, state.outer_force
    middle = force.reshape(-1, ratio, *force.shape[1:])[:, (ratio - 1) // 2 : ratio // 2 + 1]
    return Trace(acceleration.reshape(-1, ratio, 2).mean(axis=1), middle.mean(axis=1))


def waveform_row(joint: str) -> ReportRow:
    """Compare forces and waveform of an outer-ring defect with those of a short step.

    With ``pocket``, idle rollers rattle between the bursts, and no step reproduces their paths: the two bursts are compared.
    """
    configuration = load_configuration("dry", [f"cage.joint={joint}", "faults.outer_1.width=0.002"])
    run, exact = traced(configuration, 1), traced(configuration, RATIO)
    cage_speed = float(initial_state(configuration, build_payload(configuration)).cage_velocity[0, 2])
    passing = 2.0 * math.pi / (configuration.bearing.rollers_per_row * cage_speed)
    bursts = [slice(*(max(0, round((k * passing + offset) / STEP)) for offset in BURST)) for k in (0, 1)]
    spans = [slice(None)] if joint == "revolute" else bursts
    force, waveform = (
        [deviation(values[span], true[span]) for span in spans] for values, true in zip(reversed(run), reversed(exact), strict=True)
    )
    return ReportRow(
        f"Outer ring defect, {1e3 * SHORT:g} ms" + (", both bursts" if joint == "pocket" else "") + f", step over that step / {RATIO}",
        joint,
        "-",
        ", ".join(f"forces {100.0 * f:.2f} %, waveform {100.0 * w:.1f} %" for f, w in zip(force, waveform, strict=True)),
        f"RMS error {100.0 * MOST_FORCE[joint]:g} %, {100.0 * MOST_WAVEFORM[joint]:g} %",
        max(force) <= MOST_FORCE[joint] and max(waveform) <= MOST_WAVEFORM[joint],
        CHAPTER,
    )


MOST_LEVEL, MOST_SPEED = 0.02, 5e-4
"""Accepted relative deviations of RMS, kurtosis and envelope line, and of the cage speed [-]."""
LINE_WIDTH = 2.0
"""Search range to either side of 16 f_c [Hz]."""


def statistics_of(run: PaperRun) -> tuple[float, float, float, float]:
    """Return RMS [m/s^2], kurtosis [-], amplitude of the line near 16 f_c [m/s^2] and cage speed [rad/s] of a run."""
    y = run.steady_acceleration
    line = envelope_spectrum(y, run.rate).line(run.rollers_per_row * run.cage_frequency, LINE_WIDTH)
    return float(y.std()), float(kurtosis(y, fisher=False)), line.amplitude, run.mean_cage_speed


def statistics_row(run: PaperRun, exact: PaperRun) -> ReportRow:
    """Compare the statistics of a run over seconds with those of a quarter of the step."""
    deviations = [value / true - 1.0 for value, true in zip(statistics_of(run), statistics_of(exact), strict=True)]
    return ReportRow(
        f"Outer ring defect, {run.spec.duration:g} s: RMS, kurtosis, line at f_O and cage speed over those of a quarter of the step",
        run.spec.joint,
        "-",
        ", ".join(f"{100.0 * deviation:+.2f} %" for deviation in deviations),
        f"{100.0 * MOST_LEVEL:g} %; cage speed {100.0 * MOST_SPEED:g} %",
        all(within(1.0 + deviation, 1.0, MOST_LEVEL) for deviation in deviations[:3]) and abs(deviations[3]) <= MOST_SPEED,
        CHAPTER,
    )


SWING_STEPS = (1e-5, 1.25e-6)
SWING_EXACT = 1e-5 / 256
SWING, INSTANTS = 4e-4, 8
"""Time compared [s], and instants in it: at a single one an error that oscillates may pass through zero [-]."""
STRUCK = 0.01, -0.02
"""Velocity by which the inner ring is struck in X and Y [m/s]."""
MOST_ERRORS = {"dry": (8500.0, 200.0), "lubricated": (650.0, 80.0)}
"""Accepted errors at each of `SWING_STEPS` [pm]: this model's own."""


def swing(bench: str, settings: tuple[str, ...], step: float) -> Floats:
    """Return the centres of both rings as they swing on loaded rollers, at all instants, shape (instants, 4) [m]."""
    configuration = load_configuration(bench, ("cage.joint=revolute", *settings))
    payload = build_payload(configuration)
    state, payload = initial_state(configuration, payload), payload._replace(step=step)
    state.inner_velocity[:2] += STRUCK
    work, count, centres = workspace(payload), round(SWING / step) // INSTANTS, []
    for _ in range(INSTANTS):
        advance(payload, state, work, np.empty((count, 2)), np.empty(count))
        centres.append([*state.inner_position[:2], *state.outer_position[:2]])
    return np.array(centres)


def swing_errors(bench: str, settings: tuple[str, ...] = ()) -> list[float]:
    """Return the largest error of the rings' positions at each of `SWING_STEPS` [m]."""
    exact = swing(bench, settings, SWING_EXACT)
    return [float(np.abs(swing(bench, settings, step) - exact).max()) for step in SWING_STEPS]


def swing_rows() -> Iterator[ReportRow]:
    """Yield the errors of the swinging rings, on dry rollers and on lubricated ones."""
    for name, bench, settings in (("dry", "dry", ()), ("lubricated", HEALTHY, EVEN)):
        errors = [1e12 * error for error in swing_errors(bench, settings)]
        yield ReportRow(
            f"Rings swinging on {name} rollers, {1e3 * SWING:g} ms: largest error of a position, steps of 10 and 1.25 us",
            "revolute",
            "-",
            ", ".join(f"{error:.0f}" for error in errors) + " pm",
            "at most " + ", ".join(f"{most:g}" for most in MOST_ERRORS[name]) + " pm",
            all(error <= most for error, most in zip(errors, MOST_ERRORS[name], strict=True)),
            CHAPTER,
        )


def shorter_step_rows(runs: PaperRuns) -> Iterator[ReportRow]:
    """Yield all of them."""
    for joint in JOINTS:
        yield waveform_row(joint)
        yield statistics_row(runs["outer ring defect", joint], runs[QUARTER_STEP, joint])
    yield from swing_rows()
