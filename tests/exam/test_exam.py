"""The exam of a detector: scoring, statistics, exam files, recordings, reports and the command."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import suppress
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from junitparser import JUnitXml
from made_up_blocks import BODIES
from same_process import dcrb

from dcrb_ros.cli.evaluation import progress_of
from dcrb_ros.cli.score import _is_recording, output_report
from dcrb_ros.diagnosis.detector import Diagnosis
from dcrb_ros.exam.case import Case, scenarios_hash
from dcrb_ros.exam.criteria import Criteria
from dcrb_ros.exam.exam_file import Exam, exam_of, read_exam
from dcrb_ros.exam.expectation import Expectation
from dcrb_ros.exam.figure import write_figure
from dcrb_ros.exam.recorded_case import read_recorded_case
from dcrb_ros.exam.recording_cache import cache_path, cached_recording
from dcrb_ros.exam.report import Report
from dcrb_ros.exam.scoring import NO_ANSWER, ScenarioResult, score_scenario
from dcrb_ros.exam.statistics import characteristic, rate, share
from dcrb_ros.messages.received_diagnosis import ReceivedDiagnosis, decode_diagnosis, evidence
from dcrb_ros.messages.statuses import Status, encode_diagnostics, encode_truth
from dcrb_ros.messages.topics import DIAGNOSIS, GROUND_TRUTH, Message
from dcrb_ros.messages.topics.diagnosis import encode_diagnosis
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.shipped import shipped
from dcrb_ros.stream.block import Truth

SPALL = Expectation("outer", "outer_ring", 10.0, 4.0, {"width": 0.002}, twin="twin")
HEALTHY = Expectation("twin", "healthy", 10.0)
TINY: dict[str, Any] = {
    "exam": "tiny",
    "duration": 0.2,
    "onset": 0.1,
    "criteria": {"delay": {"outer_ring": 0.1}},
    "scenarios": [{"name": "outer", "verdict": "outer_ring", "fault": {"faults.outer_1.width": [0.001, 0.002]}}],
}


def diagnosed(*changes: tuple[float, str], until: float = 10.0, every: float = 0.5) -> list[ReceivedDiagnosis]:
    """Return diagnoses at regular times; the verdict is healthy until the first of the given changes."""
    times = np.arange(every, until + 1e-9, every)
    return [ReceivedDiagnosis(float(t), ([verdict for at, verdict in changes if at <= t] or ["healthy"])[-1]) for t in times]


def scored(expectation: Expectation, diagnoses: list[ReceivedDiagnosis], **criteria: Any) -> ScenarioResult:
    return score_scenario(expectation, diagnoses, Criteria(**criteria))


def test_a_folder_of_an_exams_name_hides_it_only_with_a_recording(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("smoke").mkdir()
    Path("other").mkdir()
    assert [_is_recording(Path(name)) for name in ("smoke", "other", "standard", "a.mcap")] == [False, True, False, True]
    Path("smoke/smoke_0.mcap").touch()
    assert _is_recording(Path("smoke"))


def test_a_fault_detected_in_time_with_the_correct_verdict_passes() -> None:
    found = scored(SPALL, diagnosed((5.5, "outer_ring")))
    assert (found.passed, found.found, found.delay, found.answer) == (True, True, 1.5, "outer_ring")
    assert found.healthy_time == 0.0  # the twin has the same samples before the onset
    assert scored(Expectation("alone", "outer_ring", 10.0, 4.0), diagnosed((5.5, "outer_ring"))).healthy_time == 4.0


@pytest.mark.parametrize(
    ("diagnoses", "flaw"),
    [
        (diagnosed(), "diagnosed as healthy"),
        (diagnosed((5.0, "inner_ring")), "diagnosed as inner_ring"),
        (diagnosed((9.5, "outer_ring")), "not detected within 5 s"),
        (diagnosed((5.0, "outer_ring"), (6.0, "healthy")), "diagnosed as healthy"),
        (diagnosed((2.0, "outer_ring")), "false alarm at 2.0 s (outer_ring)"),
        (diagnosed((1.0, "roller"), (2.0, "cage"), (3.0, "healthy"), (5.0, "outer_ring")), "false alarm at 1.0 s (roller) and 1 more"),
        (diagnosed((5.0, "outer_ring"), until=6.0, every=0.1)[:-1] + diagnosed((0.0, "outer_ring"))[-1:], ""),
        ([], "no diagnosis"),
        (diagnosed((0.0, "waiting")), "diagnosed as waiting"),
    ],
)
def test_the_flaw_names_the_first_reason_of_failure(diagnoses: list[ReceivedDiagnosis], flaw: str) -> None:
    assert scored(SPALL, diagnoses).flaw == flaw


def test_an_alarm_at_the_last_sample_of_a_healthy_run_is_false() -> None:
    found = scored(Expectation("well", "healthy", 10.0), diagnosed((10.0, "outer_ring")))
    assert [alarm.time for alarm in found.false_alarms] == [10.0]


def test_an_alarm_already_active_before_the_onset_is_not_a_detection() -> None:
    found = scored(SPALL, diagnosed((3.5, "outer_ring")))
    assert found.delay is None
    assert not found.found
    again = scored(SPALL, diagnosed((3.0, "outer_ring"), (4.5, "healthy"), (6.0, "outer_ring")))
    assert again.delay == 2.0


def test_the_order_of_arrival_does_not_matter() -> None:
    diagnoses = diagnosed((5.5, "outer_ring"), (7.0, "inner_ring"), (8.0, "outer_ring"))
    assert scored(SPALL, diagnoses[::-1]) == scored(SPALL, diagnoses)


def test_the_delay_of_a_late_diagnosis_is_counted_to_its_arrival() -> None:
    prompt = diagnosed((5.5, "outer_ring"))
    late = [replace(diagnosis, signal_received=diagnosis.time + 2.0) for diagnosis in prompt]
    assert scored(SPALL, late).delay == 3.5
    assert scored(SPALL, [replace(diagnosis, signal_received=10.0) for diagnosis in prompt]).flaw == "not detected within 5 s"


@pytest.mark.parametrize("period", [2, 3])
def test_waiting_neither_ends_nor_renews_an_alarm(period: int) -> None:
    flapping = [ReceivedDiagnosis(0.5 * k, "waiting" if k % period else "outer_ring") for k in range(21)]
    found = scored(SPALL, flapping)
    assert (found.delay, found.alarm_delay, found.found) == (None, None, False)
    assert len(found.false_alarms) == 1


def test_an_alarm_counts_once_when_it_is_raised() -> None:
    found = scored(HEALTHY, diagnosed((2.0, "outer_ring"), (4.0, "waiting"), (5.0, "outer_ring"), (6.0, "healthy"), (8.0, "sensor")))
    assert [(alarm.time, alarm.verdict) for alarm in found.false_alarms] == [(2.0, "outer_ring"), (8.0, "sensor")]
    assert found.counted_alarms == 2
    assert found.healthy_time == 10.0


def test_a_bearing_alarm_during_a_sensor_fault_is_false() -> None:
    broken = Expectation("dead", "sensor", 10.0, 4.0)
    assert scored(broken, diagnosed((4.5, "sensor"))).passed
    found = scored(broken, diagnosed((4.5, "outer_ring"), (5.0, "sensor")))
    assert found.flaw == "false alarm at 4.5 s (outer_ring)"
    assert found.healthy_time == 10.0


@pytest.mark.parametrize(("bearing", "alarms", "healthy"), [(2.0, 0, 2.0), (10.0, 0, 10.0), (12.0, 1, 12.0), (None, 2, 15.0)])
def test_a_hidden_bearing_fault_allows_bearing_alarms_from_its_onset(bearing: float | None, alarms: int, healthy: float) -> None:
    first = 10.0 if bearing is None else min(10.0, bearing)
    both = Expectation("both", "sensor", 15.0, 10.0, first_onset=first, bearing_onset=bearing)
    verdicts = diagnosed((3.5, "outer_ring" if bearing == 2.0 else "healthy"), (10.5, "sensor"), until=15.0)
    alternating = ((10.5, "sensor"), (11.0, "outer_ring"), (11.5, "sensor"), (13.0, "outer_ring"))
    raised = [ReceivedDiagnosis(time, verdict) for time, verdict in alternating]
    found = scored(both, [*verdicts[:20], *raised, *verdicts[26:]])
    assert (len(found.false_alarms), found.healthy_time) == (alarms, healthy)
    assert found.passed is (alarms == 0)


def test_a_gap_between_diagnoses_longer_than_the_limit_fails() -> None:
    assert scored(HEALTHY, [*diagnosed(until=3.0), ReceivedDiagnosis(9.5, "healthy")]).flaw == "no diagnosis from 3.0 s to 9.5 s"
    assert scored(HEALTHY, [*diagnosed(until=3.0), ReceivedDiagnosis(9.5, "healthy")], silence=7.0).passed
    assert scored(HEALTHY, []).answer == NO_ANSWER


def test_any_bearing_verdict_is_correct_if_the_name_does_not_count() -> None:
    found = scored(SPALL, diagnosed((5.0, "roller")), name_right=False)
    assert (found.passed, found.found, found.delay) == (True, True, 1.0)


def test_bearing_verdicts_are_counted_together_if_the_name_does_not_count() -> None:
    last = [*["outer_ring"] * 3, *["inner_ring"] * 3, *["roller"] * 3, *["healthy"] * 4]
    late = [ReceivedDiagnosis(9.0 + 0.05 * k, verdict) for k, verdict in enumerate(last)]
    diagnoses = [*diagnosed((4.5, "outer_ring"), until=8.5), *late]
    assert scored(SPALL, diagnoses, name_right=False).passed
    assert scored(SPALL, diagnoses).flaw == "diagnosed as healthy"


def test_confidence_intervals_match_published_tables() -> None:
    # Garwood 1936: no event, and ten events; NIST handbook 7.2.4.1 for the share.
    assert rate(0, 1.0) == pytest.approx((0.0, 0.0, 3.6889), abs=1e-4)
    assert rate(10, 2.0) == pytest.approx((5.0, 2.3977, 9.1952), abs=1e-4)
    assert share(4, 20) == pytest.approx((0.2, 0.0573, 0.4366), abs=1e-4)
    assert share(10, 10) == pytest.approx((1.0, 0.6915, 1.0), abs=1e-4)


@given(st.integers(0, 50), st.integers(1, 50))
def test_confidence_intervals_contain_their_estimate(count: int, more: int) -> None:
    found = share(count, count + more)
    assert 0.0 <= found.low <= found.value <= found.high <= 1.0
    events = rate(count, float(more))
    assert 0.0 <= events.low <= events.value <= events.high


def test_roc_of_known_scores() -> None:
    curve = characteristic([3.0, 2.0, 1.0], [0.5, 1.5])
    assert curve is not None
    assert curve.area == pytest.approx(5.0 / 6.0)  # one of six pairs is in the wrong order
    assert (curve.true[0], curve.true[-1], curve.false[-1]) == (0.0, 1.0, 1.0)
    steps = zip(np.diff(curve.false), np.array(curve.true)[1:], np.array(curve.true)[:-1], strict=True)
    assert sum(width * 0.5 * (a + b) for width, a, b in steps) == pytest.approx(curve.area)
    assert characteristic([1.0], []) is None
    alike = characteristic([1.0, 1.0], [1.0])
    assert alike is not None
    assert alike.area == 0.5


def test_messages_of_the_shipped_detector_are_decoded() -> None:
    found = decode_diagnosis(encode_diagnosis(Diagnosis(51200, 1.0, "inner_ring", "a line", confidence=0.9)))
    assert (found.time, found.verdict, found.score, found.alarm) == (1.0, "inner_ring", 0.9, True)
    assert decode_diagnosis(encode_diagnosis(Diagnosis(51200, 1.0, "healthy", "", confidence=0.9))).score == pytest.approx(0.1)
    scores = {"outer_ring": -3.0, "cage": 2.0}
    assert decode_diagnosis(encode_diagnosis(Diagnosis(51200, 1.0, "cage", "", confidence=0.9, scores=scores))).score == 2.0
    assert evidence("waiting", 0.0) is None


@pytest.mark.parametrize(
    ("statuses", "time", "sentence"),
    [
        ([], 1.0, "has no status"),
        ([Status("mine", 0, "", {})], 1.0, "has no value 'verdict'"),
        ([Status("mine", 0, "", {"verdict": "outer ring"})], 1.0, "did you mean 'outer_ring'?"),
        ([Status("mine", 0, "", {"verdict": "healthy"})], 1.7e9, "from the block's header"),
        ([Status("mine", 0, "", {"verdict": "healthy", "score": "nan"})], 1.0, "score = 'nan': it must be a finite number"),
    ],
)
def test_an_invalid_diagnosis_message_is_refused(statuses: list[Status], time: float, sentence: str) -> None:
    with pytest.raises(Refusal, match=sentence.replace("?", r"\?")):
        decode_diagnosis(encode_diagnostics(round(time * 1e9), statuses))


def tiny(**changes: Any) -> Exam:
    return exam_of({**TINY, **changes}, "tiny")


def test_lists_vary_and_twins_are_shared() -> None:
    points = {"slow": {"operating.speed": 60.0}, "fast": {"operating": {"speed": 180.0}}}
    exam = tiny(points=points, seeds=[1, 2])
    names = [case.expectation.name for case in exam.cases]
    assert len(names) == 2 * 2 * 2 + 4
    assert names[:3] == ["outer/slow/width=0.001/seed1", "outer/slow/width=0.002/seed1", "outer/slow/width=0.001/seed2"]
    twins = {case.expectation.name: case for case in exam.cases if not case.expectation.faulty}
    for case in exam.cases:
        if case.expectation.faulty:
            twin = twins[case.expectation.twin]
            assert twin.simulation.configuration == case.simulation.configuration
            assert twin.simulation.scenario is None
    assert {case.simulation.configuration.operating.speed for case in exam.cases} == {60.0, 180.0}


def test_a_point_may_have_a_configuration_of_its_own() -> None:
    points = {"rollers": {"operating.speed": 60.0}, "balls": {"base": "ball_bearing_6205", "operating.speed": 180.0}}
    exam = tiny(points=points)
    rows = {case.expectation.tags["point"]: case.simulation.configuration.bearing.rollers_per_row for case in exam.cases}
    loads = {case.expectation.tags["point"]: case.simulation.configuration.operating.load for case in exam.cases}
    assert rows == {"rollers": 16, "balls": 9}
    assert loads == {"rollers": 100000.0, "balls": 200.0}
    assert len(exam.cases) == 2 * 2 + 2, "each point has a healthy twin of its own"


TIMED = {"name": "outer", "verdict": "outer_ring", "timeline": [{"at": 0.05, "set": {"faults.outer_1.width": 0.002}}]}


@pytest.mark.parametrize(
    ("changes", "onset"),
    [
        ({}, 0.05),
        ({"onset": 0.08}, 0.08),
        ({"timeline": [{"at": 0.05, "over": 0.1, "set": {"faults.outer_1.width": 0.002}}]}, 0.1),  # its first size
        ({"timeline": [{"at": 0.02, "set": {"faults.inner_1.width": 0.002}}, *TIMED["timeline"]], "verdict": "compound"}, 0.05),
        ({"timeline": [], "set": {"faults.outer_1.width": 0.002}}, 0.0),
        ({"timeline": [{"at": 0.06, "set": {"sensor.fault": "dead"}}], "verdict": "sensor"}, 0.06),
        ({"verdict": "healthy", "timeline": []}, 0.0),
    ],
)
def test_the_onset_follows_from_the_timeline_unless_it_is_given(changes: dict[str, Any], onset: float) -> None:
    limits = {"delay": dict.fromkeys(("outer_ring", "compound", "sensor"), 0.1)}
    (case,) = tiny(criteria=limits, scenarios=[{**TIMED, **changes}]).cases
    assert case.expectation.onset == pytest.approx(onset, abs=1e-3)


def test_a_fault_of_bearing_and_sensor_sets_both_onsets() -> None:
    fault = {"sensor.fault": "dead", "faults.outer_1.width": 0.002}
    both, _ = tiny(criteria={"delay": {"sensor": 0.1}}, scenarios=[{"name": "both", "verdict": "sensor", "fault": fault}]).cases
    assert both.expectation.bearing_onset == both.expectation.onset == 0.1


def test_twin_names_are_unique() -> None:
    exam = tiny(scenarios=[{"name": "twin", "verdict": "healthy", "set": {"operating.speed": 60.0}}, SPALLED])
    assert [case.expectation.name for case in exam.cases] == ["twin", "outer", "twin-2"]
    assert exam.cases[1].expectation.twin == "twin-2"


def test_small_defects_are_not_required() -> None:
    fault = {"faults.outer_1.width": [0.0005, 0.001]}
    exam = tiny(scenarios=[{"name": "outer", "verdict": "outer_ring", "fault": fault}])
    assert [case.expectation.required for case in exam.cases] == [False, True, True]


def test_a_preset_provides_the_values_that_are_not_given() -> None:
    exam = tiny(scenarios=[{"name": "measured", "verdict": "healthy", "set": {"sensor.preset": ["none", "mems"]}}])
    assert [case.simulation.configuration.sensor.adc_bits for case in exam.cases] == [24, 16]


def test_a_shipped_scenario_sets_its_initial_speed(tmp_path: Path) -> None:
    exam = tiny(scenarios=[{"name": "profile", "verdict": "healthy", "scenario": "run_up"}])
    assert exam.cases[0].simulation.configuration.operating.speed == pytest.approx(20.0 / 3.6 / 0.46)  # 20 km/h on wheels of 0.92 m
    assert exam.cases[0].simulation.scenario is not None
    (tmp_path / "none.yaml").write_text("42", encoding="utf-8")
    with pytest.raises(Refusal, match="is not a scenario"):
        tiny(scenarios=[{"name": "profile", "verdict": "healthy", "scenario": str(tmp_path / "none.yaml")}])


def test_the_hash_depends_on_the_scenarios_only() -> None:
    cases = list(tiny().cases)
    assert scenarios_hash(cases) == scenarios_hash(cases[::-1])
    assert scenarios_hash(cases) == scenarios_hash(tiny(about="in other words").cases)
    assert scenarios_hash(cases) != scenarios_hash(cases[1:])
    assert scenarios_hash(cases) != scenarios_hash(tiny(seeds=[2]).cases)
    assert scenarios_hash(cases) != scenarios_hash(tiny(onset=0.05).cases)


@pytest.mark.parametrize("name", ["smoke", "standard", "blind"])
def test_shipped_exams_are_valid(name: str) -> None:
    exam = read_exam(name)
    assert exam.name == name
    assert {case.expectation.verdict for case in exam.cases if case.expectation.faulty} >= {"outer_ring", "inner_ring"}
    assert all(case.expectation.twin for case in exam.cases if case.expectation.faulty)


def test_shipped_exams_are_found() -> None:
    assert set(shipped("exam")) == {"smoke", "standard", "blind", "full", "graded", "hours", "lubrication", "bogie"}


def test_the_exam_hours_has_four_healthy_hours_of_varied_operation() -> None:
    cases = read_exam("hours").cases
    assert not any(case.expectation.faulty for case in cases)
    assert sum(case.simulation.duration for case in cases) >= 4 * 3600.0
    configurations = [case.simulation.configuration for case in cases]
    assert {c.sensor.preset for c in configurations} >= {"ideal", "iepe_100mv_g", "mems"}
    assert len({(c.operating.speed, c.operating.load) for c in configurations}) >= 10
    assert sum(bool(case.simulation.scenario) for case in cases) >= 30


SPALLED = {"name": "outer", "verdict": "outer_ring", "fault": {"faults.outer_1.width": 0.002}}


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"criteri": {}}, "unknown key 'criteri'; did you mean 'criteria'?"),
        ({"criteria": {"delays": {}}}, "criteria: unknown key 'delays'; did you mean 'delay'?"),
        ({"scenarios": [{"name": "outer"}]}, "scenario 'outer': the key 'verdict' is missing: give one of healthy, outer_ring"),
        ({"scenarios": [{**SPALLED, "verdict": "outer"}]}, "scenario 'outer': verdict = 'outer' is unknown: give one of healthy"),
        ({"scenarios": [{**SPALLED, "falt": {}}]}, "scenario 'outer': unknown key 'falt'; did you mean 'fault'?"),
        ({"scenarios": [{**SPALLED, "set": {"operating.sped": 1.0}}]}, "did you mean 'operating.speed'?"),
        ({"scenarios": [{**SPALLED, "set": {"operating.speed": 1e6}}]}, "operating.speed = 1000000.0 rad/s is outside"),
        ({"scenarios": [{**SPALLED, "fault": {"bearing.rows": 1}}]}, "bearing.rows is fixed while the bench runs"),
        ({"scenarios": [{**SPALLED, "points": ["slow"]}]}, "there is no operating point 'slow'"),
        ({"scenarios": [{"name": "outer", "verdict": "outer_ring"}]}, "nothing in it makes outer_ring correct"),
        ({"scenarios": [SPALLED, SPALLED]}, "two scenarios are called 'outer'"),
        ({"scenarios": [{**SPALLED, "duration": 0.15}]}, "it ends 0.05 s after the onset, but criteria.delay.outer_ring allows 0.1 s"),
        ({"scenarios": [{**SPALLED, "base": "heathy"}]}, "did you mean 'healthy'?"),
        ({"points": {"slow": {"base": "heathy"}}}, "did you mean 'healthy'?"),
        ({"points": {"slow": {"base": 1}}}, "point 'slow': base = 1 is not a configuration"),
        (
            {"points": {"slow": {"base": "paper"}}, "scenarios": [{**SPALLED, "base": "dry"}]},
            "base is 'paper' for the point and 'dry' for the scenario: give one of them",
        ),
        ({"scenarios": [{**SPALLED, "scenario": "growing_spal"}]}, "did you mean 'growing_spall'?"),
        ({"scenarios": []}, "defines 0 scenarios"),
        ({"scenarios": [{**SPALLED, "set": {"operating.speed": []}}]}, "operating.speed has an empty list"),
        ({"seeds": ["one"]}, "seeds"),
        ({"duration": "long"}, "duration = 'long' is refused"),
    ],
)
def test_an_invalid_exam_is_refused_with_the_location_of_the_error(changes: dict[str, Any], sentence: str) -> None:
    with pytest.raises(Refusal) as refused:
        tiny(**changes)
    assert sentence in str(refused.value)


JUNK = [None, 0, -1, 1e9, "x", "", [], {}, [[]], [1, "a"], {"a": 1}, {1: 2}, True, float("nan"), 10**30, ["a"], {"at": 1}]


def locations(tree: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the path of every node of a tree."""
    yield path
    for key in tree if isinstance(tree, dict) else range(len(tree)) if isinstance(tree, list) else ():
        yield from locations(tree[key], (*path, key))


