"""The rank correlation between an exam and measured recordings."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from made_up_entries import entry
from scipy.stats import kendalltau, spearmanr

from dcrb_ros.exam.agreement import agreement
from dcrb_ros.exam.correlation import kendall_tau, spearman_rho
from dcrb_ros.exam.leaderboard_entry import Entry
from dcrb_ros.exam.marking import VerdictMarking
from dcrb_ros.schema.refusal import Refusal


def skilled(detector: str, skill: float, count: int = 20, seed: int | None = None) -> Entry:
    """Return an entry with outer and inner ring faults of which the share ``skill`` is found, and healthy time without an alarm.

    The first faults are found, or with a ``seed`` any of them.
    """
    order = np.arange(count) if seed is None else np.random.default_rng(seed).permutation(count)
    found = [bool(place < skill * count) for place in order]
    return entry({"healthy": [True] * count, "outer_ring": found, "inner_ring": found}, detector=detector, last_verdict=False)


def entries(*skills: float) -> list[Entry]:
    return [skilled(f"d{k}", skill) for k, skill in enumerate(skills)]


def test_the_share_of_correct_verdicts_is_the_mean_over_the_classes() -> None:
    assert VerdictMarking().mark(skilled("a", 0.25)) == pytest.approx(100.0 * (1.0 + 0.25 + 0.25) / 3.0)


@pytest.mark.parametrize(
    ("second", "tau", "rho"), [((0.1, 0.4, 0.7, 0.9), 1.0, 1.0), ((0.9, 0.7, 0.4, 0.1), -1.0, -1.0), ((0.4, 0.1, 0.7, 0.9), 4 / 6, 0.8)]
)
def test_the_correlation_is_that_of_the_ranks(second: tuple[float, ...], tau: float, rho: float) -> None:
    found = agreement(entries(0.2, 0.5, 0.8, 1.0), entries(*second))
    assert found.kendall.value == pytest.approx(tau)
    assert found.spearman.value == pytest.approx(rho)
    assert found.kendall.low <= tau + 1e-9
    assert tau - 1e-9 <= found.kendall.high
    assert found.detectors == ("d3", "d2", "d1", "d0")
    assert list(found.exam) == sorted(found.exam, reverse=True)


def width(count: int) -> float:
    """Return the width of the interval of four detectors of different skill, each with ``count`` faults of a kind."""
    both = [skilled(f"d{k}", skill, count, seed=k) for k, skill in enumerate((0.4, 0.5, 0.6, 0.7))]
    found = agreement(both, both).kendall
    return found.high - found.low


def test_few_scenarios_make_a_wide_interval() -> None:
    assert width(400) < 0.2
    assert width(10) > 0.5


@pytest.mark.parametrize(("exam", "measured"), [(1, 1), (1, 20), (20, 1)])
def test_a_class_with_one_scenario_leaves_the_correlation_unknown(exam: int, measured: int) -> None:
    sides = ([skilled(f"d{k}", skill, count) for k, skill in enumerate((0.0, 0.5, 1.0))] for count in (exam, measured))
    found = agreement(*sides)
    assert (found.kendall[1:], found.spearman[1:]) == ((-1.0, 1.0), (-1.0, 1.0))


def test_detectors_that_all_score_alike_say_nothing() -> None:
    assert agreement(entries(0.2, 0.5, 0.8), entries(0.5, 0.5, 0.5)).kendall.value == 0.0


@given(arrays(np.int64, (2, 7), elements=st.integers(0, 4)))
def test_the_correlations_are_those_of_scipy_with_ties(ranks: np.ndarray) -> None:
    first, second = ranks.astype(float)[:, :, None]
    for ours, theirs in ((kendall_tau, kendalltau), (spearman_rho, spearmanr)):
        found = float(ours(first, second)[0])
        if np.ptp(first) == 0.0 or np.ptp(second) == 0.0:
            assert found == 0.0
        else:
            assert found == pytest.approx(theirs(first[:, 0], second[:, 0]).statistic, abs=1e-12)


def test_too_few_detectors_and_two_of_one_name_are_refused() -> None:
    with pytest.raises(Refusal, match=r"the two folders have 2 detectors in common \(d0, d1\)"):
        agreement(entries(0.1, 0.2), entries(0.1, 0.2, 0.3))
    other = entries(0.1, 0.2, 0.3)
    other[1] = other[1].model_copy(update={"scenarios_sha256": "f" * 64})
    with pytest.raises(Refusal, match=r"the measured recordings have 2 sets of scenarios \(60 recordings, f{16}\): compare entries"):
        agreement(entries(0.1, 0.2, 0.3), other)
    other[1] = skilled("d1", 0.2, 21)
    with pytest.raises(Refusal, match=r"the measured recordings have 2 sets of scenarios \(60 recordings, 63 recordings\)"):
        agreement(entries(0.1, 0.2, 0.3), other)
    with pytest.raises(Refusal, match="two entries of the exam are called 'd0'"):
        agreement([*entries(0.1, 0.2), skilled("d0", 0.3)], entries(0.1, 0.2, 0.3))
