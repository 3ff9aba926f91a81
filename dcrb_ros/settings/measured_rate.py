"""Settings with which a bench has the sampling rate of a measured recording."""

from __future__ import annotations

import math
from typing import Any

from dcrb_ros.schema.refusal import Refusal

USUAL_PREVIEW = 200
"""Rate of the preview where it divides the sampling rate [Hz]."""


def preview_rates(rate: int) -> list[int]:
    """Return the rates of a preview that divide a sampling rate [Hz]; there may be none."""
    return [d for d in range(10, 1001) if rate % d == 0]


def preview_at(rate: int) -> int:
    """Return the divisor of a sampling rate that is closest to the usual rate of the preview [Hz].

    Raises:
        Refusal: the rate has no divisor for the preview.
    """
    divisors = preview_rates(rate)
    if not divisors:
        raise Refusal(
            f"sampling_rate = {rate} Hz has no divisor from 10 to 1000 Hz, which the preview needs: take a multiple of 100 Hz, and "
            "resample a recording to it"
        )
    return min(divisors, key=lambda d: abs(math.log(d / USUAL_PREVIEW)))


def rates(rate: int, step: float) -> dict[str, Any]:
    """Return a sampling rate, the longest step up to ``step`` [s] that divides a sampling interval, and a preview that divides the rate.

    Raises:
        Refusal: the rate has no divisor for the preview.
    """
    steps = max(2, math.ceil(1.0 / (step * rate) - 1e-6))
    return {"sensor.sampling_rate": rate, "simulation.step": 1.0 / (rate * steps), "publishing.preview_rate": preview_at(rate)}