WHOLE = {
    **TINY,
    "points": {"slow": {"operating.speed": 60.0, "base": "dry"}},
    "scenarios": [
        {
            **SPALLED,
            "points": ["slow"],
            "seeds": [1],
            "onset": 0.1,
            "set": {"sensor.preset": ["none", "mems"]},
            "fault": {"faults.outer_1.width": [0.002]},
            "timeline": [{"at": 0.0, "set": {"operating.speed": 70.0}}],
            "tags": {"where": "here"},
            "scenario": "run_up",
        }
    ],
}


@given(st.sampled_from(list(locations(WHOLE))[1:]), st.sampled_from(JUNK))
def test_any_value_in_an_exam_file_is_accepted_or_refused(path: tuple[Any, ...], junk: Any) -> None:
    tree = deepcopy(WHOLE)
    branch: Any = tree
    for key in path[:-1]:
        branch = branch[key]
    branch[path[-1]] = junk
    with suppress(Refusal):
        assert exam_of(tree, "junk").cases


def test_recordings_are_simulated_once_and_twins_differ_from_the_onset_on(tmp_path: Path) -> None:
    spall, _, twin = tiny().cases
    first, second = cached_recording(spall, tmp_path), cached_recording(twin, tmp_path)
    written = (first / "metadata.yaml").stat().st_mtime_ns
    assert cached_recording(spall, tmp_path) == first == cache_path(spall, tmp_path)
    assert (first / "metadata.yaml").stat().st_mtime_ns == written
    assert not list(tmp_path.glob(".writing-*"))
    faulty, healthy = (np.concatenate([b.acceleration for b in Recording(bag).vibrations()]) for bag in (first, second))
    parted = int(np.flatnonzero((faulty != healthy).any(axis=1))[0])
    assert parted / 51200 == pytest.approx(0.1, abs=0.005)  # the same samples until the fault comes
    recorded = read_recorded_case(first)
    assert recorded.expectation.verdict == "outer_ring"
    assert recorded.expectation.onset == pytest.approx(0.1)
    assert recorded.expectation.tags["width"] == 0.001


