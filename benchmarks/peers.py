"""What others take for the same bearing: the paper's formulation, and general solvers on the paper's equations.

All start alike, with pinned rollers and an outer-ring defect. What is compared is the waveform up to a common end, against the
production solver at a twentieth of its step; processor time, one thread. Exudyn gets a table of its own: it cannot do all of that.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import NamedTuple

import exudyn_bearing
import numpy as np
from scipy.integrate import solve_ivp

from dcrb_ros.bearing.payload import build_payload, initial_state
from dcrb_ros.core.layout.workspace import workspace
from dcrb_ros.core.solver.step import advance
from dcrb_ros.reference.bodies import OUTER_RING
from dcrb_ros.reference.solver import ReferenceSolver, State
from dcrb_ros.runtime.arrays import Floats
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.settings.parameters import SimulationParameters

CONFIGURATION = load_configuration("outer_ring_defect", ["cage.joint=revolute"])
STEP = SimulationParameters().step
"""The default step [s]."""
FINE = 20
"""Steps of the yardstick in a default step [-]."""
REFERENCE_STEP = 1e-6
"""Longest step that the paper's scheme takes through stiff friction without error [s]."""
TOLERANCE = 1e-6
"""Relative tolerance of the general solvers, chosen so that their error is that of the default step or less [-]."""
SCALES = (1e-9, 1e-6, 1e-10)
"""What counts of a place, a velocity and a bristle [m, m/s, m]."""


class Peer(NamedTuple):
    """What a solver took and found."""

    name: str
    seconds: float
    """Processor time [s]."""
    simulated: float
    """[s]."""
    velocity: Floats
    """Of the outer ring at the end, shape (2,) [m/s]."""


def production(duration: float, part: int, repeat: int = 1) -> Peer:
    """Return our own solver at a part of the default step, the time of the last of ``repeat`` runs."""
    for _ in range(repeat):
        payload = build_payload(CONFIGURATION)._replace(step=STEP / part)
        state, work, steps = initial_state(CONFIGURATION, payload), workspace(payload), round(duration / STEP) * part
        room, angles = np.empty((steps, 2)), np.empty(steps)
        begin = time.process_time()
        advance(payload, state, work, room, angles)
        seconds = time.process_time() - begin
    return Peer("ours, default step" if part == 1 else f"ours, 1/{part} of it", seconds, steps * STEP / part, state.outer_velocity.copy())


def paper(duration: float) -> Peer:
    """Return the paper's formulation with its Runge-Kutta scheme."""
    reference = ReferenceSolver(CONFIGURATION)
    begin = time.process_time()
    reference.advance(duration, duration / round(duration / REFERENCE_STEP))
    seconds = time.process_time() - begin
    name = f"111 coordinates, multipliers, RK4 at {1e6 * REFERENCE_STEP:g} us"
    return Peer(name, seconds, duration, reference.state.velocity[OUTER_RING, :2].copy())


def general(duration: float, method: str) -> Peer:
    """Return a solver of scipy on the paper's equations."""
    reference = ReferenceSolver(CONFIGURATION)
    shapes = [part.shape for part in reference.state]
    sizes = np.cumsum([part.size for part in reference.state])[:-1]

    def joined(state: State) -> Floats:
        return np.concatenate([part.ravel() for part in state])

    def split(values: Floats) -> State:
        return State(*(part.reshape(shape) for part, shape in zip(np.split(values, sizes), shapes, strict=True)))

    def rate(moment: float, values: Floats) -> Floats:
        return joined(reference.rate(moment, split(values))[0])

    absolute = TOLERANCE * 1e3 * joined(State(*(np.full(shape, scale) for shape, scale in zip(shapes, SCALES, strict=True))))
    begin = time.process_time()
    found = solve_ivp(rate, (0.0, duration), joined(reference.state), method, rtol=TOLERANCE, atol=absolute)
    seconds = time.process_time() - begin
    name = f"scipy {method}, {found.nfev} evaluations"
    return Peer(name, seconds, duration, split(found.y[:, -1]).velocity[OUTER_RING, :2])


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=30, help="default steps simulated by the slow ones [-]")
    duration = parser.parse_args().steps * STEP
    production(STEP, 1)
    exact = production(duration, FINE)
    runs: list[Callable[[], Peer]] = [lambda: paper(duration), *(lambda m=m: general(duration, m) for m in ("RK45", "LSODA", "Radau"))]
    ours, long = production(duration, 1), production(1.0, 1, 3)
    rates = {ours.name: long.simulated / long.seconds}
    print("| solver | x real time | ours is faster by | error of the outer ring's velocity |\n|---|---|---|---|")
    for peer in (ours, *(run() for run in runs)):
        rate = rates.get(peer.name, peer.simulated / peer.seconds)
        error = np.linalg.norm(peer.velocity - exact.velocity) / np.linalg.norm(exact.velocity)
        print(f"| {peer.name} | {rate:.3g} | {rates[ours.name] / rate:.3g} | {100.0 * error:.2f} % |", flush=True)
    exudyn_bearing.main()


if __name__ == "__main__":
    main()
