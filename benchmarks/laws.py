"""Cost of a step by the laws of lubrication and surfaces, relative to the dry, smooth bearing in the same run.

The benches take turns, run after run, so that other load on the machine meets all of them; the medians of their ratios count. Time is that
of the processor; where others share its caches, the ratio of the fastest runs is nearer to that of a quiet machine.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable

import numpy as np

from dcrb_ros.bearing.payload import build_payload, initial_state
from dcrb_ros.core.layout.workspace import workspace
from dcrb_ros.core.solver.step import advance
from dcrb_ros.settings.files import load_configuration

SETTLING = 0.1
"""Simulated time before the measurement [s]."""
FILM = ("lubrication.law=film", "friction.convection=0.7", "contact.loss_time=1e-5")
PROFILE = ("surfaces.law=profile",)
LAWS = {"dry": (), "film": FILM, "profile": PROFILE, "film and profile": (*FILM, *PROFILE)}
"""Settings by law; the first one is what the others are compared with."""


def stepping(bench: str, settings: tuple[str, ...], duration: float) -> tuple[Callable[[], float], float]:
    """Return a function that runs the kernel and returns the time of a step [us], and the length of a step [us]."""
    configuration = load_configuration(bench, settings)
    payload = build_payload(configuration)
    state, work = initial_state(configuration, payload), workspace(payload)
    steps = round(duration / payload.step)
    acceleration, angles = np.empty((steps, 2)), np.empty(steps)

    def run() -> float:
        begin = time.process_time()
        advance(payload, state, work, acceleration, angles)
        return 1e6 * (time.process_time() - begin) / steps

    for _ in range(max(1, round(SETTLING / duration))):
        run()
    return run, 1e6 * payload.step


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bench", default="dry")
    parser.add_argument("--runs", type=int, default=41)
    parser.add_argument("--duration", type=float, default=0.05, help="simulated time of a run [s]")
    parser.add_argument("--set", action="append", default=[], help="parameter=value for all of them")
    options = parser.parse_args()
    made = {name: stepping(options.bench, (*settings, *options.set), options.duration) for name, settings in LAWS.items()}
    times: dict[str, list[float]] = {name: [] for name in made}
    for _ in range(options.runs):
        for name, (run, _) in made.items():
            times[name].append(run())
    first = times[next(iter(times))]
    print("| laws | us per step | of the first | fastest [us] | of the first | x real time |")
    print("|---|---|---|---|---|---|")
    for name, found in times.items():
        ratio = statistics.median(one / other for one, other in zip(found, first, strict=True))
        step, fastest = statistics.median(found), min(found)
        print(f"| {name} | {step:.2f} | {ratio:.2f} | {fastest:.2f} | {fastest / min(first):.2f} | {made[name][1] / step:.2f} |")


if __name__ == "__main__":
    main()