def test_lost_blocks_are_not_recorded(tmp_path: Path) -> None:
    lossy = {"name": "lossy", "verdict": "healthy", "set": {"publishing.loss_probability": 0.5}}
    case = tiny(scenarios=[lossy]).cases[0]
    assert 0 < sum(1 for _ in Recording(cached_recording(case, tmp_path)).vibrations()) < 10


def test_cases_with_different_samples_have_different_cache_paths(tmp_path: Path) -> None:
    places = {cache_path(case, tmp_path) for exam in (tiny(), tiny(seeds=[2]), tiny(duration=0.25)) for case in exam.cases}
    assert len(places) == 9


def record(path: Path, faults: list[dict[str, dict[str, float]]], verdicts: list[str], begin: float = 0.0, every: float = 0.02) -> Path:
    """Record ground truth and diagnoses at regular times [s], as `ros2 bag record` does while the bench runs."""
    with Recorder(path, Configuration(), BODIES) as recorder:
        for number in range(max(len(faults), len(verdicts))):
            stamp = round((begin + number * every) * 1e9)
            if number < len(faults):
                truth = encode_truth(Truth(stamp, 125.0, (0.0, -1e5), {}, faults[number]))
                recorder.write_messages([Message(GROUND_TRUTH, stamp, truth)])
            if number < len(verdicts):
                status = Status("mine", 0, "", {"verdict": verdicts[number]})
                recorder.write_messages([Message(DIAGNOSIS, stamp, encode_diagnostics(stamp, [status]))])
    return path


