"""The quality of service of publishers and subscriptions, given by parameters."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import yaml

pytest.importorskip("rclpy", reason="the nodes need ROS 2; everything else is tested without")

import rclpy
from made_up_blocks import recorded
from rclpy.parameter import Parameter
from rclpy.qos import ReliabilityPolicy

from dcrb_ros.messages.plain import encode_text
from dcrb_ros.messages.topics import ENVELOPE_SPECTRUM, VIBRATION
from dcrb_ros.nodes.fault_detector import FaultDetectorNode
from dcrb_ros.nodes.replayer import ReplayerNode
from dcrb_ros.nodes.vehicle_detector import VehicleDetectorNode
from dcrb_ros.recordings.replay import ReplayParameters
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.vehicle.description import described
from dcrb_ros.vehicle.file import read_vehicle

Start = Callable[..., None]
VIBRATION_KEY = "qos_overrides./dcrb/outer_ring/vibration"


@pytest.fixture
def start(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Start]:
    """Return a function that starts ROS with parameters for all nodes."""
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")

    def begin(**given: object) -> None:
        file = tmp_path / "parameters.yaml"
        file.write_text(yaml.safe_dump({"/**": {"ros__parameters": given}}), encoding="utf-8")
        rclpy.init(args=["--ros-args", "--params-file", str(file)])

    yield begin
    rclpy.try_shutdown()


def test_parameters_set_depth_and_reliability_of_both_ends(start: Start, tmp_path: Path) -> None:
    given = {f"{VIBRATION_KEY}.publisher.depth": 7, "qos_overrides./dcrb/outer_ring/vibration.subscription.reliability": "best_effort"}
    start(**given)
    replayer, detector = ReplayerNode(ReplayParameters(bag=str(recorded(tmp_path / "bag", 3)))), FaultDetectorNode()
    assert replayer._publisher._publishers[VIBRATION].qos_profile.depth == 7
    (subscription,) = [one for one in detector.subscriptions if one.topic_name == VIBRATION.resolved("/dcrb")]
    assert (subscription.qos_profile.reliability, subscription.qos_profile.depth) == (ReliabilityPolicy.BEST_EFFORT, VIBRATION.depth)
    present = replayer.get_parameter(f"{VIBRATION_KEY}.publisher.depth")
    assert present.value == 7
    assert replayer.set_parameters_atomically([present]).successful  # as `ros2 param load` does
    assert not replayer.set_parameters_atomically([Parameter(present.name, value=8)]).successful
    for node in (replayer, detector):
        node.destroy_node()


def test_topics_of_axle_boxes_can_be_overridden(start: Start) -> None:
    box = "qos_overrides./dcrb/axle_1/left"
    start(**{f"{box}/outer_ring/sensor.subscription.reliability": "best_effort", f"{box}/envelope_spectrum.publisher.depth": 7})
    detector = VehicleDetectorNode()
    detector._describe(encode_text(described(read_vehicle("bogie")).to_json()))
    subscribed = {subscription.topic_name: subscription.qos_profile for subscription in detector.subscriptions}
    assert subscribed["/dcrb/axle_1/left/outer_ring/sensor"].reliability == ReliabilityPolicy.BEST_EFFORT
    assert detector._spectra._publishers[ENVELOPE_SPECTRUM.below("axle_1/left")].qos_profile.depth == 7
    detector.destroy_node()


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("/dcrb/outer_ring/vibrations.publisher.depth", 7, f"did you mean '{VIBRATION_KEY}.publisher.depth'"),
        ("/dcrb/outer_ring/vibration.publisher.history", "keep_all", "unknown parameter"),
        ("/dcrb/outer_ring/vibration.publisher.depth", 0, "= 0 is not a whole number within 1 .. 100000"),
        ("/dcrb/outer_ring/vibration.publisher.depth", 7.0, "= 7.0 is not a whole number"),
        ("/dcrb/outer_ring/vibration.publisher.depth", "deep", "= 'deep' is not a whole number"),
        ("/dcrb/outer_ring/vibration.publisher.reliability", "best_efort", "did you mean 'best_effort'"),
        ("/dcrb/outer_ring/vibration.publisher.reliability", 1, "= 1 is not one of reliable, best_effort"),
    ],
)
def test_an_override_that_no_node_reads_or_that_is_invalid_is_refused(key: str, value: object, words: str, start: Start) -> None:
    start(**{f"qos_overrides.{key}": value})
    with pytest.raises(Refusal, match=re.escape(words)):
        FaultDetectorNode()


def test_overrides_in_a_configuration_are_left_to_ros(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    nested = {"operating": {"speed": 100.0}, "qos_overrides": {"/dcrb/diagnosis": {"publisher": {"depth": 7}}}}
    file.write_text(yaml.safe_dump({"/**": {"ros__parameters": nested}}), encoding="utf-8")
    assert load_configuration(file).operating.speed == 100.0
