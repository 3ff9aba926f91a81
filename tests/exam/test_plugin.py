"""Detectors given as a Python class."""

from __future__ import annotations

import pickle
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import pytest
from made_up_blocks import recorded
from same_process import dcrb

from dcrb_ros import FaultDetector
from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.exam import plugin
from dcrb_ros.exam.leaderboard_entry import read_entry
from dcrb_ros.exam.plugin import load_plugin
from dcrb_ros.exam.plugin_process import ProcessDetector
from dcrb_ros.exam.running_detector import RunningDetector
from dcrb_ros.messages.received_diagnosis import ReceivedDiagnosis
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.schema.refusal import Refusal

SOURCE = """
class Steady:
    def __init__(self, orders, rate):
        assert rate == 51200

    def update(self, index, acceleration, shaft_angle):
        return "roller"
"""


@pytest.mark.parametrize("name", ["steady_detector.py", "with-dash.py"])
def test_a_class_in_a_file_runs_on_a_recording(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(SOURCE, encoding="utf-8")
    detector = pickle.loads(pickle.dumps(ProcessDetector("steady", f"{tmp_path / name}:Steady")))  # as in another process
    assert detector.diagnose(Recording(recorded(tmp_path / "bag", 2))).received == [
        ReceivedDiagnosis(1023 / 51200, "roller"),
        ReceivedDiagnosis(2047 / 51200, "roller"),
    ]


def test_a_file_with_a_dataclass_and_a_name_that_cannot_be_imported_is_loaded(tmp_path: Path) -> None:
    source = "from __future__ import annotations\nfrom dataclasses import dataclass\n@dataclass\nclass Settings:\n    window: float = 1.0\n"
    (tmp_path / "with-dash.py").write_text(source + SOURCE, encoding="utf-8")
    detector: Any = load_plugin(f"{tmp_path / 'with-dash.py'}:Steady")(Orders(0.4, 6.8, 9.2, 3.0), 51200)
    assert detector.update(0, [], []) == "roller"


def test_a_class_in_a_module_and_an_entry_point_are_found(monkeypatch: pytest.MonkeyPatch) -> None:
    assert load_plugin("dcrb_ros:FaultDetector") is FaultDetector
    offered = [EntryPoint("shipped", "dcrb_ros:FaultDetector", plugin.GROUP)]
    monkeypatch.setattr(plugin.importlib.metadata, "entry_points", lambda group: offered if group == plugin.GROUP else [])
    assert load_plugin("shipped") is FaultDetector
    with pytest.raises(Refusal, match=r"shiped is not an installed detector: .*did you mean 'shipped'"):
        load_plugin("shiped")


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ("nothing", "is not an installed detector: give MODULE:CLASS"),
        ("gone.py:Detector", "there is no file gone.py"),
        ("no_such_module:Detector", "cannot be imported: ModuleNotFoundError"),
        ("dcrb_ros:FaultDetectr", "has no class FaultDetectr"),
        ("dcrb_ros.exam.plugin:GROUP", "GROUP in dcrb_ros.exam.plugin is 'dcrb_ros.detectors' and no class: give the name of a detector"),
        ("dcrb_ros:FaultDetector]", r"has no class FaultDetector\]"),
        (":Detector", "names no module: give MODULE:CLASS"),
        ("dcrb_ros.exam.plugin:", "names no class: give MODULE:CLASS"),
    ],
)
def test_what_is_no_detector_is_refused(given: str, sentence: str) -> None:
    with pytest.raises(Refusal, match=sentence):
        load_plugin(given)


def test_an_exception_for_the_bearing_names_the_method() -> None:
    class Careless:
        def update(self, *_: object) -> None: ...

        def take_bearing(self, _: object) -> None:
            raise KeyError("rows")

    with pytest.raises(RuntimeError, match="take_bearing failed: KeyError: 'rows'"):
        RunningDetector(lambda *_: Careless(), Orders(0.4, 6.8, 9.2, 3.0), 51200, lambda: None)


def test_a_class_is_evaluated_on_the_command_line(tmp_path: Path) -> None:
    (tmp_path / "steady.py").write_text(SOURCE, encoding="utf-8")
    given, file = f"{tmp_path / 'steady.py'}:Steady", tmp_path / "entry.json"
    options = ["--python", given, "--name", "steady", "--entry", str(file), "--workers", "1", "--quiet"]
    assert dcrb("score", str(recorded(tmp_path / "bag", 60)), *options) == 1
    entry = read_entry(file)
    assert (entry.detector, entry.exam, entry.passed, entry.exam_score) == ("steady", "recordings", False, {})
    assert [(one.answer, one.spoiled, one.periods) for one in entry.scenarios] == [("roller", 1, 1)]


def test_a_detector_that_failed_in_every_scenario_has_no_entry(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    detector, file = tmp_path / "steady.py", tmp_path / "entry.json"
    options = ["--python", f"{detector}:Steady", "--entry", str(file), "--workers", "1", "--quiet"]
    detector.write_text(SOURCE.replace('return "roller"', "raise ValueError"), encoding="utf-8")
    assert dcrb("score", str(recorded(tmp_path / "bag", 60)), *options) == 1
    assert f"the detector failed in every scenario: {file} is not written" in capsys.readouterr().err
    assert not file.exists()


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--node", "true"], "--python and --node name two detectors"),
        (["--reference"], "--python and --reference name two detectors"),
        (["--entry", "entry.txt"], "must end in one of .json"),
    ],
)
def test_two_detectors_or_a_wrong_file_are_refused(options: list[str], sentence: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert dcrb("score", "smoke", "--python", "dcrb_ros:FaultDetector", *options) == 2
    assert sentence in capsys.readouterr().err
