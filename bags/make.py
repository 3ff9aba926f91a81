"""Makes the recordings of this folder anew, or some of them: python bags/make.py [NAME ...]."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.simulation.events import Agenda, Command
from dcrb_ros.simulation.loop import Simulation

HERE = Path(__file__).resolve().parent
SECONDS = 3.0
BENCHES = ("healthy", "outer_ring_defect", "inner_ring_defect", "cage_fracture", "compound", "paper")
RUN_UP = ("outer_ring_defect", ("operating.speed=40.0",), (Command(500_000_000, "command/speed 150.0 rad/s"),))
"""From 40 to 150 rad/s at the configured ramp of 50 rad/s^2, with a defect."""
RECORDINGS: dict[str, tuple[str, tuple[str, ...], tuple[Command, ...]]] = {name: (name, (), ()) for name in BENCHES} | {"run_up": RUN_UP}


def make(name: str) -> None:
    """Make one recording, in place of the old one once it is whole."""
    config, settings, commands = RECORDINGS[name]
    configuration = load_configuration(config, settings)
    simulation, agenda = Simulation(configuration), Agenda(commands)
    folder = HERE / ".new"
    shutil.rmtree(folder, ignore_errors=True)
    with Recorder(folder / name, configuration, simulation.bodies) as recorder:
        agenda.give(simulation)
        for block in simulation.blocks(SECONDS):
            recorder.write(block)
            agenda.give(simulation)
    shutil.rmtree(HERE / name, ignore_errors=True)
    (folder / name).rename(HERE / name)
    folder.rmdir()
    size = sum(file.stat().st_size for file in (HERE / name).iterdir())
    print(f"{name}: {size / 1e6:.2f} MB, sha256 {recorder.outcome.sha256[:16]}", flush=True)


def main() -> None:
    """Make what is named, or everything."""
    names = sys.argv[1:] or list(RECORDINGS)
    unknown = [name for name in names if name not in RECORDINGS]
    if unknown:
        sys.exit(f"there is no recording '{unknown[0]}' (known: {', '.join(RECORDINGS)})")
    for name in names:
        make(name)


if __name__ == "__main__":
    main()
