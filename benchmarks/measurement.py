"""How much faster than real time the measurement chain alone is: default, by preset, and with every stage on.

Times of the processor, the best and the median of many blocks, so that neighbours on the machine count less; the model does not run.
"""

from __future__ import annotations

import argparse
import statistics
import time
from typing import Any

import numpy as np

from dcrb_ros.measurement.sensor import Sensor
from dcrb_ros.settings.configuration import Configuration

BACKGROUND = {"unbalance": 1e-4, "joint_level": 40.0, "flat_level": 30.0, "track_level": 4.0, "impact_rate": 20.0, "hum_level": 1.0}
EVERYTHING = {"preset": "mems", "ac_coupling": 0.5, "clock_offset_ppm": 20.0, "clock_jitter": 1e-9, "fault": "spikes"}
CHAINS: dict[str, dict[str, Any]] = {
    "default": {},
    "iepe_100mv_g": {"sensor": {"preset": "iepe_100mv_g"}},
    "mems": {"sensor": {"preset": "mems"}},
    "mems on an axle box": {"sensor": {"preset": "mems"}, "structure": {"modes": 6}},
    "background alone": {"background": BACKGROUND},
    "everything": {"sensor": EVERYTHING, "structure": {"modes": 6}, "background": BACKGROUND},
}


def times(configuration: Configuration, blocks: int) -> list[float]:
    """Return the processor's time for each block of samples [s]."""
    sensor, count = Sensor(configuration.measurement), configuration.publishing.block_size * configuration.steps_per_sample
    ring = np.random.default_rng(1).normal(0.0, 20.0, (count, 2))
    found = []
    for number in range(blocks):
        angle = configuration.operating.speed * np.arange(number * count, (number + 1) * count) / configuration.step_rate
        begin = time.process_time()
        sensor.measure(ring, angle)
        found.append(time.process_time() - begin)
    return found[blocks // 10 :]  # compiling and the first blocks do not count


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--blocks", type=int, default=1000, help="blocks of each chain")
    options = parser.parse_args()
    print("| chain | block [samples] | samples/s | x real time, best | median |\n|---|---|---|---|---|")
    for name, groups in CHAINS.items():
        for size in (1024, 8192):
            configuration = Configuration.model_validate({**groups, "publishing": {"block_size": size}})
            found = times(configuration, options.blocks if size < 8192 else options.blocks // 4)
            real = size / configuration.sensor.sampling_rate
            best, usual = min(found), statistics.median(found)
            print(f"| {name} | {size} | {size / best:.3g} | {real / best:.0f} | {real / usual:.0f} |", flush=True)


if __name__ == "__main__":
    main()
