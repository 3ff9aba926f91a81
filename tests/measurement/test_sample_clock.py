"""The sample clock of the ADC: tones sampled off their nominal times."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.measurement.sample_clock import SampleClock
from dcrb_ros.settings.configuration import Configuration

RATE = 51200.0


def clock(offset: float = 0.0, jitter: float = 0.0) -> SampleClock:
    return SampleClock(Configuration.model_validate({"sensor": {"clock_offset_ppm": offset, "clock_jitter": jitter}}).measurement)


def tone(frequency: float, ticks: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    phase = 2.0 * np.pi * frequency * ticks / RATE
    return np.stack([np.sin(phase), np.cos(phase)], axis=1)


@pytest.mark.parametrize("offset", [1000.0, -1000.0, 35.0])
@pytest.mark.parametrize("frequency", [100.0, 5000.0, 20000.0])
def test_an_offset_moves_the_samples_by_the_right_time(offset: float, frequency: float) -> None:
    ticks = np.arange(20000.0)
    taken, turned = clock(offset).process(tone(frequency, ticks), 0.002 * ticks)
    due = np.arange(len(taken)) * (1.0 + offset * 1e-6)
    assert len(taken) == pytest.approx(20000.0 / (1.0 + offset * 1e-6), abs=20)
    assert np.abs(taken - tone(frequency, due))[50:].max() < 2e-4  # 74 dB
    assert turned[50:] == pytest.approx(0.002 * due[50:], abs=1e-9)


def test_jitter_adds_noise_in_proportion_to_the_slope() -> None:
    frequency, jitter = 8000.0, 2e-7
    ticks = np.arange(60000.0)
    taken, _ = clock(jitter=jitter).process(tone(frequency, ticks), ticks)
    error = (taken - tone(frequency, np.arange(float(len(taken)))))[50:]
    assert error.std() == pytest.approx(2.0 * np.pi * frequency * jitter / np.sqrt(2.0), rel=0.02)


@given(st.lists(st.integers(0, 400), min_size=1, max_size=10), st.sampled_from([0.0, 900.0, -900.0]), st.sampled_from([0.0, 1e-6]))
def test_the_result_does_not_depend_on_the_split(cuts: list[int], offset: float, jitter: float) -> None:
    samples = np.random.default_rng(1).standard_normal((sum(cuts), 2))
    angle, parts, start, cut_up = np.arange(float(len(samples))), [], 0, clock(offset, jitter)
    for cut in cuts:
        parts.append(np.column_stack(cut_up.process(samples[start : start + cut], angle[start : start + cut])))
        start += cut
    assert np.array_equal(np.concatenate(parts), np.column_stack(clock(offset, jitter).process(samples, angle)))


@pytest.mark.parametrize("offset", [1000.0, -1000.0])
def test_the_needed_ticks_are_sufficient(offset: float) -> None:
    for count in (1, 5, 1024, 5000):
        needed = clock(offset, 1e-6).needed(count)
        taken, _ = clock(offset, 1e-6).process(np.zeros((needed, 2)), np.zeros(needed))
        assert count <= len(taken) <= count + 1
