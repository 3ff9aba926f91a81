"""The nodes that the launch files start, with substitutes for `launch` and `launch_ros`, which are not on PyPI."""

from __future__ import annotations

import importlib.util
import sys
from contextlib import nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest
import yaml

from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.messages.topics import TRANSFORMS
from dcrb_ros.messages.topics.transforms import encode_transforms
from dcrb_ros.nodes.vehicle_detector_input import VehicleDetectorSettings
from dcrb_ros.recordings.replay import ReplayParameters
from dcrb_ros.recordings.vehicle_recorder import VehicleRecorder
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import validated
from dcrb_ros.vehicle.file import read_parameters, read_vehicle, vehicle_of
from dcrb_ros.vehicle.simulation import VehicleSimulation

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]


@dataclass
class Node:
    package: str
    executable: str
    namespace: str
    output: str
    sigterm_timeout: str
    parameters: list[Any] = field(default_factory=list)
    arguments: list[str] = field(default_factory=list)
    on_exit: Any = None


class Argument:
    def __init__(self, name: str, *, default_value: str | None, description: str) -> None:
        assert description
        self.name, self.default = name, default_value


class Value:
    def __init__(self, name: str) -> None:
        self.name = name

    def perform(self, context: Any) -> str:
        return str(context.launch_configurations[self.name])


@dataclass
class Environment:
    name: str
    default_value: str


@dataclass
class Typed:
    value: str
    value_type: type


class Anything:
    def __init__(self, *arguments: Any, **named: Any) -> None:
        self.arguments, self.named = arguments, named


class Message(Anything):
    pass


class End(Anything):
    pass


def modules() -> dict[str, ModuleType]:
    contents: dict[str, dict[str, Any]] = {
        "launch": {"LaunchContext": Anything, "LaunchDescription": list},
        "launch.actions": {
            "DeclareLaunchArgument": Argument,
            "LogInfo": Message,
            "OpaqueFunction": Anything,
            "SetEnvironmentVariable": Anything,
            "Shutdown": End,
        },
        "launch.substitutions": {"EnvironmentVariable": Environment, "LaunchConfiguration": Value},
        "launch_ros": {},
        "launch_ros.actions": {"Node": Node},
        "launch_ros.parameter_descriptions": {"ParameterValue": Typed},
    }
    made = {name: ModuleType(name) for name in contents}
    for name, values in contents.items():
        vars(made[name]).update(values)
    return made


