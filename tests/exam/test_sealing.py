"""Sealed exams: bound by a hash, drawn alike from the same secret, and opened only with it."""

from __future__ import annotations

import datetime
import json
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from same_process import dcrb

from dcrb_ros.exam.case import scenarios_hash, simulation_seeds
from dcrb_ros.exam.exam_file import exam_of
from dcrb_ros.exam.expectation import Expectation
from dcrb_ros.exam.leaderboard_entry import Entry, entry_of
from dcrb_ros.exam.report import Report
from dcrb_ros.exam.scoring import score_scenario
from dcrb_ros.exam.sealing import SealedExam, _value, commitment, drawn_exam, new_secret, open_exam, seal
from dcrb_ros.messages.received_diagnosis import ReceivedDiagnosis
from dcrb_ros.runtime.version import __version__
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.json import digest_of

SECRET = "0" * 63 + "1"
TEMPLATE: dict[str, Any] = {
    "exam": "autumn",
    "duration": 9.0,
    "onset": 4.0,
    "scenarios": [
        {
            "name": "outer",
            "verdict": "outer_ring",
            "count": 4,
            "draw": {
                "set": {"operating.speed": {"low": 60.0, "high": 190.0}, "sensor.preset": ["ideal", "mems"]},
                "fault": {
                    "faults.outer_1.width": {"low": 0.0004, "high": 0.003, "scale": "log"},
                    "faults.outer_1.row": {"low": 1, "high": 2},
                },
            },
        },
        {"name": "well", "verdict": "healthy"},
    ],
}


@pytest.mark.parametrize(
    ("entry", "sentence"),
    [
        ({"name": {"a": 1}}, "name = {'a': 1} is not a text"),
        ({"name": None}, "name = None is not a text"),
        ({"set": [1]}, r"set = \[1\] must name parameters"),
        ({"seeds": [1, 2]}, r"seeds = \[1, 2\] would have no effect"),
        ({"set": {"operating.speed": 90.0}}, "operating.speed is in 'set' and in draw.set"),
        ({"fault": {"faults": {"outer_1": {"width": 0.001}}}}, "faults.outer_1.width is in 'fault' and in draw.fault"),
    ],
)
def test_a_drawn_scenario_has_a_name_and_parameters_that_the_draw_leaves(entry: dict[str, Any], sentence: str) -> None:
    template = {**TEMPLATE, "scenarios": [{**TEMPLATE["scenarios"][0], **entry}]}
    with pytest.raises(Refusal, match=sentence):
        drawn_exam(template, SECRET, "t")


@pytest.mark.parametrize("value", [float("nan"), {1: 2, "a": 3}, {"day": datetime.date(2026, 1, 1)}])
def test_a_template_that_json_cannot_represent_is_refused(value: Any) -> None:
    with pytest.raises(Refusal, match="the template cannot be sealed"):
        commitment({**TEMPLATE, "note": value}, SECRET)


def test_the_same_secret_draws_the_same_exam_and_another_secret_another_one() -> None:
    first, again, other = (exam_of(drawn_exam(TEMPLATE, secret, "t"), "t") for secret in (SECRET, SECRET, "f" * 64))
    assert scenarios_hash(first.cases) == scenarios_hash(again.cases) != scenarios_hash(other.cases)
    assert len(simulation_seeds(first.cases)) == 5  # one for each of four draws, and 1
    assert [case.expectation.name for case in first.cases[:5]] == ["outer/1", "outer/2", "outer/3", "outer/4", "well"]


def test_drawn_values_are_those_of_sha_256_on_every_machine() -> None:
    """The first scenario, computed once; another value would break exams that are sealed already."""
    first = drawn_exam(TEMPLATE, SECRET, "t")["scenarios"][0]
    assert (first["seeds"], first["set"], first["fault"]) == FIRST_DRAWN


