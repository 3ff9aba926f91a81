"""The anti-alias filters, with analytic tones."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.measurement.decimation import Cascade, Decimator, anti_alias_taps, stages


def tone(frequency: float, rate: float, count: int, offset: float) -> npt.NDArray[np.float64]:
    """Return a tone sampled at (k + offset)/rate in two columns."""
    phase = 2.0 * np.pi * frequency * (np.arange(count) + offset) / rate
    return np.stack([np.sin(phase), np.cos(phase)], axis=1)


@pytest.mark.parametrize(("factor", "between"), [(2, True), (4, True), (8, True), (256, False)])
def test_the_pass_band_is_unchanged_and_not_delayed(factor: int, between: bool) -> None:
    decimator = Decimator(factor, between=between)
    out_rate = 51200.0
    for share in (0.01, 0.2, 0.39):
        inputs = tone(share * out_rate, factor * out_rate, 600 * factor, 0.5 if between else 0.0)
        outputs = Decimator(factor, between=between).process(inputs)
        exact = tone(share * out_rate, out_rate, len(outputs), 0.0)
        settled = slice(decimator.lead // factor + 2, None)
        assert np.abs(outputs[settled] - exact[settled]).max() < 2e-4


@pytest.mark.parametrize("factor", [2, 4, 256])
def test_frequencies_that_alias_into_the_band_are_stopped(factor: int) -> None:
    out_rate = 51200.0
    for share in (0.601, 0.75, 0.93):  # of the output rate: aliases to 0.399 and below
        inputs = tone(share * out_rate, factor * out_rate, 400 * factor, 0.0)
        outputs = Decimator(factor, between=True).process(inputs)
        assert 20.0 * np.log10(np.abs(outputs[150:]).max()) < -80.0


@given(st.lists(st.integers(1, 300), min_size=1, max_size=12), st.sampled_from([2, 5, 16]))
def test_the_result_does_not_depend_on_the_split(cuts: list[int], factor: int) -> None:
    samples = np.random.default_rng(1).standard_normal((sum(cuts), 2))
    decimator, start, parts = Decimator(factor), 0, []
    for cut in cuts:
        parts.append(decimator.process(samples[start : start + cut]))
        start += cut
    assert np.array_equal(np.concatenate(parts), Decimator(factor).process(samples))


@pytest.mark.parametrize("between", [True, False])
@pytest.mark.parametrize("factor", [2, 3, 8, 16])
def test_an_output_is_returned_once_its_lead_is_known(factor: int, between: bool) -> None:
    decimator = Decimator(factor, between=between)
    lead = decimator.lead
    assert len(decimator.process(np.zeros((lead, 2)))) == 0
    assert len(decimator.process(np.zeros((1, 2)))) == 1
    assert len(decimator.process(np.zeros((factor - 1, 2)))) == 0
    assert len(decimator.process(np.zeros((1, 2)))) == 1


@pytest.mark.parametrize("between", [True, False])
@pytest.mark.parametrize("factor", [2, 4, 16])
def test_the_taps_pass_and_stop_by_85_decibels(factor: int, between: bool) -> None:
    taps = anti_alias_taps(factor, between=between)
    assert (len(taps) % 2 == 0) == between
    assert taps == pytest.approx(taps[::-1], abs=1e-15)
    frequencies = np.linspace(0.0, 0.5, 20001)  # of the input rate
    gain = np.abs(np.exp(-2j * np.pi * np.outer(frequencies, np.arange(len(taps)))) @ taps)
    passed, stopped = frequencies <= 0.4 / factor, frequencies >= 0.6 / factor
    assert np.abs(gain[passed] - 1.0).max() < 10.0 ** (-83.0 / 20.0)  # Kaiser's formula is an estimate
    assert gain[stopped].max() < 10.0 ** (-83.0 / 20.0)
    # Oppenheim and Schafer, "Discrete-Time Signal Processing", Kaiser's formula: (A - 7.95) / (2.285 width) + 1 taps.
    needed = (85.0 - 7.95) / (2.285 * np.pi * 0.4 / factor) + 1.0
    assert needed <= len(taps) < needed + 2.0


def test_a_factor_is_split_into_stages_of_at_most_sixteen() -> None:
    assert [stages(factor) for factor in (1, 2, 16, 32, 1024, 51, 17, 34, 1)] == [
        [],
        [2],
        [16],
        [16, 2],
        [16, 16, 4],
        [3, 17],
        [17],
        [2, 17],
        [],
    ]


def test_a_cascade_keeps_the_pass_band_and_the_time() -> None:
    inputs = tone(0.2, 48.0, 48 * 200, 0.0)
    outputs = Cascade(48).process(inputs)
    exact = tone(0.2, 1.0, len(outputs), 0.0)
    assert 150 < len(outputs) < 200
    assert np.abs(outputs[60:] - exact[60:]).max() < 2e-4


@pytest.mark.parametrize("factor", [1, 0, -2])
def test_a_factor_below_two_is_refused(factor: int) -> None:
    with pytest.raises(ValueError, match=f"factor of {factor} is below 2"):
        Decimator(factor)
