"""Scoring at its limits: exactly in time, exactly at the onset, exactly as long a silence."""

from __future__ import annotations

import math

import pytest

from dcrb_ros.exam.criteria import Criteria
from dcrb_ros.exam.expectation import Expectation
from dcrb_ros.exam.scoring import NO_ANSWER, ScenarioResult, score_scenario
from dcrb_ros.messages.received_diagnosis import LATEST, ReceivedDiagnosis, decode_diagnosis
from dcrb_ros.messages.statuses import Status, encode_diagnostics
from dcrb_ros.schema.refusal import Refusal

SPALL = Expectation("outer", "outer_ring", 10.0, 4.0)


def at(*diagnoses: tuple[float, str]) -> list[ReceivedDiagnosis]:
    return [ReceivedDiagnosis(time, verdict) for time, verdict in diagnoses]


def scored(expectation: Expectation, *diagnoses: tuple[float, str], **criteria: object) -> ScenarioResult:
    return score_scenario(expectation, at(*diagnoses), Criteria.model_validate(criteria))


@pytest.mark.parametrize(("time", "delay"), [(4.0, 0.0), (9.0, 5.0), (9.01, None), (3.99, None)])
def test_a_detection_counts_from_the_onset_to_the_limit_inclusive(time: float, delay: float | None) -> None:
    found = scored(SPALL, (time, "outer_ring"))
    assert found.delay == (None if delay is None else pytest.approx(delay))


def test_a_verdict_that_arrives_after_the_limit_is_late_whatever_its_stamp() -> None:
    for received, delay in ((9.0, 5.0), (9.5, None)):
        found = score_scenario(SPALL, [ReceivedDiagnosis(5.0, "outer_ring", signal_received=received)], Criteria())
        assert found.delay == delay


def test_an_alarm_is_false_before_the_onset_and_not_at_it() -> None:
    assert len(scored(SPALL, (3.99, "inner_ring")).false_alarms) == 1
    assert not scored(SPALL, (4.0, "inner_ring")).false_alarms


def test_the_delay_of_any_alarm_is_given_beside_that_of_the_correct_verdict() -> None:
    found = scored(SPALL, (4.5, "inner_ring"), (6.0, "outer_ring"))
    assert (found.alarm_delay, found.delay) == (0.5, 2.0)
    assert scored(SPALL, (5.0, "sensor")).alarm_delay == 1.0
    assert scored(Expectation("well", "healthy", 10.0), (5.0, "sensor")).alarm_delay is None


def test_the_answer_is_the_most_frequent_verdict_after_the_limit_and_the_later_of_two() -> None:
    assert scored(SPALL, (8.99, "cage"), (9.0, "roller"), (9.5, "outer_ring")).answer == "outer_ring"
    assert scored(SPALL, (9.0, "roller"), (9.2, "roller"), (9.5, "outer_ring")).answer == "roller"
    assert scored(SPALL, (9.0, "outer_ring"), (9.5, "roller")).answer == "roller"
    assert scored(SPALL, (5.0, "cage"), (8.0, "roller")).answer == "roller"  # none after the limit: the last one
    assert scored(SPALL, (9.0, "waiting"), (9.1, "waiting"), (9.2, "cage")).answer == "cage"
    assert scored(Expectation("well", "healthy", 10.0), (1.0, "healthy"), (2.0, "healthy"), (9.0, "cage")).answer == "healthy"


@pytest.mark.parametrize(("last", "flaw"), [(5.0, ""), (4.99, "no diagnosis from 5.0 s to 10.0 s")])
def test_silence_may_last_as_long_as_its_limit(last: float, flaw: str) -> None:
    found = scored(Expectation("well", "healthy", 10.0), (last, "healthy"))
    assert (found.flaw, found.broken) == (flaw, bool(flaw))


def test_a_detector_without_a_verdict_has_failed() -> None:
    well = Expectation("well", "healthy", 4.0)
    assert scored(well).broken
    assert scored(well).answer == NO_ANSWER
    assert scored(well, (2.0, "waiting")).broken
    assert not scored(well, (2.0, "cage")).broken
    assert score_scenario(well, at((2.0, "healthy")), Criteria(), failure="it crashed").flaw == "it crashed"


def test_the_score_is_the_largest_from_the_onset_on() -> None:
    diagnoses = [ReceivedDiagnosis(time, "healthy", score) for time, score in ((3.0, 9.0), (4.0, 5.0), (6.0, 2.0))]
    assert score_scenario(SPALL, diagnoses, Criteria()).score == 5.0
    assert score_scenario(Expectation("well", "healthy", 10.0), diagnoses, Criteria()).score == 9.0
    assert score_scenario(SPALL, [*diagnoses, ReceivedDiagnosis(7.0, "healthy")], Criteria()).diagnoses == 4
    assert scored(SPALL, (5.0, "healthy")).score is None


def test_alarms_before_the_onset_are_counted_in_the_twin() -> None:
    alone, with_twin = (Expectation("outer", "outer_ring", 10.0, 4.0, twin=twin, first_onset=6.0) for twin in ("", "twin"))
    diagnoses = (2.0, "cage"), (3.0, "healthy"), (4.0, "cage"), (5.0, "healthy"), (9.5, "outer_ring")
    assert (scored(alone, *diagnoses).counted_alarms, scored(with_twin, *diagnoses).counted_alarms) == (2, 1)


