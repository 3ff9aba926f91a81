"""A bench with a known path, gain, noise, modulation, hum and unbalance is found again from its recording alone."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
import pytest
from scipy.signal import sosfreqz

import dcrb_ros
from dcrb_ros.calibration.calibration import STEPS
from dcrb_ros.calibration.spectra import power_density
from dcrb_ros.diagnosis.features.band_levels import EDGE
from dcrb_ros.measurement.stages.structure import sections

pytestmark = pytest.mark.slow


def drawn(seed: int) -> dict[str, Any]:
    """Return the parameters of a plant."""
    random = np.random.default_rng(seed)
    return {
        "structure.modes": int(random.integers(2, 7)),
        "structure.seed": seed,
        "structure.gain_x": float(random.uniform(0.3, 3.0)),
        "structure.gain_y": float(random.uniform(0.3, 3.0)),
        "structure.modulation": float(random.uniform(0.2, 0.5)),
        "sensor.noise_density": float(random.uniform(1e-3, 6e-3)),
        "background.hum_level": float(random.uniform(0.05, 0.2)),
        "background.unbalance": float(random.uniform(5e-5, 2e-4)),
        "simulation.seed": seed,
        "surfaces.seed": 1,
    }


@functools.cache
def calibrated(seed: int) -> tuple[dcrb_ros.SimulationResult, dcrb_ros.Calibration]:
    """Return a plant's run, and what a calibration finds."""
    run = dcrb_ros.simulate("healthy", 5.0, settings=drawn(seed))
    return run, dcrb_ros.calibrate(run)


def true_powers(run: dcrb_ros.SimulationResult, axis: int, gain: float) -> tuple[Any, Any]:
    """Return frequencies from 200 Hz to 20 kHz, and the power of the ring before and behind the true path, shape (2, lines)."""
    spectrum = power_density(run.clean[25600:, axis].astype(float), run.sampling_rate)
    used = (spectrum.frequency >= 200.0) & (spectrum.frequency <= 0.4 * run.sampling_rate)
    rate = float(run.configuration.step_rate)
    response = np.abs(sosfreqz(sections(run.configuration.structure, rate)[axis], spectrum.frequency[used], fs=rate)[1])
    before = spectrum.density[used]
    return spectrum.frequency[used], np.array([before, before * (gain * response) ** 2])


@pytest.mark.parametrize("seed", [101, 102])
def test_the_path_is_recovered_within_2_db_where_the_bearing_is_heard(seed: int) -> None:
    run, found = calibrated(seed)
    for axis in "xy":
        frequency, powers = true_powers(run, "xy".index(axis), drawn(seed)[f"structure.gain_{axis}"])
        heard = [one for one in found.path if one.axis == axis and one.identified]
        assert len(heard) >= 10
        for one in heard:
            band = (frequency >= one.frequency / EDGE) & (frequency < one.frequency * EDGE)
            before, behind = powers[:, band].sum(axis=1)
            assert one.level == pytest.approx(10.0 * np.log10(behind / before), abs=2.0), f"{axis} at {one.frequency:.0f} Hz"


@pytest.mark.parametrize("seed", [101, 102])
def test_gain_and_noise_are_recovered_within_10_percent(seed: int) -> None:
    run, found = calibrated(seed)
    assert found["sensor.noise_density"].value == pytest.approx(drawn(seed)["sensor.noise_density"], rel=0.1)
    for axis in "xy":
        before, behind = true_powers(run, "xy".index(axis), drawn(seed)[f"structure.gain_{axis}"])[1].sum(axis=1)
        assert found.gains[axis].value == pytest.approx(float(np.sqrt(behind / before)), rel=0.1)


@pytest.mark.parametrize("seed", [101, 102])
def test_modulation_hum_and_unbalance_are_recovered(seed: int) -> None:
    _, found = calibrated(seed)
    plant = drawn(seed)
    assert found["structure.modulation"].value == pytest.approx(plant["structure.modulation"], abs=0.12)
    assert found["background.hum_level"].value == pytest.approx(plant["background.hum_level"], rel=0.1)
    assert found.configuration.background.hum_frequency == pytest.approx(50.0, abs=0.02)
    # The path at rest is not seen where the bearing is silent, so that only the amplitude at the sensor is known.
    at_sensor = found["background.unbalance"].value * found.configuration.structure.gain_y
    assert at_sensor == pytest.approx(plant["background.unbalance"] * plant["structure.gain_y"], rel=0.25)
    assert found["operating.speed"].value == pytest.approx(125.664, rel=2e-3)
    assert found["operating.speed_ripple"].value == pytest.approx(1e-4, rel=0.3)


def test_the_calibrated_bench_measures_like_the_plant() -> None:
    run, found = calibrated(101)
    twin = dcrb_ros.simulate(found.configuration, 3.0)
    for one in dcrb_ros.compare(run.between(0.5), twin.between(0.5)).axes:
        heard = one.frequency >= 200.0
        assert np.abs(one.difference[heard]).max() < 3.0
        assert one.kurtosis_distance < 0.5


def test_a_calibration_of_the_same_recording_gives_the_same_configuration() -> None:
    run, found = calibrated(101)
    steps: list[str] = []
    assert dcrb_ros.calibrate(run, progress=steps.append).configuration == found.configuration
    assert len(steps) == STEPS


def test_machines_are_drawn_within_the_intervals_and_can_be_simulated() -> None:
    _, found = calibrated(101)
    assert found.draw(3) == found.draw(3)
    assert found.draw(3) != found.draw(4)
    for seed in range(20):
        drawn_machine = found.draw(seed)
        for key, (low, high) in found.intervals.items():
            assert low <= drawn_machine[key] <= high * (1.0 + 1e-12)
        dcrb_ros.load_configuration(found.configuration, drawn_machine)


def test_what_a_recording_cannot_show_is_said() -> None:
    _, found = calibrated(101)
    assert any("load" in sentence for sentence in found.unidentified)
    assert any("minimum phase" in sentence for sentence in found.unidentified)
