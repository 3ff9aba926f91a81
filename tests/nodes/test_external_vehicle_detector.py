"""The exam of detectors of a vehicle that run as processes."""

from __future__ import annotations

import json
import shlex
import sys
from typing import Any

import pytest
import yaml

pytest.importorskip("rclpy", reason="the nodes need ROS 2; everything else is tested without")

from ros_bench import PATIENCE
from same_process import dcrb

from dcrb_ros.messages.statuses import Status, encode_diagnostics
from dcrb_ros.messages.vehicle import encode_vehicle_diagnosis
from dcrb_ros.nodes import detector_answers, external_detector
from dcrb_ros.nodes.external_vehicle_detector import VehicleAnswers
from dcrb_ros.stream.vehicle_diagnosis import Status as PartStatus
from dcrb_ros.stream.vehicle_diagnosis import VehicleDiagnosis
from dcrb_ros.vehicle.description import described
from dcrb_ros.vehicle.file import read_vehicle

pytestmark = [pytest.mark.node, pytest.mark.slow]

EXAM = {
    "exam": "one_vehicle",
    "vehicle": "healthy_bogie",
    "duration": 2.6,
    "set": {"vehicle.bench": "dry", "axle_2.right.faults.outer_1.width": 0.003},
    "scenarios": [{"name": "outer", "damaged": {"axle_2.right": "outer_ring"}}],
}


@pytest.fixture(scope="module")
def exam(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    folder = tmp_path_factory.mktemp("exam")
    (folder / "one.yaml").write_text(yaml.safe_dump(EXAM), encoding="utf-8")
    return ["score", str(folder / "one.yaml"), "--recordings", str(folder / "kept"), "--json"]


@pytest.fixture
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Wait long for diagnoses, as on a machine that is not busy: a late one would count as issued late, or be missed."""
    monkeypatch.setattr(detector_answers, "PROMPT", PATIENCE)
    monkeypatch.setattr(external_detector, "DIAGNOSIS_TIMEOUT", PATIENCE)


def python(*words: str) -> str:
    return shlex.join([sys.executable, *words])


@pytest.mark.usefixtures("patient")
def test_the_shipped_node_and_the_detector_in_this_process_give_the_same_diagnoses(
    exam: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    found: list[Any] = []
    for options in ([], ["--node", python("-m", "dcrb_ros.nodes.vehicle_detector")]):
        dcrb(*exam, *options)
        scenarios = json.loads(capsys.readouterr().out)["scenarios"]
        found.append(scenarios)
    assert len(found[0]) == 4
    for here, there in zip(*found, strict=True):
        assert [here[key] for key in ("name", "answer", "opinions")] == [there[key] for key in ("name", "answer", "opinions")]
        assert here["score"] == pytest.approx(there["score"], abs=0.005)  # a message has two digits [dB]
        assert here["delay"] == pytest.approx(there["delay"], abs=1e-6)


HALF = """
import rclpy
from sensor_msgs.msg import PointCloud2
rclpy.init()
node = rclpy.create_node("candidate", namespace="dcrb")
node.create_subscription(PointCloud2, "axle_1/left/outer_ring/vibration", lambda message: None, 200)
rclpy.spin(node)
"""


def test_a_detector_that_subscribes_to_one_box_is_told_what_is_missing(exam: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert dcrb(*exam, "--node", python("-c", HALF), "--patience", "20") == 1
    assert "it did not subscribe to /dcrb/axle_1/right/outer_ring/vibration within 20 s" in capsys.readouterr().err


def answers() -> VehicleAnswers:
    taken = VehicleAnswers(description=described(read_vehicle("healthy_bogie")))
    taken.signal_sent(3.0)
    return taken


def test_verdicts_and_scores_are_those_of_the_message() -> None:
    taken = answers()
    statuses = {
        "axle_1/left/bearing": PartStatus("outer_ring", "", 0.99, 12.5),
        "axle_1/right/bearing": PartStatus("healthy", "", 0.9, -3.0),
    }
    taken.receive(encode_vehicle_diagnosis(VehicleDiagnosis(102400, 2.0, statuses, {})))
    assert [(diagnosis.time, diagnosis.verdict, diagnosis.score) for diagnosis in taken.received["axle_1/left"]] == [
        (2.0, "outer_ring", 12.5)
    ]
    assert taken.received["axle_1/right"][0].score == -3.0
    assert taken.received["axle_2/left"][0].verdict == "waiting"
    assert not taken.refused


@pytest.mark.parametrize(
    ("time", "status", "sentence"),
    [
        (2.0, Status("axle_1/left/bearing", 0, "", {"verdict": "broken"}), "'broken' for axle_1/left/bearing"),
        (2.0, Status("axle_1/left/bearing", 0, "", {"verdict": "healthy", "score": "nan"}), "it must be a finite number"),
        (2.0, Status("axle_1/left/bolt", 0, "", {"verdict": "healthy"}), "its last part must be one of"),
        (2.0, Status("axle_1.left/bearing", 0, "", {"verdict": "healthy"}), "no box 'axle_1.left'"),
        (9.0, Status("axle_1/left/bearing", 0, "", {"verdict": "healthy"}), "when the signal had been sent up to 3.00 s"),
    ],
)
def test_an_invalid_message_is_refused(time: float, status: Status, sentence: str) -> None:
    taken = answers()
    taken.receive(encode_diagnostics(round(time * 1e9), [status]))
    assert not taken.received
    assert sentence in taken.refused[0]