@given(st.floats(0.0, 1.0, exclude_max=True), st.floats(-1e6, 1e6), st.floats(0.0, 1e6))
def test_drawn_numbers_lie_within_their_range(share: float, low: float, span: float) -> None:
    assert low <= _value({"low": low, "high": low + span}, share, "x") <= low + span
    whole = _value({"low": int(low), "high": int(low + span)}, share, "x")
    assert isinstance(whole, int)
    assert int(low) <= whole <= int(low + span)
    assert 0.001 <= _value({"low": 0.001, "high": 0.001 + span, "scale": "log"}, share, "x") <= 0.001 + span


def test_drawn_numbers_cover_their_range_evenly() -> None:
    found = [_value({"low": 1, "high": 4}, k / 100.0, "x") for k in range(100)]
    assert [found.count(value) for value in (1, 2, 3, 4)] == [25] * 4
    assert _value({"low": 0.01, "high": 1.0, "scale": "log"}, 0.5, "x") == 0.1
    assert {_value({"low": 1, "high": 1000, "scale": "log"}, k / 100.0, "x") for k in (0, 40, 99)} == {1, 16, 933}
    assert [_value(["a", "b"], share, "x") for share in (0.0, 0.49, 0.5, 0.99)] == ["a", "a", "b", "b"]


def test_secrets_are_long_and_never_the_same() -> None:
    found = {new_secret() for _ in range(20)}
    assert len(found) == 20
    assert {len(secret) for secret in found} == {64}


def test_an_exam_opens_with_its_secret_only() -> None:
    sealed = seal(TEMPLATE, SECRET, "t")
    opened, _ = open_exam(sealed, SECRET, "t")
    assert opened.seal == sealed.sealed == commitment(TEMPLATE, SECRET)
    assert scenarios_hash(opened.cases) == sealed.scenarios_sha256
    changed = sealed.model_copy(update={"template": {**TEMPLATE, "onset": 3.0}})
    for exam, secret in ((sealed, "f" * 64), (changed, SECRET)):
        with pytest.raises(Refusal, match="not sealed with this secret, or its template has been changed"):
            open_exam(exam, secret, "t")


def test_the_published_file_does_not_contain_the_secret() -> None:
    assert SECRET not in json.dumps(seal(TEMPLATE, SECRET, "t").model_dump())


def entry(**changes: Any) -> dict[str, Any]:
    return {**TEMPLATE, "scenarios": [{**TEMPLATE["scenarios"][0], **changes}]}


@pytest.mark.parametrize(
    ("template", "sentence"),
    [
        ({**TEMPLATE, "scenarios": TEMPLATE["scenarios"][1:]}, "draws nothing"),
        ([], "draws nothing"),
        ({**TEMPLATE, "scenarios": [*TEMPLATE["scenarios"], None]}, "scenario 3 is empty: give it a name"),
        (entry(count=3), "draws 3 scenarios, so few that their published hash could be found"),
        (entry(count=1), "draws 1 scenario, so few"),
        (entry(count=0), "count = 0 is outside 1"),
        (entry(count=True), "count = True is outside"),
        (entry(count=3000), "count = 3000 is outside"),
        (entry(draw={}), "'draw' must have 'set' or 'fault'"),
        (entry(draw={"timeline": {}}), "'draw' must have 'set' or 'fault'"),
        (entry(draw={"set": 3}), "must name parameters and their ranges"),
        (entry(draw={"set": {"operating.speed": 3.0}}), "is not a range"),
        (entry(draw={"set": {"operating.speed": []}}), "is not a range"),
        (entry(draw={"set": {"operating.speed": {"low": 2.0, "high": 1.0}}}), "range 2.0 .. 1.0 is invalid"),
        (entry(draw={"set": {"operating.speed": {"low": 0.0, "high": 1.0, "scale": "log"}}}), "above 0 with scale: log"),
        (entry(draw={"set": {"operating.speed": {"low": 0.0, "high": 1.0, "scale": "cubic"}}}), "scale = 'cubic' is unknown"),
        ({**TEMPLATE, "scenarios": [*TEMPLATE["scenarios"], {"name": "x", "verdict": "healthy", "count": 2}]}, "has 'count' but no 'draw'"),
        (entry(draw={"set": {"operating.speeed": {"low": 1.0, "high": 2.0}}}), "operating.speeed"),
    ],
)
def test_an_invalid_template_is_refused(template: Any, sentence: str) -> None:
    with pytest.raises(Refusal, match=sentence.replace("(", r"\(")):
        seal(template, SECRET, "t")


