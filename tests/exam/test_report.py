"""The report of an exam: numbers, sentences, tables, figures and JUnit XML."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from junitparser import Failure, JUnitXml, Skipped
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from rich.table import Table

from dcrb_ros.exam import figure
from dcrb_ros.exam.criteria import Criteria
from dcrb_ros.exam.exam_file import read_exam
from dcrb_ros.exam.expectation import Expectation
from dcrb_ros.exam.figure import write_figure
from dcrb_ros.exam.junit import write_junit
from dcrb_ros.exam.report import Report
from dcrb_ros.exam.scoring import FalseAlarm, ScenarioResult, score_scenario
from dcrb_ros.exam.statistics import Interval, share
from dcrb_ros.exam.table import MOST_FAILURES, bounds, number, sentences, tables
from dcrb_ros.messages.received_diagnosis import ReceivedDiagnosis
from dcrb_ros.runtime.terminal import console
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.schema.verdicts import FAULTS
from dcrb_ros.settings.shipped import find_shipped, shipped
from dcrb_ros.text.yaml import read_yaml


def result(
    verdict: str,
    answer: str,
    delay: float | None = None,
    *,
    width: float | None = None,
    score: float | None = None,
    alarms: tuple[float, ...] = (),
    required: bool = True,
    healthy: float = 4.0,
    grade: tuple[str, float] | None = None,
    difficulty: str | None = None,
    **more: Any,
) -> ScenarioResult:
    """Return the result of a scenario of 10 s whose fault appears at 4 s."""
    tags: dict[str, str | float] = {} if width is None else {"width": width}
    tags |= {} if grade is None else {"graded_by": grade[0], "grade": grade[1]}
    tags |= {} if difficulty is None else {"difficulty": difficulty}
    expectation = Expectation(f"{verdict}/{width}", verdict, 10.0, 4.0, tags, required=required)
    flaw = "" if answer == verdict else f"diagnosed as {answer}"
    raised = tuple(FalseAlarm(time, "cage") for time in alarms)
    return ScenarioResult(expectation, answer, delay, delay, raised, healthy, score, 20, flaw, **more)


def last_verdicts(one: ScenarioResult) -> ScenarioResult:
    """Return a result whose last verdict is the answer."""
    return dataclasses.replace(one, expectation=dataclasses.replace(one.expectation, last_verdict=True))


def report(*results: ScenarioResult, **criteria: Any) -> Report:
    return Report("made up", "nobody", Criteria.model_validate(criteria), "0" * 64, results)


MIXED = report(
    result("outer_ring", "outer_ring", 1.0, width=0.002, score=3.0),
    result("outer_ring", "outer_ring", 2.0, width=0.002, score=2.0),
    result("outer_ring", "healthy", None, width=0.001, score=1.0),
    result("sensor", "sensor", 0.5, score=9.0),
    result("healthy", "healthy", score=0.5, healthy=1796.0),
    result("healthy", "cage", score=1.5, alarms=(1.0, 6.0), healthy=1788.0),
)


def test_a_right_answer_before_a_failure_does_not_count_for_its_rig() -> None:
    given = [result("outer_ring", "outer_ring", 1.0), result("outer_ring", "outer_ring", 1.0, failure="it ended")]
    named = [dataclasses.replace(one, expectation=dataclasses.replace(one.expectation, tags={"rig": "ours"})) for one in given]
    assert [(rig.right, rig.recordings) for rig in report(*named).rigs()] == [(1, 2)]


def test_widths_on_the_bearings_of_a_replica_are_not_compared(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    given = result("outer_ring", "outer_ring", 1.5, width=0.001)
    assert len(report(given).detections()) == 1
    assert report(last_verdicts(given)).detections() == []
    said: list[str] = []
    monkeypatch.setattr(figure, "_empty", lambda _, text: said.append(text))
    write_figure(report(last_verdicts(given)), tmp_path / "replica.png")
    assert said[0].startswith("widths on different bearings")


@pytest.mark.parametrize(("limit", "top", "labels"), [(1e6, 6.0, ["median"]), (2.0, 2.025, ["median", "limit"])])
def test_delays_without_a_limit_are_drawn_up_to_the_end_of_the_scenarios(limit: float, top: float, labels: list[str]) -> None:
    axes = Figure().subplots()
    delays = dict.fromkeys(FAULTS, limit)
    figure._delay(axes, report(result("outer_ring", "outer_ring", 1.5), result("inner_ring", "healthy"), delay=delays))
    assert axes.get_ylim()[1] == pytest.approx(top)
    assert [text.get_text() for text in axes.get_legend().get_texts()] == labels


def test_scenarios_graded_by_another_parameter_are_reported_over_it_and_not_over_their_width(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    key = "background.track_level"
    graded = report(
        result("cage", "cage", 1.0, grade=(key, 1.0)),
        result("cage", "healthy", None, grade=(key, 10.0)),
        result("compound", "compound", 1.0, width=0.002, grade=("faults.inner_1.width", 0.001)),
        result("compound", "compound", 1.0, width=0.002, grade=("faults.inner_1.width", 0.001)),
        result("inner_ring", "inner_ring", 1.0, width=0.002),
    )
    found = [(d.verdict, d.parameter, d.value, d.found, d.scenarios) for d in graded.graded_detections()]
    assert found == [("cage", key, 1.0, 1, 1), ("cage", key, 10.0, 0, 1), ("compound", "faults.inner_1.width", 0.001, 2, 2)]
    assert [d.verdict for d in graded.detections()] == ["inner_ring"]
    assert [d["found"] for d in graded.described()["graded_detection"]] == [1, 0, 2]
    assert "background.track_level [m/s^2]" in printed(graded)
    write_figure(graded, tmp_path / "report.png")
    assert (tmp_path / "report.png").stat().st_size > 10_000
    made = axes(figure._graded, graded)
    cage, compound = made.get_lines()
    assert (cage.get_label(), compound.get_label()) == ("cage, track_level to 10", "compound, width to 0.001")
    assert np.asarray(cage.get_xdata()).tolist() == [0.1, 1.0]
    assert np.asarray(cage.get_ydata()).tolist() == [1.0, 0.0]


def test_strata_of_their_own_are_left_out_of_the_detections_over_the_width() -> None:
    masked = report(
        result("outer_ring", "outer_ring", 1.0, width=0.002),
        result("outer_ring", "healthy", width=0.002, difficulty="masked by the background"),
    )
    assert [(d.value, d.found, d.scenarios) for d in masked.detections()] == [(0.002, 1, 1)]


def test_a_report_of_last_verdicts_has_their_share_and_no_exam_score(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    given = [result("outer_ring", "outer_ring", 1.0), result("outer_ring", "healthy"), result("healthy", "healthy")]
    named = [dataclasses.replace(one, expectation=dataclasses.replace(one.expectation, name=f"{k}")) for k, one in enumerate(given)]
    text = printed(report(*map(last_verdicts, named)))
    assert "mean over their classes: 75.0 (0.0 .. 100.0) % (95% bootstrap interval)" in " ".join(text.split())
    assert "exam score" not in text.lower()
    assert "time without a verdict" not in text
    assert "exam score: none" in printed(report(*named))
    assert list(figure._marks(report(*map(last_verdicts, named)))) == ["correct verdicts: 75.0 %"]
    assert "mean over their classes: - (0.0 .. 100.0)" in printed(report(last_verdicts(result("roller", "roller", 1.0, required=False))))


def test_without_a_known_speed_a_delay_has_no_revolutions() -> None:
    unknown = result("outer_ring", "outer_ring", 1.0, delay_revolutions=0.0)
    turning = dataclasses.replace(unknown.expectation, speeds=((0.0, 6.283),))
    known = dataclasses.replace(unknown, expectation=turning, delay_revolutions=1.0)
    assert math.isnan(report(unknown).delays()[0].turns)
    assert report(known).delays()[0].turns == 1.0
    assert [one["delay_turns"] for one in report(unknown, known).described()["scenarios"]] == [None, 1.0]


def test_the_statistics_of_a_report_follow_from_its_results() -> None:
    assert MIXED.hours == pytest.approx(1.0)
    assert (MIXED.alarms, MIXED.alarm_rate().value) == (2, pytest.approx(2.0))
    outer, sensor = MIXED.delays()
    assert (outer.verdict, outer.limit, outer.found, outer.scenarios, outer.median, outer.p95) == ("outer_ring", 5.0, 2, 3, 1.5, 1.95)
    assert (sensor.verdict, sensor.found, sensor.scenarios) == ("sensor", 1, 1)
    narrow, wide = MIXED.detections()
    assert [(d.verdict, d.value, d.found, d.scenarios) for d in (narrow, wide)] == [
        ("outer_ring", 0.001, 0, 1),
        ("outer_ring", 0.002, 2, 2),
    ]
    assert wide.probability == share(2, 2)
    curve = MIXED.characteristic()
    assert curve is not None
    assert curve.area == pytest.approx(5.0 / 6.0)  # without the sensor fault: 3, 2, 1 against 0.5, 1.5
    unscored = report(*MIXED.results, result("roller", "healthy"), result("healthy", "healthy")).characteristic()
    assert unscored is not None
    assert unscored.area == pytest.approx(5.0 / 12.0)  # -inf, 3, 2, 1 against 0.5, 1.5, inf: 5 of 12 pairs
    assert [score for score in unscored.threshold if math.isfinite(score)] == curve.threshold
    assert (
        report(result("outer_ring", "healthy"), result("sensor", "sensor", score=1.0), result("healthy", "healthy")).characteristic()
        is None
    )
    counts = {(right, answer): n for right, row in MIXED.confusion().items() for answer, n in row.items() if n}
    assert counts == {
        ("healthy", "healthy"): 1,
        ("healthy", "cage"): 1,
        ("outer_ring", "outer_ring"): 2,
        ("outer_ring", "healthy"): 1,
        ("sensor", "sensor"): 1,
    }


@pytest.mark.parametrize(
    ("criteria", "holds"),
    [
        ({"found": 0.75, "false_alarms": 2}, [True, True, True]),
        ({"found": 0.76, "false_alarms": 1}, [False, False, True]),
    ],
)
def test_a_criterion_is_met_at_its_limit(criteria: dict[str, Any], holds: list[bool]) -> None:
    checks = report(*MIXED.results, **criteria).checks()
    assert [check.holds for check in checks] == holds
    assert [check.got for check in checks] == ["3 of 4", "2", "0"]
    assert checks[0].name == "required faults detected in time with the correct verdict"
    assert report(name_right=False).checks()[0].name == "required faults detected in time"


def test_missing_verdicts_and_faults_that_are_not_required_are_distinguished() -> None:
    assert report(result("cage", "healthy", required=False)).passed
    assert report().passed
    assert not report(result("healthy", "nothing", broken=True)).passed


def test_a_report_as_a_tree_has_null_for_what_does_not_exist() -> None:
    tree = MIXED.described()
    assert [scenario["onset"] for scenario in tree["scenarios"]] == [4.0] * 4 + [None] * 2
    assert tree["false_alarms"]["per_hour"]["value"] == pytest.approx(2.0)
    assert tree["scenarios"][5]["false_alarms"] == [{"time": time, "verdict": "cage", "reason": ""} for time in (1.0, 6.0)]
    empty = report(result("healthy", "healthy", healthy=0.0)).described()
    assert (empty["false_alarms"]["per_hour"], empty["roc"]) == ({"value": None, "low": 0.0, "high": None}, None)
    assert Report("made up", "nobody", Criteria(), "", ()).described()["scenarios_sha256"] is None


def test_a_report_as_a_frame_has_a_row_per_scenario() -> None:
    frame = MIXED.to_pandas()
    assert frame["false_alarms"].tolist() == [0, 0, 0, 0, 0, 2]
    assert frame["passed"].tolist() == [True, True, False, True, True, False]
    assert frame["onset"].isna().tolist() == [False] * 4 + [True] * 2
    assert repr(MIXED) == "<Report: nobody failed made up, 6 scenarios>"


def test_numbers_and_intervals_as_text() -> None:
    assert (number(1.005, 1), number(2.0), number(math.nan), number(math.inf)) == ("1.0", "2.00", "-", "-")
    assert bounds(Interval(0.5, 0.25, math.inf)) == "0.50 (0.25 .. -)"
    assert bounds(Interval(0.5, 0.25, 0.75), 1) == "0.5 (0.2 .. 0.8)"


def test_the_sentences_of_a_report_have_its_numbers() -> None:
    alarms, silent, roc, scenarios, software = sentences(MIXED)
    assert alarms.startswith("false alarms: 2 in 60.0 min of healthy signal, 2.0 (0.2 .. 7.2) per hour (95% Poisson")
    assert silent == "time without a verdict: 0.0%"
    assert roc == "ROC: area 0.833 over 5 thresholds"
    assert scenarios == f"scenarios: sha256 {'0' * 64}"
    assert software.startswith("dcrb_ros ")
    empty = list(sentences(Report("made up", "nobody", Criteria(), "", ())))
    assert empty[0] == "false alarms: not counted, there is no healthy signal"
    assert empty[1].startswith("ROC: none")
    assert len(empty) == 3


def printed(shown: Report) -> str:
    output = console()
    with output.capture() as capture:
        output.print(tables(shown))
    return capture.get()


def cells(text: str, word: str) -> list[list[str]]:
    """Return the cells of the rows of tables that begin with a word."""
    rows = [[cell.strip() for cell in line.strip("│┃ ").split("│")] for line in text.splitlines()]
    return [row for row in rows if row[0] == word and len(row) > 1]


def test_the_tables_have_delays_widths_and_counts() -> None:
    text = printed(MIXED)
    assert "made up: FAILED, nobody" in text
    assert ["outer_ring", "2 of 3", "1.50", "1.95", "5", "-"] in cells(text, "outer_ring")
    assert ["outer_ring", "2", "2 of 2", "1.00 (0.16 .. 1.00)"] in cells(text, "outer_ring")
    assert ["outer_ring", "1", "2", ".", "."] in cells(text, "outer_ring")  # answers: healthy, outer_ring, cage, sensor
    assert "2 of 6 scenarios failed" in text
    good = printed(report(result("healthy", "healthy")))
    assert "made up: passed, nobody" in good
    assert not any(word in good for word in ("scenarios failed", "Detection delay", "Detection by width"))


def test_the_tables_have_units_and_names_as_they_are() -> None:
    shown = dataclasses.replace(MIXED, exam="mine [s]", detector="node --name '[x]'")
    text = printed(shown)
    for words in (
        "median [s]",
        "95 % [s]",
        "limit [s]",
        "width [mm]",
        "correct \\ answer",
        "mine [s]",
        "node --name '[x]'",
    ):
        assert words in text


def test_the_table_has_the_reason_of_a_wrong_sensor_verdict() -> None:
    received = (ReceivedDiagnosis(5.0, "sensor", reason="the sensor is dead"),)
    text = printed(report(result("outer_ring", "sensor", received=received), result("cage", "sensor", received=received, broken=True)))
    assert text.count("diagnosed as sensor") == 2
    assert text.count("diagnosed as sensor: the sensor is dead") == 1


@pytest.mark.parametrize("failed", [MOST_FAILURES, MOST_FAILURES + 3])
def test_at_most_forty_failed_scenarios_are_listed(failed: int) -> None:
    text = printed(report(*[result("cage", "roller", required=k > 0) for k in range(failed)]))
    assert MOST_FAILURES == 40
    assert text.count("diagnosed as roller") == 40
    assert text.count("(not required)") == 1
    assert ("and 3 more" in text) == (failed > 40)
    assert ("more: --json" in text) == (failed > 40)


def test_met_and_missed_criteria_differ_in_style() -> None:
    checks: Any = next(iter(tables(MIXED).renderables))  # type: ignore[union-attr]
    assert isinstance(checks, Table)
    assert [row.style for row in checks.rows] == ["bold red", "bold red", ""]


def axes(draw: Any, shown: Report) -> Axes:
    made: Axes = Figure().subplots()
    draw(made, shown)
    return made


def test_the_figure_shows_the_probability_of_detection_over_the_width() -> None:
    both = report(*MIXED.results, result("cage", "healthy", width=0.004))
    made = axes(figure._detection, both)
    cage, outer = (line for line in made.get_lines() if len(line.get_xdata()) in (1, 2) and line.get_marker() == "o")
    if len(np.asarray(cage.get_xdata())) == 2:
        cage, outer = outer, cage
    assert np.asarray(outer.get_ydata()).tolist() == [0.0, 1.0]
    # The families are shifted to either side, so that their bars do not hide each other.
    assert np.asarray(outer.get_xdata()) == pytest.approx(np.array([1.0, 2.0]) - 0.024, abs=0.03)
    assert np.asarray(outer.get_xdata()) - [1.0, 2.0] == pytest.approx(-(np.asarray(cage.get_xdata())[0] - 4.0))
    (bars, _) = (collection.get_segments() for collection in made.collections)
    assert bars[0][:, 1] == pytest.approx([share(0, 1).low, share(0, 1).high])
    assert bars[1][:, 1] == pytest.approx([share(2, 2).low, share(2, 2).high])
    (required,) = (line for line in made.get_lines() if line.get_label() == "smallest required width")
    assert list(np.asarray(required.get_xdata())) == [1.0, 1.0]
    assert made.get_xlim() == pytest.approx((0.0, 4.4))
    assert made.get_ylim()[0] < 0.0 < 1.0 < made.get_ylim()[1]


def test_the_figure_shows_each_delay_with_median_and_limit() -> None:
    made = axes(figure._delay, MIXED)
    outer, sensor = (line for line in made.get_lines() if line.get_marker() == "o")
    assert np.asarray(outer.get_ydata()).tolist() == [1.0, 2.0]
    assert np.asarray(outer.get_xdata()).mean() == pytest.approx(0.0)
    assert np.asarray(sensor.get_xdata()).tolist() == [1.0]
    assert to_hex(sensor.get_color()) == FAULTS["sensor"].colour
    levels = [collection.get_segments()[0][0, 1] for collection in made.collections]
    assert levels == [1.5, 5.0, 0.5, 5.0]
    assert [label.get_text() for label in made.get_xticklabels()] == ["outer_ring\n2 of 3", "sensor\n1 of 1"]
    assert made.get_ylim()[0] == 0.0
    missed = axes(figure._delay, report(result("cage", "healthy")))
    assert len(missed.collections) == 1  # no median


def test_the_figure_shows_the_confusion_matrix_with_counts() -> None:
    made = axes(figure._confusion, MIXED)
    texts = {(round(text.get_position()[1]), round(text.get_position()[0])): text for text in made.texts}
    rows = [label.get_text() for label in made.get_yticklabels()]
    answers = [label.get_text() for label in made.get_xticklabels()]
    assert (rows, answers) == (["healthy", "outer_ring", "sensor"], ["healthy", "outer_ring", "cage", "sensor"])
    printed = [[texts[i, j].get_text() for j in range(4)] for i in range(3)]
    assert printed == [["1", "0", "1", "0"], ["1", "2", "0", "0"], ["0", "0", "0", "1"]]
    assert [texts[i, j].get_color() for i, j in ((0, 0), (1, 1), (2, 3))] == ["black", "white", "white"]
    assert {(i, j) for i, j in texts if texts[i, j].get_fontweight() == "bold"} == {(0, 0), (1, 1), (2, 3)}
    right, wrong = (image.get_array() for image in made.images)
    assert right is not None
    assert wrong is not None
    assert right.compressed() == pytest.approx([0.5, 2.0 / 3.0, 1.0])
    assert wrong.compressed() == pytest.approx([0.0, 0.5, 0.0, 1.0 / 3.0, 0.0, 0.0, 0.0, 0.0, 0.0])


def test_the_figure_says_which_correct_answers_came_too_late() -> None:
    late = report(*[result("cage", "cage", 1.0 if k < 3 else None, width=0.001) for k in range(8)], result("roller", "roller", None))
    (roller, cage) = (text.get_text() for text in axes(figure._confusion, late).texts if text.get_text() != "0")
    assert (cage, roller) == ("8\n3 in time", "1\n0 in time")
    assert [text.get_text() for text in axes(figure._delay, late).texts] == ["none detected\nin time"]


def test_the_figure_shows_the_characteristic() -> None:
    made = axes(figure._roc, MIXED)
    curve, chance = made.get_lines()
    expected = MIXED.characteristic()
    assert expected is not None
    assert (list(np.asarray(curve.get_xdata())), list(np.asarray(curve.get_ydata()))) == (expected.false, expected.true)
    assert curve.get_label() == "area 0.833"
    assert (list(np.asarray(chance.get_xdata())), list(np.asarray(chance.get_ydata()))) == ([0.0, 1.0], [0.0, 1.0])
    assert made.get_xlim()[0] <= 0.0 < 1.0 <= made.get_xlim()[1] < 1.1
    assert made.get_ylim()[0] <= 0.0 < 1.0 <= made.get_ylim()[1] < 1.1


def test_a_figure_without_data_says_so() -> None:
    empty = report(result("healthy", "healthy"))
    for draw, words in (
        (figure._detection, "no defect with a width"),
        (figure._delay, "no scenario with a fault"),
        (figure._roc, "no score or confidence for both\nfaulty and healthy scenarios"),
    ):
        assert [text.get_text() for text in axes(draw, empty).texts] == [words]
    assert [text.get_text() for text in axes(figure._confusion, report()).texts] == ["no scenario"]


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in shipped("exam") if "vehicle" not in read_yaml(find_shipped("exam", name))])
def test_the_figure_of_every_shipped_exam_has_the_colour_of_each_of_its_verdicts(name: str, tmp_path: Path) -> None:
    exam = read_exam(name)
    results = []
    for case in exam.cases:
        expected = case.expectation
        diagnoses = [ReceivedDiagnosis(expected.onset + 0.5, expected.verdict, 1.0), ReceivedDiagnosis(expected.end, expected.verdict, 1.0)]
        results.append(score_scenario(expected, diagnoses, exam.criteria))
    shown = Report(exam.name, "made up", exam.criteria, "", tuple(results))
    write_figure(shown, tmp_path / "f.svg")
    drawn = (tmp_path / "f.svg").read_text(encoding="utf-8")
    assert [delay.verdict for delay in shown.delays() if FAULTS[delay.verdict].colour not in drawn] == []
    assert all(delay.found == delay.scenarios for delay in shown.delays())


def test_every_fault_has_a_colour_of_its_own() -> None:
    assert len({fault.colour for fault in FAULTS.values()}) == len(FAULTS)


@pytest.mark.parametrize(("name", "words"), [("f.bmp", "unknown file type"), ("gone/f.png", "cannot be written")])
def test_a_figure_that_cannot_be_written_is_refused(name: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(Refusal, match=words):
        write_figure(report(), tmp_path / name)


def test_a_suffix_may_have_capitals(tmp_path: Path) -> None:
    write_figure(report(), tmp_path / "F.PNG")
    assert (tmp_path / "F.PNG").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(("shown", "word"), [(MIXED, "failed"), (report(), "passed")])
def test_the_title_of_the_figure_says_whether_the_detector_passed(shown: Report, word: str, tmp_path: Path) -> None:
    write_figure(shown, tmp_path / "f.svg")
    assert f"made up: {word}, nobody" in (tmp_path / "f.svg").read_text(encoding="utf-8")


def test_junit_of_a_detector_whose_name_is_no_utf_8_is_valid_xml(tmp_path: Path) -> None:
    write_junit(dataclasses.replace(MIXED, detector="mine\udcff"), tmp_path / "junit.xml")
    criteria, _ = JUnitXml.fromfile(str(tmp_path / "junit.xml"))
    assert {p.name: p.value for p in criteria.properties()}["detector"] == "mine?"


def test_junit_has_criteria_and_scenarios_with_their_failures(tmp_path: Path) -> None:
    shown = report(*MIXED.results, result("cage", "healthy", required=False))
    write_junit(shown, tmp_path / "junit.xml")
    criteria, scenarios = JUnitXml.fromfile(str(tmp_path / "junit.xml"))
    assert [len(case.result) for case in criteria] == [1, 1, 0]
    assert {p.name: p.value for p in criteria.properties()}["scenarios_sha256"] == "0" * 64
    kinds = [[type(found) for found in case.result] for case in scenarios]
    assert kinds == [[], [], [Failure], [], [], [Failure], [Skipped]]
    assert [case.time for case in scenarios] == [1.0, 2.0, 0.0, 0.5, 0.0, 0.0, 0.0]


@pytest.mark.parametrize(("found", "false_alarms"), [(0.6, 2), (0.6, 1), (1.0, 2)])
def test_flaws_that_a_criterion_tolerates_are_skipped(found: float, false_alarms: int, tmp_path: Path) -> None:
    write_junit(report(*MIXED.results, found=found, false_alarms=false_alarms), tmp_path / "junit.xml")
    _, scenarios = JUnitXml.fromfile(str(tmp_path / "junit.xml"))
    missed, alarm = ([(type(found), found.message) for found in case.result] for case in scenarios if case.result)
    assert missed == [(Skipped, "tolerated by the criteria: diagnosed as healthy") if found < 1.0 else (Failure, "diagnosed as healthy")]
    assert alarm == [(Skipped, "tolerated by the criteria: diagnosed as cage") if false_alarms == 2 else (Failure, "diagnosed as cage")]


def test_a_false_alarm_or_silence_is_a_failure_although_the_fault_need_not_be_detected(tmp_path: Path) -> None:
    narrow = Expectation("narrow", "outer_ring", 10.0, 4.0, required=False)
    verdicts = {"alarm": ("cage", "healthy"), "missed": ("healthy", "healthy"), "silent": ("waiting", "waiting")}
    diagnoses = {name: [ReceivedDiagnosis(float(k), two[k > 2]) for k in range(11)] for name, two in verdicts.items()}
    shown = report(*[score_scenario(dataclasses.replace(narrow, name=name), given, Criteria()) for name, given in diagnoses.items()])
    write_junit(shown, tmp_path / "junit.xml")
    _, scenarios = JUnitXml.fromfile(str(tmp_path / "junit.xml"))
    kinds = {case.name: [(type(found), found.message) for found in case.result] for case in scenarios}
    assert kinds["alarm"] == [(Failure, "false alarm at 0.0 s (cage)")]
    assert kinds["missed"] == [(Skipped, "not required: diagnosed as healthy")]
    assert kinds["silent"] == [(Failure, "diagnosed as waiting")]
    assert printed(shown).count("(not required)") == 1
