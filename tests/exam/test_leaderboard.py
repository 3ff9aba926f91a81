"""Entries, comparisons of detectors and the leaderboard."""

from __future__ import annotations

import html
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from full_disk import files_of_at_most
from matplotlib.axes import Axes
from same_process import dcrb

from dcrb_ros.exam import leaderboard_figure
from dcrb_ros.exam.agreement import agreement
from dcrb_ros.exam.criteria import Criteria
from dcrb_ros.exam.expectation import Expectation
from dcrb_ros.exam.leaderboard import about, boards, markdown, page, read_entries, rows
from dcrb_ros.exam.leaderboard_entry import Entry, StoredDiagnoses, entry_of, read_entry, write_entry
from dcrb_ros.exam.leaderboard_figure import board_figure
from dcrb_ros.exam.marking import ScoreMarking, compare
from dcrb_ros.exam.profile import PROFILES
from dcrb_ros.exam.report import Report
from dcrb_ros.exam.scoring import score_scenario
from dcrb_ros.messages.received_diagnosis import ReceivedDiagnosis
from dcrb_ros.schema.refusal import Refusal

pytestmark = pytest.mark.slow

MARKING = ScoreMarking()
COUNT = 24
EXPECTATIONS = [
    *(Expectation(f"outer/{k}", "outer_ring", 10.0, 4.0, {"speed": 125.0, "width": 0.002}, twin="twin/0") for k in range(COUNT)),
    *(Expectation(f"twin/{k}", "healthy", 10.0, tags={"speed": 125.0}) for k in range(COUNT)),
]


def detector(seed: int, skill: float, *, name: str = "") -> Entry:
    """Return the entry of a detector that finds a share of the faults, ``skill``, and is silent otherwise."""
    random = np.random.default_rng(seed)
    results = []
    for expectation in EXPECTATIONS:
        found = expectation.faulty and random.random() < skill
        given = [
            ReceivedDiagnosis(t, "outer_ring" if found and t > 4.0 else "healthy", float(found and t > 4.0))
            for t in np.arange(0.0, 10.5, 0.5)
        ]
        results.append(score_scenario(expectation, given, Criteria()))
    return entry_of(Report("made up", f"detector {seed}", Criteria(), "0" * 64, tuple(results)), name)


def test_an_entry_survives_its_file(tmp_path: Path) -> None:
    entry = detector(1, 0.5)
    write_entry(entry, tmp_path / "e.json")
    assert read_entry(tmp_path / "e.json") == entry
    assert 0.0 < entry.exam_score["research"] < 100.0
    assert (entry.detector, len(entry.scenarios), entry.false_alarms) == ("detector 1", 2 * COUNT, 0)


MISSED, FOUND = (next(k for k, s in enumerate(detector(1, 0.5).scenarios) if s.found is found) for found in (False, True))
"""Scenarios whose fault the first detector did not detect, and did."""
FULL = {profile.name: 1.0 for profile in PROFILES}
"""Credit of an ideal detector [-]."""


def test_an_entry_without_a_digest_is_refused(tmp_path: Path) -> None:
    (tmp_path / "e.json").write_text(json.dumps(detector(1, 0.5).model_dump()), encoding="utf-8")
    with pytest.raises(Refusal, match="has no sha256, so that a change would not be found"):
        read_entry(tmp_path / "e.json")


def test_an_entry_has_full_credit_for_a_late_detection_where_delays_cost_nothing(tmp_path: Path) -> None:
    criteria = Criteria.model_validate({"delay": {"outer_ring": 2.0}})
    given = [ReceivedDiagnosis(t, "outer_ring" if t >= 7.0 else "healthy") for t in np.arange(0.0, 10.5, 0.5)]
    results = tuple(score_scenario(expectation, given if expectation.faulty else given[:1], criteria) for expectation in EXPECTATIONS)
    assert (results[0].delay, results[0].credit.detection["cost"]) == (None, 1.0)
    write_entry(entry_of(Report("made up", "late", criteria, "0" * 64, results)), tmp_path / "e.json")
    assert read_entry(tmp_path / "e.json").scenarios[0].credit["cost"] == 1.0