def test_a_template_cannot_be_scored_unopened() -> None:
    for tree in (TEMPLATE, seal(TEMPLATE, SECRET, "t").model_dump()):
        with pytest.raises(Refusal, match="dcrb exam open"):
            exam_of(tree, "t")


def test_seal_open_and_verify_on_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    template, sealed, secret = tmp_path / "a.yaml", tmp_path / "a.sealed.yaml", tmp_path / "a.secret"
    template.write_text(yaml.safe_dump(TEMPLATE), encoding="utf-8")
    assert dcrb("exam", "seal", str(template)) == 0
    published = SealedExam.model_validate(yaml.safe_load(sealed.read_text(encoding="utf-8")))
    assert published.sealed in capsys.readouterr().out
    assert secret.stat().st_mode & 0o077 == 0
    assert dcrb("exam", "seal", str(template)) == 2  # neither file is replaced
    assert dcrb("exam", "open", str(sealed), str(secret)) == 0
    opened = exam_of(yaml.safe_load((tmp_path / "a.opened.yaml").read_text(encoding="utf-8")), "a")
    assert (opened.seal, scenarios_hash(opened.cases)) == (published.sealed, published.scenarios_sha256)
    assert dcrb("exam", "verify", str(sealed), str(secret)) == 0
    (tmp_path / "other.secret").write_text("f" * 64, encoding="utf-8")
    assert dcrb("exam", "verify", str(sealed), str(tmp_path / "other.secret")) == 1
    assert "DOES NOT AGREE" in capsys.readouterr().out
    (tmp_path / "none.secret").write_text("secret", encoding="utf-8")
    assert dcrb("exam", "open", str(sealed), str(tmp_path / "none.secret"), "--force") == 2
    assert dcrb("exam", "open", str(template), str(secret)) == 2


