"""Cost of the phases of a step: a copy of the time loop that reads the processor's clock between the phases.

Reading the clock prevents the phases from overlapping on the processor, so the step takes slightly longer than without it.
"""

from __future__ import annotations

import itertools
import time
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from dcrb_ros.bearing.payload import build_payload, initial_state
from dcrb_ros.core.contacts.conformal import linearize_cages, store_lands
from dcrb_ros.core.contacts.films import write_films
from dcrb_ros.core.contacts.notch import turn_notches
from dcrb_ros.core.contacts.raceway import linearize_raceways, locate_raceways
from dcrb_ros.core.jit import loop
from dcrb_ros.core.layout.records import Floats
from dcrb_ros.core.layout.state import State
from dcrb_ros.core.layout.workspace import Workspace, workspace
from dcrb_ros.core.payload import Payload
from dcrb_ros.core.solver.bodies import drift, finish_bodies, predict_bodies
from dcrb_ros.core.solver.step import advance, advance_unbound, clear, find_bound, solve, write_pockets
from dcrb_ros.core.solver.update import store_bound
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration

PHASES = ("geometry", "free rollers", "raceways", "bars and lands", "linear solve", "integration")
"""Free rollers that are not bound are advanced in a single loop; the following phases treat the bound ones, the rings and the cages.
Normal force and friction at the raceways share a loop, so that memory is traversed once."""
SETTLING, DURATION = 0.1, 0.5
"""Simulated time before the measurement, and of the measurement [s]."""
BENCHES = {
    "healthy": (),
    "outer ring defect": ("faults.outer_1.width=0.002",),
    "inner ring defect": ("faults.inner_1.width=0.002",),
    "broken bars": ("faults.broken_bars=row1/bar15, row2/bar15",),
}
"""Settings of the bench `dry`."""
JOINTS = ("revolute", "pocket")


@intrinsic
def ticks(typingctx: Any) -> Any:
    """Return the processor's clock."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        clock = builder.module.declare_intrinsic("llvm.readcyclecounter", fnty=ir.FunctionType(ir.IntType(64), []))
        return builder.call(clock, [])

    return types.int64(), codegen


@loop
def advance_by_phases(payload: Payload, state: State, work: Workspace, steps: int, spent: Floats) -> None:
    """Advance the state at constant speed and load; add the ticks of each phase to ``spent``, shape (phases,)."""
    write_pockets(payload, state)
    turn_notches(payload.outer_notches, 0.0, work.outer_notch_direction)
    for _ in range(steps):
        t0 = ticks()  # type: ignore[call-arg, var-annotated]
        drift(payload, state, 0.5 * payload.step)
        predict_bodies(payload, state, work)
        write_films(payload, state)
        clear(work.force_of_free)
        t1 = ticks()
        turn_notches(payload.inner_notches, state.shaft[0], work.inner_notch_direction)
        count = find_bound(payload, state, work)
        t2 = ticks()
        advance_unbound(payload, state, work)
        t3 = ticks()
        locate_raceways(payload, state, work, count)
        t4 = ticks()
        linearize_raceways(payload, state, work, count)
        t5 = ticks()
        lands = linearize_cages(payload, state, work, count)
        t6 = ticks()
        solve(payload, state, work, count, lands)
        t7 = ticks()
        store_bound(payload, state, work, count)
        store_lands(payload, state, work, lands)
        finish_bodies(payload, state, work)
        drift(payload, state, 0.5 * payload.step)
        t8 = ticks()
        spent[0] += t2 - t1 + t4 - t3
        spent[1] += t3 - t2
        spent[2] += t5 - t4
        spent[3] += t6 - t5
        spent[4] += t7 - t6
        spent[5] += t8 - t7 + t1 - t0


def costs(configuration: Configuration) -> tuple[Floats, float, float]:
    """Return the cost of the phases, of a step with clock readings, and of a step without them [us]."""
    payload = build_payload(configuration)
    state, work = initial_state(configuration, payload), workspace(payload)
    settling, steps = round(SETTLING / payload.step), round(DURATION / payload.step)
    acceleration, angles = np.empty((steps, 2)), np.empty(steps)
    advance(payload, state, work, acceleration[:settling], angles[:settling])
    advance_by_phases(payload, state, work, 1, np.zeros(len(PHASES)))
    start = time.perf_counter()
    advance(payload, state, work, acceleration, angles)
    plain, spent = 1e6 * (time.perf_counter() - start) / steps, np.zeros(len(PHASES))
    start = time.perf_counter()
    advance_by_phases(payload, state, work, steps, spent)
    timed = 1e6 * (time.perf_counter() - start) / steps
    return spent / spent.sum() * timed, timed, plain


def main() -> None:
    """Print a table."""
    print("| bench | joint | " + " | ".join(f"{name} [us]" for name in (*PHASES, "sum", "step")) + " |")
    print("|---|---|" + "---|" * (len(PHASES) + 2))
    for (name, settings), joint in itertools.product(BENCHES.items(), JOINTS):
        phases, timed, plain = costs(load_configuration("dry", [f"cage.joint={joint}", *settings]))
        print(f"| {name} | {joint} | " + " | ".join(f"{cost:.2f}" for cost in (*phases, timed, plain)) + " |", flush=True)


if __name__ == "__main__":
    main()