def read(bag: Path) -> tuple[Expectation, tuple[ReceivedDiagnosis, ...]]:
    recorded = read_recorded_case(bag)
    return recorded.expectation, recorded.diagnoses


def test_a_recording_with_diagnoses_is_scored(tmp_path: Path) -> None:
    fault = {"outer_1": {"width": 0.002, "onset": 0.04}}
    bag = record(tmp_path / "bag", [{}, {}, fault, fault, fault], ["healthy", "healthy", "healthy", "outer_ring", "outer_ring"])
    recorded = read_recorded_case(bag)
    found = score_scenario(recorded.expectation, recorded.diagnoses, Criteria())
    assert found.passed
    assert found.delay == pytest.approx(0.02)


def test_damage_of_a_recording_is_reported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bag = record(tmp_path / "bag", [{}] * 5, ["healthy"] * 5)
    (bag / "bag_1.mcap").touch()  # what a power loss leaves behind after a split
    whole = bag / "bag_0.mcap"
    whole.write_bytes(whole.read_bytes()[:-200])
    assert dcrb("score", str(bag)) == 0
    assert "left out, not an MCAP file: it is empty; the readable part is scored" in (message := capsys.readouterr().err)
    assert "bag_0.mcap" in message
    whole.write_bytes(whole.read_bytes()[:2000])
    assert dcrb("score", str(bag)) == 2
    assert "the correct verdict is unknown" in (message := capsys.readouterr().err)
    assert "not all of it could be read: bag_1.mcap" in message


