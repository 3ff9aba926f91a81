"""Sealed exams: bound by a hash, drawn alike from the same secret, and opened only with it."""

from __future__ import annotations

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
from dcrb_ros.exam.sealing import SealedExam, _value, commitment, drawn_exam, new_secret, open_exam, seal
from dcrb_ros.schema.refusal import Refusal

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
    assert [_value(["a", "b"], share, "x") for share in (0.0, 0.49, 0.5, 0.99)] == ["a", "a", "b", "b"]


def test_secrets_are_long_and_never_the_same() -> None:
    found = {new_secret() for _ in range(20)}
    assert len(found) == 20
    assert {len(secret) for secret in found} == {64}


def test_an_exam_opens_with_its_secret_only() -> None:
    sealed = seal(TEMPLATE, SECRET, "t")
    opened = open_exam(sealed, SECRET, "t")
    assert opened.exam.seal == sealed.sealed == commitment(TEMPLATE, SECRET)
    assert scenarios_hash(opened.exam.cases) == sealed.scenarios_sha256
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


FIRST_DRAWN = (
    [1908443077],
    {"operating.speed": 128.553, "sensor.preset": "ideal"},
    {"faults.outer_1.width": 0.00294327, "faults.outer_1.row": 1},
)
