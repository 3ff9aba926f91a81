"""The level of a healthy bearing behind its path."""

from __future__ import annotations

import numpy as np
import pytest

from dcrb_ros import Refusal, healthy_level, simulate
from dcrb_ros.settings.measured_rate import rates


def test_it_is_the_rms_of_the_same_machine_without_fault_background_and_sensor_errors() -> None:
    machine = {"structure.seed": 2, "structure.housing": "laboratory"}
    spoiled = {
        "faults.outer_1.kind": "spall",
        "faults.outer_1.width": 0.002,
        "background.track_level": 5.0,
        "structure.healthy_level": 4.0,
        "sensor.fault": "dead",
        "sensor.sampling_rate": 25600,
    }
    run = simulate("healthy", 0.5, settings={**machine, "sensor.preset": "ideal"})
    expected = float(np.sqrt(np.mean(run.acceleration[round(0.2 * 51200) :].astype(float) ** 2)))
    assert healthy_level("healthy", 0.3, settings={**machine, **spoiled}) == pytest.approx(expected, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("rate", [84611, 65536, 120002])
def test_it_has_the_band_up_to_20_khz_at_every_rate_of_a_recording(rate: int) -> None:
    """The rates of steps of these recordings have no divisor from 48 to 60 kHz with a preview; other ones are 802, 32 768 and 8276 Hz."""
    machine = {"structure.seed": 2, "structure.housing": "laboratory"}
    expected = healthy_level("healthy", 0.3, settings=machine)
    assert healthy_level("healthy", 0.3, settings={**machine, **rates(rate, 1.0 / 102400.0)}) == pytest.approx(expected, rel=0.03)


def test_a_duration_of_zero_is_refused() -> None:
    with pytest.raises(Refusal, match="duration ="):
        healthy_level("healthy", 0.0)