def test_a_recording_may_start_in_the_middle_of_a_run(tmp_path: Path) -> None:
    old = {"outer_1": {"width": 0.002, "onset": 2.0}}
    bag = record(tmp_path / "healthy", [{}] * 13, ["healthy"] * 13, begin=7.0, every=0.5)
    found = score_scenario(*read(bag), Criteria())
    assert (found.flaw, found.healthy_time, found.expectation.duration) == ("", 6.0, 6.0)
    bag = record(tmp_path / "old", [old] * 13, ["outer_ring"] * 13, begin=7.0, every=0.5)
    found = score_scenario(*read(bag), Criteria())
    assert (found.flaw, found.delay, found.healthy_time) == ("", 0.0, 0.0)
    bag = record(
        tmp_path / "later", [{}] * 4 + [{"outer_1": {"width": 0.002, "onset": 9.0}}] * 9, ["healthy"] * 6 + ["outer_ring"] * 7, 7.0, 0.5
    )
    found = score_scenario(*read(bag), Criteria())
    assert (found.flaw, found.delay, found.healthy_time) == ("", 1.0, 2.0)


def test_diagnoses_of_the_time_before_a_recording_are_ignored(tmp_path: Path) -> None:
    bag = tmp_path / "bag"
    with Recorder(bag, Configuration(), BODIES) as recorder:
        for time in (7.0, 7.5, 8.0):
            truth = encode_truth(Truth(round(time * 1e9), 125.0, (0.0, -1e5), {}, {"outer_1": {"width": 0.002, "onset": 2.0}}))
            recorder.write_messages([Message(GROUND_TRUTH, round(time * 1e9), truth)])
            late = round((time - 0.2) * 1e9)
            status = Status("mine", 2, "", {"verdict": "outer_ring"})
            recorder.write_messages([Message(DIAGNOSIS, late, encode_diagnostics(late, [status]))])
    expectation, diagnoses = read(bag)
    assert [diagnosis.time for diagnosis in diagnoses] == pytest.approx([7.3, 7.8])
    assert score_scenario(expectation, diagnoses, Criteria()).passed