def test_an_entry_of_four_hours_with_a_score_for_every_block_is_read(tmp_path: Path) -> None:
    blocks = 4 * 3600 * 50
    times, scores = (np.arange(blocks) / 50.0).tolist(), np.random.default_rng(1).normal(size=blocks).tolist()
    given = StoredDiagnoses(time=times, verdicts=["healthy"], counts=[blocks], score=scores)
    entry = detector(1, 0.5)
    entry = entry.model_copy(update={"scenarios": [*entry.scenarios[:-1], entry.scenarios[-1].model_copy(update={"diagnoses": given})]})
    write_entry(entry, tmp_path / "e.json")
    assert read_entry(tmp_path / "e.json") == entry


def test_diagnoses_survive_their_columns() -> None:
    given = [ReceivedDiagnosis(0.5, "healthy"), ReceivedDiagnosis(1.0, "healthy", 2.5), ReceivedDiagnosis(1.5, "cage", None, "", 3.0)]
    assert StoredDiagnoses.of(given).received() == given
    assert StoredDiagnoses.of(given).verdicts == ["healthy", "cage"]
    assert StoredDiagnoses.of(given).counts == [2, 1]
    assert StoredDiagnoses.of([]).received() == []
    assert (StoredDiagnoses.of(given[:1]).score, StoredDiagnoses.of(given).flaw, StoredDiagnoses.of([]).flaw) == (None, "", "")


def edited(tree: dict[str, Any], path: tuple[Any, ...], value: Any) -> dict[str, Any]:
    copy = json.loads(json.dumps(tree))
    at = copy
    for key in path[:-1]:
        at = at[key]
    at[path[-1]] = value
    return copy


@pytest.mark.parametrize(
    ("path", "value", "sentence"),
    [
        (("exam_score", "research"), 99.0, "do not follow from its scenarios"),
        (("exam_score",), {}, "do not follow from its scenarios"),
        (("scenarios", 0, "credit", "research"), 1.5, "impossible credit in the scenario 'outer/0'"),
        (("scenarios", 0, "credit"), {}, "impossible credit"),
        (("scenarios", 0, "name"), "outer/1", "has the scenario 'outer/1' twice"),
        (("scenarios", 30, "spoiled"), 9, "impossible credit in the scenario 'twin/6'"),
        (("scenarios",), [], r"is not an entry \(scenarios"),
        (("format",), "dcrb exam entry 1", r"is not an entry \(format"),
        (("surprise",), 1, r"is not an entry \(surprise"),
        (("area",), 17.5, r"states the area 17.5, but 0\.\d+ follows from its scenarios"),
        (("area",), None, "states the area None, but"),
        (
            ("scenarios", MISSED, "credit"),
            dict.fromkeys(("safety", "cost", "research"), 1.0),
            r"a credit of 1 \(safety\) for a fault that was",
        ),
        (("scenarios", MISSED, "found"), True, "found is True, with the answer healthy and the delay None"),
        (("scenarios", FOUND, "found"), False, "found is False, with the answer outer_ring and the delay"),
        (("scenarios", FOUND, "delay_turns"), None, "found is True, with the answer outer_ring and the delay None"),
        (("scenarios", FOUND, "answer"), "banana", "'banana' is not a verdict"),
        (("scenarios", 30, "delay_turns"), 3.0, "it has no fault, but the delay"),
        (("scenarios", 30, "evidence"), 5.0, "states the area"),
        (("scenarios", FOUND, "diagnoses", "counts"), [10**12, 1], "the columns of its diagnoses have different lengths"),
        (("scenarios", FOUND, "diagnoses", "verdicts", 0), "banana", "'banana' is not a verdict"),
        (("scenarios", FOUND, "diagnoses", "time", 0), -1.0, "the time of a diagnosis is outside"),
    ],
)
def test_an_edited_entry_is_refused(path: tuple[Any, ...], value: Any, sentence: str, tmp_path: Path) -> None:
    (tmp_path / "e.json").write_text(json.dumps(edited(detector(1, 0.5).model_dump(), path, value)), encoding="utf-8")
    with pytest.raises(Refusal, match=sentence):
        read_entry(tmp_path / "e.json")