def test_a_recording_from_the_middle_of_a_run_has_its_own_times() -> None:
    late = Expectation("late", "outer_ring", 6.0, 9.0, begin=7.0)
    assert (late.end, late.clean_until, late.bearing_clean_until) == (13.0, 9.0, 9.0)
    assert scored(late, (10.0, "outer_ring")).healthy_time == 2.0
    assert Expectation("well", "healthy", 6.0, begin=7.0).clean_until == 13.0
    assert Expectation("both", "sensor", 6.0, 9.0, first_onset=8.0, begin=7.0).bearing_clean_until == 13.0


@pytest.mark.parametrize(("tags", "width"), [({}, 0.0), ({"width": 0.002}, 0.002), ({"width": "wide"}, 0.0)])
def test_the_width_of_a_defect_is_a_tag(tags: dict[str, str | float], width: float) -> None:
    assert Expectation("outer", "outer_ring", 1.0, tags=tags).width == width


@pytest.mark.parametrize(("received", "issued"), [(None, 5.0), (4.0, 5.0), (6.0, 6.0)])
def test_a_diagnosis_is_issued_at_the_later_of_its_time_and_its_arrival(received: float | None, issued: float) -> None:
    assert ReceivedDiagnosis(5.0, "healthy", signal_received=received).issued_at == issued


@pytest.mark.parametrize("time", [0.0, LATEST])
def test_stamps_from_zero_to_ten_million_seconds_are_simulated_times(time: float) -> None:
    status = Status("mine", 0, "", {"verdict": "healthy"})
    assert decode_diagnosis(encode_diagnostics(round(time * 1e9), [status])).time == time
    if time:
        assert time == 1e7
        with pytest.raises(Refusal, match="simulated time"):
            decode_diagnosis(encode_diagnostics(round((time + 1.0) * 1e9), [status]))


@pytest.mark.parametrize("key", ["score", "confidence"])
@pytest.mark.parametrize("value", ["inf", "text", "nan"])
def test_an_evidence_that_is_no_number_is_refused(key: str, value: str) -> None:
    with pytest.raises(Refusal, match=f"a diagnosis has {key} = '{value}': it must be a finite number"):
        decode_diagnosis(encode_diagnostics(0, [Status("mine", 0, "", {"verdict": "cage", key: value})]))


def test_a_score_outweighs_a_confidence() -> None:
    values = {"verdict": "healthy", "score": "-3.5", "confidence": "0.75", "reason": "quiet"}
    found = decode_diagnosis(encode_diagnostics(0, [Status("mine", 0, "", values)]))
    assert (found.score, found.reason) == (-3.5, "quiet")
    del values["score"]
    assert decode_diagnosis(encode_diagnostics(0, [Status("mine", 0, "", values)])).score == 0.25
    assert decode_diagnosis(encode_diagnostics(0, [Status("mine", 0, "", {"verdict": "sensor", "confidence": "0.75"})])).score is None


@pytest.mark.parametrize(("speed", "owed"), [(0.0, False), (6.2, False), (6.3, True), (None, True)])
@pytest.mark.parametrize("verdict", ["waiting", "healthy", "sensor"])
def test_no_verdict_is_owed_on_a_bearing_that_hardly_turns(speed: float | None, owed: bool, verdict: str) -> None:
    """At 6.3 rad/s it makes 10.03 revolutions in 10 s; without a speed nothing is known about its turning."""
    well = Expectation("well", "healthy", 10.0, tags={} if speed is None else {"speed": speed})
    found = scored(well, *((0.5 * number, verdict) for number in range(1, 21)))
    assert found.passed is (verdict == "healthy" or (verdict == "waiting" and not owed))
    assert found.broken is (verdict == "waiting" and owed)
    assert found.credit.periods == 2
    # Neither half of 5 s has ten revolutions at any of these speeds.
    assert found.credit.failed == (2 if verdict == "sensor" or (verdict == "waiting" and speed is None) else 0)


def test_silence_at_standstill_is_no_answer() -> None:
    still = Expectation("well", "healthy", 10.0, tags={"speed": 0.0})
    assert scored(still).broken
    assert not scored(still).passed
    assert scored(Expectation("outer", "outer_ring", 10.0, 4.0, tags={"speed": 0.0}), (5.0, "waiting"), (9.0, "waiting")).broken


@pytest.mark.timeout(60)  # a search through all speeds at every time takes hours
def test_a_recording_of_twenty_minutes_with_ten_speeds_a_second_is_scored() -> None:
    speeds = tuple((0.1 * number, 100.0 + number % 2) for number in range(12_000))
    found = scored(Expectation("outer", "outer_ring", 1200.0, 4.0, speeds=speeds), *((2.0 * k, "outer_ring") for k in range(3, 600)))
    assert found.delay_revolutions == pytest.approx(2.0 * 100.5 / (2.0 * math.pi))
