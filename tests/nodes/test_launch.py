"""The launch files, run against stand-ins for `launch` and `launch_ros`, which are not on PyPI: what they would start."""

from __future__ import annotations

import importlib.util
import sys
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
import yaml

from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.recordings.replay import ReplayParameters
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import flatten, read_parameters, validated

ROOT = Path(__file__).parents[2]


@dataclass
class Node:
    package: str
    executable: str
    namespace: str
    output: str
    parameters: list[Any] = field(default_factory=list)
    arguments: list[str] = field(default_factory=list)


class Argument:
    def __init__(self, name: str, *, default_value: str | None, description: str) -> None:
        assert description
        self.name, self.default = name, default_value


class Value:
    def __init__(self, name: str) -> None:
        self.name = name

    def perform(self, context: dict[str, str]) -> str:
        return context[self.name]


@dataclass
class Environment:
    name: str
    default_value: str


class Typed:
    def __init__(self, value: Value, *, value_type: type) -> None:
        self.value, self.kind = value, value_type


class Anything:
    def __init__(self, *arguments: Any, **named: Any) -> None:
        self.arguments, self.named = arguments, named


def modules() -> dict[str, ModuleType]:
    contents: dict[str, dict[str, Any]] = {
        "launch": {"LaunchContext": Anything, "LaunchDescription": list},
        "launch.actions": {"DeclareLaunchArgument": Argument, "OpaqueFunction": Anything, "SetEnvironmentVariable": Anything},
        "launch.substitutions": {"EnvironmentVariable": Environment, "LaunchConfiguration": Value},
        "launch_ros": {},
        "launch_ros.actions": {"Node": Node},
        "launch_ros.parameter_descriptions": {"ParameterValue": Typed},
        "ament_index_python": {},
        "ament_index_python.packages": {"get_package_share_directory": lambda name: str(ROOT)},
    }
    made = {name: ModuleType(name) for name in contents}
    for name, values in contents.items():
        vars(made[name]).update(values)
    return made


def description(name: str, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Return the module of a launch file, with stand-ins for what it imports."""
    for module, made in modules().items():
        monkeypatch.setitem(sys.modules, module, made)
    monkeypatch.delitem(sys.modules, "dcrb_ros.nodes.launching", raising=False)
    spec = importlib.util.spec_from_file_location("described", ROOT / "launch" / f"{name}.launch.py")
    assert spec is not None
    assert spec.loader is not None
    described = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(described)
    monkeypatch.delitem(sys.modules, "dcrb_ros.nodes.launching", raising=False)
    return described


def started(name: str, monkeypatch: pytest.MonkeyPatch, **given: str) -> list[Node]:
    """Return the nodes that a launch file starts with its defaults and what is given."""
    described = description(name, monkeypatch)
    arguments = {action.name: action.default for action in described.generate_launch_description() if isinstance(action, Argument)}
    assert given.keys() <= arguments.keys()
    assert arguments["discovery"] == Environment("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")  # what the user has set stays
    found: list[Node] = described.nodes({**arguments, **given})
    return found


def configuration(node: Node) -> Any:
    """Return what a node would make of its parameters."""
    model = Configuration if node.executable == "simulator" else DetectorParameters
    flat: dict[str, Any] = {}
    for given in node.parameters:
        flat.update(flatten(given) if isinstance(given, dict) else read_parameters(Path(given), node.executable))
    return validated(flat, model, node.executable)


def test_bench_starts_both_nodes(monkeypatch: pytest.MonkeyPatch) -> None:
    nodes = started("bench", monkeypatch, config="outer_ring_defect", scenario="growing_spall", time_scale="0.5", clock="true")
    assert [(node.executable, node.namespace) for node in nodes] == [("simulator", "dcrb"), ("fault_detector", "dcrb")]
    simulator = configuration(nodes[0])
    assert simulator.faults.outer_1.width == 0.002
    assert (simulator.time_scale, simulator.publishing.clock) == (0.5, True)
    assert nodes[0].arguments == ["--scenario", "growing_spall"]
    assert configuration(nodes[1]) == DetectorParameters()


def test_bench_leaves_to_the_configuration_what_is_not_asked_for(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    mine, judging = tmp_path / "mine.yaml", tmp_path / "judging.yaml"
    own = {"time_scale": 0.5, "recording": {"path": "/tmp/mine"}, "publishing": {"clock": True}}
    mine.write_text(yaml.safe_dump({"/**": {"ros__parameters": own}}))
    judging.write_text(yaml.safe_dump({"/**/fault_detector": {"ros__parameters": {"learn": 10.0}}}))
    simulator, detector = started("bench", monkeypatch, config=str(mine), detector=str(judging))
    found = configuration(simulator)
    assert (found.time_scale, found.recording.path, found.publishing.clock) == (0.5, "/tmp/mine", True)
    assert configuration(detector) == DetectorParameters(learn=10.0)


def test_bench_is_shown_where_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    nodes = started("bench", monkeypatch, rerun="true", namespace="wagon/box1")
    assert (nodes[0].executable, nodes[0].namespace) == ("viewer", "wagon/box1")
    assert len(nodes) == 3


def test_replay_takes_its_parameters_from_the_arguments(monkeypatch: pytest.MonkeyPatch) -> None:
    described = description("replay", monkeypatch)
    actions = described.generate_launch_description()
    defaults = {action.name: action.default for action in actions if isinstance(action, Argument)}
    assert [name for name, default in defaults.items() if default is None] == ["bag"]
    replayer = next(action for action in actions if isinstance(action, Node))
    (detector,) = described.detector_node({"namespace": "dcrb", "detector": "detector"})
    given = {
        name: typed.kind(defaults[typed.value.name] or "/tmp/bag")
        for name, typed in replayer.parameters[0].items()
        if typed.kind is not bool
    }
    assert ReplayParameters.model_validate({**given, "loop": False, "clock": False}) == ReplayParameters(bag="/tmp/bag")
    assert (replayer.executable, detector.executable) == ("replayer", "fault_detector")
    assert (replayer.namespace.name, detector.namespace) == ("namespace", "dcrb")


def test_axle_boxes_differ(monkeypatch: pytest.MonkeyPatch) -> None:
    nodes = started("axle_boxes", monkeypatch, clock="true")
    assert [node.namespace for node in nodes] == [f"wagon/box{box}" for box in (1, 2, 3, 4) for _ in range(2)]
    boxes = [configuration(node) for node in nodes if node.executable == "simulator"]
    assert [box.simulation.seed for box in boxes] == [1, 2, 3, 4]
    assert [box.publishing.clock for box in boxes] == [True, False, False, False]
    assert [set(box.faults.described()) for box in boxes] == [set(), set(), {"outer_1"}, set()]
    assert len({box.publishing.frame for box in boxes}) == 4
