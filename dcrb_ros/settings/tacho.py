"""The tacho on the shaft: its parameter, and the number of pulses that the sampling rate allows."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from dcrb_ros.schema.fields import Group, quantity

if TYPE_CHECKING:
    from dcrb_ros.settings.configuration import Configuration

SAMPLES_PER_PULSE = 8
"""Least number of samples from pulse to pulse: exported files have the pulses at the sampling rate, with edges of two samples."""


class Tacho(Group):
    """A toothed wheel on the shaft, as the wheel speed sensor of an axle box has one."""

    pulses_per_turn: int = quantity(
        0, "-", "Pulses of the tacho per turn of the shaft; 0 for no tacho, since the waveform has the angle of the shaft", 0, 10000
    )


def tacho_limits(c: Configuration) -> Iterator[str]:
    """Yield a sentence if the pulses follow each other too fast for the sampling rate."""
    rate, turns = c.sensor.sampling_rate / SAMPLES_PER_PULSE, abs(c.operating.speed) / (2.0 * math.pi)
    pulses = c.tacho.pulses_per_turn
    if pulses * turns > rate:
        yield (
            f"tacho.pulses_per_turn = {pulses} makes {pulses * turns:.4g} pulses per second at operating.speed = "
            f"{c.operating.speed:g} rad/s, above {rate:g}, one in {SAMPLES_PER_PULSE} samples at sensor.sampling_rate = "
            f"{c.sensor.sampling_rate} Hz: give at most {int(rate / turns)}, or a higher sampling rate"
        )
