"""The measured path, its deviations, and the modulation by the shaft."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import sosfreqz

from dcrb_ros import Refusal, load_configuration
from dcrb_ros.measurement.filters import pole_zero_pair
from dcrb_ros.measurement.stage import Span
from dcrb_ros.measurement.stages.modulation import ShaftModulation
from dcrb_ros.measurement.stages.path import MeasuredPath, Pair, cascade, deviations, pairs, text_of
from dcrb_ros.schema.arrays import Floats

RATE = 102400.0

dampings = st.floats(0.005, 0.5)
frequencies = st.floats(50.0, 20000.0)


def stage(kind: type[MeasuredPath] | type[ShaftModulation], **structure: object) -> MeasuredPath | ShaftModulation:
    """Return a stage with parameters of the group structure."""
    setup = load_configuration("dry", {f"structure.{key}": value for key, value in structure.items()}).measurement
    return kind(setup, RATE)


def span(samples: int) -> Span:
    """Return a span from the first step on at 20 Hz of the shaft."""
    return Span(0, 2.0 * math.pi * 20.0 * np.arange(samples + 1) / RATE)


@given(frequencies, dampings, frequencies, dampings)
def test_a_pair_has_the_gain_of_its_formula(pole: float, pole_damping: float, zero: float, zero_damping: float) -> None:
    frequency = np.array([0.0, 30.0, 700.0, 5000.0])
    section = pole_zero_pair((pole, pole_damping), (zero, zero_damping), RATE)
    s = 1j * np.tan(math.pi * frequency / RATE)
    p, z = math.tan(math.pi * pole / RATE), math.tan(math.pi * zero / RATE)
    expected = ((s / z) ** 2 + 2.0 * zero_damping * s / z + 1.0) / ((s / p) ** 2 + 2.0 * pole_damping * s / p + 1.0)
    assert np.abs(sosfreqz(section, frequency, fs=RATE)[1]) == pytest.approx(np.abs(expected), rel=1e-6)


def test_each_axis_has_a_gain_and_a_path_of_its_own() -> None:
    path = stage(MeasuredPath, gain_x=2.0, gain_y=0.5, path_y="2000 0.02 3000 0.02")
    tone = np.sin(2.0 * math.pi * 2000.0 * np.arange(40960) / RATE)
    after = path.process(np.column_stack([tone, tone]), span(len(tone)))[20480:]
    assert after[:, 0] == pytest.approx(2.0 * tone[20480:])
    gain = abs(sosfreqz(cascade([Pair(2000.0, 0.02, 3000.0, 0.02)], RATE), [2000.0], fs=RATE)[1][0])
    assert after[:, 1].std() * math.sqrt(2.0) == pytest.approx(0.5 * gain, rel=1e-3)


@given(st.lists(st.builds(Pair, frequencies, dampings, frequencies, dampings), max_size=5))
def test_a_text_gives_its_pairs(found: list[Pair]) -> None:
    read = pairs(text_of(found), "structure.path_x")
    assert np.array(read) == pytest.approx(np.array(found), rel=1e-5)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("1400 0.03", "structure.path_y: '1400 0.03' is not a pair of poles and zeros"),
        ("1400 0.03 fast 0.1", "is not a pair of poles and zeros: give the frequency"),
        ("5 0.03 1600 0.05", "frequency 5 Hz is outside 10 .. 40000 Hz"),
        ("1400 9 1600 0.05", "damping ratio 9 is outside 0.001 .. 5"),
        ("; ".join(["1400 0.03 1600 0.05"] * 49), "49 pairs of poles and zeros; at most 48"),
        ("1400 nan 1600 0.05", "damping ratio nan is outside"),
    ],
)
def test_a_path_that_is_none_is_refused(text: str, reason: str) -> None:
    with pytest.raises(Refusal, match=reason.replace("(", r"\(")):
        load_configuration("dry", {"structure.path_y": text})


def test_a_path_without_gain_and_sections_changes_nothing() -> None:
    assert not stage(MeasuredPath).active
    assert not stage(ShaftModulation).active
    assert stage(MeasuredPath, path_spread=1.0).active


@pytest.mark.slow
@pytest.mark.parametrize("spread", [1.0, 3.0])
def test_deviations_have_the_standard_deviation_that_is_asked_for(spread: float) -> None:
    frequency = np.geomspace(250.0, 10000.0, 40)
    levels = [
        20.0 * np.log10(np.abs(sosfreqz(cascade(deviations(seed, spread, RATE)[0], RATE), frequency, fs=RATE)[1])) for seed in range(150)
    ]
    assert np.std(levels) == pytest.approx(spread, rel=0.12)
    assert np.mean(levels) == pytest.approx(0.0, abs=0.15 * spread)


def test_deviations_are_those_of_the_seed() -> None:
    assert deviations(3, 2.0, RATE) == deviations(3, 2.0, RATE)
    assert deviations(3, 2.0, RATE) != deviations(4, 2.0, RATE)
    x, y = deviations(3, 2.0, RATE)
    assert x != y


def envelope(modulation: float) -> Floats:
    """Return what a constant acceleration becomes over ten turns."""
    return stage(ShaftModulation, modulation=modulation).process(np.ones((51200, 2)), span(51200))


def test_modulation_has_its_depth_once_per_turn() -> None:
    found = envelope(0.4)
    line = 2.0 * np.abs(np.mean(found[:, 0] * np.exp(-2j * math.pi * 20.0 * np.arange(1, 51201) / RATE)))
    assert line == pytest.approx(0.4, rel=1e-6)
    assert found.mean() == pytest.approx(1.0, abs=1e-6)
    assert np.array_equal(found[:, 0], found[:, 1])