@pytest.mark.parametrize(
    ("family", "verdicts", "answer", "sentence"),
    [
        ("outer_ring", ("healthy", "outer_ring"), "outer_ring", ""),
        ("outer_ring", ("healthy", "outer_ring", "waiting"), "outer_ring", ""),
        ("outer_ring", ("outer_ring", "healthy"), "outer_ring", "the answer is outer_ring, but the last verdict is healthy"),
        ("healthy", ("cage", "healthy"), "cage", "the answer is cage, but the last verdict is healthy"),
        ("healthy", ("waiting",), "healthy", "the answer is healthy, but the last verdict is nothing"),
        ("healthy", ("cage", "waiting"), "waiting", ""),  # the alarm was before the onset
        ("outer_ring", ("inner_ring",), "outer_ring", ""),  # with name_right off
    ],
)
def test_the_answer_of_an_entry_of_last_verdicts_is_the_last_one(
    family: str, verdicts: tuple[str, ...], answer: str, sentence: str, tmp_path: Path
) -> None:
    entry = detector(1, 0.5)
    number = next(k for k, one in enumerate(entry.scenarios) if one.family == family and not one.found)
    given = StoredDiagnoses.of([ReceivedDiagnosis(1.0 + k, verdict) for k, verdict in enumerate(verdicts)])
    one = entry.scenarios[number].model_copy(update={"answer": answer, "diagnoses": given, "credit": {}})
    one = one if family == "healthy" else one.model_copy(update={"credit": dict.fromkeys(FULL, 0.0)})
    (tmp_path / "e.json").write_text(json.dumps(entry.model_copy(update={"scenarios": [one], "last_verdict": True}).model_dump()))
    with pytest.raises(Refusal) as refused:
        read_entry(tmp_path / "e.json")
    # One scenario has no exam score, so an entry whose answers are right is refused for the scores that it states.
    assert (sentence or "states exam scores that do not follow") in str(refused.value)


@pytest.mark.parametrize(
    ("path", "value"), [(("scenarios", FOUND, "delay_turns"), 1.0), (("false_alarms",), 3), (("detector",), "other"), (("passed",), None)]
)
def test_a_written_entry_that_was_edited_is_refused(path: tuple[Any, ...], value: Any, tmp_path: Path) -> None:
    """Also where the new value contradicts nothing."""
    file = tmp_path / "e.json"
    write_entry(detector(1, 0.5), file)
    tree = json.loads(file.read_text(encoding="utf-8"))
    value = not tree["passed"] if value is None else value
    file.write_text(json.dumps(edited(tree, path, value)), encoding="utf-8")
    with pytest.raises(Refusal, match="was changed: its digest does not match"):
        read_entry(file)


def test_a_detector_is_not_distinguished_from_itself() -> None:
    own = detector(1, 0.5)
    found = compare(MARKING, own, own)
    assert (found.low, found.high, found.confidence) == (0.0, 0.0, 0.5)
    assert not found.distinguished


def test_a_comparison_is_antisymmetric() -> None:
    first, second = detector(1, 0.5), detector(2, 0.6)
    there, back = compare(MARKING, first, second), compare(MARKING, second, first)
    assert there.confidence == pytest.approx(1.0 - back.confidence)
    assert (there.low, there.high) == pytest.approx((-back.high, -back.low))


def test_detectors_of_different_skill_are_distinguished() -> None:
    found = compare(MARKING, detector(1, 0.9), detector(2, 0.4))
    assert found.distinguished
    assert found.confidence > 0.99


def test_detectors_of_equal_skill_are_distinguished_as_rarely_as_the_confidence_says() -> None:
    """At 95 % confidence, one pair in twenty is told apart wrongly; percentile intervals of 24 scenarios are a little too narrow."""
    pairs = 60
    wrong = sum(compare(MARKING, detector(k, 0.5), detector(k + 1000, 0.5)).distinguished for k in range(pairs))
    assert wrong <= 9  # a binomial number with p = 0.07 exceeds 9 of 60 with a probability below 1 %


def test_the_paired_comparison_sees_a_small_difference_on_the_same_scenarios() -> None:
    """One detector finds everything that the other finds, and three more: unpaired intervals overlap widely."""
    weaker = detector(3, 0.5)
    missed = [s.name for s in weaker.scenarios if s.family != "healthy" and not s.found][:6]
    full = next(s.credit for s in weaker.scenarios if s.found)
    better = [s.model_copy(update={"credit": full}) if s.name in missed else s for s in weaker.scenarios]
    stronger = weaker.model_copy(update={"scenarios": better})
    found = compare(MARKING, stronger, weaker)
    assert found.distinguished
    assert stronger.scores()[2].score.low < weaker.scores()[2].score.high


