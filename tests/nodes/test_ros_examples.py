"""The examples for other ROS tools name what the nodes publish and offer."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
import yaml

pytest.importorskip("rclpy", reason="the nodes need ROS 2; everything else is tested without")

import mqtt_bridge
from made_up_blocks import blocks

from dcrb_ros.messages.joints import encode_features
from dcrb_ros.messages.topics import (
    AMBIENT_TEMPERATURE,
    BENCH,
    COMMANDS,
    DETECTED,
    DIAGNOSIS,
    FEATURES,
    NAMESPACE,
    OUTER_RING_TEMPERATURE,
    SENSOR,
    SIMULATED,
    VIBRATION,
)
from dcrb_ros.messages.topics.diagnosis import encode_diagnosis
from dcrb_ros.nodes.bench_status import SERVICES
from dcrb_ros.stream.diagnosis import Diagnosis

EXAMPLES = Path(__file__).parents[2] / "examples"
ANALYZERS = yaml.safe_load((EXAMPLES / "ros" / "diagnostic_aggregator.yaml").read_text(encoding="utf-8"))["analyzers"]["ros__parameters"]
POLICY = ElementTree.parse(EXAMPLES / "ros" / "sros2_policy.xml").getroot()


def analyzers(group: Any, path: str) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the generic analyzers of a group by their paths."""
    for entry in group.values():
        if isinstance(entry, dict) and entry["type"] == "diagnostic_aggregator/AnalyzerGroup":
            yield from analyzers(entry["analyzers"], f"{path}/{entry['path']}")
        elif isinstance(entry, dict):
            yield f"{path}/{entry['path']}", entry


def places(name: str) -> set[str]:
    """Return where the aggregator puts a status, as its GenericAnalyzer matches names."""

    def matches(entry: dict[str, Any]) -> bool:
        starts = any(name.startswith(part) for part in entry.get("startswith", []))
        return starts or any(part in name for part in entry.get("contains", [])) or name in entry.get("name", [])

    return {path for path, entry in analyzers(ANALYZERS, ANALYZERS["path"]) if matches(entry)}


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        (f"{NAMESPACE}/simulator", {"Bearings/Simulators", "Bearings/Places/Bench"}),
        (f"{NAMESPACE}/vehicle_simulator", {"Bearings/Simulators", "Bearings/Places/Bench"}),
        (f"{NAMESPACE}/replayer", {"Bearings/Replayers", "Bearings/Places/Bench"}),
        ("/wagon/box3/simulator", {"Bearings/Simulators", "Bearings/Places/Wagon"}),
        ("/other/motor", set()),
    ],
)
def test_every_status_of_the_nodes_has_its_analyzers(name: str, expected: set[str]) -> None:
    assert places(name) == expected


def allowed(node: str, kind: str, permission: str) -> set[str]:
    """Return what the policy allows a node, as absolute names."""
    (profile,) = (found for found in POLICY.iter("profile") if found.get("node") == node)
    names = [entry.text or "" for group in profile.findall(f"{kind}s") if group.get(permission) == "ALLOW" for entry in group]
    return {
        name if name.startswith("/") else name.replace("~", f"{NAMESPACE}/{node}", 1) if name[0] == "~" else f"{NAMESPACE}/{name}"
        for name in names
    }


def test_the_policy_allows_the_nodes_their_topics_and_services() -> None:
    simulated, detected = ({topic.resolved(NAMESPACE) for topic in topics} for topics in (SIMULATED, DETECTED))
    commands, rosout = {topic.resolved(NAMESPACE) for topic in COMMANDS}, {"/rosout", "/parameter_events"}
    received = {topic.resolved(NAMESPACE) for topic in (SENSOR, VIBRATION, OUTER_RING_TEMPERATURE, AMBIENT_TEMPERATURE)}
    recorded = {topic.resolved(NAMESPACE) for topic in DETECTED if topic.recorded}
    time = {"/clock", "/parameter_events"}
    assert allowed("simulator", "topic", "publish") == simulated | {topic.name for topic in BENCH} | rosout
    assert allowed("simulator", "topic", "subscribe") == commands | recorded | time
    assert allowed("simulator", "service", "reply") >= {f"{NAMESPACE}/{name}" for name in SERVICES}
    assert allowed("simulator", "action", "execute") == allowed("operator", "action", "call") == {f"{NAMESPACE}/simulate_steps"}
    assert allowed("fault_detector", "topic", "publish") == detected | rosout | {f"{NAMESPACE}/fault_detector/transition_event"}
    assert allowed("fault_detector", "topic", "subscribe") == received | time
    assert allowed("operator", "topic", "publish") == commands | rosout
    assert allowed("operator", "service", "request") >= allowed("simulator", "service", "reply") | allowed(
        "fault_detector", "service", "reply"
    )


def test_the_mqtt_example_encodes_diagnoses_and_features_as_json() -> None:
    from rclpy.serialization import deserialize_message

    data = encode_diagnosis(Diagnosis(51200, 1.0, "outer_ring", "BPFO 20 dB over its limit", confidence=0.9))
    found = json.loads(mqtt_bridge.diagnosis_json(deserialize_message(data, mqtt_bridge.DiagnosticArray)))
    assert (found["time"], found["verdict"], found["confidence"]) == (1.0, "outer_ring", 0.9)
    block = next(blocks(1))
    features = json.loads(mqtt_bridge.features_json(deserialize_message(encode_features(block), mqtt_bridge.JointState)))
    assert {"time", "rms", "peak", "crest", "kurtosis", "clipped"} == features.keys()
    assert features["rms"] == pytest.approx(10.0, rel=0.1)
    assert (DIAGNOSIS.name, FEATURES.name) == ("diagnosis", "outer_ring/features")


def test_the_mqtt_example_takes_messages_of_other_publishers() -> None:
    assert mqtt_bridge.diagnosis_json(mqtt_bridge.DiagnosticArray()) is None

    def refuse(constant: str) -> None:
        raise AssertionError(f"{constant} is no JSON")

    features = mqtt_bridge.features_json(mqtt_bridge.JointState(name=["rms", "peak", "crest"], position=[1.5, float("nan")]))
    assert json.loads(features, parse_constant=refuse) == {"time": 0.0, "rms": 1.5, "peak": "nan"}
