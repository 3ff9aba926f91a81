"""Segments from blocks that are lost, late, repeated or not finite."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.diagnosis.segments import Segment, Segmenter, _wrapped, bridged_turns
from dcrb_ros.schema.refusal import Refusal

RATE = 10000
HOP, MARGIN, GAP = 1000, 50, 500
FREQUENCY = 21.3


def signal(first: int, samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Return a signal equal to its index, and the angle of a shaft at constant speed."""
    index = np.arange(first, first + samples)
    angle = np.mod(2.0 * math.pi * FREQUENCY * index / RATE, 2.0 * math.pi).astype(np.float32)
    return np.column_stack([index, -index]).astype(np.float32), angle


def segmented(parts: list[tuple[int, int]]) -> tuple[Segmenter, list[Segment]]:
    """Return the segments of blocks of the signal, each given by its first index and length."""
    segmenter = Segmenter(HOP, MARGIN, GAP)
    return segmenter, [segment for first, samples in parts for segment in segmenter.add(first, *signal(first, samples))]


@given(cuts=st.lists(st.integers(1, 700), min_size=1, max_size=30))
def test_segments_do_not_depend_on_the_blocks(cuts: list[int]) -> None:
    parts, first = [], 0
    for cut in cuts:
        parts.append((first, cut))
        first += cut
    (_, found), (_, whole) = segmented(parts), segmented([(0, first)])
    assert [segment.last for segment in found] == [segment.last for segment in whole] == [HOP * (k + 1) - 1 for k in range(first // HOP)]
    for one, other in zip(found, whole, strict=True):
        np.testing.assert_array_equal(one.acceleration, other.acceleration)
        np.testing.assert_array_equal(one.turns, other.turns)


def test_a_long_block_is_held_hop_by_hop() -> None:
    segmenter = Segmenter(HOP, MARGIN, GAP)
    held = [segmenter._held for _ in segmenter.add(0, *signal(0, 50 * HOP + 7))]
    assert (len(held), max(held)) == (50, 2 * MARGIN)


@pytest.mark.parametrize("hours", [0, 10])
@pytest.mark.parametrize("sign", [1, -1])
def test_an_angle_that_is_not_wrapped_keeps_its_resolution(hours: int, sign: int) -> None:
    acceleration, _ = signal(0, 2 * HOP)
    turns = sign * FREQUENCY * (3600 * hours + np.arange(2 * HOP) / RATE)
    segments = list(Segmenter(HOP, MARGIN, GAP).add(0, acceleration, 2.0 * math.pi * turns))
    found = segments[-1].turns
    assert found is not None
    np.testing.assert_allclose(np.diff(found), sign * FREQUENCY / RATE, atol=2e-7)


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_a_wrapped_angle_is_taken_as_it_is(kind: Any) -> None:
    wrapped = np.array([0.0, 1e-9, 3.0, 6.2831853, np.float32(2.0 * np.pi), -3.14, np.nan, -np.inf], kind)
    np.testing.assert_array_equal(_wrapped(wrapped)[:-1], wrapped.astype(np.float32)[:-1])
    assert not np.isfinite(_wrapped(wrapped)[-2:]).any()


@pytest.mark.parametrize("axes", [1, 3])
def test_the_first_block_tells_the_number_of_axes(axes: int) -> None:
    segmenter, (first, angle) = Segmenter(HOP, MARGIN, GAP), signal(0, 2 * HOP)
    samples = np.column_stack([first[:, 0] * (k + 1) for k in range(axes)])
    samples[MARGIN + 7, axes - 1] = np.nan
    found = [*segmenter.add(0, samples[:HOP], angle[:HOP]), *segmenter.add(HOP + 10, samples[HOP + 10 :], angle[HOP + 10 :])]
    assert found[0].acceleration.shape == (HOP + 2 * MARGIN, axes)
    assert found[0].acceleration[3 * MARGIN, axes - 1] == MARGIN * axes
    assert (found[0].not_finite, found[0].missing[2 * MARGIN :].sum()) == (1, 1)
    with pytest.raises(Refusal, match=rf"acceleration \(5, 2\) .* they must be \(samples, {axes}\)"):
        list(segmenter.add(2 * HOP, np.zeros((5, 2)), np.zeros(5)))
    with pytest.raises(Refusal, match="with one to three axes"):
        list(Segmenter(HOP, MARGIN, GAP).add(0, np.zeros((5, 4)), np.zeros(5)))


def test_segments_overlap_by_the_margins() -> None:
    _, (one, two) = segmented([(0, 2 * HOP)])
    np.testing.assert_array_equal(one.acceleration[HOP:], two.acceleration[: 2 * MARGIN])
    assert (one.first, two.first) == (True, False)
    assert one.missing[: 2 * MARGIN].all()
    assert not two.missing.any()


@given(first=st.integers(200, 900), lost=st.integers(1, GAP))
def test_short_gap_is_bridged_at_the_shaft_speed(first: int, lost: int) -> None:
    segmenter, found = segmented([(0, first), (first + lost, 3 * HOP)])
    assert (segmenter.counts.gaps, segmenter.counts.lost) == (1, lost)
    for segment in found[1:]:
        assert segment.turns is not None
        assert segment.turns[-1] == pytest.approx(FREQUENCY * (HOP + 2 * MARGIN - 1) / RATE, abs=1e-3)
    assert sum(int(segment.missing[MARGIN:-MARGIN].sum()) for segment in found) == lost + MARGIN


def test_a_long_gap_restarts_the_segments() -> None:
    segmenter, found = segmented([(0, 1500), (1500 + GAP + 1, 1500)])
    assert segmenter.counts.gaps == 1
    assert [segment.first for segment in found] == [True, True]


@given(st.lists(st.tuples(st.integers(0, 2 * GAP), st.integers(1, 1500)), min_size=1, max_size=8), st.integers(0, 2 * HOP))
def test_aligned_segments_are_those_of_the_whole_signal(parts: list[tuple[int, int]], origin: int) -> None:
    """Blocks, each after a gap that may be bridged or not: every segment ends a multiple of the hop after the origin."""
    segmenter, index, found = Segmenter(HOP, MARGIN, GAP), 0, []
    segmenter.align(origin)
    for lost, samples in parts:
        found += list(segmenter.add(index + lost, *signal(index + lost, samples)))
        index += lost + samples
    assert segmenter.counts.lost == sum(lost for lost, _ in parts[1:])
    for segment in found:
        assert (segment.last + 1 - origin) % HOP == 0
        at = np.arange(segment.last + 1 - HOP - 2 * MARGIN, segment.last + 1)
        np.testing.assert_array_equal(segment.acceleration[:, 0], np.where(segment.missing, 0, at))


@given(order=st.permutations(range(6)))
def test_late_and_repeated_blocks_are_ignored(order: list[int]) -> None:
    size = 300
    segmenter, found = segmented([(size * k, size) for k in [0, *order, *order]])
    for segment in found:
        known = ~segment.missing
        np.testing.assert_array_equal(segment.acceleration[known, 0], -segment.acceleration[known, 1])
        assert np.all(np.diff(segment.acceleration[known, 0]) > 0)
    assert segmenter.counts.repeated + segmenter.counts.restarts > 0


def test_a_restarted_signal_is_followed() -> None:
    segmenter, found = segmented([*((size, 500) for size in range(0, 3000, 500)), *((size, 500) for size in range(0, 3000, 500))])
    assert segmenter.counts.restarts == 1
    assert [segment.last for segment in found][:3] == [999, 1999, 2999]
    assert found[-1].last > 1000
    assert segmenter.counts.repeated == 500


@pytest.mark.parametrize("begins", [[500 * k + k for k in range(8)], [500 * k + (-1) ** k for k in range(1, 9)]], ids=["lost", "jitter"])
def test_a_restarted_signal_with_gaps_or_inexact_times_is_followed(begins: list[int]) -> None:
    segmenter, found = segmented([*((500 * k, 500) for k in range(8)), *((begin, 500) for begin in begins)])
    assert segmenter.counts.restarts == 1
    assert segmenter.counts.repeated < 1100
    assert [segment.first for segment in found] == [True, False, False, False, True, False, False]


@pytest.mark.parametrize(
    ("order", "lost", "repeated"),
    [([0, 3, 4, 1, 2, 5, 6, 7, 8, 9, 10], 2, 2), ([k + m for k in range(0, 12, 2) for m in (0, 1, 0, 1)], 0, 12)],
)
def test_blocks_that_overtake_each_other_are_not_a_restart(order: list[int], lost: int, repeated: int) -> None:
    segmenter, found = segmented([(200 * k, 200) for k in order])
    assert (segmenter.counts.restarts, segmenter.counts.lost, segmenter.counts.repeated) == (0, 200 * lost, 200 * repeated)
    assert [segment.last for segment in found] == [HOP - 1, 2 * HOP - 1]


def test_a_short_repetition_is_ignored() -> None:
    segmenter, found = segmented([(first, 200) for first in (0, 200, 400, 600, *range(0, 4000, 200))])
    assert (segmenter.counts.restarts, segmenter.counts.repeated) == (0, 800)
    assert [segment.last for segment in found] == [999, 1999, 2999, 3999]


def test_an_empty_block_makes_no_gap() -> None:
    segmenter, _ = segmented([(0, 1000), (1200, 0), (1200, 0), (1200, 1000)])
    assert (segmenter.counts.gaps, segmenter.counts.lost) == (1, 200)


@given(cuts=st.lists(st.integers(1, 3000), min_size=1, max_size=8), places=st.sets(st.integers(0, 3999), max_size=20))
def test_samples_that_are_not_finite_are_counted_in_their_hop(cuts: list[int], places: set[int]) -> None:
    acceleration, angle = signal(0, 4000)
    acceleration[sorted(places), 0] = np.nan
    segmenter, first, found = Segmenter(HOP, MARGIN, GAP), 0, []
    for cut in (*cuts, 4000):
        found += list(segmenter.add(first, acceleration[first : first + cut], angle[first : first + cut]))
        first = min(4000, first + cut)
    assert [segment.not_finite for segment in found] == [
        sum(HOP * k - MARGIN <= place < HOP * (k + 1) - MARGIN for place in places) for k in range(len(found))
    ]


def test_too_few_angles_give_no_turns() -> None:
    angle = np.full(100, np.nan, np.float32)
    assert bridged_turns(angle) is None
    angle[3] = 1.0
    assert bridged_turns(angle) is None


@pytest.mark.parametrize("shape", [(10, 4), (10,), (9, 2), ()])
def test_a_block_of_the_wrong_shape_is_refused(shape: tuple[int, ...]) -> None:
    segmenter = Segmenter(HOP, MARGIN, GAP)
    with pytest.raises(Refusal, match=r"they must be \(samples, 2\)"):
        list(segmenter.add(0, np.zeros(shape, np.float32), np.zeros(10, np.float32)))


@pytest.mark.parametrize("value", ["x", 1j, True])
def test_values_that_are_not_real_numbers_are_refused(value: object) -> None:
    segmenter = Segmenter(HOP, MARGIN, GAP)
    with pytest.raises(Refusal, match="must be real numbers"):
        list(segmenter.add(0, np.full((10, 2), value), np.zeros(10, np.float32)))


@pytest.mark.parametrize("masked", [0, 1])
def test_a_block_with_masked_values_is_refused(masked: int) -> None:
    segmenter, block = Segmenter(HOP, MARGIN, GAP), [np.zeros((10, 2), np.float32), np.zeros(10, np.float32)]
    block[masked] = np.ma.masked_equal(block[masked], 0.0)
    with pytest.raises(Refusal, match="masked values is refused: replace them by NaN"):
        list(segmenter.add(0, block[0], block[1]))
