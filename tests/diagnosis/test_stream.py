"""The stream's mending: whatever is wrong with the order of blocks is counted and leaves the turns right."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.diagnosis.stream import Stream, Stretch, bridged_turns
from dcrb_ros.runtime.refusal import Refusal

RATE = 10000
HOP, MARGIN, GAP = 1000, 50, 500
FREQUENCY = 21.3


def signal(first: int, samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Return a part of a signal that tells its index, and the angle of a shaft at a steady speed."""
    index = np.arange(first, first + samples)
    angle = np.mod(2.0 * math.pi * FREQUENCY * index / RATE, 2.0 * math.pi).astype(np.float32)
    return np.column_stack([index, -index]).astype(np.float32), angle


def fed(parts: list[tuple[int, int]]) -> tuple[Stream, list[Stretch]]:
    """Feed parts of the signal, each by first index and samples."""
    stream = Stream(HOP, MARGIN, GAP)
    return stream, [stretch for first, samples in parts for stretch in stream.take(first, *signal(first, samples))]


@given(cuts=st.lists(st.integers(1, 700), min_size=1, max_size=30))
def test_stretches_do_not_depend_on_the_blocks(cuts: list[int]) -> None:
    parts, first = [], 0
    for cut in cuts:
        parts.append((first, cut))
        first += cut
    (_, found), (_, whole) = fed(parts), fed([(0, first)])
    assert [stretch.last for stretch in found] == [stretch.last for stretch in whole] == [HOP * (k + 1) - 1 for k in range(first // HOP)]
    for one, other in zip(found, whole, strict=True):
        np.testing.assert_array_equal(one.acceleration, other.acceleration)
        np.testing.assert_array_equal(one.turns, other.turns)


def test_stretches_overlap_by_the_margins() -> None:
    _, (one, two) = fed([(0, 2 * HOP)])
    np.testing.assert_array_equal(one.acceleration[HOP:], two.acceleration[: 2 * MARGIN])
    assert (one.fresh, two.fresh) == (True, False)
    assert one.missing[: 2 * MARGIN].all()
    assert not two.missing.any()


@given(first=st.integers(200, 900), lost=st.integers(1, GAP))
def test_short_gap_is_bridged_at_the_shaft_speed(first: int, lost: int) -> None:
    stream, found = fed([(0, first), (first + lost, 3 * HOP)])
    assert (stream.counts.gaps, stream.counts.lost) == (1, lost)
    for stretch in found[1:]:
        assert stretch.turns is not None
        assert stretch.turns[-1] == pytest.approx(FREQUENCY * (HOP + 2 * MARGIN - 1) / RATE, abs=1e-3)
    assert sum(int(stretch.missing[MARGIN:-MARGIN].sum()) for stretch in found) == lost + MARGIN


def test_long_gap_begins_anew() -> None:
    stream, found = fed([(0, 1500), (1500 + GAP + 1, 1500)])
    assert stream.counts.gaps == 1
    assert [stretch.fresh for stretch in found] == [True, True]


@given(order=st.permutations(range(6)))
def test_late_and_repeated_blocks_are_left_out(order: list[int]) -> None:
    size = 300
    stream, found = fed([(size * k, size) for k in [0, *order, *order]])
    for stretch in found:
        known = ~stretch.missing
        np.testing.assert_array_equal(stretch.acceleration[known, 0], -stretch.acceleration[known, 1])
        assert np.all(np.diff(stretch.acceleration[known, 0]) > 0)
    assert stream.counts.repeated + stream.counts.restarts > 0


def test_stream_that_begins_again_is_followed() -> None:
    stream, found = fed([*((size, 500) for size in range(0, 3000, 500)), *((size, 500) for size in range(0, 3000, 500))])
    assert stream.counts.restarts == 1
    assert [stretch.last for stretch in found][:3] == [999, 1999, 2999]
    assert found[-1].last > 1000
    assert stream.counts.repeated == 500


@pytest.mark.parametrize(
    ("order", "lost", "repeated"),
    [([0, 3, 4, 1, 2, 5, 6, 7, 8, 9, 10], 2, 2), ([k + m for k in range(0, 12, 2) for m in (0, 1, 0, 1)], 0, 12)],
)
def test_blocks_that_overtake_each_other_are_no_new_beginning(order: list[int], lost: int, repeated: int) -> None:
    stream, found = fed([(200 * k, 200) for k in order])
    assert (stream.counts.restarts, stream.counts.lost, stream.counts.repeated) == (0, 200 * lost, 200 * repeated)
    assert [stretch.last for stretch in found] == [HOP - 1, 2 * HOP - 1]


def test_what_comes_again_from_close_by_is_left_out() -> None:
    stream, found = fed([(first, 200) for first in (0, 200, 400, 600, *range(0, 4000, 200))])
    assert (stream.counts.restarts, stream.counts.repeated) == (0, 800)
    assert [stretch.last for stretch in found] == [999, 1999, 2999, 3999]


def test_an_empty_block_ahead_makes_no_gap() -> None:
    stream, _ = fed([(0, 1000), (1200, 0), (1200, 0), (1200, 1000)])
    assert (stream.counts.gaps, stream.counts.lost) == (1, 200)


@given(cuts=st.lists(st.integers(1, 3000), min_size=1, max_size=8), places=st.sets(st.integers(0, 3999), max_size=20))
def test_what_is_no_number_counts_in_its_hop(cuts: list[int], places: set[int]) -> None:
    acceleration, angle = signal(0, 4000)
    acceleration[sorted(places), 0] = np.nan
    stream, first, found = Stream(HOP, MARGIN, GAP), 0, []
    for cut in (*cuts, 4000):
        found += list(stream.take(first, acceleration[first : first + cut], angle[first : first + cut]))
        first = min(4000, first + cut)
    assert [stretch.senseless for stretch in found] == [
        sum(HOP * k - MARGIN <= place < HOP * (k + 1) - MARGIN for place in places) for k in range(len(found))
    ]


def test_too_few_angles_are_none() -> None:
    angle = np.full(100, np.nan, np.float32)
    assert bridged_turns(angle) is None
    angle[3] = 1.0
    assert bridged_turns(angle) is None


@pytest.mark.parametrize("shape", [(10, 3), (10,), (9, 2)])
def test_misshapen_block_is_refused(shape: tuple[int, ...]) -> None:
    stream = Stream(HOP, MARGIN, GAP)
    with pytest.raises(Refusal, match=r"they must be \(samples, 2\)"):
        list(stream.take(0, np.zeros(shape, np.float32), np.zeros(10, np.float32)))


def test_words_for_samples_are_refused() -> None:
    stream = Stream(HOP, MARGIN, GAP)
    with pytest.raises(Refusal, match="must be numbers"):
        list(stream.take(0, np.full((10, 2), "x"), np.zeros(10, np.float32)))
