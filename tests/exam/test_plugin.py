"""Detectors given as a Python class."""

from __future__ import annotations

from importlib.metadata import EntryPoint
from pathlib import Path

import pytest
from made_up_blocks import recorded

from dcrb_ros import FaultDetector
from dcrb_ros.exam import plugin
from dcrb_ros.exam.plugin import load_plugin, run_plugin
from dcrb_ros.messages.received_diagnosis import ReceivedDiagnosis
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
    found = run_plugin(recorded(tmp_path / "bag", 2), f"{tmp_path / name}:Steady")
    assert found == [ReceivedDiagnosis(1023 / 51200, "roller"), ReceivedDiagnosis(2047 / 51200, "roller")]


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
        ("dcrb_ros.exam.plugin:GROUP", "has no class GROUP"),
        (":Detector", "cannot be imported"),
    ],
)
def test_what_is_no_detector_is_refused(given: str, sentence: str) -> None:
    with pytest.raises(Refusal, match=sentence):
        load_plugin(given)
