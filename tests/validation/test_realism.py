"""Statistics of simulated bearings within the ranges of measured ones, and the statistics of signals with known ones."""

from __future__ import annotations

import functools
from collections.abc import Mapping

import numpy as np
import pytest

from dcrb_ros.bearing.frequencies import Orders, characteristic_orders
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.validation.realism import Statistics, statistics
from dcrb_ros.validation.realism_rows import HARMONICS, HEALTHY_AIMS, SPALL_AIMS

pytestmark = pytest.mark.slow

RATE = 51200
SHAFT = 20.0
ORDERS = Orders(0.4, 6.0, 8.0, 2.5)


def modulated(envelope: np.ndarray) -> Statistics:
    """Return the statistics of a tone of 6 kHz with a squared envelope."""
    time = np.arange(len(envelope)) / RATE
    return statistics(np.sqrt(envelope) * np.cos(2.0 * np.pi * 6000.0 * time), RATE, SHAFT, ORDERS)


def turns(duration: float, order: float, wander: float = 0.0) -> np.ndarray:
    """Return the cosine of an order whose frequency sways slowly by a relative amplitude."""
    time = np.arange(round(duration * RATE)) / RATE
    sway = wander * np.sin(2.0 * np.pi * 0.4 * time) / (2.0 * np.pi * 0.4)
    return np.asarray(np.cos(2.0 * np.pi * order * SHAFT * (time + sway)))


def test_depth_and_sidebands_are_those_of_the_squared_envelope() -> None:
    found = modulated((1.0 + 0.8 * turns(2.0, 6.0)) * (1.0 + 0.4 * turns(2.0, 1.0)))
    assert found.bpfo_depth == pytest.approx(0.8, rel=0.02)
    assert found.sidebands == pytest.approx(0.2, rel=0.02)
    assert found.cage_depth < 0.01
    assert found.departure == pytest.approx(0.0, abs=1e-3)  # half a line of 0.25 Hz
    assert found.wander < 1e-5


def test_lines_are_found_where_the_rollers_slip() -> None:
    found = modulated(1.0 + 0.8 * turns(2.0, 6.0 * 1.013))
    assert found.departure == pytest.approx(0.013, abs=1e-3)
    assert found.bpfo_depth == pytest.approx(0.8, rel=0.02)


def test_wander_is_the_standard_deviation_of_the_frequency() -> None:
    found = modulated(1.0 + 0.8 * turns(10.0, 6.0, 0.002))
    # Windows of half a second average over a fifth of the sway.
    assert found.wander == pytest.approx(0.002 / np.sqrt(2.0), rel=0.1)


def test_noise_has_no_lines_and_a_known_envelope() -> None:
    """The squared envelope of noise is exponential: its 99.5th percentile is ln 200/ln 2 times the median, 8.8 dB."""
    found = statistics(np.random.default_rng(2).normal(size=4 * RATE), RATE, SHAFT, ORDERS)
    assert found.kurtosis == pytest.approx(3.0, abs=0.05)
    assert found.crest == pytest.approx(8.8, abs=0.2)
    assert found.bpfo_depth < 0.05


@functools.cache
def bench(name: str, *settings: str) -> Statistics:
    """Return the statistics of the sensor's Y in 1.5 s of a bench after its start."""
    configuration = load_configuration(name, settings)
    blocks = list(Simulation(configuration, waveform_only=True).blocks(1.7))
    values = np.concatenate([block.acceleration for block in blocks])[round(0.2 * RATE) :, 1]
    return statistics(values, RATE, configuration.operating.speed / (2.0 * np.pi), characteristic_orders(configuration.bearing))


def outside(found: Statistics, aims: Mapping[str, tuple[float, float, str]]) -> dict[str, float]:
    """Return the statistics outside the ranges of measured bearings, docs/results/realism.md."""
    values = {name: getattr(found, name) for name in aims}
    return {name: value for name, value in values.items() if not aims[name][0] < value < aims[name][1]}


@pytest.mark.parametrize("settings", [(), ("operating.speed=62.832",)])
def test_a_healthy_bearing_is_as_quiet_as_measured_ones(settings: tuple[str, ...]) -> None:
    found = bench("healthy", *settings)
    assert outside(found, HEALTHY_AIMS) == {}
    assert found.kurtosis < 3.5


def test_a_spall_of_2_mm_has_the_statistics_of_measured_outer_ring_faults() -> None:
    """The sensor of a machine is behind the modes of a housing."""
    found = bench("outer_ring_defect", "structure.modes=6")
    assert outside(found, SPALL_AIMS) == {}
    assert HARMONICS[0] < found.harmonics[0] / found.harmonics[1] < HARMONICS[1]


def test_run_out_makes_the_sidebands_and_fluctuation_the_wander() -> None:
    still = bench("outer_ring_defect", "surfaces.run_out=0", "operating.speed_fluctuation=0", "operating.speed_ripple=0")
    wide = bench("outer_ring_defect", "surfaces.run_out=1.5e-5")
    assert still.wander < 0.5 * bench("outer_ring_defect").wander
    assert wide.sidebands > 2.0 * still.sidebands


def test_cages_slip_more_under_less_load() -> None:
    def speed(load: float) -> float:
        simulation = Simulation(load_configuration("healthy", [f"operating.load={load}", "operating.speed_fluctuation=0"]))
        list(simulation.blocks(0.5))
        start = simulation._state.cage_position[:, 2].copy()
        list(simulation.blocks(0.5))
        return float((simulation._state.cage_position[:, 2] - start).mean())

    assert speed(5e3) < 0.97 * speed(1e5)