@pytest.mark.parametrize(
    ("onsets", "since"),
    [
        ({"outer_1": 2.0, "outer_2": 8.0}, ("outer_ring", 2.0)),
        ({"outer_1": 2.0, "inner_1": 3.0, "roller_1": 8.0}, ("compound", 3.0)),
        ({"sensor.dead": 2.0, "outer_1": 8.0}, ("sensor", 2.0)),
        ({"sensor.dead": 8.0, "outer_1": 2.0}, ("sensor", 8.0)),
    ],
)
def test_the_onset_is_when_the_verdict_becomes_correct(onsets: dict[str, float], since: tuple[str, float], tmp_path: Path) -> None:
    truths = [{name: {"onset": onset} for name, onset in onsets.items() if onset <= time} for time in range(11)]
    expectation, _ = read(record(tmp_path / "bag", truths, [], every=1.0))
    assert (expectation.verdict, expectation.onset, expectation.first_onset) == (*since, 2.0)


def test_recordings_that_cannot_be_scored_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    fault = {"outer_1": {"width": 0.002, "onset": 0.0}}
    for name, faults, verdicts, sentence in (
        ("untold", [], ["healthy"], "has no messages on ground_truth"),
        ("silent", [fault, fault], [], "has no messages on diagnosis"),
        ("healed", [fault, {}], ["healthy"], "the fault outer_1 ends at 0.02 s"),
    ):
        assert dcrb("score", str(record(tmp_path / name, faults, verdicts))) == 2
        assert sentence in capsys.readouterr().err


