"""A detector written in Python against the exam."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

from dcrb_ros import FaultDetector, Refusal, score

EXAM = {
    "exam": "tiny",
    "base": "dry",
    "duration": 5.0,
    "onset": 2.0,
    "criteria": {"delay": {"outer_ring": 3.0}},
    "scenarios": [{"name": "outer", "verdict": "outer_ring", "fault": {"faults.outer_1.width": 0.002}}],
}


class Always:
    """Give one verdict for every block."""

    verdict: Any = "healthy"

    def __init__(self, orders: Any, sampling_rate: int) -> None:
        assert (round(orders.bpfo, 2), sampling_rate) == (6.72, 51200)

    def update(self, index: int, acceleration: Any, shaft_angle: Any) -> Any:
        assert acceleration.shape == (len(shaft_angle), 2)
        return self.verdict


@pytest.fixture(scope="module")
def exam(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Return the file of an exam and the folder of its recordings."""
    folder = tmp_path_factory.mktemp("exam")
    (folder / "tiny.yaml").write_text(yaml.safe_dump(EXAM), encoding="utf-8")
    return folder / "tiny.yaml", folder


def test_the_shipped_detector_passes(exam: tuple[Path, Path]) -> None:
    report = score(FaultDetector, exam[0], recordings=exam[1])
    assert report.passed
    frame = report.to_pandas()
    assert frame.loc["outer", "answer"] == "outer_ring"
    assert 0.0 < frame.loc["outer", "delay"] < 3.0
    assert bool(frame.loc["twin", "passed"])
    assert repr(report) == "<Report: FaultDetector passed tiny, 2 scenarios>"


@pytest.mark.parametrize(("verdict", "answers"), [("healthy", ["healthy", "healthy"]), ("outer_ring", ["outer_ring", "outer_ring"])])
def test_a_verdict_as_text_counts(verdict: str, answers: list[str], exam: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Always, "verdict", verdict)
    report = score(Always, exam[0], recordings=exam[1])
    assert not report.passed
    assert report.to_pandas()["answer"].tolist() == answers


def test_refusals(exam: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Always, "verdict", "outer_rng")
    with pytest.raises(Refusal, match=r"update returned 'outer_rng', which is not a verdict.*did you mean 'outer_ring'"):
        score(Always, exam[0], recordings=exam[1])
    with pytest.raises(Refusal, match="there is no exam 'smok'"):
        score(Always, "smok")
    with pytest.raises(Refusal, match=r"workers = 0 is outside 1 .. 256"):
        score(Always, "smoke", workers=0)


class Failing(Always):
    """Fail at the second second."""

    def update(self, index: int, acceleration: Any, shaft_angle: Any) -> Any:
        if index >= 51200:
            raise ZeroDivisionError("division by zero")


def test_an_exception_of_a_detector_names_scenario_and_sample(exam: tuple[Path, Path]) -> None:
    sentence = r"scenario 'outer.*' could not be evaluated: update failed at sample 51200: ZeroDivisionError: division by zero"
    with pytest.raises(RuntimeError, match=sentence):
        score(Failing, exam[0], recordings=exam[1])


@pytest.mark.parametrize(
    ("detector", "sentence"),
    [("x", "detector = 'x' cannot be called: give a class"), (lambda orders, rate: 5, r"the detector 5 has no method update\(")],
)
def test_what_is_no_detector_is_refused(detector: Any, sentence: str, exam: tuple[Path, Path]) -> None:
    with pytest.raises(Refusal, match=sentence):
        score(detector, exam[0], recordings=exam[1])
