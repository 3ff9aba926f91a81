"""Regenerate the recordings in bags/, or some of them: python benchmarks/bags.py [NAME ...]."""

from __future__ import annotations

import shutil
import sys
from dataclasses import dataclass
from pathlib import Path

from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.stream.events import CommandSchedule, SpeedCommand, TimedCommand

BAGS = Path(__file__).resolve().parents[1] / "bags"
DURATION = 3.0
"""Simulated time of a recording [s]."""


@dataclass(frozen=True)
class Run:
    """A run to record."""

    settings: tuple[str, ...] = ()
    """Parameters that differ from those of the shipped configuration."""
    config: str = "dry"
    """Name of a shipped configuration."""
    commands: tuple[TimedCommand, ...] = ()


OUTER = "faults.outer_1.width=0.002"
RUNS = {
    "healthy": Run(),
    "outer_ring_defect": Run((OUTER,)),
    "inner_ring_defect": Run(("faults.inner_1.width=0.002",)),
    "cage_fracture": Run(("faults.broken_bars=row1/bar15, row2/bar15",)),
    "compound": Run((OUTER, "faults.outer_1.row=1", "faults.inner_1.width=0.002", "faults.inner_1.row=2", "faults.broken_bars=row1/bar15")),
    "paper": Run(config="paper"),
    # From 40 to 150 rad/s with the configured ramp of 50 rad/s^2.
    "run_up": Run((OUTER, "operating.speed=40.0"), commands=(TimedCommand(500_000_000, SpeedCommand(150.0)),)),
}


def make(name: str) -> None:
    """Simulate and record a run; replace the previous recording once the new one is complete."""
    run = RUNS[name]
    configuration = load_configuration(run.config, run.settings)
    simulation, schedule = Simulation(configuration), CommandSchedule(run.commands)
    folder = BAGS / ".new"
    shutil.rmtree(folder, ignore_errors=True)
    with Recorder(folder / name, configuration, simulation.bodies) as recorder:
        schedule.apply_due(simulation)
        for block in simulation.blocks(DURATION):
            recorder.write(block)
            schedule.apply_due(simulation)
    shutil.rmtree(BAGS / name, ignore_errors=True)
    (folder / name).rename(BAGS / name)
    folder.rmdir()
    size = sum(file.stat().st_size for file in (BAGS / name).iterdir())
    print(f"{name}: {size / 1e6:.2f} MB, sha256 {recorder.outcome.sha256[:16]}", flush=True)


def main() -> None:
    """Regenerate the named recordings, or all."""
    names = sys.argv[1:] or list(RUNS)
    unknown = [name for name in names if name not in RUNS]
    if unknown:
        sys.exit(f"there is no recording '{unknown[0]}' (known: {', '.join(RUNS)})")
    for name in names:
        make(name)


if __name__ == "__main__":
    main()
