"""Real-time factor of the kernel, of the block loop with sensor chain and encoding, and of a simulation with recording.

Medians of several runs in one process; run it on an otherwise idle machine.
"""

from __future__ import annotations

import argparse
import itertools
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from dcrb_ros.bearing.payload import build_payload, initial_state
from dcrb_ros.core.layout.workspace import workspace
from dcrb_ros.core.solver.step import advance
from dcrb_ros.messages.encoder import BlockEncoder
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.runtime.prefetch import WRITING_DEPTH, prefetch
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.simulation.loop import Simulation

WARM_UP = 0.2
"""Simulated time before every measurement, during which the kernels are compiled [s]."""
RECORDING_FACTOR = 5
"""Factor by which runs with a recording are longer [-]; opening and closing a recording takes 40 ms."""
BENCHES = {
    "healthy": (),
    "healthy, heat and tacho": ("thermal.law=network", "tacho.pulses_per_turn=60"),
    "outer_ring_defect": (),
    "dry": (),
    "dry, outer ring defect": ("faults.outer_1.width=0.002",),
    "dry, inner ring defect": ("faults.inner_1.width=0.002",),
    "dry, broken bars": ("faults.broken_bars=row1/bar15, row2/bar15",),
    "dry, 48 rpm": ("operating.speed=5.0",),
}
"""Settings by bench. On a slow shaft, idle rollers rest on their bars, so more rollers are bound."""
JOINTS = ("revolute", "pocket")


def kernel(configuration: Configuration) -> Callable[[float], None]:
    """Return a function that runs the kernel for a simulated time [s]."""
    payload = build_payload(configuration)
    state, work = initial_state(configuration, payload), workspace(payload)

    def run(duration: float) -> None:
        steps = round(duration / payload.step)
        advance(payload, state, work, np.empty((steps, 2)), np.empty(steps))

    return run


def blocks(configuration: Configuration) -> Callable[[float], None]:
    """Return a function that simulates and encodes blocks for a simulated time [s]."""
    simulation = Simulation(configuration)
    encoder = BlockEncoder(configuration, simulation.bodies)

    def run(duration: float) -> None:
        for block in simulation.blocks(duration):
            encoder.encode(block)

    return run


def recorded(configuration: Configuration) -> Callable[[float], None]:
    """Return a function that simulates and records like ``dcrb simulate`` for a simulated time [s]."""
    simulation = Simulation(configuration)

    def run(duration: float) -> None:
        with tempfile.TemporaryDirectory() as folder, Recorder(Path(folder) / "bag", configuration, simulation.bodies) as recorder:
            for block in prefetch(simulation.blocks(duration), depth=WRITING_DEPTH):
                recorder.write(block)

    return run


def factors(run: Callable[[float], None], duration: float, runs: int) -> list[float]:
    """Return the real-time factor of each run [-]."""
    run(WARM_UP)
    speeds = []
    for _ in range(runs):
        begin = time.perf_counter()
        run(duration)
        speeds.append(duration / (time.perf_counter() - begin))
    return speeds


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=7)
    parser.add_argument("--duration", type=float, default=1.0, help="simulated time of a run [s]")
    options = parser.parse_args()
    print("| bench | joint | part | median x real time | smallest | largest | us per step | of the kernel |")
    print("|---|---|---|---|---|---|---|---|")
    for (name, settings), joint in itertools.product(BENCHES.items(), JOINTS):
        configuration = load_configuration(name.partition(",")[0], [f"cage.joint={joint}", *settings])
        alone = 0.0
        parts = (("kernel", kernel, 1), ("blocks, encoded", blocks, 1), ("simulate, recorded", recorded, RECORDING_FACTOR))
        for part, make, longer in parts:
            speeds = factors(make(configuration), longer * options.duration, options.runs)
            median = statistics.median(speeds)
            alone = alone or median
            step, share = 1e6 / (median * configuration.step_rate), 100.0 * median / alone
            spread = f"{min(speeds):.2f} | {max(speeds):.2f}"
            print(f"| {name} | {joint} | {part} | {median:.2f} | {spread} | {step:.2f} | {share:.0f} % |", flush=True)


if __name__ == "__main__":
    main()
