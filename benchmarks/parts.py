"""Cost of the parts of a step by the laws of lubrication and surfaces: a copy of the time loop that reads the processor's clock in between.

The benches take turns, so that other load on the machine meets all of them; the faster third counts. Reading the clock prevents the parts
from overlapping on the processor. `phases.py` does the same, more coarsely, for dry benches.
"""

from __future__ import annotations

import argparse
import time

import numpy as np
from phases import ticks

from dcrb_ros.bearing.payload import build_payload, initial_state
from dcrb_ros.core.contacts.cage_films import add_land_films, drag_bound, store_land_films, write_spin_drag
from dcrb_ros.core.contacts.conformal import add_land_forces, linearize_cages, store_lands
from dcrb_ros.core.contacts.films import write_films
from dcrb_ros.core.contacts.lines import RingMotion
from dcrb_ros.core.contacts.notch import turn_notches
from dcrb_ros.core.contacts.raceway import linearize_crossing, linearize_smooth, locate_raceways
from dcrb_ros.core.contacts.surface import add_bound_heights, add_parts, write_free_heights
from dcrb_ros.core.jit import NO, ZERO, loop
from dcrb_ros.core.laws.calls import has_cage_oil
from dcrb_ros.core.layout.records import Floats
from dcrb_ros.core.layout.state import INNER, OUTER, State
from dcrb_ros.core.layout.workspace import Workspace, workspace
from dcrb_ros.core.payload import Payload
from dcrb_ros.core.solver.bodies import add_preload, book_preload, drift, finish_bodies, move_cage, move_rings, predict_bodies
from dcrb_ros.core.solver.bound import prepare_bound, solve_bound, sum_bound_forces
from dcrb_ros.core.solver.classification import bind_special, classify_rollers, gather_bound, list_bound, predict_bound
from dcrb_ros.core.solver.step import CONVERGED, CONVERGED_AT_REST, MOST_SWEEPS, advance, advance_unbound, clear, write_pockets
from dcrb_ros.core.solver.update import store_bound
from dcrb_ros.settings.files import load_configuration

PARTS = (
    "films, drag of the bars on the spin",
    "classification, drift, prediction",
    "heights under all rollers, outer raceway",
    "heights under bound rollers",
    "free rollers",
    "gathering the bound ones",
    "forces at raceways",
    "bars and lands",
    "linear solve",
    "results, energy, integration",
)
DRY, FILM, SMOOTH = "lubrication.law=dry", "lubrication.law=film", "surfaces.law=smooth"
CASES: dict[str, tuple[str, tuple[str, ...]]] = {
    "dry": ("dry", ()),
    "healthy: dry, smooth": ("healthy", (DRY, SMOOTH)),
    "dry, profile": ("healthy", (DRY,)),
    "film, profile": ("healthy", (FILM,)),
    "oil on cages, smooth": ("healthy", (SMOOTH,)),
    "healthy": ("healthy", ()),
}
"""Bench and settings by name."""
SETTLING, STEPS = 10240, 1024
"""Steps before the measurement, and of a turn."""


