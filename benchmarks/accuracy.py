"""Accuracy of the time loop: order of convergence, forces and waveform of a defect, statistics over seconds, energy.

Prints Markdown tables. A row with a tolerance has a verdict; the exit status is 1 if a row exceeds its tolerance.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from dcrb_ros.bearing.energy import energy_of_bars, energy_of_lands, kinetic_energy, potential_of_weight
from dcrb_ros.bearing.equilibrium import penetrations, radial_directions, stored_energy
from dcrb_ros.bearing.observation import place_pinned_rollers, wrapped
from dcrb_ros.bearing.payload import build_payload, initial_state
from dcrb_ros.core.layout.state import State, copy_of
from dcrb_ros.core.layout.workspace import workspace
from dcrb_ros.core.payload import Payload
from dcrb_ros.core.solver.step import advance
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.settings.parameters import SimulationParameters
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.validation.measures import envelope_spectrum, kurtosis

Floats = npt.NDArray[np.float64]

STEP = SimulationParameters().step
"""The default step [s]."""
JOINTS = ("revolute", "pocket")


class Entry(NamedTuple):
    """One row of a table."""

    cells: tuple[str, ...]
    holds: bool | None = None
    """Whether it is within its tolerance; None for a row without tolerance."""


def print_table(title: str, tolerance: str, heads: Sequence[str], entries: Iterable[Entry]) -> bool:
    """Print a table row by row; return whether all rows are within their tolerances."""
    print(f"\n### {title}\n\n{tolerance}\n\n| " + " | ".join([*heads, "verdict"]) + " |\n|" + "---|" * (len(heads) + 1))
    passed = True
    for entry in entries:
        verdict = {None: "", True: "passed", False: "**failed**"}[entry.holds]
        print("| " + " | ".join([*entry.cells, verdict]) + " |", flush=True)
        passed = passed and entry.holds is not False
    return passed


def step_name(part: int) -> str:
    """Return the name of a fraction of the default step h."""
    return f"h/{part}" if part > 1 else "h"


def percent(share: float) -> str:
    """Return a ratio as text in percent."""
    return f"{100.0 * share:.3f} %"


def relative_rms(found: Floats, exact: Floats) -> float:
    """Return the rms of the error over the rms of the exact values [-]."""
    return float(np.linalg.norm(found - exact) / np.linalg.norm(exact))


# 1. Order of convergence

ORDER_STEPS = (8e-6, 4e-6, 2e-6, 1e-6)
COMMON = 8e-6
"""Interval at which runs with different steps are compared [s]."""
EXACT_STEP = 6.25e-8
SETTLING_STEP = 5e-7
PASSAGE = 4.096e-3
"""Time compared, in which the roller moves by 12 degrees around the middle of the load zone [s]."""
SETTLING = 2e-3
START_AZIMUTH = -0.25
"""Azimuth at which the roller starts to settle, already loaded [rad]."""
SETTLING_BRISTLE_DAMPING = 0.1
"""Bristle damping while settling [s/m]: it removes the 35 kHz oscillation of the sticking roller, which a step of 8 us cannot resolve."""
FIXED = 1e12
"""Mass of a ring that does not move [kg]."""


def lone_roller() -> tuple[Payload, State]:
    """Return a bearing in which one roller passes the load zone; the five others rest in the gap without contact.

    The inner ring rotates at a fixed position; the outer ring moves on the housing. There are no bars, so the roller is driven by
    friction only.
    """
    configuration = Configuration.model_validate(
        {"bearing": {"rows": 1, "rollers_per_row": 6}, "cage": {"joint": "pocket"}, "operating": {"load": 30e3, "gravity": 0.0}}
    )
    payload = build_payload(configuration)._replace(step=SETTLING_STEP, inner_ring_mass=FIXED, broken=np.ones((1, 6), np.bool_))
    state = initial_state(configuration, payload)
    state.load[:] = state.target[1:] = 0.0
    state.cage_velocity[:] = 0.0
    state.roller_velocity[0, 1:] = 0.0
    state.roller_position[0, 1:] = 0.5 * (state.outer_position + state.inner_position)
    state.roller_position[0, 1:] += payload.pitch_radius * radial_directions(payload)[0, 1:]
    cosine, sine = math.cos(START_AZIMUTH), math.sin(START_AZIMUTH)
    turn = np.array([[cosine, -sine], [sine, cosine]])
    state.roller_position[0, 0] = state.outer_position + turn @ (state.roller_position[0, 0] - state.outer_position)
    state.roller_velocity[0, 0, :2] = turn @ state.roller_velocity[0, 0, :2]
    settling = payload._replace(bristle_damping=SETTLING_BRISTLE_DAMPING)
    steps = round(SETTLING / payload.step)
    advance(settling, state, workspace(payload), np.empty((steps, 2)), np.empty(steps))
    return payload, state


def with_step(payload: Payload, state: State, step: float) -> tuple[Payload, State]:
    """Return the payload and a copy of the state with another step [s]."""
    copy = copy_of(state)
    for change in (copy.change, copy.earlier_change, copy.roller_change):
        change *= step / payload.step
    return payload._replace(step=step), copy


def passage(payload: Payload, state: State) -> Floats:
    """Return the centres of outer ring and first roller at the common times, shape (times, 4) [m]."""
    work, steps = workspace(payload), round(COMMON / payload.step)
    places = []
    for _ in range(round(PASSAGE / COMMON)):
        advance(payload, state, work, np.empty((steps, 2)), np.empty(steps))
        places.append([*state.outer_position, *state.roller_position[0, 0]])
    if max(state.inner_force[0, 1:].max(), state.outer_force[0, 1:].max()) > 0.0 or state.inner_force[0, 0] == 0.0:
        raise RuntimeError("the first roller, and no other, must be in contact: check the parameters of the case")
    return np.array(places)


def orders() -> Iterator[Entry]:
    """Yield errors and order of convergence for the lone roller, without and with contact damping."""
    payload, state = lone_roller()
    for name, loss_time in (("friction", 0.0), ("friction and damping", payload.loss_time)):
        case = payload._replace(loss_time=loss_time)
        exact = passage(*with_step(case, state, EXACT_STEP))
        errors = [passage(*with_step(case, state, step)) - exact for step in ORDER_STEPS]
        for body, columns in (("outer ring", slice(0, 2)), ("roller", slice(2, 4))):
            sizes = [math.sqrt(float((error[:, columns] ** 2).sum(axis=1).mean())) for error in errors]
            order = float(np.polyfit(np.log(ORDER_STEPS), np.log(sizes), 1)[0])
            yield Entry((name, body, *(f"{1e12 * size:.4g}" for size in sizes), f"{order:.3f}"), 1.8 <= order <= 2.2)


# 2. Forces and waveform of a defect

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


def outer_defect(joint: str, *settings: str) -> Configuration:
    """Return the bench `dry` with a defect of 2 mm across both rows of the outer raceway."""
    return load_configuration("dry", ["faults.outer_1.width=0.002", f"cage.joint={joint}", *settings])


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


# 3. Statistics

SPAN = 3.0
LEFT_OUT = 0.2
LINE_WIDTH = 2.0
"""Search range to either side of 16 f_c [Hz]."""
MOST_SIZE, MOST_RATE = 0.05, 0.005
"""Relative tolerances of rms, kurtosis and line amplitude, and of line frequency and cage speed [-]."""
ONE_ROW = "faults.outer_1.row=1"
NEARBY = "operating.load=100000.001"
"""A load that differs by 1e-8, to show the scatter due to chaotic motion."""


class Statistics(NamedTuple):
    """Statistics of the vertical acceleration without noise, and of the cages."""

    rms: float
    """[m/s^2]."""
    kurtosis: float
    line_frequency: float
    """Frequency of the largest envelope line near 16 f_c [Hz]."""
    line_amplitude: float
    """[m/s^2]."""
    cage_speed: float
    """Mean rotation speed of the cages [rad/s]."""
    rows_apart: float
    """Largest angle between the cages [rad]."""


def statistics_of(configuration: Configuration) -> Statistics:
    """Return the statistics of a run."""
    blocks = list(Simulation(configuration).blocks(SPAN))
    rate, bearing = configuration.sensor.sampling_rate, configuration.bearing
    y = np.concatenate([block.clean for block in blocks])[round(LEFT_OUT * rate) :, 1].astype(np.float64)
    states = [states for block in blocks for states in block.states]
    rollers = bearing.rows * bearing.rollers_per_row
    cages = slice(rollers, rollers + bearing.rows)
    speed = float(np.mean([at.speed[cages] for at in states if at.time_ns >= LEFT_OUT * 1e9]))
    apart = wrapped(np.array([np.ptp(at.azimuth[cages]) for at in states]))
    line = envelope_spectrum(y, rate).line(bearing.rollers_per_row * speed / (2.0 * math.pi), LINE_WIDTH)
    return Statistics(float(y.std()), kurtosis(y), line.frequency, line.amplitude, speed, float(np.abs(apart).max()))


def statistics_entry(case: str, part: int, found: Statistics, exact: Statistics, held: bool) -> Entry:
    """Return a row of `statistics`: every value with its deviation from the exact one; it has a verdict if ``held``."""
    errors = [value / true - 1.0 for value, true in zip(found[:5], exact[:5], strict=True)]
    values = (f"{value:.5g} ({100.0 * error:+.2f} %)" for value, error in zip(found[:5], errors, strict=True))
    sizes, rates = (errors[0], errors[1], errors[3]), (errors[2], errors[4])
    within = max(map(abs, sizes)) <= MOST_SIZE and max(map(abs, rates)) <= MOST_RATE
    return Entry((case, step_name(part), *values, f"{math.degrees(found.rows_apart):.3f}"), within if held else None)


def statistics() -> Iterator[Entry]:
    """Yield the statistics for three steps, and for a slightly different load."""
    cases: tuple[tuple[str, str, tuple[str, ...]], ...] = (
        ("revolute", "revolute", ()),
        ("pocket", "pocket", ()),
        ("pocket, defect in one row", "pocket", (ONE_ROW,)),
    )
    for case, joint, settings in cases:

        def run(part: int, *more: str, joint: str = joint, settings: tuple[str, ...] = settings) -> Statistics:
            return statistics_of(outer_defect(joint, f"simulation.step={STEP / part!r}", *settings, *more))

        exact = run(4)
        yield statistics_entry(case, 4, exact, exact, False)
        for part in (2, 1):
            yield statistics_entry(case, part, run(part), exact, True)
        yield statistics_entry(f"{case}, load + 1e-8", 1, run(1, NEARBY), exact, False)


# 4. Energy

FRICTIONLESS = {"kinetic_coefficient": 0.0, "static_coefficient": 1e-9, "bristle_damping": 0.0, "bristle_stiffness": 1.0}
UNDAMPED: dict[str, Any] = {"contact": {"loss_time": 0.0}, "housing": {"damping": 0.0}, "friction": FRICTIONLESS}
BLOW = 0.02
"""Speed given to the inner ring [m/s]."""
WINDOW = 128
"""Steps over which the energy is averaged [-]; the energy of the leapfrog scheme oscillates with the phase of a mode within a step."""
MOST_DRIFT = 0.01


class Swing(NamedTuple):
    """A case without friction and damping, at rest until the inner ring gets an initial speed."""

    name: str
    cage: dict[str, Any]
    gravity: float
    """[m/s^2]."""
    windows: int
    """Length of the run in windows of the default step [-]."""
    blows: tuple[float, ...]
    """Speeds given to the inner ring [m/s]."""
    parts: tuple[int, ...]
    """Numbers of steps in a default step [-]."""


SWINGS = (
    Swing("revolute", {"joint": "revolute"}, 9.81, 8, (BLOW,), (1,)),
    Swing("pocket, no weight", {"joint": "pocket"}, 0.0, 8, (0.5 * BLOW, BLOW, 5.0 * BLOW), (1,)),
    Swing("pocket", {"joint": "pocket"}, 9.81, 8, (0.5 * BLOW, BLOW, 2.5 * BLOW, 5.0 * BLOW), (1, 4)),
)


def mechanical_energy(payload: Payload, state: State) -> float:
    """Return the kinetic and potential energy of a bearing with smooth raceways at the end of a step [J]."""
    place_pinned_rollers(payload, state)
    _, _, *depths = penetrations(payload, state.outer_position, state.inner_position, state.roller_position)
    energy = kinetic_energy(payload, state) + potential_of_weight(payload, state) - float(state.load @ state.inner_position)
    energy += 0.5 * payload.housing_stiffness * float(state.outer_position @ state.outer_position)
    energy += energy_of_bars(payload, state) + energy_of_lands(payload, state)
    sites = (payload.inner, payload.outer)
    return energy + sum(float(stored_energy(payload, depth, site).sum()) for depth, site in zip(depths, sites, strict=True))


def drift(case: Swing, blow: float, part: int) -> tuple[float, float]:
    """Return the largest change of the mean energy in a window, relative to the excitation and to the energy of the blow [-].

    Without friction the cages fall onto their lands and into the rollers; the work of their weight is a part of the excitation.
    """
    cage = {"restitution": 1.0, **case.cage}
    configuration = Configuration.model_validate({**UNDAMPED, "operating": {"speed": 0.0, "gravity": case.gravity}, "cage": cage})
    payload = build_payload(configuration)._replace(step=STEP / part)
    state, work = initial_state(configuration, payload), workspace(payload)
    state.inner_velocity[1] = -blow

    def height() -> float:
        """Return the potential energy of the cages and the rollers in pockets, which can fall [J]."""
        rings = payload.outer_ring_mass * state.outer_position[1] + payload.inner_ring_mass * state.inner_position[1]
        return potential_of_weight(payload, state) - payload.gravity * float(rings) if payload.any_free else 0.0

    energies, heights = [], [height()]
    for _ in range(WINDOW * case.windows * part):
        advance(payload, state, work, np.empty((1, 2)), np.empty(1))
        energies.append(mechanical_energy(payload, state))
        heights.append(height())
    means = np.array(energies).reshape(case.windows, -1).mean(axis=1)
    changed, struck = float(np.abs(means - means[0]).max()), 0.5 * payload.inner_ring_mass * blow**2
    return changed / (struck + heights[0] - min(heights)), changed / struck


def drifts() -> Iterator[Entry]:
    """Yield the drift of the energy for every case."""
    for case, blow, part in ((swing, blow, part) for swing in SWINGS for blow in swing.blows for part in swing.parts):
        found = drift(case, blow, part)
        cells = (case.name, f"{blow:g}", step_name(part), f"{1e3 * WINDOW * case.windows * STEP:.2f}", *map(percent, found))
        yield Entry(cells, found[0] < MOST_DRIFT if part == 1 else None)


def order_table() -> bool:
    """Print the order of convergence."""
    heads = ("case", "body", *(f"{1e6 * step:g} us [pm]" for step in ORDER_STEPS), "order")
    return print_table("Order of convergence, one roller in the load zone", "Error of positions; order within 1.8 .. 2.2.", heads, orders())


def path_table() -> bool:
    """Print the errors of a defect's forces and waveform."""
    heads = ("joint", "step [us]", "interval", "roller forces", "total forces", "waveform")
    tolerance = (
        f"Relative rms error compared with a step of {1e6 * FINE_STEP:g} us from the same start. Tolerances at the default step: forces "
        f"{100.0 * MOST_FORCE:g} %, waveform {100.0 * MOST_WAVEFORM:g} %, over both bursts and, with `revolute`, over 12 ms. With "
        "`pocket`, idle rollers rattle between the bursts, and no step reproduces their individual paths."
    )
    return print_table("Outer ring defect, forces and waveform", tolerance, heads, paths())


