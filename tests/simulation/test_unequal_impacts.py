"""Bearings whose impacts on damage differ: the same bits in any blocks, faults that change while it runs, and the scatter of impacts."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.simulation.loop import Simulation

pytestmark = pytest.mark.slow

SPALL = {"kind": "spall", "width": 5e-4, "depth": 1e-4, "share": 1.0, "row": 1}
ALL = {"spread": 0.5, "element_share": 0.3, "shaft_share": 0.15, "time_spread": 4e-5, "spin_memory": 0.01}
BPFO = 3.585 * 188.18 / (2.0 * np.pi)
"""Of the bench [Hz]."""


def bench(impacts: dict[str, float], faults: dict[str, Any] | None = None, **groups: Any) -> Configuration:
    given = {"impacts": impacts, "faults": faults or {"outer_1": SPALL}, "surfaces": {"seed": 1}} | groups
    return load_configuration("ball_bearing_6205", given)


def samples(configuration: Configuration, seconds: float) -> Floats:
    return np.concatenate([block.acceleration for block in Simulation(configuration).blocks(seconds)])


def test_samples_do_not_depend_on_the_blocks() -> None:
    faults = {"outer_1": SPALL, "inner_1": {"width": 3e-4}, "roller_1": {"width": 5e-4}}
    runs = [samples(bench(ALL, faults, publishing={"block_size": size}), 0.1) for size in (256, 700, 2048)]
    shortest = min(len(run) for run in runs)
    assert shortest > 0.09 * 48000
    assert all(np.array_equal(run[:shortest], runs[0][:shortest]) for run in runs)
    assert not np.array_equal(runs[0], samples(bench(ALL, faults, surfaces={"seed": 2}, publishing={"block_size": 256}), 0.1))


def test_a_fault_appears_and_grows_while_the_bearing_runs() -> None:
    simulation = Simulation(bench(ALL, {"outer_1": SPALL | {"width": 0.0}}))
    found = []
    for number, block in enumerate(simulation.blocks(0.4)):
        found.append(block.acceleration[:, 1])
        if number == 1:
            simulation.change({"faults.outer_1.width": 5e-4})
    assert np.std(found[-1]) > 2.0 * np.std(found[1])


@pytest.mark.parametrize("spread", [0.0, 0.4])
def test_the_energies_of_the_impacts_scatter(spread: float) -> None:
    """Energies over successive periods of the defect; without a spread only speed and dimensions make them differ."""
    configuration = bench({"spread": spread, "time_spread": 1e-9})
    signal = samples(configuration, 1.0)[:, 1].astype(np.float64)
    power = np.diff(signal) ** 2
    period = configuration.sensor.sampling_rate / BPFO
    edges = np.arange(0.0, len(power) - period, period).astype(int)
    energy = np.add.reduceat(power, edges)[5:-1]
    scatter = energy.std() / energy.mean()
    assert scatter < 0.2 if spread == 0.0 else 0.25 < scatter < 1.0