def report(*results: ScenarioResult, **criteria: Any) -> Report:
    return Report("made up", "nobody", Criteria(**criteria), "0" * 64, results)


def with_score(score: float, *changes: tuple[float, str]) -> list[ReceivedDiagnosis]:
    return [ReceivedDiagnosis(diagnosis.time, diagnosis.verdict, score) for diagnosis in diagnosed(*changes)]


GOOD = scored(SPALL, with_score(9.0, (5.0, "outer_ring"))), scored(HEALTHY, with_score(1.0))
BAD = scored(SPALL, with_score(8.0, (1.0, "outer_ring"))), scored(HEALTHY, with_score(8.0, (1.0, "outer_ring")))


def test_a_report_passes_if_every_criterion_is_met() -> None:
    good, bad = report(*GOOD), report(*BAD)
    assert good.passed
    assert not bad.passed
    assert [check.holds for check in bad.checks()] == [False, False, True]
    assert bad.alarms == 1  # those before the onset are the twin's
    assert bad.hours == pytest.approx(10.0 / 3600.0)
    assert good.confusion()["outer_ring"]["outer_ring"] == 1
    assert good.detections()[0].probability.value == 1.0
    assert (good.characteristic().area, bad.characteristic().area) == (1.0, 0.5)  # type: ignore[union-attr]
    assert report(*BAD, found=0.0, false_alarms=1).passed


def test_a_report_can_be_written_as_json_and_figure(tmp_path: Path) -> None:
    for name, found in (("good", report(*GOOD)), ("bad", report(*BAD)), ("empty", report(scored(HEALTHY, diagnosed())))):
        tree = json.loads(json.dumps(found.described(), allow_nan=False))
        assert tree["passed"] is found.passed
        assert len(tree["scenarios"]) == len(found.results)
        write_figure(found, tmp_path / f"{name}.png")
        assert (tmp_path / f"{name}.png").stat().st_size > 10_000


def test_special_characters_in_names_and_messages_do_not_break_the_outputs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    name, words = "outer [my_detector-1] \x01", "it ended; its last words:\n    [/usr/lib/libfoo.so] $a^$ \x1b[31m"
    results = score_scenario(replace(SPALL, name=name), [], Criteria(), failure=words), *GOOD
    found = Report("an exam (only [ab]*) $x^$ \x01", "bash -c '[/x] $a^$'", Criteria(), "0" * 64, results)
    output_report(found, as_json=False, junit=tmp_path / "junit.xml", figure=None)
    printed = capsys.readouterr().out
    assert all(part in printed for part in ("[my_detector-1]", "[/usr/lib/libfoo.so]", "(only [ab]*)", "[/x]"))
    suites = {suite.name: suite for suite in JUnitXml.fromfile(str(tmp_path / "junit.xml"))}
    assert next(case.name for case in suites["an exam (only [ab]*) $x^$ ?: scenarios"]) == "outer [my_detector-1] ?"
    write_figure(replace(found, exam="$x^$"), tmp_path / "figure.png")
    assert (tmp_path / "figure.png").is_file()


def test_units_in_table_heads_are_printed(capsys: pytest.CaptureFixture[str]) -> None:
    output_report(report(*GOOD), as_json=False, junit=None, figure=None)
    printed = capsys.readouterr().out
    assert all(head in printed for head in ("median [s]", "limit [s]", "width [mm]"))


def test_results_are_printed_before_files_are_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for as_json in (True, False):
        with pytest.raises(Refusal, match="cannot be written"):
            output_report(report(*GOOD), as_json=as_json, junit=tmp_path / "gone/junit.xml", figure=None)
        assert "made up" in capsys.readouterr().out