def test_detectors_on_different_scenarios_are_not_compared() -> None:
    own = detector(1, 0.5)
    with pytest.raises(Refusal, match="different scenarios"):
        compare(MARKING, own, own.model_copy(update={"scenarios": own.scenarios[1:]}))


def test_the_leaderboard_is_sorted_by_the_score() -> None:
    (board,) = boards([detector(1, 0.3), detector(2, 0.9), detector(3, 0.6)])
    assert [entry.detector for entry in board.entries] == ["detector 2", "detector 3", "detector 1"]
    found = list(rows(board))
    assert [row[0] for row in found] == ["1", "2", "3"]
    assert found[0][-1].startswith("yes, ")
    assert found[-1][-1] == "–"


def test_exams_with_different_scenarios_have_boards_of_their_own() -> None:
    other = detector(2, 0.5).model_copy(update={"scenarios_sha256": "1" * 64})
    assert [len(board.entries) for board in boards([detector(1, 0.5), other])] == [1, 1]


def test_entries_of_one_exam_under_several_titles_have_one_board() -> None:
    other = detector(2, 0.5).model_copy(update={"exam": "another title"})
    (board,) = boards([detector(1, 0.5), other])
    assert (board.exam, len(board.entries)) == ("made up", 2)
    recordings = [entry.model_copy(update={"scenarios_sha256": ""}) for entry in (detector(1, 0.5), other)]
    assert [board.exam for board in boards(recordings)] == ["another title", "made up"]


def test_entries_with_different_criteria_have_boards_of_their_own() -> None:
    given = [ReceivedDiagnosis(t, "healthy") for t in np.arange(0.0, 10.5, 0.5)]
    entries: list[Entry] = []
    for tolerated in (0, 0, 3):
        criteria = Criteria(false_alarms=tolerated)
        results = tuple(score_scenario(expectation, given, criteria) for expectation in EXPECTATIONS)
        entries.append(entry_of(Report("made up", "healthy", criteria, "0" * 64, results), f"d{len(entries)}"))
    found = boards(entries)
    assert sorted([entry.detector for entry in board.entries] for board in found) == [["d0", "d1"], ["d2"]]
    assert len(set(map(about, found))) == 2


def test_entries_of_the_same_name_are_refused() -> None:
    with pytest.raises(Refusal, match="two entries of the exam made up are called 'mine'"):
        boards([detector(1, 0.5, name="mine"), detector(2, 0.5, name="mine")])


def test_a_leaderboard_of_last_verdicts_names_its_marks() -> None:
    (board,) = boards([detector(k, skill).model_copy(update={"last_verdict": True}) for k, skill in ((1, 0.3), (2, 0.9))])
    assert "![Correct verdicts of made up](f.png)" in markdown([board], ["f.png"])
    assert 'alt="Correct verdicts of made up"' in page([board], ["f.png"])


def test_the_figure_compares_every_pair_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (board,) = boards([detector(k, 0.2 * k) for k in range(1, 5)])
    pairs, drawn = [], []
    monkeypatch.setattr(leaderboard_figure, "compare", lambda marking, *pair: pairs.append(pair) or compare(marking, *pair))
    monkeypatch.setattr(Axes, "imshow", lambda _, shares, **options: drawn.append(shares))
    board_figure(board).savefig(tmp_path / "f.png")
    assert len(pairs) == 4 * 3 / 2
    (shares,) = drawn
    assert np.isnan(shares.diagonal()).all()
    apart = ~np.eye(4, dtype=bool)
    assert (shares + shares.T)[apart] == pytest.approx(100.0)
    assert shares[0, 1] == pytest.approx(100.0 * compare(board.marking, *board.entries[:2]).confidence)


def test_names_are_text_in_markdown_and_html() -> None:
    found = boards([detector(1, 0.5, name="<b>a|b</b> [x](y) `z`")])
    text, site = markdown(found, ["f.png"]), page(found, ["f.png"])
    assert "<b>" not in text
    assert "<b>" not in site
    row = next(line for line in text.splitlines() if line.startswith("| 1 |"))
    assert row.replace("\\|", "").count("|") == len(next(iter(rows(found[0])))) + 1
    assert "\\[x\\](y)" in text