@loop
def advance_by_parts(payload: Payload, state: State, work: Workspace, steps: int, spent: Floats, counts: Floats) -> None:
    """Advance the state at constant speed and load; add the ticks of each part to ``spent``, shape (parts,).

    Adds bound rollers, elements of their loops and sweeps to ``counts``, shape (3,).
    """
    write_pockets(payload, state)
    turn_notches(payload.outer_notches, 0.0, work.outer_notch_direction)
    for _ in range(steps):
        t0 = ticks()  # type: ignore[call-arg, var-annotated]
        drift(payload, state, 0.5 * payload.step)
        predict_bodies(payload, state, work)
        t1 = ticks()
        write_films(payload, state)
        if has_cage_oil(payload.lubrication):
            write_spin_drag(payload, state, work)
        clear(work.force_of_free)
        if payload.suspended:
            add_preload(payload, state, work)
        t2 = ticks()
        turn_notches(payload.inner_notches, state.shaft[0], work.inner_notch_direction)
        classify_rollers(payload, state, work, NO)
        t3 = ticks()
        write_free_heights(payload.surfaces, payload, state, work)
        t4 = ticks()
        bind_special(payload, work)
        found = ZERO
        for row in range(payload.free.shape[0]):
            found = list_bound(payload, work, row, found)
            work.row_ends[row] = found
        count = gather_bound(payload, state, work, found)
        predict_bound(payload, state, work, count)
        if has_cage_oil(payload.lubrication):
            drag_bound(payload, work, count)
        t5 = ticks()
        advance_unbound(payload, state, work)
        t6 = ticks()
        locate_raceways(payload, state, work, count)
        mean, before, speed = work.mean_velocity, state.velocity, state.shaft[1]
        outer = RingMotion((mean[OUTER, 0], mean[OUTER, 1]), (before[OUTER, 0], before[OUTER, 1]), 0.0, 0.0, False)
        surface = speed * payload.inner_raceway_radius
        inner = RingMotion((mean[INNER, 0], mean[INNER, 1]), (before[INNER, 0], before[INNER, 1]), speed, surface, True)
        t7 = ticks()
        add_bound_heights(payload.surfaces, payload, state, work, work.bound[0].outer, outer)
        add_bound_heights(payload.surfaces, payload, state, work, work.bound[0].inner, inner)
        t8 = ticks()
        linearize_smooth(payload, state, work, work.bound[0].outer, count, outer)
        linearize_smooth(payload, state, work, work.bound[0].inner, count, inner)
        linearize_crossing(payload, state, work, work.bound[0].outer, outer)
        linearize_crossing(payload, state, work, work.bound[0].inner, inner)
        add_parts(payload.surfaces, payload, state, work, work.bound[0].outer, outer)
        add_parts(payload.surfaces, payload, state, work, work.bound[0].inner, inner)
        t9 = ticks()
        lands = linearize_cages(payload, state, work, count)
        t10 = ticks()
        prepare_bound(payload, work, count)
        h = payload.step
        for _ in range(MOST_SWEEPS):
            counts[2] += 1
            solve_bound(payload, work, count, surface)
            sum_bound_forces(payload, work)
            add_land_forces(payload, work, lands)
            if has_cage_oil(payload.lubrication):
                add_land_films(payload, work)
            moved, changed = move_rings(payload, state, work)
            for row in range(payload.free.shape[0]):
                moved = max(moved, move_cage(payload, state, work, row))
            if moved < h * h * (CONVERGED * changed + CONVERGED_AT_REST * h):
                break
        t11 = ticks()
        store_bound(payload, state, work, count)
        store_lands(payload, state, work, lands)
        if has_cage_oil(payload.lubrication):
            store_land_films(payload, state, work)
        finish_bodies(payload, state, work)
        if payload.suspended:
            book_preload(payload, state, work)
        drift(payload, state, 0.5 * payload.step)
        t12 = ticks()
        counts[0] += found
        counts[1] += count
        spent[0] += t2 - t1
        spent[1] += t1 - t0 + t3 - t2
        spent[2] += t4 - t3
        spent[3] += t8 - t7
        spent[4] += t6 - t5
        spent[5] += t5 - t4 + t7 - t6
        spent[6] += t9 - t8
        spent[7] += t10 - t9
        spent[8] += t11 - t10
        spent[9] += t12 - t11


def started(bench: str, settings: tuple[str, ...]) -> tuple[Payload, State, Workspace]:
    """Return a bench that runs, with everything compiled."""
    configuration = load_configuration(bench, settings)
    payload = build_payload(configuration)
    state, work = initial_state(configuration, payload), workspace(payload)
    advance(payload, state, work, np.empty((SETTLING, 2)), np.empty(SETTLING))
    advance_by_parts(payload, state, work, 1, np.zeros(len(PARTS)), np.zeros(3))
    return payload, state, work


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--turns", type=int, default=60)
    turns = parser.parse_args().turns
    benches = {name: started(*case) for name, case in CASES.items()}
    spent = {name: np.zeros((turns, len(PARTS))) for name in benches}
    counts, ticked, elapsed = {name: np.zeros(3) for name in benches}, 0.0, 0.0
    for turn in range(turns):
        for name, bench in benches.items():
            begin = time.perf_counter()
            advance_by_parts(*bench, STEPS, spent[name][turn], counts[name])
            elapsed += time.perf_counter() - begin
            ticked += float(spent[name][turn].sum())
    by_tick = 1e9 * elapsed / ticked / STEPS
    costs = {name: by_tick * np.median(np.sort(found, axis=0)[: max(1, turns // 3)], axis=0) for name, found in spent.items()}
    print("| part [ns] | " + " | ".join(costs) + " |\n" + "|---" * (1 + len(costs)) + "|")
    for part, name in enumerate(PARTS):
        print(f"| {name} | " + " | ".join(f"{cost[part]:.0f}" for cost in costs.values()) + " |")
    print("| sum | " + " | ".join(f"{cost.sum():.0f}" for cost in costs.values()) + " |")
    for at, name in enumerate(("bound rollers", "elements of their loops", "sweeps")):
        print(f"| {name} | " + " | ".join(f"{count[at] / turns / STEPS:.2f}" for count in counts.values()) + " |")


if __name__ == "__main__":
    main()
