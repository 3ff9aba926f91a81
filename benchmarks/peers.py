"""Speed and accuracy of other solvers for the same bearing: the paper's formulation, and general solvers of the paper's equations.

All runs start from the same state, with pinned rollers and an outer-ring defect. The velocity of the outer ring at the end is compared
with that of the production solver at a twentieth of its step; times are processor times of one thread. Exudyn has a table of its own,
since it supports only a part of the model.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import Literal, NamedTuple

import exudyn_bearing
import numpy as np
from scipy.integrate import solve_ivp

from dcrb_ros.bearing.payload import build_payload, initial_state
from dcrb_ros.core.layout.workspace import workspace
from dcrb_ros.core.solver.step import advance
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.settings.parameters import SimulationParameters
from dcrb_ros.validation.reference.bodies import OUTER_RING
from dcrb_ros.validation.reference.solver import ReferenceSolver, State

CONFIGURATION = load_configuration("dry", ["faults.outer_1.width=0.002", "cage.joint=revolute"])
STEP = SimulationParameters().step
"""The default step [s]."""
FINE = 20
"""Number of steps of the exact run in a default step [-]."""
REFERENCE_STEP = 1e-6
"""Longest step at which the paper's scheme is accurate with stiff friction [s]."""
TOLERANCE = 1e-6
"""Relative tolerance of the general solvers, chosen so that their error does not exceed that of the default step [-]."""
SCALES = (1e-9, 1e-6, 1e-10)
"""Relevant differences of a position, a velocity and a bristle deflection [m, m/s, m]."""


class Peer(NamedTuple):
    """Cost and result of a solver."""

    name: str
    seconds: float
    """Processor time [s]."""
    simulated: float
    """[s]."""
    velocity: Floats
    """Velocity of the outer ring at the end, shape (2,) [m/s]."""


def production(duration: float, part: int, repeat: int = 1) -> Peer:
    """Return the result of the production solver at 1 / ``part`` of the default step, with the time of the last of ``repeat`` runs."""
    for _ in range(repeat):
        payload = build_payload(CONFIGURATION)._replace(step=STEP / part)
        state, work, steps = initial_state(CONFIGURATION, payload), workspace(payload), round(duration / STEP) * part
        acceleration, angles = np.empty((steps, 2)), np.empty(steps)
        begin = time.process_time()
        advance(payload, state, work, acceleration, angles)
        seconds = time.process_time() - begin
    name = "production, default step" if part == 1 else f"production, 1/{part} of it"
    return Peer(name, seconds, steps * STEP / part, state.outer_velocity.copy())


def paper(duration: float) -> Peer:
    """Return the result of the paper's formulation with its Runge-Kutta scheme."""
    reference = ReferenceSolver(CONFIGURATION)
    begin = time.process_time()
    reference.advance(duration, duration / round(duration / REFERENCE_STEP))
    seconds = time.process_time() - begin
    name = f"111 coordinates, multipliers, RK4 at {1e6 * REFERENCE_STEP:g} us"
    return Peer(name, seconds, duration, reference.state.velocity[OUTER_RING, :2].copy())


def general(duration: float, method: Literal["RK45", "LSODA", "Radau"]) -> Peer:
    """Return the result of a solver of scipy for the paper's equations."""
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
    found = solve_ivp(rate, (0.0, duration), joined(reference.state), method=method, rtol=TOLERANCE, atol=absolute)
    seconds = time.process_time() - begin
    name = f"scipy {method}, {found.nfev} evaluations"
    return Peer(name, seconds, duration, split(found.y[:, -1]).velocity[OUTER_RING, :2])


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=30, help="number of default steps simulated with the slow solvers")
    duration = parser.parse_args().steps * STEP
    production(STEP, 1)
    exact = production(duration, FINE)
    runs: list[Callable[[], Peer]] = [lambda: paper(duration), *(lambda m=m: general(duration, m) for m in ("RK45", "LSODA", "Radau"))]
    own, long = production(duration, 1), production(1.0, 1, 3)
    rates = {own.name: long.simulated / long.seconds}
    print("| solver | x real time | production solver is faster by | error of the outer ring's velocity |\n|---|---|---|---|")
    for peer in (own, *(run() for run in runs)):
        rate = rates.get(peer.name, peer.simulated / peer.seconds)
        error = np.linalg.norm(peer.velocity - exact.velocity) / np.linalg.norm(exact.velocity)
        print(f"| {peer.name} | {rate:.3g} | {rates[own.name] / rate:.3g} | {100.0 * error:.2f} % |", flush=True)
    exudyn_bearing.main()


if __name__ == "__main__":
    main()
