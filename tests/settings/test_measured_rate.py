"""Settings for the sampling rate of a measured recording."""

from __future__ import annotations

import pytest

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.measured_rate import rates

STEP = 1.0 / 102400.0


@pytest.mark.parametrize(
    ("rate", "steps", "preview"), [(51200, 2, 200), (25600, 4, 200), (12000, 9, 200), (48828, 3, 156), (97656, 2, 156), (65536, 2, 256)]
)
def test_the_step_is_the_longest_that_divides_a_sampling_interval(rate: int, steps: int, preview: int) -> None:
    expected = {"sensor.sampling_rate": rate, "simulation.step": 1.0 / (rate * steps), "publishing.preview_rate": preview}
    assert rates(rate, STEP) == expected


def test_a_rate_without_divisor_for_the_preview_is_refused() -> None:
    with pytest.raises(Refusal, match=r"sampling_rate = 12007 Hz has no divisor from 10 to 1000 Hz"):
        rates(12007, STEP)
