"""The exam score: 0 for a detector that knows nothing, 100 for an oracle, and nothing gained by flicker, hindsight or silence."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.exam.breakdown import PARTIAL, difficulty, family_areas, overall_area, strata
from dcrb_ros.exam.credit import FINAL, GRACE, credit, period_of
from dcrb_ros.exam.criteria import Criteria
from dcrb_ros.exam.exam_score import RESAMPLES, Contribution, clean_factor, draws, exam_scores, upper_bound
from dcrb_ros.exam.expectation import Expectation
from dcrb_ros.exam.profile import PROFILES
from dcrb_ros.exam.scoring import score_scenario
from dcrb_ros.exam.statistics import characteristic, partial_area
from dcrb_ros.messages.received_diagnosis import ReceivedDiagnosis
from dcrb_ros.schema.verdicts import FAULT_CLASSES, VERDICTS

pytestmark = pytest.mark.slow

SHAFT = 2.0 * math.pi * 20.0
"""20 revolutions a second [rad/s]."""
TAGS: dict[str, str | float] = {"speed": SHAFT}
CRITERIA = Criteria()
EXAM = (
    Expectation("outer", "outer_ring", 20.0, 8.0, TAGS, twin="twin"),
    Expectation("inner", "inner_ring", 10.0, 4.0, TAGS),
    Expectation("both", "compound", 12.0, 6.0, TAGS, first_onset=5.0, twin="twin"),
    Expectation("dead", "sensor", 20.0, 6.0, TAGS, twin="twin"),
    Expectation("twin", "healthy", 20.0, tags=TAGS),
    Expectation("track", "healthy", 33.0, tags=TAGS),
)
STEP = 0.5
"""Time between two diagnoses [s]."""
Answers = Mapping[str, Sequence[ReceivedDiagnosis]]


def times(expectation: Expectation) -> list[float]:
    return [STEP * k for k in range(round(expectation.duration / STEP) + 1)]


def truth(expectation: Expectation, time: float) -> str:
    return expectation.verdict if expectation.faulty and time >= expectation.onset else "healthy"


def answers(verdict: object) -> Answers:
    """Return diagnoses of the exam; ``verdict`` is called with the expectation and the time, or is the answer itself."""
    return {e.name: [ReceivedDiagnosis(t, verdict(e, t) if callable(verdict) else str(verdict)) for t in times(e)] for e in EXAM}


def contributions(given: Answers) -> list[Contribution]:
    return [Contribution(e.name, e.verdict, credit(e, given[e.name], CRITERIA)) for e in EXAM]


def values(given: Answers) -> list[float]:
    """Return the exam score of every profile."""
    return [one.score.value for one in exam_scores(contributions(given))]


def parts(given: Answers) -> list[float]:
    """Return everything that enters the score, so that a larger value never makes a smaller score."""
    found = [one.credit for one in contributions(given)]
    return [value for one in found for value in (*one.detection.values(), -float(one.failed))]


def assert_no_better(worse: Answers, better: Answers) -> None:
    assert all(low <= high + 1e-9 for low, high in zip(parts(worse), parts(better), strict=True))
    assert all(low <= high + 1e-6 for low, high in zip(values(worse), values(better), strict=True))


spoken = st.sampled_from(VERDICTS)


@st.composite
def detectors(draw: st.DrawFn) -> dict[str, list[ReceivedDiagnosis]]:
    """Return diagnoses that persist for a while, with gaps and late arrivals."""
    given: dict[str, list[ReceivedDiagnosis]] = {}
    for expectation in EXAM:
        own: list[ReceivedDiagnosis] = []
        verdict = "healthy"
        for time in times(expectation):
            action = draw(st.integers(0, 9))
            verdict = truth(expectation, time) if action < 4 else draw(spoken) if action == 4 else verdict
            if action < 8:
                own.append(ReceivedDiagnosis(time, verdict, signal_received=time + draw(st.sampled_from([0.0, 0.3, 7.0]))))
        given[expectation.name] = own
    return given


def test_an_oracle_scores_100_in_every_profile() -> None:
    assert values(answers(truth)) == [100.0, 100.0, 100.0]


@pytest.mark.parametrize("verdict", ["healthy", "waiting", *(fault for fault in FAULT_CLASSES if fault != "healthy")])
def test_one_verdict_for_everything_scores_0(verdict: str) -> None:
    assert values(answers(verdict)) == [0.0, 0.0, 0.0]


def test_a_detector_that_flickers_all_the_time_scores_0() -> None:
    flicker = answers(lambda e, t: "outer_ring" if round(t / STEP) % 2 else "healthy")
    assert values(flicker) == [0.0, 0.0, 0.0]


def test_silence_scores_0() -> None:
    assert values({e.name: [] for e in EXAM}) == [0.0, 0.0, 0.0]


@given(detectors(), st.data())
def test_a_correct_verdict_instead_of_another_never_lowers_the_score(
    given_: dict[str, list[ReceivedDiagnosis]], data: st.DataObject
) -> None:
    name = data.draw(st.sampled_from([name for name, own in given_.items() if own]))
    expectation = next(e for e in EXAM if e.name == name)
    number = data.draw(st.integers(0, len(given_[name]) - 1))
    better = list(given_[name])
    better[number] = replace(better[number], verdict=truth(expectation, better[number].time))
    assert_no_better(given_, {**given_, name: better})


@given(detectors(), st.data(), st.floats(0.0, 20.0))
def test_a_later_arrival_never_raises_the_score(given_: dict[str, list[ReceivedDiagnosis]], data: st.DataObject, late: float) -> None:
    name = data.draw(st.sampled_from([name for name, own in given_.items() if own]))
    number = data.draw(st.integers(0, len(given_[name]) - 1))
    worse = list(given_[name])
    worse[number] = replace(worse[number], signal_received=worse[number].issued_at + late)
    assert_no_better({**given_, name: worse}, given_)


@given(detectors(), st.data())
def test_silence_in_a_healthy_run_never_raises_the_score(given_: dict[str, list[ReceivedDiagnosis]], data: st.DataObject) -> None:
    name = data.draw(st.sampled_from(["twin", "track"]))
    assert_no_better({**given_, name: []}, given_)


@given(detectors(), st.data())
def test_waiting_instead_of_a_correct_verdict_never_raises_the_score(
    given_: dict[str, list[ReceivedDiagnosis]], data: st.DataObject
) -> None:
    """The last one is left out, since it takes the place of nothing else."""
    name = data.draw(st.sampled_from([name for name, own in given_.items() if own]))
    expectation = next(e for e in EXAM if e.name == name)
    worse = [replace(d, verdict="waiting") if d.verdict == truth(expectation, d.time) else d for d in given_[name]]
    wrong_only = [d for d in given_[name] if d.verdict != truth(expectation, d.time)]
    assert parts({**given_, name: worse}) == parts({**given_, name: wrong_only})


@given(st.lists(spoken, min_size=13, max_size=13))
def test_cycling_through_the_names_gains_no_more_than_the_share_of_the_time(names: list[str]) -> None:
    """The credit of each instant depends on the verdict at that instant alone: the credits of all names add up to that of one."""
    expectation = EXAM[1]
    healthy = [ReceivedDiagnosis(t, "healthy") for t in times(expectation) if t < expectation.onset]
    after = [t for t in times(expectation) if t >= expectation.onset]
    total = 0.0
    for fault in ("outer_ring", "inner_ring", "roller", "cage", "compound"):
        own = replace(expectation, verdict=fault)
        given_ = [*healthy, *(ReceivedDiagnosis(t, verdict) for t, verdict in zip(after, names, strict=True))]
        found = credit(own, given_, CRITERIA).detection["research"]
        alarm = credit(
            own, [replace(d, verdict=fault) if d.verdict not in ("healthy", "waiting", "sensor") else d for d in given_], CRITERIA
        )
        total += 2.0 * found - alarm.detection["research"]  # the half for the name
    assert total <= 1.0 + 1e-9


@given(st.floats(0.0, 8.9))
def test_a_detection_is_worth_its_delay_in_revolutions(delay: float) -> None:
    """Half after the grace and one half-life, whatever the speed."""
    expectation = EXAM[0]
    given_ = [ReceivedDiagnosis(0.0, "healthy"), ReceivedDiagnosis(4.0, "healthy")]
    given_ += [ReceivedDiagnosis(8.0 + t, "outer_ring") for t in np.arange(delay, 12.0, 1.0).tolist()]
    found = credit(expectation, given_, CRITERIA).detection
    late = max(0.0, 20.0 * delay - GRACE)
    assert found["research"] == pytest.approx(2.0 ** (-late / 100.0))
    assert found["safety"] == pytest.approx(2.0 ** (-late / 50.0))
    assert found["cost"] == pytest.approx(1.0)


def test_a_wrong_name_costs_the_share_of_the_profile() -> None:
    found = credit(EXAM[1], [ReceivedDiagnosis(t, truth(EXAM[1], t).replace("inner", "outer")) for t in times(EXAM[1])], CRITERIA)
    assert [found.detection[p.name] for p in PROFILES] == pytest.approx([1.0 - p.naming for p in PROFILES])


def test_an_alarm_that_stands_at_the_onset_detects_nothing() -> None:
    own = [ReceivedDiagnosis(t, "inner_ring" if t >= 3.5 else "healthy") for t in times(EXAM[1])]
    assert set(credit(EXAM[1], own, CRITERIA).detection.values()) == {0.0}


def test_the_rest_of_the_credit_is_for_the_end_of_the_run() -> None:
    """An alarm that ends too soon keeps the weight of the time during which it stood."""
    onset, final = 8.0, 20.0 - FINAL * 12.0
    own = [ReceivedDiagnosis(t, "outer_ring" if onset <= t < final else "healthy") for t in times(EXAM[0])]
    found = credit(EXAM[0], own, CRITERIA).detection
    assert found["cost"] == 0.0
    assert found["research"] == pytest.approx(1.0 - 2.0 ** -((20.0 * (final - onset) - GRACE) / 100.0))
    # The last quarter of the 12 s after the onset, docs/explanation/exam.md: half of it is worth half of what is left.
    own = [ReceivedDiagnosis(t, "outer_ring" if onset <= t < 18.5 else "healthy") for t in times(EXAM[0])]
    found = credit(EXAM[0], own, CRITERIA).detection
    assert found["cost"] == pytest.approx(0.5)
    assert found["research"] == pytest.approx(1.0 - 0.5 * 2.0 ** -((20.0 * (17.0 - onset) - GRACE) / 100.0))


def test_healthy_periods_cover_the_healthy_time_and_are_no_shorter_than_silence_may_last() -> None:
    found = {e.name: credit(e, answers(truth)[e.name], CRITERIA) for e in EXAM}
    assert period_of(CRITERIA) == 5.0
    assert period_of(Criteria(silence=0.2)) == 1.0
    # The healthy time of inner is before its onset; dead has bearing alarms to avoid from its onset to its end.
    assert {name: one.periods for name, one in found.items()} == {"outer": 0, "inner": 1, "both": 0, "dead": 2, "twin": 4, "track": 6}
    assert not any(one.failed for one in found.values())


def test_a_false_alarm_spoils_the_periods_in_which_it_stands() -> None:
    def spoiled(*alarms: float) -> int:
        return credit(EXAM[4], [ReceivedDiagnosis(t, "cage" if t in alarms else "healthy") for t in times(EXAM[4])], CRITERIA).failed

    assert (spoiled(2.0), spoiled(2.0, 3.0), spoiled(2.0, 7.0), spoiled(20.0)) == (1, 1, 2, 1)
    standing = [ReceivedDiagnosis(4.0, "cage"), *(ReceivedDiagnosis(t, "healthy") for t in (8.0, 12.0, 17.0))]
    assert credit(EXAM[4], standing, CRITERIA).failed == 2


def test_periods_without_a_verdict_in_time_are_spoiled() -> None:
    at = [ReceivedDiagnosis(t, "healthy") for t in (3.0, 8.0, 19.0)]
    assert credit(EXAM[4], at, CRITERIA).failed == 1
    assert credit(EXAM[4], at, CRITERIA).silent == pytest.approx(20.0 - 5.0 - 5.0 - 1.0)
    assert credit(EXAM[4], [replace(d, signal_received=20.0) for d in at], CRITERIA).failed == 3


def test_the_factor_for_false_alarms_has_its_ends() -> None:
    assert float(clean_factor(0.0, 50.0)) == 1.0
    assert float(clean_factor(50.0, 50.0)) == 0.0
    assert np.all(np.diff(clean_factor(np.arange(51.0), 50.0)) < 0.0)
    # Garwood 1936, as in every table of Poisson limits: 3.00 for none and 4.74 for one, one-sided at 95 %.
    assert upper_bound(np.array([0.0, 1.0])) == pytest.approx([2.996, 4.744], abs=5e-4)


def test_families_count_alike_however_many_scenarios_they_have() -> None:
    good, missed = answers(truth), answers("healthy")
    one = contributions({**good, "outer": missed["outer"]})
    twice = [*one, replace(one[0], name="outer again")]
    assert exam_scores(one)[2].detection == exam_scores(twice)[2].detection == 0.75


def test_there_is_no_score_without_a_fault_or_without_healthy_time() -> None:
    whole = contributions(answers(truth))
    assert exam_scores([one for one in whole if one.family == "healthy"]) == []
    assert exam_scores([one for one in whole if one.name in ("outer", "both")]) == []
    assert exam_scores([]) == []


def test_the_bootstrap_draws_within_families_and_the_same_for_every_order() -> None:
    whole = contributions(answers(truth))
    many = [replace(one, name=f"{one.name}{k}") for one in whole for k in range(5)]
    counts = draws(many)
    assert counts.shape == (RESAMPLES, 30)
    for family in {one.family for one in many}:
        members = [k for k, one in enumerate(many) if one.family == family]
        assert counts[:, members].sum(axis=1) == pytest.approx(len(members))
        # Independent scenarios: the mean of n has the variance s^2 / n with the unbiased s^2.
        values = np.arange(float(len(members)))
        assert np.var(counts[:, members] @ values / len(members)) == pytest.approx(np.var(values, ddof=1) / len(members), rel=0.1)
    assert np.array_equal(draws(many[::-1])[:, ::-1], counts)


def test_the_interval_contains_the_score_and_shrinks_with_the_scenarios() -> None:
    half = answers(lambda e, t: truth(e, t) if e.name != "outer" else "healthy")
    whole = contributions(half)

    def many(count: int) -> list[Contribution]:
        found = [replace(whole[1], name=f"hit{k}", family="inner_ring") for k in range(count)]
        return [*found, *(replace(whole[0], name=f"miss{k}", family="inner_ring") for k in range(count)), *whole[4:]]

    few, more = exam_scores(many(4))[2].score, exam_scores(many(64))[2].score
    assert few.low < few.value < few.high
    assert more.high - more.low < 0.5 * (few.high - few.low)


@given(st.lists(st.integers(0, 5), min_size=1, max_size=12), st.lists(st.integers(0, 5), min_size=10, max_size=40))
def test_the_partial_area_is_that_of_the_highest_healthy_scores(faulty: list[int], healthy: list[int]) -> None:
    """Compared with the definition of DCASE 2020 task 2, written out."""
    top = sorted(healthy, reverse=True)[: math.floor(PARTIAL * len(healthy))]
    pairs = [(x > y) + 0.5 * (x == y) for x in faulty for y in top]
    assert partial_area(faulty, healthy, PARTIAL) == pytest.approx(sum(pairs) / len(pairs))
    whole = characteristic(faulty, healthy)
    assert whole is not None
    assert partial_area(faulty, healthy, 1.0) == pytest.approx(whole.area)


def test_a_partial_area_takes_ten_healthy_scores() -> None:
    assert partial_area([1.0], [0.0] * 9, 0.1) is None
    assert partial_area([1.0], [0.0] * 10, 0.1) == 1.0


def test_without_areas_there_is_no_overall_area() -> None:
    assert math.isnan(overall_area([]))


def test_areas_are_given_for_each_family_and_a_missing_score_is_the_least_convincing() -> None:
    def scored(expectation: Expectation, score: float | None) -> object:
        return score_scenario(expectation, [ReceivedDiagnosis(t, truth(expectation, t), score) for t in times(expectation)], CRITERIA)

    results = [scored(e, 2.0 if e.faulty else 1.0) for e in EXAM]
    areas = family_areas(results)  # type: ignore[arg-type]
    assert [(one.verdict, one.faulty, one.healthy, one.area, one.partial) for one in areas] == [
        ("outer_ring", 1, 2, 1.0, None),
        ("inner_ring", 1, 2, 1.0, None),
        ("compound", 1, 2, 1.0, None),
    ]
    assert overall_area(areas) == 1.0
    silent = family_areas([scored(EXAM[0], None), scored(EXAM[4], 1.0)])  # type: ignore[list-item]
    assert [one.area for one in silent] == [0.0]
    assert family_areas([scored(EXAM[0], None)]) == []  # type: ignore[list-item]


def test_scenarios_are_sorted_by_the_width_of_the_defect_or_by_their_tag() -> None:
    def at(**tags: str | float) -> Expectation:
        return Expectation("x", "outer_ring", 10.0, 4.0, tags)

    names = [difficulty(at(width=w), CRITERIA)[1] for w in (0.0005, 0.001, 0.002)]
    assert names == ["below 1 mm, not required", "1 to 2 x 1 mm", "from 2 mm on"]
    assert difficulty(at(), CRITERIA)[1] == "without a width"
    assert difficulty(at(width=0.002, difficulty="masked"), CRITERIA)[1] == "masked"
    found = strata([score_scenario(e, answers(truth)[e.name], CRITERIA) for e in EXAM], CRITERIA)
    assert [(one.name, one.scenarios, one.found, one.credit) for one in found] == [("without a width", 4, 4, 1.0)]


def test_a_diagnosis_that_arrives_after_the_run_earns_nothing() -> None:
    own = answers(truth)["outer"]
    after = [replace(d, signal_received=20.0) if d.time >= 8.0 else d for d in own]
    assert set(credit(EXAM[0], after, CRITERIA).detection.values()) == {0.0}