def statistics_table() -> bool:
    """Print the statistics over seconds."""
    units = ("rms [m/s^2]", "kurtosis [-]", "line [Hz]", "line [m/s^2]", "cage speed [rad/s]")
    tolerance = (
        f"{SPAN:g} s with the default step h compared with h/4: rms, kurtosis and line amplitude within {100.0 * MOST_SIZE:g} %, "
        f"line frequency and cage speed within {100.0 * MOST_RATE:g} %. Rows in phase start identically and stay so, so their rollers "
        "strike together. Any difference lets free rows drift apart, and rms and kurtosis depend on the angle between them."
    )
    heads = ("case", "step", *units, "rows apart [deg]")
    return print_table("Outer ring defect, statistics", tolerance, heads, statistics())


def energy_table() -> bool:
    """Print the drift of the energy."""
    heads = ("case", "initial speed [m/s]", "step", "time [ms]", "drift", "relative to the blow")
    tolerance = (
        f"Without friction and damping, after a blow to the inner ring, means over {1e3 * WINDOW * STEP:g} ms. Tolerance at the default "
        f"step h: {100.0 * MOST_DRIFT:g} % of the energy of the blow and of the falling bodies."
    )
    return print_table("Energy", tolerance, heads, drifts())


def main() -> int:
    """Print the tables; return 1 if a tolerance is exceeded."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="leave out the statistics over seconds")
    quick = parser.parse_args().quick
    passed = [order_table(), path_table(), True if quick else statistics_table(), energy_table()]
    return 0 if all(passed) else 1


if __name__ == "__main__":
    sys.exit(main())