def test_the_leaderboard_states_how_it_agrees_with_measured_recordings(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    skills = {1: 0.3, 2: 0.9, 3: 0.6}
    for number, skill in skills.items():
        write_entry(detector(number, skill), tmp_path / f"{number}.json")
    recorded = tmp_path / "measured"
    recorded.mkdir()
    for number in skills:
        write_entry(detector(number, 1.0 - skills[number]), recorded / f"{number}.json")
    ranks = agreement(read_entries(tmp_path), read_entries(recorded))
    assert ranks.kendall.value == -1.0
    assert dcrb("exam", "table", str(tmp_path), "--measured", str(recorded), "-o", str(tmp_path / "out")) == 0
    for name in ("leaderboard.md", "leaderboard.html"):
        text = (tmp_path / "out" / name).read_text(encoding="utf-8")
        assert "Kendall's tau-b -1.00" in html.unescape(text)
        for share in ranks.measured:
            assert f"| {share:.0f}% |" in text or f"<td>{share:.0f}%</td>" in text
    assert dcrb("exam", "agreement", str(tmp_path), str(recorded)) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "exam score [-]" in printed
    for name, score, share in zip(ranks.detectors, ranks.exam, ranks.measured, strict=True):
        assert f"│ {name} │ {score:.1f} │ {share:.0f} │" in printed
    (recorded / "3.json").unlink()
    assert dcrb("exam", "table", str(tmp_path), "--measured", str(recorded), "-o", str(tmp_path / "other")) == 2
    assert not (tmp_path / "other").exists()
    assert "the two folders have 2 detectors in common" in capsys.readouterr().err


def test_the_command_writes_the_leaderboard(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for number, skill in ((1, 0.3), (2, 0.9)):
        write_entry(detector(number, skill), tmp_path / f"{number}.json")
    assert dcrb("exam", "table", str(tmp_path), "--output", str(tmp_path / "out")) == 0
    written = {file.name: file.stat().st_size for file in (tmp_path / "out").iterdir()}
    assert set(written) == {"leaderboard.md", "leaderboard.html", "leaderboard-1.png"}
    assert all(size > 500 for size in written.values())
    assert dcrb("exam", "table", str(tmp_path / "gone")) == 2
    assert dcrb("exam", "table", str(tmp_path / "out")) == 2
    assert "has no .json file" in capsys.readouterr().err


def test_figures_of_a_longer_table_are_removed_and_other_files_kept(tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    for name in ("leaderboard-2.png", "leaderboard-10.png", "leaderboard-old.png", "leaderboard-02.png", "leaderboard-3.png.txt"):
        (out / name).write_bytes(b"x")
    (out / "leaderboard-4.png").mkdir()
    for number, skill in ((1, 0.3), (2, 0.9)):
        write_entry(detector(number, skill), tmp_path / f"{number}.json")
    assert dcrb("exam", "table", str(tmp_path), "--output", str(out)) == 0
    kept = {"leaderboard-old.png", "leaderboard-02.png", "leaderboard-3.png.txt", "leaderboard-4.png"}
    assert {file.name for file in out.iterdir()} == {"leaderboard.md", "leaderboard.html", "leaderboard-1.png"} | kept


def test_a_table_that_cannot_be_replaced_stays_as_it_was(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_entry(detector(1, 0.3), tmp_path / "1.json")
    (tmp_path / "out" / "leaderboard.html").mkdir(parents=True)
    for name in ("leaderboard.md", "leaderboard-1.png"):
        (tmp_path / "out" / name).write_text("old")
    assert dcrb("exam", "table", str(tmp_path), "--output", str(tmp_path / "out")) == 2
    assert "leaderboard.html is a folder" in capsys.readouterr().err
    assert {path.read_text() for path in (tmp_path / "out").glob("leaderboard[.-][m1]*")} == {"old"}
    with files_of_at_most(1000):
        (tmp_path / "out" / "leaderboard.html").rmdir()
        assert dcrb("exam", "table", str(tmp_path), "--output", str(tmp_path / "out")) == 2
    assert {path.name: path.read_text() for path in (tmp_path / "out").iterdir()} == {"leaderboard.md": "old", "leaderboard-1.png": "old"}


@pytest.mark.parametrize("size", [1000, 20_000])
def test_a_full_disk_leaves_no_leaderboard(size: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for number, skill in ((1, 0.3), (2, 0.9)):
        write_entry(detector(number, skill), tmp_path / f"{number}.json")
    with files_of_at_most(size):
        assert dcrb("exam", "table", str(tmp_path), "--output", str(tmp_path / "out")) == 2
    assert capsys.readouterr().err.count("File too large") == 1
    assert not (tmp_path / "out").exists()
