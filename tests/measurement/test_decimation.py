"""The anti-alias filters, with analytic tones."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.measurement.decimation import Decimator


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
