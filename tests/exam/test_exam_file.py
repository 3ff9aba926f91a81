"""Exam files expanded into cases: boundaries, names, tags and twins."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from dcrb_ros.exam.case import Case, derived_tags
from dcrb_ros.exam.criteria import Criteria
from dcrb_ros.exam.exam_file import MOST_CASES, Exam, ExamFile, ScenarioEntry, exam_of, read_exam
from dcrb_ros.exam.scoring import score_scenario
from dcrb_ros.messages.received_diagnosis import ReceivedDiagnosis
from dcrb_ros.schema.fields import Group
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import validated

SPALL = {"name": "outer", "verdict": "outer_ring", "fault": {"faults.outer_1.width": 0.002}}
WELL = {"name": "well", "verdict": "healthy"}


def exam(*scenarios: dict[str, Any], **changes: Any) -> Exam:
    """Return an exam of short scenarios."""
    tree = {"exam": "tiny", "duration": 0.2, "onset": 0.1, "criteria": {"delay": {"outer_ring": 0.1, "sensor": 0.1}}, **changes}
    return exam_of({**tree, "scenarios": list(scenarios)}, "tiny")


def first(*scenarios: dict[str, Any], **changes: Any) -> Case:
    return exam(*scenarios, **changes).cases[0]


def refused(*scenarios: Any, **changes: Any) -> str:
    with pytest.raises(Refusal) as found:
        exam(*scenarios, **changes)
    return str(found.value)


@pytest.mark.parametrize("group", [ExamFile, ScenarioEntry])
def test_the_reference_page_has_every_key(group: type[Group]) -> None:
    page = (Path(__file__).parents[2] / "docs/reference/exams.md").read_text(encoding="utf-8")
    assert [key for key in group.model_fields if f"`{key}`" not in page and f"`{key}: " not in page] == []


@pytest.mark.parametrize("seeds", [MOST_CASES, MOST_CASES + 1])
def test_an_exam_may_have_two_thousand_scenarios(seeds: int, monkeypatch: pytest.MonkeyPatch) -> None:
    assert MOST_CASES == 2_000
    monkeypatch.setattr("dcrb_ros.exam.exam_file.MOST_CASES", seeds - MOST_CASES + 3)
    assert len(exam(WELL, seeds=list(range(1, seeds - MOST_CASES + 4))).cases) == seeds - MOST_CASES + 3
    assert "an exam must have 1 to" in refused(WELL, seeds=list(range(1, seeds - MOST_CASES + 5)))


def test_a_list_of_many_seeds_is_counted_before_any_case_is_made(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dcrb_ros.exam.exam_file._cases", lambda *_: pytest.fail("a case was made"))
    entry = {**WELL, "set": {"operating.speed": [100.0, 110.0], "operating.load": [1e5, 9e4, 8e4]}}
    assert "defines 59988 scenarios: an exam must have 1 to 2000" in refused(entry, seeds=list(range(9998)))


def test_the_seeds_of_a_list_give_the_cases_that_each_of_them_gives() -> None:
    entry = {**SPALL, "set": {"operating.speed": [100.0, 110.0]}}
    together = exam(entry, WELL, seeds=[1, 7, 2**31 - 1]).cases
    for seed in (1, 7, 2**31 - 1):
        alone = [case.simulation for case in exam(entry, WELL, seeds=[seed]).cases]
        assert [case.simulation for case in together if case.simulation.configuration.simulation.seed == seed] == alone


@pytest.mark.parametrize("seed", [-1, 2**40])
def test_every_seed_of_a_list_is_checked(seed: int) -> None:
    assert f"simulation.seed = {seed} is outside 0 .. " in refused(WELL, seeds=[1, seed])


def test_the_configuration_is_checked_once_for_all_seeds(monkeypatch: pytest.MonkeyPatch) -> None:
    checked: list[str] = []
    monkeypatch.setattr(
        "dcrb_ros.exam.exam_file.validated", lambda flat, model, where: checked.append(where) or validated(flat, model, where)
    )
    exam(SPALL, seeds=list(range(50)))
    assert checked == ["tiny, scenario 'outer/seed0'"]


def test_twins_of_many_seeds_have_names_of_their_own() -> None:
    cases = exam(SPALL, {**WELL, "name": "twin-2"}, seeds=[1, 2, 3]).cases
    names = [case.expectation.name for case in cases]
    assert len(set(names)) == len(names) == 9
    assert sorted(name for name in names if name.startswith("twin") and "/" not in name) == ["twin", "twin-2", "twin-3"]


def test_a_scenario_may_end_exactly_at_the_limit() -> None:
    assert first({**SPALL, "duration": 0.2}).simulation.duration == 0.2
    assert "it ends 0.0999 s after the onset" in refused({**SPALL, "duration": 0.1999})
    assert first({**WELL, "duration": 0.1}).simulation.duration == 0.1  # nothing to detect


@pytest.mark.parametrize(("width", "required"), [(0.0009, False), (0.001, True), (0.002, True)])
def test_defects_of_the_smallest_width_are_required(width: float, required: bool) -> None:
    assert first({**SPALL, "fault": {"faults.outer_1.width": width}}).expectation.required is required
    assert first({**SPALL, "fault": {"faults.outer_1.width": width}, "required": False}).expectation.required is False


def test_a_fault_without_width_is_required() -> None:
    assert first({"name": "dead", "verdict": "sensor", "fault": {"sensor.fault": "dead"}}).expectation.required


@pytest.mark.parametrize(
    ("scenario", "twins"),
    [(SPALL, 1), ({**SPALL, "twin": False}, 0), (WELL, 0), ({**SPALL, "fault": {}, "set": {"faults.outer_1.width": 0.002}}, 0)],
)
def test_a_scenario_with_a_fault_at_an_onset_has_a_twin(scenario: dict[str, Any], twins: int) -> None:
    found = exam({**scenario, "duration": 0.3}).cases
    assert len(found) == 1 + twins
    assert bool(found[0].expectation.twin) == bool(twins)
    assert all(case.expectation.verdict == "healthy" for case in found[1:])


def test_a_twin_is_as_long_as_the_longest_of_its_scenarios_and_keeps_their_timeline() -> None:
    timeline = [{"at": 0.05, "set": {"operating.speed": 100.0}}]
    long, short = ({**SPALL, "name": name, "duration": duration, "timeline": timeline} for name, duration in (("a", 0.4), ("b", 0.3)))
    for order in ((long, short), (short, long)):
        (*_, twin) = exam(*order).cases
        assert (twin.simulation.duration, twin.expectation.duration) == (0.4, 0.4)
        assert twin.simulation.scenario == {"timeline": timeline}
    assert exam(SPALL).cases[1].simulation.scenario is None


def test_a_scenario_may_be_graded_by_another_parameter_than_the_width() -> None:
    graded = {**SPALL, "set": {"background.track_level": [1.0, 30]}, "graded_by": "background.track_level"}
    cases = exam({**graded, "twin": False}).cases
    assert [case.expectation.grade for case in cases] == [("background.track_level", 1.0), ("background.track_level", 30.0)]
    assert first(SPALL).expectation.grade is None
    assert "graded_by = faults.outer_1.depth is neither in 'set' nor in 'fault'" in refused({**graded, "graded_by": "faults.outer_1.depth"})
    text = {**SPALL, "fault": {"sensor.fault": "dead"}, "verdict": "sensor", "graded_by": "sensor.fault"}
    assert "graded_by = sensor.fault has the value 'dead': give a parameter with numbers" in refused(text)


def test_names_have_the_parts_that_vary() -> None:
    points = {"slow": {"operating.speed": 60.0}, "fast": {"operating.speed": 180.0}}
    names = [case.expectation.name for case in exam({**SPALL, "points": ["slow"]}, points=points).cases]
    assert names == ["outer", "twin/slow"]
    names = [case.expectation.name for case in exam({**SPALL, "twin": False}, points=points, seeds=[3, 4]).cases]
    assert names == ["outer/slow/seed3", "outer/slow/seed4", "outer/fast/seed3", "outer/fast/seed4"]
    (case, twin) = exam({**SPALL, "points": ["slow"], "seeds": [9], "tags": {"where": "here"}}, points=points, seeds=[1, 2]).cases
    assert case.simulation.configuration.simulation.seed == 9
    assert (case.expectation.tags["where"], case.expectation.tags["point"], twin.expectation.tags["point"]) == ("here", "slow", "slow")
    assert "where" not in twin.expectation.tags
    lists = {"name": "v", "verdict": "healthy", "set": {"operating.speed": [60.0, 70.0], "operating.load": [1e4, 2e4]}}
    names = [case.expectation.name for case in exam(lists).cases]
    assert names == ["v/speed=60.0/load=10000.0", "v/speed=60.0/load=20000.0", "v/speed=70.0/load=10000.0", "v/speed=70.0/load=20000.0"]


def test_a_twin_does_not_have_the_speed_that_comes_with_the_fault() -> None:
    speed = 60.0
    stopped = {**SPALL, "set": {"operating.speed": speed}, "fault": {**SPALL["fault"], "operating.speed": 0.0}}
    faulty, twin = (case.expectation for case in exam(stopped).cases)
    assert twin.revolutions(0.0, twin.duration) == pytest.approx(speed * twin.duration / (2.0 * math.pi))
    assert faulty.revolutions(0.0, twin.duration) < twin.revolutions(0.0, twin.duration)


def test_the_twin_of_a_point_with_a_number_at_its_end_is_no_twin_of_another_point() -> None:
    points = {"a": {"operating.speed": 100.0}, "a-2": {"operating.speed": 120.0}}
    cases = exam(SPALL, points=points, seeds=[1, 2]).cases
    assert len({case.name for case in cases}) == len(cases) == 8
    speed = {case.name: case.simulation.configuration.operating.speed for case in cases}
    assert all(speed[case.expectation.twin] == speed[case.name] for case in cases if case.expectation.twin)


def test_twins_of_different_configurations_have_different_names() -> None:
    found = exam({**SPALL, "set": {"operating.speed": [60.0, 70.0, 80.0]}}).cases
    assert [case.expectation.name for case in found[3:]] == ["twin", "twin-2", "twin-3"]
    assert [case.expectation.twin for case in found[:3]] == ["twin", "twin-2", "twin-3"]


def test_tags_are_derived_from_configuration_and_changes() -> None:
    configuration = Configuration.model_validate(
        {"operating": {"speed": 100.0, "load": 3e4, "lateral_load": 4e4}, "faults": {"outer_1": {"width": 0.002}}}
    )
    tags = derived_tags(configuration, {"faults.inner_1.width": 0.003, "faults.inner_1.depth": 0.9, "operating.speed": 0.5})
    assert tags == {"speed": 100.0, "speed_rpm": 954.9, "load": 5e4, "joint": configuration.cage.joint, "width": 0.003}
    assert derived_tags(configuration, {})["width"] == 0.002
    assert "width" not in derived_tags(Configuration(), {"operating.speed": 0.5})


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"scenarios": 3}, "tiny: scenarios = 3 is refused: input should be a valid list"),
        ({"scenarios": [3]}, "tiny: scenarios: 0 = 3 is refused"),
        ({"scenarios": [WELL, {"verdict": "healthy"}]}, "tiny: scenario 2: the key 'name' is missing"),
        ({"criteria": {"delay": {"cog": 1.0}}}, "criteria.delay: unknown key 'cog' (known: outer_ring"),
        ({"criteria": {"found": 2.0}}, "criteria: found = 2.0 is refused: input should be less than or equal to 1"),
        ({"scenarios": [{**WELL, "duration": 0.05}]}, "scenario 'well': duration = 0.05 is refused"),
        ({"scenarios": [{**WELL, "seeds": []}]}, "scenario 'well': seeds = [] is refused: list should have at least 1 item"),
        ({"scenarios": [{**WELL, "name": ""}]}, "scenario 1: name = '' is refused"),
        (
            {"scenarios": [{**WELL, "set": {"simulation.seed": 3}}]},
            "simulation.seed cannot be set here: use 'seeds', a list such as [1, 2]",
        ),
        ({"scenarios": [{**WELL, "set": {"simulation": {"seed": 3}}}]}, "simulation.seed cannot be set here"),
        ({"points": {"a": {"simulation.seed": 3}}}, "simulation.seed cannot be set here"),
        ({"scenarios": [{**WELL, "set": {"time_scale": 2.0}}]}, "'well': time_scale has no effect in an exam"),
        ({"points": {"a": {"recording": {"path": "x"}}}}, "'well': recording.path has no effect in an exam"),
        (
            {"scenarios": [{**WELL, "duration": 5.0, "timeline": [{"at": 5.0, "set": {"operating.speed": 60.0}}]}]},
            "an entry at 5 s is not before its end at 5 s: increase the duration or remove it",
        ),
    ],
)
def test_the_place_of_an_error_is_named(changes: dict[str, Any], sentence: str) -> None:
    with pytest.raises(Refusal) as found:
        exam_of({"exam": "tiny", "scenarios": [WELL], **changes}, "tiny")
    assert sentence in str(found.value)


def test_an_unknown_exam_is_refused_and_a_file_is_read(tmp_path: Path) -> None:
    with pytest.raises(Refusal, match=r"there is no exam 'smoek': .*did you mean 'smoke'"):
        read_exam("smoek")
    file = tmp_path / "own.yaml"
    file.write_text("{exam: own, about: mine, scenarios: [{name: well, verdict: healthy}]}", encoding="utf-8")
    found = read_exam(file)
    assert (found.name, found.about, len(found.cases)) == ("own", "mine", 1)
    with pytest.raises(Refusal, match="is not an exam"):
        exam_of([1], "list.yaml")


def test_a_hidden_bearing_fault_needs_a_sensor_verdict() -> None:
    fault = {"sensor.fault": "dead", "faults.outer_1.width": 0.002}
    assert first({"name": "both", "verdict": "sensor", "fault": fault}).expectation.bearing_onset == 0.1
    assert first({"name": "dead", "verdict": "sensor", "fault": {"sensor.fault": "dead"}}).expectation.bearing_onset is None
    assert first(SPALL).expectation.bearing_onset is None


INNER, BOTH_RINGS = {"faults.inner_1.width": 0.002}, {"name": "both", "verdict": "compound", "duration": 5.2}


@pytest.mark.parametrize(
    ("entry", "first_fault"),
    [
        ({"timeline": [{"at": 0.05, "set": INNER}], "fault": SPALL["fault"]}, 0.05),
        ({"timeline": [{"at": 0.05, "set": INNER}, {"at": 0.1, "set": SPALL["fault"]}]}, 0.05),
        ({"set": INNER, "fault": SPALL["fault"]}, 0.0),
        ({"fault": {**INNER, **SPALL["fault"]}}, None),
    ],
)
def test_an_alarm_between_the_first_fault_and_the_onset_is_not_false(entry: dict[str, Any], first_fault: float | None) -> None:
    expectation = first({**BOTH_RINGS, **entry}).expectation
    assert (expectation.onset, expectation.first_onset) == (0.1, first_fault)
    raised = [(0.01, "healthy"), (0.07, "inner_ring"), (0.1, "compound"), (2.0, "compound"), (5.2, "compound")]
    result = score_scenario(expectation, [ReceivedDiagnosis(*one) for one in raised], Criteria())
    assert len(result.false_alarms) == (first_fault is None)
    assert result.passed is (first_fault is not None)


def test_a_scenario_that_begins_after_the_run_is_refused() -> None:
    late = {**WELL, "scenario": "load_steps"}
    sentence = "scenario 'well': the scenario 'load_steps' changes nothing in a run of 3 s, its first entry is at 3 s: increase"
    assert sentence in refused(late, duration=3.0)
    assert len(exam(late, duration=3.1).cases) == 1


def test_a_run_that_is_faulty_without_the_fault_is_no_healthy_twin() -> None:
    late = [{"at": 0.15, "set": {"faults.outer_2.width": 0.002, "faults.outer_2.azimuth": 3.0}}]
    for entry in ({"set": INNER, **BOTH_RINGS}, {"timeline": late, "verdict": "outer_ring"}):
        assert [case.name for case in exam({**SPALL, **entry}).cases] == [{**SPALL, **entry}["name"]]
    assert len(exam({**SPALL, "timeline": [{"at": 0.15, "set": {"operating.speed": 60.0}}]}).cases) == 2


@pytest.mark.parametrize(
    ("entry", "reason"),
    [
        (WELL, "without a fault that appears"),
        ({**WELL, "fault": {"operating.load": 9e4}}, "without a fault that appears"),
        ({"name": "outer", "verdict": "outer_ring", "set": SPALL["fault"]}, "without a fault that appears"),
        ({**SPALL, **BOTH_RINGS, "set": INNER}, "where another fault remains in the healthy run"),
    ],
)
def test_a_twin_is_refused_where_there_is_none(entry: dict[str, Any], reason: str) -> None:
    assert f"twin = true has no effect {reason}: leave it out" in refused({**entry, "twin": True})
    assert exam({**entry, "twin": False}).cases[0].expectation.twin == exam(entry).cases[0].expectation.twin == ""


def test_a_healthy_scenario_is_not_graded() -> None:
    graded = {"set": {"background.track_level": 1.0}, "graded_by": "background.track_level"}
    assert "graded_by = background.track_level has no effect on a healthy bearing" in refused({**WELL, **graded})
    assert first({**SPALL, **graded}).expectation.grade == ("background.track_level", 1.0)


def test_a_bearing_fault_before_that_of_the_sensor_allows_bearing_alarms_from_its_onset() -> None:
    found = first({"name": "dead", "verdict": "sensor", "timeline": [{"at": 0.05, "set": INNER}], "fault": {"sensor.fault": "dead"}})
    assert (found.expectation.first_onset, found.expectation.bearing_onset, found.expectation.onset) == (0.05, 0.05, 0.1)


def test_a_healthy_case_has_no_onset() -> None:
    assert first(WELL).expectation.onset == 0.0


def test_what_has_no_effect_on_a_healthy_bearing_is_refused() -> None:
    assert "'well': onset = 0 s has no effect on a healthy bearing" in refused({**WELL, "onset": 0.0})
    assert "'well': required = false has no effect on a healthy bearing" in refused({**WELL, "required": False})


INNER = {"faults.inner_1.width": 0.002}
ENDS = {"at": 12.0, "set": {"faults.outer_1.width": 0.0}}
SPALL_UNTIL_ONSET = {"set": SPALL["fault"], "timeline": [{"at": 0.02, "set": {"faults.outer_1.width": 0.0}}]}


@pytest.mark.parametrize(
    ("changes", "correct"),
    [
        ({"verdict": "outer_ring", "fault": INNER}, "inner_ring"),
        ({"verdict": "outer_ring", "fault": {**SPALL["fault"], **INNER}}, "compound"),
        ({"verdict": "outer_ring", "set": INNER, "onset": 0.1}, "inner_ring"),
        ({"verdict": "outer_ring", "set": INNER, "fault": SPALL["fault"]}, "inner_ring and then compound"),
        ({"verdict": "outer_ring", **SPALL_UNTIL_ONSET, "fault": INNER}, "inner_ring"),
        ({"verdict": "outer_ring", "fault": {"operating.load": 9e4}}, "healthy"),
        ({"verdict": "overheating", "fault": INNER}, "inner_ring"),
        ({"verdict": "sensor", "fault": INNER}, "inner_ring"),
        ({"verdict": "inner_ring", "fault": {**INNER, "sensor.fault": "dead"}}, "sensor"),
        ({"verdict": "outer_ring", "fault": SPALL["fault"], "timeline": [ENDS]}, "healthy from 12 s on"),
        ({"verdict": "outer_ring", "fault": SPALL["fault"], "timeline": [{"at": 12.0, "set": INNER}]}, "compound from 12 s on"),
        ({"verdict": "compound", "fault": SPALL["fault"], "timeline": [{"at": 12.0, "set": INNER}]}, "outer_ring from 0.1 s on"),
        ({"verdict": "healthy", "set": INNER}, "inner_ring"),
        ({"verdict": "healthy", "fault": {"sensor.fault": "dead"}}, "sensor"),
        ({"verdict": "healthy", "base": "outer_ring_defect"}, "outer_ring"),
        ({"verdict": "healthy", "timeline": [{"at": 0.05, "set": INNER}]}, "inner_ring"),
    ],
)
def test_a_verdict_that_contradicts_the_faults_is_refused(changes: dict[str, Any], correct: str) -> None:
    sentence = refused({"name": "wrong", "duration": 25.0, **changes})
    assert f"'wrong': verdict = {changes['verdict']} contradicts its faults, which make {correct} correct: change the verdict" in sentence


@pytest.mark.parametrize(
    "changes",
    [
        {"verdict": "compound", "set": INNER, "fault": SPALL["fault"]},
        {"verdict": "sensor", "fault": {**INNER, "sensor.fault": "dead"}},
        {"verdict": "inner_ring", "base": "inner_ring_defect"},
        {"verdict": "inner_ring", "timeline": [{"at": 0.05, "over": 0.1, "set": INNER}], "onset": 0.02},
        {"verdict": "inner_ring", "fault": INNER, "timeline": [{"at": 12.0, "set": {"faults.inner_1.width": 0.001}}]},
        {"verdict": "overheating", "fault": {"operating.load": 9e4}},
        {"verdict": "sensor", "set": {"sensor.range": 5.0}, "onset": 0.1},
    ],
)
def test_a_verdict_that_the_faults_allow_is_accepted(changes: dict[str, Any]) -> None:
    assert first({"name": "right", "duration": 25.0, **changes}).expectation.verdict == changes["verdict"]