def test_entries_of_an_exam_that_is_not_sealed_are_verified(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    exam, opened = Sealed(tmp_path), tmp_path / "open.yaml"
    tree = {**exam.tree, "sealed_sha256": ""}
    exam.verify(tree)  # writes the file
    scenarios = drawn_exam(TEMPLATE, SECRET, "t")
    opened.write_text(yaml.safe_dump(scenarios), encoding="utf-8")
    capsys.readouterr()
    assert dcrb("exam", "verify", str(opened), str(exam.file)) == 0
    assert capsys.readouterr().out == f"{exam.file}: agrees\n"
    opened.write_text(yaml.safe_dump({**scenarios, "onset": 3.5}), encoding="utf-8")
    assert dcrb("exam", "verify", str(opened), str(exam.file)) == 1
    assert "its scenarios are of another exam, 'autumn'" in capsys.readouterr().out
    assert dcrb("exam", "verify", str(opened)) == 2


def test_entries_of_the_leaderboard_follow_from_their_exam(capsys: pytest.CaptureFixture[str]) -> None:
    root = Path(__file__).parents[2]
    entry = root / "docs/leaderboard/autogram.json"
    assert dcrb("exam", "verify", str(root / "examples/detectors/exam.yaml"), str(entry)) == 0
    assert capsys.readouterr().out == f"{entry}: agrees\n"


def test_an_entry_with_other_criteria_does_not_agree(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    exam = Sealed(tmp_path)
    assert exam.tree["criteria_sha256"]
    assert exam.verify({**exam.tree, "criteria_sha256": "f" * 64, "dcrb_ros": "9.9.9"}) == 1
    sentence = f"DOES NOT AGREE, its criteria are not those of the exam in dcrb_ros {__version__}; dcrb_ros 9.9.9 made it: "
    assert sentence in capsys.readouterr().out


class Sealed:
    """A sealed exam on the disk and the entry of a detector that finds each fault half a second after its onset."""

    def __init__(self, folder: Path, secret: str = SECRET) -> None:
        sealed = seal(TEMPLATE, secret, "t")
        self.sealed, self.secret, self.file = folder / "a.sealed.yaml", folder / "a.secret", folder / "entry.json"
        self.sealed.write_text(yaml.safe_dump(sealed.model_dump()), encoding="utf-8")
        self.secret.write_text(secret, encoding="utf-8")
        exam, _ = open_exam(sealed, secret, "t")
        results = tuple(score_scenario(case.expectation, self.diagnoses(case.expectation), exam.criteria) for case in exam.cases)
        report = Report(exam.name, "mine", exam.criteria, scenarios_hash(exam.cases), results, exam.seal, simulation_seeds(exam.cases))
        self.tree: dict[str, Any] = entry_of(report).model_dump()

    @staticmethod
    def diagnoses(expectation: Expectation) -> list[ReceivedDiagnosis]:
        times = [0.5 * k for k in range(1, round(2.0 * expectation.duration) + 1)]
        faulty = [expectation.faulty and time >= expectation.onset + 0.5 for time in times]
        return [
            ReceivedDiagnosis(t, expectation.verdict if fault else "healthy", 2.0 + t if fault else -t)
            for t, fault in zip(times, faulty, strict=True)
        ]

    def verify(self, tree: dict[str, Any]) -> int:
        self.file.write_text(json.dumps(tree | {"sha256": digest_of(tree, "sha256")}), encoding="utf-8")
        return dcrb("exam", "verify", str(self.sealed), str(self.secret), str(self.file))


def test_an_entry_is_computed_again_from_its_diagnoses(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    exam = Sealed(tmp_path)
    assert exam.verify(exam.tree) == 0
    assert "entry.json: agrees" in capsys.readouterr().out
    assert exam.tree["scenarios"][0]["found"]
    assert 0.0 < exam.tree["scenarios"][0]["credit"]["research"] <= 1.0


def test_entries_beside_an_unreadable_one_are_verified(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    exam = Sealed(tmp_path)
    assert exam.verify(exam.tree) == 0
    changed, half, good = tmp_path / "changed.json", tmp_path / "half.json", exam.file
    changed.write_text(good.read_text(encoding="utf-8").replace('"mine"', '"theirs"'), encoding="utf-8")
    half.write_text(good.read_text(encoding="utf-8")[:500], encoding="utf-8")
    capsys.readouterr()
    assert dcrb("exam", "verify", *map(str, (exam.sealed, exam.secret, changed, half, good))) == 1
    printed = capsys.readouterr()
    assert f"{good}: agrees" in printed.out
    first, second = printed.err.splitlines()
    assert first.endswith("changed.json was changed: its digest does not match; make it again with dcrb score --entry")
    assert "half.json is not valid JSON: " in second
    assert second.endswith("; give an entry of dcrb score --entry")


@pytest.mark.parametrize(
    ("version", "reason"),
    [
        (__version__, "scenarios_sha256 has been changed, or this dcrb_ros has other defaults: give the file as it was published"),
        ("9.9.9", f"the scenarios of dcrb_ros {__version__} are not those of dcrb_ros 9.9.9, which sealed it: verify it with that version"),
    ],
)
def test_the_reason_of_other_scenarios_names_two_versions_only_if_they_differ(
    version: str, reason: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    exam = Sealed(tmp_path)
    published = yaml.safe_load(exam.sealed.read_text(encoding="utf-8"))
    exam.sealed.write_text(yaml.safe_dump({**published, "scenarios_sha256": "0" * 64, "dcrb_ros": version}), encoding="utf-8")
    assert dcrb("exam", "verify", str(exam.sealed), str(exam.secret)) == 1
    assert f"scenarios: DO NOT AGREE, {reason}\n" in capsys.readouterr().out


def test_a_missing_value_is_named_in_words(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    exam = Sealed(tmp_path)
    assert exam.verify({**exam.tree, "sealed_sha256": ""}) == 1
    printed = capsys.readouterr().out
    assert f"sealed_sha256 is stated as nothing, but {exam.tree['sealed_sha256']} follows: make it again with dcrb score --entry" in printed


def test_an_entry_of_another_exam_is_named_as_such(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "other").mkdir()
    exam, other = Sealed(tmp_path), Sealed(tmp_path / "other", "f" * 64)
    assert exam.verify({**other.tree, "exam": "spring"}) == 1
    assert (
        f"{exam.file}: DOES NOT AGREE, its scenarios are of another exam, 'spring': give entries of this one\n" in capsys.readouterr().out
    )
    assert exam.verify({**other.tree, "sealed_sha256": ""}) == 1
    assert "its scenarios are of another exam, 'autumn'" in capsys.readouterr().out


def test_an_entry_of_another_exam_with_copied_hashes_does_not_agree(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "other").mkdir()
    exam, other = Sealed(tmp_path), Sealed(tmp_path / "other", "f" * 64)
    hashes = {key: exam.tree[key] for key in ("sealed_sha256", "scenarios_sha256")}
    assert exam.verify({**other.tree, **hashes}) == 1
    assert "DOES NOT AGREE, seeds is stated as" in capsys.readouterr().out
    assert exam.verify({**other.tree, **hashes, "seeds": exam.tree["seeds"]}) == 1
    renamed = {**exam.tree, "scenarios": [{**scenario, "name": f"x{k}"} for k, scenario in enumerate(exam.tree["scenarios"])]}
    assert exam.verify(renamed) == 1
    assert "it lacks the scenario 'outer/1' of the exam" in capsys.readouterr().out
    assert exam.verify({**exam.tree, "scenarios": [*exam.tree["scenarios"], {**exam.tree["scenarios"][-1], "name": "more"}]}) != 0


@pytest.mark.parametrize("key", ["exam", "scenarios_sha256", "sealed_sha256", "seeds", "passed", "false_alarms", "healthy_hours"])
def test_whatever_follows_from_an_exam_and_is_changed_does_not_agree(key: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    exam = Sealed(tmp_path)
    stated = exam.tree[key]
    value = not stated if isinstance(stated, bool) else [7] if isinstance(stated, list) else f"{stated}f" if isinstance(stated, str) else 5
    assert exam.verify({**exam.tree, key: value}) == 1
    assert f"DOES NOT AGREE, {key} is stated as {value}" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"delay_turns": 0.0}, "delay_turns is stated as 0.0"),
        ({"stratum": "easy"}, "stratum is stated as easy"),
        ({"required": False}, "required is stated as False"),
        ({"silent": 0.25}, "silent is stated as 0.25"),
        ({"periods": 7}, "periods is stated as 7"),
        ({"failure": "it ended"}, "passed is stated as"),
    ],
)
def test_a_changed_scenario_does_not_agree(
    changes: dict[str, Any], sentence: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    exam = Sealed(tmp_path)
    first, *others = exam.tree["scenarios"]
    tree = {**exam.tree, "scenarios": [{**first, **changes}, *others]}
    entry = Entry.model_validate(tree)
    tree["exam_score"] = {score.profile: score.score.value for score in entry.scores()}
    assert exam.verify(tree) == 1
    assert sentence in capsys.readouterr().out


def test_more_credit_than_the_diagnoses_give_does_not_agree(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    exam = Sealed(tmp_path)
    first, *others = exam.tree["scenarios"]
    late = {"verdicts": ["healthy", "outer_ring"], "counts": [14, 4]}
    tree = {**exam.tree, "scenarios": [{**first, "diagnoses": {**first["diagnoses"], **late}}, *others]}
    assert exam.verify(tree) == 1
    assert "DOES NOT AGREE, exam_score is stated as" in capsys.readouterr().out


FIRST_DRAWN = (
    [1908443077],
    {"operating.speed": 128.553, "sensor.preset": "ideal"},
    {"faults.outer_1.width": 0.00294327, "faults.outer_1.row": 1},
)