def test_names_in_brackets_are_printed_literally(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "tiny.yaml"
    file.write_text(yaml.safe_dump({**TINY, "about": "[/x]", "scenarios": [{**SPALLED, "name": "outer [a]"}]}), encoding="utf-8")
    assert dcrb("score", str(file), "--list") == 0
    printed = capsys.readouterr().out
    assert all(part in printed for part in ("outer [a]", "[/x]"))
    with progress_of("evaluated", 1, quiet=False) as done:
        done("outer [/a]")
    assert "outer [/a]" in capsys.readouterr().err


def test_a_list_without_a_description_is_headed_by_the_name_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "tiny.yaml"
    file.write_text(yaml.safe_dump({**TINY, "exam": "undescribed"}), encoding="utf-8")
    assert dcrb("score", str(file), "--list") == 0
    assert capsys.readouterr().out.split("\n")[0].strip() == "undescribed"


def test_the_command_evaluates_an_exam(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, junit, figure = tmp_path / "tiny.yaml", tmp_path / "junit.xml", tmp_path / "figure.png"
    file.write_text(yaml.safe_dump(TINY), encoding="utf-8")
    options = ["--recordings", str(tmp_path / "kept"), "--workers", "1", "--junit", str(junit), "--figure", str(figure)]
    assert dcrb("score", str(file), *options, "--json") == 1  # nobody can judge a fifth of a second
    about = json.loads(capsys.readouterr().out)
    assert about["exam"] == "tiny"
    assert about["scenarios_sha256"] == scenarios_hash(tiny().cases)
    assert len(about["scenarios"]) == 3
    suites = {suite.name: suite for suite in JUnitXml.fromfile(str(junit))}
    assert (suites["tiny: scenarios"].tests, suites["tiny: scenarios"].failures) == (3, 3)
    assert figure.is_file()
    assert dcrb("score", "--exam", str(file), "--list") == 0
    assert scenarios_hash(tiny().cases) in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (
            [],
            "give an exam (blind, bogie, full, graded, hours, lubrication, smoke, standard or a YAML file), or recordings",
        ),
        (["smok"], "give a YAML file or one of blind, bogie, full, graded, hours, lubrication, smoke, standard; did you mean 'smoke'?"),
        (["smoke", "standard"], "2 exams are given (smoke, standard): give one at a time"),
        (["smoke", "bags/healthy"], "smoke is not a recording but bags/healthy is"),
        (["bags/healthy", "bags/healthy"], "is given twice"),
        (["bags/healthy", "--only", "h*"], "apply to an exam, but bags/healthy is a recording"),
        (["smoke", "--rate", "nan"], "--rate nan is outside"),
        (["smoke", "--workers", "-1"], "--workers -1 is outside"),
        (["smoke", "--only", "cage*"], "--only 'cage*' matches no scenario of smoke"),
        (["smoke", "--figure", "figure.bmp"], "must end in one of .png"),
        (["smoke", "--figure", "no/such/figure.png"], "--figure no/such/figure.png cannot be written: there is no folder no/such"),
        (["smoke", "--junit", "no/such/junit.xml"], "--junit no/such/junit.xml cannot be written: there is no folder no/such"),
        (["smoke", "--junit", "docs"], "--junit docs is a folder"),
        (["smoke", "--node", "x", "--reference"], "name two detectors"),
        (["smoke", "--node", "x", "--detector", "config/detector.yaml"], "applies to the shipped detector only"),
        (["smoke", "--detector", "config/none.yaml"], "config/none.yaml"),
        (["smoke", "--recordings", "/dev/null/x"], "cannot hold the exam's recordings"),
        (["README.md"], "README.md is not an MCAP file"),
    ],
)
def test_invalid_input_is_refused_in_one_sentence(arguments: list[str], sentence: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert dcrb("score", *arguments) == 2
    said = capsys.readouterr().err
    assert sentence in said
    assert "Traceback" not in said


def test_the_shipped_detector_is_evaluated_on_recordings(capsys: pytest.CaptureFixture[str]) -> None:
    assert dcrb("score", "bags/outer_ring_defect", "bags/healthy", "--reference", "--json", "--workers", "1") == 0
    about = json.loads(capsys.readouterr().out)
    assert {found["name"]: found["answer"] for found in about["scenarios"]} == {"outer_ring_defect": "outer_ring", "healthy": "healthy"}


def test_the_shipped_detector_is_evaluated_with_given_parameters(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    deaf = tmp_path / "deaf.yaml"
    deaf.write_text(yaml.safe_dump({"/**/fault_detector": {"ros__parameters": {"outer_limit": 5000.0, "outer_limit_high": 5000.0}}}))
    assert dcrb("score", "bags/outer_ring_defect", "--detector", str(deaf), "--json", "--workers", "1") == 1
    about = json.loads(capsys.readouterr().out)
    assert (about["detector"], about["scenarios"][0]["answer"]) == ("the shipped detector with deaf.yaml", "healthy")


def test_case_is_hashable_by_content() -> None:
    spall = tiny().cases[0]
    assert isinstance(spall, Case)
    assert spall == tiny().cases[0]
