"""Speed of the kernel and of the programs around it, in simulated seconds per second of processor time, as Markdown tables.

All rows of a table run in turn, so that a ratio is that of neighbouring runs; each figure is the median over the rounds.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from dcrb_ros.bearing.payload import build_payload, initial_state
from dcrb_ros.core.layout.workspace import workspace
from dcrb_ros.core.solver.step import advance
from dcrb_ros.measurement.sensor import Sensor
from dcrb_ros.messages.encoder import BlockEncoder
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.runtime.prefetch import WRITING_DEPTH, prefetch
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.simulation.loop import Simulation

WARM_UP = 0.2
"""Simulated time before every measurement, during which the kernels are compiled [s]."""
RECORDING_FACTOR = 4
"""Factor by which runs with a recording are longer [-]; opening and closing a recording takes 40 ms."""
REVOLUTE = "cage.joint=revolute"
SMOOTH = "surfaces.law=smooth"
BENCHES: dict[str, tuple[str, ...]] = {
    "dry": (),
    "dry, outer-ring defect": ("faults.outer_1.width=0.002",),
    "dry, broken bars": ("faults.broken_bars=row1/bar15, row2/bar15",),
    "dry, 48 rpm": ("operating.speed=5.0",),
    "dry, pinned rollers": (REVOLUTE,),
    "healthy": (),
    "healthy, smooth surfaces": (SMOOTH,),
    "healthy, oil at raceways only": ("lubrication.law=film",),
    "healthy, smooth surfaces, oil at raceways only": (SMOOTH, "lubrication.law=film"),
    "healthy, smooth surfaces, no oil": (SMOOTH, "lubrication.law=dry"),
    "healthy, heat and tacho": ("thermal.law=network", "tacho.pulses_per_turn=60"),
    "healthy, pinned rollers": (REVOLUTE,),
    "outer_ring_defect": (),
}
"""Settings by bench. On a slow shaft, idle rollers rest on their bars, so more rollers are bound."""
WHOLE = ("dry", "healthy", "healthy, heat and tacho", "healthy, pinned rollers")
"""Benches whose programs are measured, too."""

CHAINS: dict[str, tuple[str, ...]] = {
    "default": (),
    "`iepe_100mv_g`": ("sensor.preset=iepe_100mv_g",),
    "`mems`": ("sensor.preset=mems",),
    "`mems`, axle box with 6 modes": ("sensor.preset=mems", "structure.modes=6"),
    "`mems`, axle box with 6 modes, track, flat, joints and impacts": (
        *("sensor.preset=mems", "structure.modes=6", "background.joint_level=20.0", "background.flat_level=20.0"),
        *("background.track_level=1.0", "background.impact_rate=10.0", "background.impact_level=20.0"),
    ),
}
"""Settings of `dry` by measurement chain."""

Run = Callable[[float], None]
"""Runs for a simulated time [s]."""


def bench(name: str) -> Configuration:
    """Return a bench of the table."""
    return load_configuration(name.partition(",")[0], list(BENCHES[name]))


def kernel(configuration: Configuration) -> Run:
    """Return a function that runs the kernel."""
    payload = build_payload(configuration)
    state, work = initial_state(configuration, payload), workspace(payload)

    def run(duration: float) -> None:
        steps = round(duration / payload.step)
        advance(payload, state, work, np.empty((steps, 2)), np.empty(steps))

    return run


def blocks(configuration: Configuration) -> Run:
    """Return a function that simulates and encodes blocks."""
    simulation = Simulation(configuration)
    encoder = BlockEncoder(configuration, simulation.bodies)

    def run(duration: float) -> None:
        for block in simulation.blocks(duration):
            encoder.encode(block)

    return run


def recorded(configuration: Configuration) -> Run:
    """Return a function that simulates and records like ``dcrb simulate``."""
    simulation = Simulation(configuration)

    def run(duration: float) -> None:
        with tempfile.TemporaryDirectory() as folder, Recorder(Path(folder) / "bag", configuration, simulation.bodies) as recorder:
            for block in prefetch(simulation.blocks(duration), depth=WRITING_DEPTH):
                recorder.write(block)

    return run


def chain(configuration: Configuration) -> Run:
    """Return a function that measures noise in blocks, without a model."""
    sensor, block = Sensor(configuration.measurement), 1024 * configuration.steps_per_sample
    acceleration = np.random.default_rng(1).normal(size=(block, 2))
    angle = np.arange(block, dtype=np.float64) * (100.0 / configuration.step_rate)

    def run(duration: float) -> None:
        for _ in range(round(duration * configuration.step_rate / block)):
            sensor.measure(acceleration, angle)

    return run


def rounds(runs: dict[str, Run], durations: dict[str, float], number: int) -> list[dict[str, float]]:
    """Return the processor time per simulated second of each run, in rounds of one run each after the other [-]."""
    for run in runs.values():
        run(WARM_UP)
    measured = []
    for _ in range(number):
        times = {}
        for name, run in runs.items():
            begin = time.process_time()
            run(durations[name])
            times[name] = (time.process_time() - begin) / durations[name]
        measured.append(times)
    return measured


def kernel_factor(configuration: Configuration, duration: float, number: int = 1) -> float:
    """Return simulated over processor time of the kernel alone [-], the median of runs of ``duration`` [s]."""
    return statistics.median(1.0 / times["kernel"] for times in rounds({"kernel": kernel(configuration)}, {"kernel": duration}, number))


def relative(measured: list[dict[str, float]], name: str, to: str) -> float:
    """Return the median ratio of two runs of a round [-]."""
    return statistics.median(times[name] / times[to] for times in measured)


def print_kernels(duration: float, number: int) -> None:
    """Print the speed of the kernel on every bench."""
    measured = rounds({name: kernel(bench(name)) for name in BENCHES}, dict.fromkeys(BENCHES, duration), number)
    print("| kernel of | simulated seconds per second | µs per step | step relative to `dry` |\n|---|---|---|---|")
    for name in BENCHES:
        seconds = statistics.median(times[name] for times in measured)
        step = 1e6 * seconds / bench(name).step_rate
        print(f"| {name} | {1.0 / seconds:.1f} | {step:.2f} | {relative(measured, name, 'dry'):.2f} |", flush=True)


def print_programs(duration: float, number: int) -> None:
    """Print the speed of the programs around the kernel."""
    print("\n| program | simulated seconds per second | speed relative to the kernel |\n|---|---|---|")
    for name in WHOLE:
        parts = {"kernel": kernel, "blocks, encoded": blocks, "`dcrb simulate`, recorded": recorded}
        durations = {part: duration * (RECORDING_FACTOR if make is recorded else 1) for part, make in parts.items()}
        measured = rounds({part: make(bench(name)) for part, make in parts.items()}, durations, number)
        for part in parts:
            seconds = statistics.median(times[part] for times in measured)
            print(f"| {name}: {part} | {1.0 / seconds:.1f} | {100 * relative(measured, 'kernel', part):.0f} % |", flush=True)


def print_chains(duration: float, number: int) -> None:
    """Print the speed of measurement chains."""
    chains = {name: chain(load_configuration("dry", list(settings))) for name, settings in CHAINS.items()}
    measured = rounds(chains, dict.fromkeys(CHAINS, 4.0 * duration), number)
    print("\n| measurement chain | measured seconds per second |\n|---|---|")
    for name in CHAINS:
        print(f"| {name} | {1.0 / statistics.median(times[name] for times in measured):.0f} |", flush=True)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=7, help="rounds")
    parser.add_argument("--duration", type=float, default=1.0, help="simulated time of a run [s]")
    options = parser.parse_args()
    print_kernels(options.duration, options.runs)
    print_programs(options.duration, options.runs)
    print_chains(options.duration, options.runs)


if __name__ == "__main__":
    main()
