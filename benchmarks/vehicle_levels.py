"""Levels of the axle boxes of a healthy vehicle by the track, and the processor time of each part of a vehicle, as Markdown tables.

The levels are on the page docs/explanation/vehicle.md, the times on docs/results/performance.md. Usage:

    python benchmarks/vehicle_levels.py levels [SECONDS]
    python benchmarks/vehicle_levels.py cost [SECONDS]
"""

from __future__ import annotations

import argparse
import time
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from scipy.signal import butter, sosfiltfilt

from dcrb_ros.diagnosis.vehicle.detector import VehicleDetector
from dcrb_ros.messages.vehicle import box_path
from dcrb_ros.messages.vehicle_encoder import VehicleEncoder
from dcrb_ros.recordings.splitting import Bag
from dcrb_ros.recordings.vehicle_recorder import VehicleRecorder
from dcrb_ros.simulation import loop
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.text.markdown import table
from dcrb_ros.vehicle.description import described
from dcrb_ros.vehicle.file import read_parameters, read_vehicle
from dcrb_ros.vehicle.frame import FRAME
from dcrb_ros.vehicle.model import VehicleModel
from dcrb_ros.vehicle.simulation import VehicleSimulation

SPEEDS = (72.0, 144.0, 216.0)
"""[km/h]"""
SPECTRA = ("erri_low", "erri_high", "fra_6", "fra_5")
CUTOFF = 200.0
"""Frequency below which levels are compared [Hz]."""
TESTED = 38.0
"""Rms with which EN 61373 tests what is mounted on an axle [m/s^2] (from memory)."""
LATER = 2.5
"""Time before which the kernels are compiled, the detector has less than its window, and nothing is measured [s]."""
KERNELS, STEPS = "kernels of four boxes", "states and truths of four boxes"


def levels(seconds: float) -> None:
    """Print the rms of the boxes below `CUTOFF` by track and wheels, and that of the dynamic loads."""
    lowpass = butter(4, CUTOFF, fs=102400.0, output="sos")
    rows = []
    for spectrum in SPECTRA:
        cells = [f"`{spectrum}`"]
        for speed in SPEEDS:
            model = VehicleModel(read_vehicle("healthy_bogie", {"track.spectrum": spectrum, "vehicle.speed_kmh": speed}))
            plans = [model.plan() for _ in range(round(seconds * model.rate / FRAME))]
            motion = np.concatenate([plan.motion for plan in plans], axis=1)
            load = np.array([plan.load[:, 1] for plan in plans]).std(axis=0).mean()
            rms = float(np.sqrt(np.mean(sosfiltfilt(lowpass, motion) ** 2)))
            cells.append(f"{rms:.1f}{' *' if rms > TESTED else ''} ({load / 1e3:.1f} kN)")
        rows.append(cells)
    print(table(("spectrum", *(f"{speed:g} km/h" for speed in SPEEDS)), rows))
    print(f"\n\\* above the {TESTED:g} m/s^2 of EN 61373")


def cost(seconds: float) -> None:
    """Print the processor time of the parts of `bogie` for each 20 ms, stepped by one thread, recorded and diagnosed."""
    spent: dict[str, float] = defaultdict(float)

    def timed(owner: Any, name: str, part: str) -> None:
        original: Callable[..., Any] = getattr(owner, name)

        def measured(*arguments: Any, **options: Any) -> Any:
            began = time.thread_time()
            try:
                return original(*arguments, **options)
            finally:
                spent[part] += time.thread_time() - began

        setattr(owner, name, measured)

    timed(loop, "advance", KERNELS)
    timed(Simulation, "step_to", STEPS)
    timed(VehicleModel, "plan", "track, wheels and loads")
    timed(VehicleModel, "mix", "mixing")
    timed(Simulation, "sense", "sensing of four boxes")
    timed(Simulation, "cut", "blocks")
    timed(VehicleEncoder, "encode", "messages")
    timed(Bag, "write", "recording")
    timed(VehicleDetector, "add", "comparing detector")
    vehicle = read_vehicle("bogie")
    simulation, detector = VehicleSimulation(vehicle, threads=1), VehicleDetector(described(vehicle))
    with TemporaryDirectory() as folder, VehicleRecorder(Path(folder) / "bag", read_parameters("bogie"), simulation) as recorder:

        def run(duration: float) -> None:
            for block in simulation.blocks(duration):
                recorder.write(block)
                detector.add({box_path(name): box for name, box in block.boxes.items()})

        run(LATER)
        spent.clear()
        began = time.process_time()
        run(seconds)
        whole = time.process_time() - began
    spent[STEPS] -= spent[KERNELS]
    spent["everything else"] = whole - sum(spent.values())
    parts = sorted(spent.items(), key=lambda item: -item[1])
    rows = [(part, f"{used / seconds * 20.0:.2f}", f"{used / whole:.0%}") for part, used in parts]
    print(table(("part", "ms per 20 ms", "share"), [*rows, ("all", f"{whole / seconds * 20.0:.2f}", "")]))


def main() -> None:
    """Print the table that was asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("table", choices=("levels", "cost"))
    parser.add_argument("seconds", nargs="?", type=float, default=10.0, help="simulated time, 1 to 1000 s")
    options = parser.parse_args()
    if not 1.0 <= options.seconds <= 1000.0:
        parser.error(f"SECONDS = {options.seconds:g} is not a duration of 1 .. 1000 s")
    {"levels": levels, "cost": cost}[options.table](options.seconds)


if __name__ == "__main__":
    main()
