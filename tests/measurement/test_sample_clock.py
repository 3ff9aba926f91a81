"""The sample clock of the ADC: tones sampled off their nominal times."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.measurement.sample_clock import SampleClock, interpolation_weights
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


def test_the_interpolation_weights_are_those_of_a_kaiser_windowed_sinc() -> None:
    """Kaiser 1974: w(x) = I0(beta sqrt(1 - x^2)) / I0(beta)."""
    place = np.arange(1025) / 1024.0
    distance = place[:, None] - np.arange(-13.0, 15.0)
    window = np.i0(8.3 * np.sqrt(np.clip(1.0 - (distance / 14.0) ** 2, 0.0, None))) / np.i0(8.3)
    assert interpolation_weights() == pytest.approx(np.sinc(distance) * window, abs=1e-9)
    assert interpolation_weights()[0] == pytest.approx(np.eye(28)[13], abs=1e-15)


@pytest.mark.parametrize("offset", [1000.0, -1000.0, 0.0])
def test_the_first_sample_at_a_tick_is_not_before_it(offset: float) -> None:
    for tick in (0, 1, 999, 1000, 1001, 123456):
        sample, period = clock(offset, 1e-9).sample_at(tick), 1.0 + offset * 1e-6
        assert sample * period >= tick - 1e-6
        assert (sample - 1) * period < tick


def test_before_the_start_the_shaft_is_at_its_first_angle() -> None:
    _, turned = clock(-1000.0, 1e-5).process(np.ones((500, 2)), np.full(500, 5.0))
    assert turned == pytest.approx(5.0, abs=1e-12)


class Extreme(np.random.Generator):
    """Random numbers far from their mean."""

    def standard_normal(self, size: Any = None, *_: Any, **__: Any) -> Any:
        return np.where(np.arange(size) % 2, 9.0, -9.0)


def test_jitter_is_limited_to_six_times_its_rms() -> None:
    jittery = clock(jitter=1e-6)
    jittery._random = Extreme(np.random.PCG64(1))
    ticks = np.arange(400.0)
    _, turned = jittery.process(np.zeros((400, 2)), ticks)
    late = turned[40:] - np.arange(40.0, float(len(turned)))
    assert np.abs(late) == pytest.approx(6.0 * 1e-6 * RATE, rel=1e-9)


@pytest.mark.parametrize("offset", [1000.0, -1000.0])
def test_the_memory_does_not_grow(offset: float) -> None:
    made = clock(offset, 1e-6)
    for _ in range(30):
        made.process(np.zeros((1000, 2)), np.zeros(1000))
        assert len(made._known) < 50


def test_without_offset_and_jitter_samples_stay_as_they_are() -> None:
    samples = np.random.default_rng(1).standard_normal((300, 2))
    taken, turned = clock().process(samples, np.arange(300.0))
    assert taken == pytest.approx(samples[: len(taken)], abs=1e-14)
    assert turned.tolist() == list(range(len(taken)))
    assert len(taken) == 300 - 15