def description(name: str, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Return the module of a launch file, with substitutes for what it imports."""
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


def entities(name: str, monkeypatch: pytest.MonkeyPatch, **given: str) -> list[Any]:
    """Return what a launch file starts with the given arguments and its defaults."""
    actions = description(name, monkeypatch).generate_launch_description()
    arguments = {action.name: action.default for action in actions if isinstance(action, Argument)}
    assert arguments["discovery"] == Environment("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")  # what the user has set stays
    arguments["discovery"] = "LOCALHOST"
    start = next(action.named["function"] for action in actions if isinstance(action, Anything) and "function" in action.named)
    found: list[Any] = start(SimpleNamespace(launch_configurations={**arguments, **given}))
    return found


def started(name: str, monkeypatch: pytest.MonkeyPatch, **given: str) -> list[Node]:
    """Return the nodes that a launch file starts with the given arguments and its defaults."""
    return [entity for entity in entities(name, monkeypatch, **given) if isinstance(entity, Node)]


def given_to(node: Node) -> dict[str, Any]:
    """Return the parameters of a node with dotted keys."""
    return {key: value.value if isinstance(value, Typed) else value for given in node.parameters for key, value in given.items()}


def configuration(node: Node) -> Any:
    """Return the parameters as the node would read them."""
    model = {"simulator": Configuration, "replayer": ReplayParameters, "fault_detector": DetectorParameters}[node.executable]
    return validated(given_to(node), model, node.executable)


def test_bench_starts_both_nodes(monkeypatch: pytest.MonkeyPatch) -> None:
    nodes = started("bench", monkeypatch, config="outer_ring_defect", scenario="growing_spall", time_scale="0.5", clock="true")
    assert [(node.executable, node.namespace) for node in nodes] == [("simulator", "dcrb"), ("fault_detector", "dcrb")]
    simulator = configuration(nodes[0])
    assert simulator.faults.outer_1.width == 0.002
    assert (simulator.time_scale, simulator.publishing.clock) == (0.5, True)
    assert nodes[0].arguments == ["--scenario", "growing_spall"]
    assert configuration(nodes[1]) == DetectorParameters()


def test_arguments_left_empty_do_not_override_the_configuration(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    mine, judging = tmp_path / "mine.yaml", tmp_path / "judging.yaml"
    own = {"time_scale": 0.5, "recording": {"path": "/tmp/mine"}, "publishing": {"clock": True}}
    mine.write_text(yaml.safe_dump({"/**": {"ros__parameters": own}}))
    judging.write_text(yaml.safe_dump({"/**/fault_detector": {"ros__parameters": {"learn": 10.0}}}))
    simulator, detector = started("bench", monkeypatch, config=str(mine), detector=str(judging))
    found = configuration(simulator)
    assert (found.time_scale, found.recording.path, found.publishing.clock) == (0.5, "/tmp/mine", True)
    assert configuration(detector) == DetectorParameters(learn=10.0)


@pytest.mark.parametrize("form", ["plain", "/dcrb/simulator", "simulator", "/**"])
def test_a_valid_configuration_reaches_the_node_in_any_form_and_namespace(
    form: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    # ROS itself reads no plain groups, and a section of another namespace not at all.
    mine, own = tmp_path / "mine.yaml", {"operating": {"speed": 100.0}, "faults": {"outer_1": {"width": 0.002}}, "bearing": {}}
    mine.write_text(yaml.safe_dump(own if form == "plain" else {form: {"ros__parameters": own}}))
    for file in ("bench", "axle_boxes"):
        simulator = next(node for node in started(file, monkeypatch, config=str(mine)) if node.executable == "simulator")
        found = configuration(simulator)
        assert (found.operating.speed, found.faults.outer_1.width) == (100.0, 0.002)


def test_a_detector_file_reaches_the_node_in_any_namespace(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    mine = tmp_path / "mine.yaml"
    mine.write_text(yaml.safe_dump({"/dcrb/fault_detector": {"ros__parameters": {"learn": 10.0}}}))
    detectors = [node for node in started("axle_boxes", monkeypatch, detector=str(mine)) if node.executable == "fault_detector"]
    assert [configuration(node) for node in detectors] == [DetectorParameters(learn=10.0)] * 4


@pytest.mark.parametrize("file", ["bench", "vehicle"])
def test_parameters_of_the_detector_that_do_not_fit_each_other_are_refused(
    file: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    mine = tmp_path / "mine.yaml"
    mine.write_text(yaml.safe_dump({"/**/fault_detector": {"ros__parameters": {"window": 1.0, "hop": 2.0}}}))
    with pytest.raises(Refusal, match=r"^detector:=.*mine.yaml: window = 1 s is below hop = 2 s"):
        started(file, monkeypatch, detector=str(mine))


def test_parameters_of_every_node_are_kept(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    mine = tmp_path / "mine.yaml"
    mine.write_text(yaml.safe_dump({"/**": {"ros__parameters": {"use_sim_time": True, "operating": {"speed": 100.0}}}}))
    simulator, _ = started("bench", monkeypatch, config=str(mine))
    assert given_to(simulator)["use_sim_time"] is True


OF_ROS = {"use_sim_time": True, "qos_overrides": {"/dcrb/vehicle/diagnosis": {"publisher": {"depth": 7}}}}


def test_parameters_of_every_node_are_kept_for_a_vehicle(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    mine, judging = tmp_path / "mine.yaml", tmp_path / "judging.yaml"
    mine.write_text(yaml.safe_dump({"/**": {"ros__parameters": {**OF_ROS, "axle_1": {"left": {}, "right": {}}}}}))
    judging.write_text(yaml.safe_dump({"/**": {"ros__parameters": {**OF_ROS, "learn": 10.0}}}))
    simulator, detector = started("vehicle", monkeypatch, vehicle=str(mine), detector=str(judging))
    of_ros = {"use_sim_time": True, "qos_overrides./dcrb/vehicle/diagnosis.publisher.depth": 7}
    assert given_to(simulator) == {**of_ros, "publishing.listeners": 1}
    assert given_to(detector) == {**of_ros, "boxes.learn": 10.0}


@pytest.mark.parametrize("file", ["bench", "vehicle", "axle_boxes"])
def test_listeners_and_wait_of_the_file_are_kept(file: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    mine, own = tmp_path / "mine.yaml", {"publishing": {"listeners": 3, "wait": 60.0}}
    mine.write_text(yaml.safe_dump({**own, "axle_1": {"left": {}, "right": {}}} if file == "vehicle" else own))
    argument = "vehicle" if file == "vehicle" else "config"
    simulator = next(node for node in started(file, monkeypatch, **{argument: str(mine)}) if node.executable.endswith("simulator"))
    found = read_vehicle(mine, given_to(simulator)).boxes[0].configuration if file == "vehicle" else configuration(simulator)
    assert (found.publishing.listeners, found.publishing.wait) == (3, 60.0)


def test_boxes_of_one_configuration_record_to_folders_of_their_own(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    mine = tmp_path / "mine.yaml"
    mine.write_text("recording: {path: /tmp/drive}")
    boxes = [node for node in started("axle_boxes", monkeypatch, config=str(mine)) if node.executable == "simulator"]
    assert [configuration(box).recording.path for box in boxes] == ["/tmp/drive/box1", "/tmp/drive/box2", "", "/tmp/drive/box4"]


def test_frames_do_not_begin_with_a_slash(monkeypatch: pytest.MonkeyPatch) -> None:
    boxes = [node for node in started("axle_boxes", monkeypatch, namespace="/wagon") if node.executable == "simulator"]
    assert [configuration(box).publishing.frame for box in boxes] == [f"wagon/box{box}/outer_ring" for box in (1, 2, 3, 4)]


def test_a_vehicle_is_started_with_the_detector_that_compares_its_boxes(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    given = {"vehicle": "bogie", "time_scale": "0.5", "record": str(tmp_path / "run"), "duration": "2.0", "namespace": "wagon"}
    simulator, detector = started("vehicle", monkeypatch, **given)
    assert [(node.executable, node.namespace) for node in (simulator, detector)] == [
        ("vehicle_simulator", "wagon"),
        ("vehicle_detector", "wagon"),
    ]
    assert simulator.arguments == ["--vehicle", "bogie", "--duration", "2.0"]
    found = read_vehicle("bogie", given_to(simulator)).boxes[0].configuration
    assert (found.time_scale, found.publishing.listeners, found.recording.path) == (0.5, 1, str(tmp_path / "run"))
    settings = validated(given_to(detector), VehicleDetectorSettings, "vehicle_detector")
    assert settings.boxes == DetectorParameters()
    viewer, *_ = started("vehicle", monkeypatch, rerun="true")
    assert (viewer.executable, viewer.arguments) == ("viewer", ["--vehicle"])


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"vehicle": "no_such"}, "vehicle:=no_such: there is no vehicle 'no_such'"),
        ({"time_scale": "-1.0"}, "time_scale:=-1.0: "),
        ({"record": "/proc/run"}, "record:=/proc/run: no folder can be created"),
    ],
)
def test_a_vehicle_that_cannot_be_started_is_refused_by_its_argument(
    given: dict[str, str], sentence: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(Refusal) as refused:
        started("vehicle", monkeypatch, **given)
    assert str(refused.value).startswith(sentence)


def test_the_scenario_of_a_vehicle_is_checked_from_its_own_start(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    vehicle, ride = tmp_path / "fast.yaml", tmp_path / "ride.yaml"
    vehicle.write_text("{vehicle: {speed_kmh: 300.0}, axle_1: {left: {}, right: {}}}")
    ride.write_text("start: {vehicle.speed_kmh: 72.0}\ntimeline: [{at: 1.0, over: 10.0, set: {vehicle.speed_kmh: 120.0}}]")
    simulator, _ = started("vehicle", monkeypatch, vehicle=str(vehicle), scenario=str(ride))
    assert simulator.arguments == ["--vehicle", str(vehicle), "--scenario", str(ride)]
    ride.write_text("start: {vehicle.speed_kmh: 500.0}\ntimeline: [{at: 1.0, set: {vehicle.speed_kmh: 120.0}}]")
    with pytest.raises(Refusal, match=r"scenario:=.*speed_kmh = 500"):
        started("vehicle", monkeypatch, vehicle=str(vehicle), scenario=str(ride))


def test_a_scenario_that_begins_after_the_run_of_a_vehicle_is_refused(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    late = tmp_path / "late.yaml"
    late.write_text("timeline: [{at: 2.0, set: {vehicle.speed_kmh: 60.0}}]")
    with pytest.raises(Refusal, match=r"^scenario:=.*late.yaml: the scenario changes nothing in a run of 2 s, its first entry is at 2 s"):
        started("vehicle", monkeypatch, scenario=str(late), duration="2.0")
    simulator, _ = started("vehicle", monkeypatch, scenario=str(late))  # without an end nothing is too late
    assert simulator.arguments == ["--vehicle", "bogie", "--scenario", str(late)]


def test_the_viewer_is_started_on_request(monkeypatch: pytest.MonkeyPatch) -> None:
    nodes = started("bench", monkeypatch, rerun="true", namespace="wagon/box1")
    assert (nodes[0].executable, nodes[0].namespace) == ("viewer", "wagon/box1")
    assert len(nodes) == 3


def test_replay_takes_its_parameters_from_the_arguments(monkeypatch: pytest.MonkeyPatch) -> None:
    actions = description("replay", monkeypatch).generate_launch_description()
    assert [action.name for action in actions if isinstance(action, Argument) and action.default is None] == ["bag"]
    bag = str(ROOT / "bags" / "healthy")
    replayer, detector = started("replay", monkeypatch, bag=bag, loop="True", rate="2", topics="ground_truth, outer_ring/vibration")
    assert (replayer.executable, detector.executable) == ("replayer", "fault_detector")
    assert configuration(replayer) == ReplayParameters(bag=bag, loop=True, rate=2.0, wait=30.0, topics="ground_truth, outer_ring/vibration")
    assert (replayer.namespace, detector.namespace) == ("dcrb", "dcrb")


def test_the_replay_of_a_vehicle_is_compared(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    bag, parameters = tmp_path / "bag", read_parameters("bogie", {"vehicle.bench": "dry"})
    simulation = VehicleSimulation(vehicle_of(parameters, "test"))
    with VehicleRecorder(bag, parameters, simulation) as recorder:
        for block in simulation.blocks(0.02):
            recorder.write(block)
    _, detector = started("replay", monkeypatch, bag=str(bag))
    assert detector.executable == "vehicle_detector"
    assert validated(given_to(detector), VehicleDetectorSettings, "vehicle_detector").boxes == DetectorParameters()


def test_axle_boxes_have_different_seeds_and_faults(monkeypatch: pytest.MonkeyPatch) -> None:
    nodes = started("axle_boxes", monkeypatch, clock="true")
    assert [node.namespace for node in nodes] == [f"wagon/box{box}" for box in (1, 2, 3, 4) for _ in range(2)]
    boxes = [configuration(node) for node in nodes if node.executable == "simulator"]
    assert [box.simulation.seed for box in boxes] == [1, 2, 3, 4]
    assert [box.publishing.clock for box in boxes] == [True, False, False, False]
    assert [set(box.faults.described()) for box in boxes] == [set(), set(), {"outer_1"}, set()]
    assert len({box.publishing.frame for box in boxes}) == 4
    assert [box.publishing.listeners for box in boxes] == [1, 1, 1, 1]
    transforms = [TRANSFORMS.decoded(encode_transforms(box)).transforms[0] for box in boxes]
    frames = [frame for transform in transforms for frame in (transform.header.frame_id, transform.child_frame_id)]
    assert len(set(frames)) == 8  # four trees without a common frame


BAG = str(ROOT / "bags" / "healthy")


@pytest.mark.parametrize(
    ("file", "given", "sentence"),
    [
        (
            "bench",
            {"config": "outer_ring_defct"},
            r"config:=outer_ring_defct: there is no configuration .*did you mean 'outer_ring_defect'",
        ),
        ("bench", {"config": ""}, "config:= is empty: leave it out"),
        ("bench", {"detector": "detectr"}, "detector:=detectr: there is no such file.*did you mean 'detector'"),
        ("bench", {"scenario": "growing_spal"}, "scenario:=growing_spal: there is no scenario.*did you mean 'growing_spall'"),
        ("bench", {"time_scale": "fast"}, "time_scale:=fast is not a finite number"),
        ("bench", {"time_scale": "-1"}, "^time_scale:=-1.0: settings: time_scale = -1.0 is outside 0 .. 1000"),
        ("bench", {"clock": "maybe"}, "clock:=maybe is neither true nor false"),
        ("bench", {"rerun": "tru"}, "rerun:=tru is neither true nor false"),
        ("bench", {"listeners": "1.5"}, "listeners:=1.5 is not a whole number"),
        ("bench", {"wait": "nan"}, "wait:=nan is not a finite number"),
        ("bench", {"wait": "-1"}, "^wait:=-1.0: settings: publishing.wait = -1.0 s is outside"),
        ("bench", {"namespace": "my bench"}, "namespace:=my bench is not a ROS namespace"),
        ("bench", {"discovery": "SUBNETS"}, "discovery:=SUBNETS is not one of .*did you mean 'SUBNET'"),
        ("bench", {"discovery": "OFF"}, "= OFF hides the nodes of the bench from each other: unset it, or set LOCALHOST or SUBNET"),
        ("axle_boxes", {"fault": "cage_fractur"}, "fault:=cage_fractur: there is no configuration.*did you mean 'cage_fracture'"),
        ("axle_boxes", {"clock": "2"}, "clock:=2 is neither true nor false"),
        ("replay", {"bag": "/nowhere"}, "bag:=/nowhere: there is no recording"),
        ("replay", {"bag": BAG, "rate": "-1"}, "^replay: rate = -1.0 is outside 0 .. 1000"),
        ("replay", {"bag": BAG, "loop": "2"}, "loop:=2 is neither true nor false"),
        ("replay", {"bag": BAG, "offset": "9"}, "^offset:=9.0: .*lower the offset"),
        ("bench", {"record": "/dev/null/bag"}, "^record:=/dev/null/bag: no folder can be created in /dev/null"),
        ("bench", {"record": "/proc/a/bag"}, "^record:=/proc/a/bag: no folder can be created in /proc"),
        ("bench", {"record": "x" * 300}, "^record:=x+: "),
        ("bench", {"duration": "0"}, "^duration:= 0.*give the simulated time"),
        ("bench", {"duration": "ten"}, "^duration:=ten is not a finite number"),
        ("replay", {"bag": BAG, "listeners": "two"}, "listeners:=two is not a whole number"),
        (
            "bench",
            {"scenario": "growing_spall", "duration": "0.5"},
            "^scenario:=growing_spall: the scenario changes nothing in a run of 0.5 s, .*increase duration:=",
        ),
    ],
)
def test_an_invalid_argument_is_refused_by_name_before_the_start(
    file: str, given: dict[str, str], sentence: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(Refusal, match=sentence):
        started(file, monkeypatch, **given)


@pytest.mark.parametrize(("text", "value"), [("true", True), ("True", True), ("1", True), ("on", True), ("false", False), ("0", False)])
def test_every_spelling_of_a_truth_value_is_understood(text: str, value: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    simulator = next(node for node in started("bench", monkeypatch, clock=text, rerun=text) if node.executable == "simulator")
    assert configuration(simulator).publishing.clock is value
    assert configuration(simulator).publishing.listeners == (2 if value else 1)  # the detector, and the viewer


def test_the_simulator_waits_for_the_listeners_that_are_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    simulator, _ = started("bench", monkeypatch, listeners="3", wait="60")
    publishing = configuration(simulator).publishing
    assert (publishing.listeners, publishing.wait) == (3, 60.0)


def test_texts_remain_texts(monkeypatch: pytest.MonkeyPatch) -> None:
    simulator, _ = started("bench", monkeypatch, record="2026")
    assert simulator.parameters[0]["recording.path"] == Typed("2026", str)


def every_node(monkeypatch: pytest.MonkeyPatch) -> list[Node]:
    return [*started("bench", monkeypatch, rerun="true"), *started("replay", monkeypatch, bag=BAG), *started("axle_boxes", monkeypatch)]


def test_the_end_of_a_node_ends_the_launch_but_that_of_the_viewer_does_not(monkeypatch: pytest.MonkeyPatch) -> None:
    nodes = every_node(monkeypatch)
    assert all((node.on_exit is None) == (node.executable == "viewer") for node in nodes)
    for shut in (False, True):
        ends = [node.on_exit(SimpleNamespace(returncode=0), SimpleNamespace(is_shutdown=shut)) for node in nodes if node.on_exit]
        assert all(isinstance(end, End) for end in ends)


@pytest.mark.parametrize(("status", "shut", "failed"), [(1, False, True), (1, True, True), (-9, False, True), (-9, True, False)])
def test_a_node_that_fails_makes_the_launch_fail(status: int, shut: bool, failed: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    for node in every_node(monkeypatch):
        if node.on_exit is not None:
            event, context = SimpleNamespace(returncode=status), SimpleNamespace(is_shutdown=shut)
            # `launch` logs what a handler raises, ends its nodes and returns 1.
            with pytest.raises(Refusal, match=f"{node.executable} in .* has failed with status {status}") if failed else nullcontext():
                node.on_exit(event, context)


def test_a_launch_of_a_stated_duration_ends_by_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    simulator = next(node for node in started("bench", monkeypatch, duration="10") if node.executable == "simulator")
    assert simulator.arguments == ["--duration", "10.0"]


def test_a_pushed_namespace_is_no_misspelt_argument(monkeypatch: pytest.MonkeyPatch) -> None:
    for file, given in (("bench", {}), ("replay", {"bag": BAG}), ("axle_boxes", {})):
        assert not [entity for entity in entities(file, monkeypatch, ros_namespace="/robot", **given) if isinstance(entity, Message)]


def test_a_misspelt_argument_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    messages = [entity for entity in entities("bench", monkeypatch, confg="healthy", unrelated="1") if isinstance(entity, Message)]
    assert [message.named["msg"] for message in messages] == ["the argument 'confg' is ignored; did you mean 'config'?"]
