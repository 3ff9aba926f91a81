"""The marks by which entries are sorted: the share of correct last verdicts, its interval and the difference of two detectors."""

from __future__ import annotations

import math

import numpy as np
import pytest
from made_up_entries import entry, scenario

from dcrb_ros.exam.exam_score import draws
from dcrb_ros.exam.marking import ScoreMarking, VerdictMarking, compare, marking_of
from dcrb_ros.schema.refusal import Refusal

MARKING = VerdictMarking()


def test_classes_count_alike_whatever_their_number_of_scenarios() -> None:
    given = entry({"healthy": [True] * 8, "outer_ring": [True, False], "inner_ring": [False] * 4})
    assert MARKING.mark(given) == pytest.approx(50.0)
    assert MARKING.cells(given, MARKING.heads([given]))[1:] == ("8 of 8", "1 of 2", "0 of 4")


def test_a_right_answer_before_a_failure_does_not_count() -> None:
    failed = scenario("outer_ring1", "outer_ring", right=True).model_copy(update={"failure": "it ended"})
    assert MARKING.cells(entry({"outer_ring": [True]}, failed), MARKING.heads([entry({"outer_ring": [True]})]))[1:] == ("1 of 2",)
    assert MARKING.mark(entry({"outer_ring": [True]}, failed)) == pytest.approx(50.0)


def test_scenarios_that_are_not_required_have_no_effect_on_the_mark() -> None:
    right = {"healthy": [True, False], "outer_ring": [True, True]}
    rollers = [scenario(f"roller{k}", "roller", right=False, required=False) for k in range(3)]
    assert MARKING.series(entry(right, *rollers)) == MARKING.series(entry(right))
    with pytest.raises(Refusal, match="no required scenario and so no share of correct verdicts"):
        MARKING.mark(entry({}, *rollers))


def test_the_interval_is_that_of_a_mean_over_classes() -> None:
    classes = {"healthy": 0.8, "outer_ring": 0.4, "inner_ring": 0.6}
    given = entry({name: [k < 40 * share for k in range(40)] for name, share in classes.items()})
    value = MARKING.series(given)["correct verdicts"]
    # With n drawn of each class, the variance is that of the sample, p (1 - p) / (n - 1).
    spread = 100.0 / 3.0 * math.sqrt(sum(p * (1.0 - p) / 39.0 for p in classes.values()))
    assert MARKING.samples(given).std() == pytest.approx(spread, rel=0.05)
    assert (value.high - value.low) / 2.0 == pytest.approx(1.96 * spread, rel=0.08)


def test_the_difference_is_taken_on_the_same_scenarios() -> None:
    better = entry({"healthy": [True] * 20, "outer_ring": [k % 2 == 0 for k in range(20)]})
    worse = entry({"healthy": [k % 5 != 0 for k in range(20)], "outer_ring": [k % 2 == 0 for k in range(20)]})
    same, apart = compare(MARKING, better, better), compare(MARKING, better, worse)
    assert (same.low, same.high, same.confidence) == (0.0, 0.0, 0.5)
    # Of unpaired samples the outer ring alone would have a standard deviation of 8 percentage points.
    assert MARKING.mark(better) - MARKING.mark(worse) == pytest.approx(10.0)
    assert 0.0 < apart.low < apart.high < 20.0
    assert apart.distinguished
    turned = compare(MARKING, worse, better)
    assert turned.low == pytest.approx(-apart.high)
    assert turned.confidence == pytest.approx(1.0 - apart.confidence)


def test_a_class_with_one_scenario_leaves_the_mark_unknown() -> None:
    given = entry({"healthy": [True, True], "outer_ring": [True]})
    assert MARKING.series(given)["correct verdicts"] == (100.0, 0.0, 100.0)
    other = entry({"healthy": [False, False], "outer_ring": [False]})
    compared = compare(MARKING, given, other)
    assert (compared.confidence, compared.distinguished) == (0.5, False)


def test_entries_with_other_scenarios_are_refused() -> None:
    first, second = entry({"healthy": [True, True]}), entry({"healthy": [True, True], "outer_ring": [True]})
    with pytest.raises(Refusal, match="the detectors were evaluated on different scenarios"):
        compare(MARKING, first, second)


def test_entries_of_last_verdicts_are_sorted_by_them() -> None:
    assert isinstance(marking_of(entry({"healthy": [True]})), VerdictMarking)
    assert isinstance(marking_of(entry({"healthy": [True]}, last_verdict=False)), ScoreMarking)


def test_the_draws_are_made_once_and_cannot_be_written() -> None:
    first = draws(entry({"healthy": [True] * 3, "outer_ring": [True] * 4}).contributions())
    assert draws(entry({"healthy": [False] * 3, "outer_ring": [True] * 4}).contributions()) is first
    with pytest.raises(ValueError, match="read-only"):
        first[0, 0] = 1.0
    assert np.allclose(first.sum(axis=1), 7.0)
