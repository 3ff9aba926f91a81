"""Combinations of parameters that the measurement chain, the waveform's blocks and the tacho do not allow."""

from __future__ import annotations

import math
from collections.abc import Iterator

from dcrb_ros.measurement.registry import STAGES
from dcrb_ros.measurement.stage import Setup
from dcrb_ros.settings.parameters import Publishing
from dcrb_ros.settings.sensor import Tacho

LONGEST_BLOCK = 4.29
"""Longest block [s]: messages state the time of a sample after the stamp of its block in nanoseconds of 32 bits."""
SAMPLES_PER_PULSE = 8
"""Least number of samples from pulse to pulse: exported files have the pulses at the sampling rate, with edges of two samples."""


def measurement_limits(setup: Setup) -> Iterator[str]:
    """Yield a sentence for every combination of parameters that a stage of the measurement chain cannot work with."""
    for stage in STAGES:
        yield from stage.problems(setup.parameters, setup.step_rate)


def block_limits(publishing: Publishing, rate: int) -> Iterator[str]:
    """Yield a sentence if blocks are too long at a sampling rate [Hz] for the time of their last samples."""
    most = int(LONGEST_BLOCK * rate)
    if publishing.block_size > most:
        yield (
            f"publishing.block_size = {publishing.block_size} lasts {publishing.block_size / rate:.4g} s at sensor.sampling_rate = "
            f"{rate} Hz: the times of samples within a block are limited to {LONGEST_BLOCK:g} s; give {most} or fewer"
        )


def burst_limits(publishing: Publishing, rate: int) -> Iterator[str]:
    """Yield a sentence if bursts have no length or no period at a sampling rate [Hz]."""
    length, period, block = publishing.burst_length, publishing.burst_period, publishing.block_size / rate
    if period and not block <= length <= period:
        yield (
            f"publishing.burst_length = {length:g} s is outside {block:.4g} .. {period:g} s, a block and publishing.burst_period: "
            "give a length between them, or a period of 0.0 for no pauses"
        )
    if length and not period:
        yield f"publishing.burst_length = {length:g} s has no publishing.burst_period: give the period too, or a length of 0.0"


def tacho_limits(tacho: Tacho, speed: float, rate: int) -> Iterator[str]:
    """Yield a sentence if pulses at a speed of the shaft [rad/s] follow each other too fast for a sampling rate [Hz]."""
    most, turns = rate / SAMPLES_PER_PULSE, abs(speed) / (2.0 * math.pi)
    pulses = tacho.pulses_per_turn
    if pulses * turns > most:
        yield (
            f"tacho.pulses_per_turn = {pulses} makes {pulses * turns:.4g} pulses per second at operating.speed = "
            f"{speed:g} rad/s, above {most:g}, one in {SAMPLES_PER_PULSE} samples at sensor.sampling_rate = "
            f"{rate} Hz: give at most {int(most / turns)}, or a higher sampling rate"
        )
