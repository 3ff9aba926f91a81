"""Parameters of a node: what others may set, without a process of its own."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import yaml

pytest.importorskip("rclpy", reason="the nodes need ROS 2; everything else is tested without")

import rclpy
from geometry_msgs.msg import Wrench
from made_up_blocks import recorded
from rclpy.parameter import Parameter, parameter_dict_from_yaml_file
from rclpy.serialization import serialize_message
from std_msgs.msg import Float64
from waiting import wait_for

from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.messages.bundle import Bundle
from dcrb_ros.messages.statuses import ERROR, Status, decode_diagnostics
from dcrb_ros.messages.topics import CLOCK, LOAD_COMMAND, SPEED_COMMAND, Message
from dcrb_ros.nodes.base import BenchNode
from dcrb_ros.nodes.clock import ClockPublisher
from dcrb_ros.nodes.fault_detector import FaultDetectorNode
from dcrb_ros.nodes.hot_box_detector import HotBoxDetectorNode
from dcrb_ros.nodes.publisher import Publisher
from dcrb_ros.nodes.replayer import ReplayerNode
from dcrb_ros.nodes.simulator import RUN_TIME, SimulatorNode
from dcrb_ros.nodes.vehicle_simulator import VehicleSimulatorNode
from dcrb_ros.recordings.replay import ReplayParameters
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import flatten, load_configuration, nest
from dcrb_ros.vehicle.file import read_parameters


class Asked(BenchNode):
    """A node with the parameters of the simulator that keeps what it is asked for, and refuses what is fixed."""

    def __init__(self) -> None:
        super().__init__("asked")
        self.changes: list[dict[str, Any]] = []
        self.declare(Configuration, run_time=RUN_TIME)

    def on_parameters(self, changes: dict[str, Any]) -> None:
        self.changes.append(changes)
        for key in changes:
            if key not in RUN_TIME:
                raise Refusal(f"{key} is fixed")


@pytest.fixture
def ros(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")
    rclpy.init(args=[])
    try:
        yield
    finally:
        rclpy.try_shutdown()


@pytest.fixture
def node(ros: None) -> Iterator[Asked]:
    asked = Asked()
    yield asked
    asked.destroy_node()


def answer(node: BenchNode, **values: Any) -> tuple[bool, str]:
    """Return the answer to a request."""
    result = node.set_parameters_atomically([Parameter(key.replace("__", "."), value=value) for key, value in values.items()])
    return result.successful, result.reason


@pytest.mark.parametrize("name", ["faults.broken_bars", "recording.topics", "structure.frequencies", "time_scale"])
def test_no_parameter_can_be_deleted(node: Asked, name: str) -> None:
    present = node.get_parameter(name).value
    assert not node.set_parameters_atomically([Parameter(name, Parameter.Type.NOT_SET)]).successful
    assert node.get_parameter(name).value == present


def test_every_parameter_may_be_set_to_the_value_that_it_has(node: Asked) -> None:
    present = [node.get_parameter(name) for name in node.list_parameters([], 0).names]
    assert {parameter.name for parameter in present} > set(flatten(Configuration().model_dump()))
    assert [(one.name, node.set_parameters_atomically([one]).reason) for one in present] == [(one.name, "") for one in present]
    assert {key for changes in node.changes for key in changes} == set(RUN_TIME)


def test_an_integer_is_the_present_value_of_a_number(node: Asked) -> None:
    assert answer(node, operating__load=100000, bearing__rows=2) == (True, "")
    assert node.changes == []


def test_a_text_that_reads_as_a_number_is_that_number(node: Asked) -> None:
    assert answer(node, operating__load="1e+05", bearing__rows="2") == (True, "")
    assert node.changes == []
    assert answer(node, faults__outer_1__width="5e-06") == (True, "")
    assert node.get_parameter("faults.outer_1.width").value == 5e-6
    for text in ("wide", "1_000", "0.001 m", "[1.0]", "a: 1", "'", "9" * 5000, "1e"):
        assert answer(node, faults__outer_1__width=text)[0] is False, text
    assert answer(node, bearing__rows="9" * 90)[0] is False


def test_a_file_of_dumped_parameters_is_loaded_without_a_refusal(ros: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    bag = recorded(tmp_path / "bag", 3)
    small = {"faults.outer_1.width": 1e-5, "recording.path": "2026", "publishing.frame": "true"}
    given = [
        lambda: SimulatorNode(parameters=load_configuration(Configuration(), small)),
        lambda: ReplayerNode(ReplayParameters(bag=str(bag), offset=1e-5, rate=1e-5)),
        lambda: FaultDetectorNode(DetectorParameters(band_low=1e3)),
        HotBoxDetectorNode,
    ]
    for create in given:
        node = create()
        if isinstance(node, SimulatorNode):
            node.engine.prepare()
        present = {name: node.get_parameter(name).value for name in node.list_parameters([], 0).names}
        name, dump = node.get_fully_qualified_name(), tmp_path / "dump.yaml"
        # As `ros2 param dump` writes it, and with the function of rclpy by which `ros2 param load` reads it.
        dump.write_text(yaml.dump({name: {"ros__parameters": nest(present)}}, default_flow_style=False), encoding="utf-8")
        loaded = parameter_dict_from_yaml_file(str(dump), target_nodes=[name]).values()
        assert {parameter.name for parameter in loaded} == set(present)
        answers = {parameter.name: node.set_parameters_atomically([Parameter.from_parameter_msg(parameter)]).reason for parameter in loaded}
        assert set(answers.values()) == {""}, {key: reason for key, reason in answers.items() if reason}
        assert {name: node.get_parameter(name).value for name in present} == present
        node.close()
        node.destroy_node()


VEHICLE = """
vehicle: {bench: dry, speed_kmh: 100.0}
axle_1: {left: {faults.outer_1.width: 0.003, background.hum_level: 1.0}, right: {}}
"""


@pytest.fixture
def vehicle(ros: None, tmp_path: Path) -> Iterator[VehicleSimulatorNode]:
    """A vehicle of two boxes, whose node has parameters of its own beside the file."""
    path = tmp_path / "two.yaml"
    path.write_text(VEHICLE)
    rclpy.try_shutdown()
    given = ("vehicle.seed:=5", "publishing.listeners:=2", "axle_1.radius:=0.45", "axle_1.right.wheel.flat:=0.01", "track.spectrum:=none")
    rclpy.init(args=["--ros-args", *(word for text in given for word in ("-p", text))])
    node = VehicleSimulatorNode(None, str(path))
    node.engine.prepare()
    yield node
    node.close()
    node.destroy_node()


def test_a_vehicle_takes_each_of_its_parameters_again(vehicle: VehicleSimulatorNode) -> None:
    names = [name for name in vehicle.list_parameters([], 0).names if not name.startswith("qos_overrides")]
    assert {"vehicle.seed", "publishing.listeners", "axle_1.radius", "track.spectrum", "axle_1.right.wheel.flat"} < set(names)
    reasons = {name: vehicle.set_parameters_atomically([vehicle.get_parameter(name)]).reason for name in names}
    assert {name: reason for name, reason in reasons.items() if reason} == {}
    assert answer(vehicle, vehicle__seed=6) == (False, "parameters: vehicle.seed cannot be set while the node runs: give it at the start")
    assert vehicle.get_parameter("vehicle.seed").value == 5


def test_the_background_that_a_box_has_of_its_own_can_be_set(vehicle: VehicleSimulatorNode) -> None:
    assert vehicle.get_parameter("axle_1.left.background.hum_level").value == 1.0
    assert answer(vehicle, axle_1__left__background__hum_level=2.0, axle_1__right__background__impact_rate=3.0) == (True, "")
    assert vehicle.get_parameter("axle_1.left.background.hum_level").value == 2.0
    assert vehicle._source.simulation.simulations["axle_1.left"].has_pending
    assert answer(vehicle, axle_1__left__background__flat_level=2.0)[1] == (
        "parameters: axle_1.left.background.flat_level follows from the vehicle's wheels, track and gear: "
        "set axle_1.left.wheel, or give track and gear at the start"
    )


@pytest.mark.parametrize(
    "key",
    [
        *("axle_3.left.wheel.flat", "axle_2.slide", "axle_1.middle.wheel.flat", "axle_1.raduis", "axle_1.gear.teet", "axle_1.left.bnch"),
        *("trak.roughness", "track.roughnes", "vehicle.sped", "publishing.blok", "time_scale.a"),
    ],
)
def test_a_parameter_that_no_vehicle_has_is_called_unknown(vehicle: VehicleSimulatorNode, key: str) -> None:
    result = vehicle.set_parameters_atomically([Parameter(key, value=0.01)])
    assert not result.successful
    assert result.reason.startswith(f"parameters: unknown parameter '{key}'")


@pytest.mark.parametrize(
    "key",
    [
        *("vehicle.ramp", "track.roughness", "axle_1.x", "axle_1.gear.teeth", "publishing.block_size", "recording.path"),
        *("axle_1.left.bench", "axle_1.left.sensor.swapped_with", "axle_1.left.simulation.seed"),
    ],
)
def test_a_parameter_of_the_start_is_refused_as_such(vehicle: VehicleSimulatorNode, key: str) -> None:
    result = vehicle.set_parameters_atomically([Parameter(key, value=0.01)])
    assert (result.successful, result.reason) == (False, f"parameters: {key} cannot be set while the node runs: give it at the start")


def test_a_vehicle_names_a_parameter_of_a_wrong_type_once(vehicle: VehicleSimulatorNode) -> None:
    for key, words in (("time_scale", "0 .. 1000"), ("axle_1.left.faults.outer_1.width", "0 .. 0.05 m"), ("axle_1.slide", "0 .. 0.2")):
        reason = vehicle.set_parameters_atomically([Parameter(key, value="x")]).reason
        assert reason.startswith(f"parameters: {key} = 'x'")
        assert reason.endswith(f" is not a number within {words}")
    requested = Parameter.from_parameter_msg(Parameter("time_scale", value=[1.0, 2.0]).to_parameter_msg())
    assert "time_scale = [1.0, 2.0] is not a number" in vehicle.set_parameters_atomically([requested]).reason


def check_pending_reset(node: SimulatorNode | VehicleSimulatorNode, key: str) -> None:
    """Check that a node refuses to set a parameter of the simulation while a reset is pending."""
    assert not node.engine.gate.reset(0.0)  # nobody finishes it yet
    assert answer(node, **{key: 0.002}) == (
        False,
        "parameters: a reset is pending, which would discard the change: give it again once the simulation is at its start",
    )
    assert answer(node, **{key: 0.002, "time_scale": 0.5})[0] is False
    assert node.engine.gate.pacer.scale == 1.0
    assert answer(node, time_scale=0.5) == (True, "")
    assert node.engine.gate.pacer.scale == 0.5
    node.engine.gate.finish_reset()
    assert answer(node, **{key: 0.002}) == (True, "")


def test_a_vehicle_is_not_changed_while_a_reset_is_pending(vehicle: VehicleSimulatorNode) -> None:
    check_pending_reset(vehicle, "axle_1__left__faults__outer_1__width")


def check_ended(node: SimulatorNode | VehicleSimulatorNode, key: str) -> None:
    """Check that a node whose simulation has ended refuses to set parameters."""
    node.engine.close()
    for given in ({key: 0.002}, {"time_scale": 0.5}):
        assert answer(node, **given) == (False, "parameters: the simulation has ended or is quitting: start the node again")


def test_a_vehicle_is_not_changed_after_its_end(vehicle: VehicleSimulatorNode) -> None:
    check_ended(vehicle, "axle_1__left__faults__outer_1__width")


def test_a_bench_is_neither_changed_nor_commanded_after_its_end(ros: None) -> None:
    node = SimulatorNode()
    node.engine.prepare()
    check_ended(node, "faults__outer_1__width")
    node._on_command(SPEED_COMMAND, bytes(serialize_message(Float64(data=100.0))))
    assert node.refusals.count("command/speed") == 1
    node.destroy_node()


def test_a_bench_is_neither_changed_nor_commanded_while_a_reset_is_pending(ros: None) -> None:
    node = SimulatorNode()
    node.engine.prepare()
    check_pending_reset(node, "faults__outer_1__width")
    speed, load = bytes(serialize_message(Float64(data=100.0))), bytes(serialize_message(Wrench()))
    node.engine.gate.reset(0.0)
    for _ in range(2):  # during the reset, and after it
        node._on_command(SPEED_COMMAND, speed)
        node._on_command(LOAD_COMMAND, load)
        assert (node.refusals.count("command/speed"), node.refusals.count("command/load")) == (1, 1)
        node.engine.gate.finish_reset()
    node.destroy_node()


def test_a_change_that_fits_a_pending_one_is_accepted(ros: None) -> None:
    node = SimulatorNode(parameters=load_configuration("healthy", {"faults.outer_1.width": 0.002}))
    node.engine.prepare()
    assert answer(node, faults__outer_1__azimuth=1.0) == (True, "")
    assert answer(node, faults__outer_2__width=0.002) == (True, "")
    assert not answer(node, time_scale=-1.0, faults__outer_3__azimuth=1.0)[0]
    node.destroy_node()


def test_a_node_records_no_topic_that_it_does_not_publish(ros: None, tmp_path: Path) -> None:
    SimulatorNode(parameters=load_configuration("dry", {"recording.topics": "diagnosis"})).destroy_node()
    with pytest.raises(Refusal, match=r"recording.topics: this run does not record 'envelope_spectrum'"):
        SimulatorNode(parameters=load_configuration("dry", {"recording.topics": "envelope_spectrum"}))
    path = tmp_path / "two.yaml"
    path.write_text(VEHICLE)
    with pytest.raises(Refusal, match=r"recording.topics: this run does not record 'diagnosis'"):
        VehicleSimulatorNode(None, str(path), parameters=read_parameters(str(path), ["recording.topics=diagnosis"]))


def test_a_wrong_type_is_named_as_such(ros: None) -> None:
    node = SimulatorNode()
    node.engine.prepare()
    for key, value, words in (
        ("bearing__roller_radius", "wide", "'wide' m is not a number within"),
        ("bearing__rows", 1.5, "1.5 is not a whole number within"),
        ("recording__path", 5, "5 is not a text"),
        ("publishing__clock", "yes", "'yes' is not true or false"),
        ("operating__speed", "fast", "'fast' rad/s is not a number within"),
    ):
        done, reason = answer(node, **{key: value})
        assert not done
        assert words in reason
        assert "fixed" not in reason
        assert "changes by" not in reason
    assert "is fixed while the bench runs" in answer(node, bearing__rows=1)[1]
    node.destroy_node()


def test_a_fixed_parameter_refuses_another_value_and_takes_the_request_with_it(node: Asked) -> None:
    assert answer(node, bearing__rows=1) == (False, "bearing.rows is fixed")
    assert answer(node, bearing__rows=2.0) == (False, "bearing.rows is fixed")
    assert answer(node, faults__outer_1__width=0.002, bearing__rows=1)[0] is False
    assert node.get_parameter("faults.outer_1.width").value == 0.0
    assert answer(node, faults__outer_1__width=0.002, bearing__rows=2) == (True, "")
    assert node.get_parameter("faults.outer_1.width").value == 0.002
    assert node.changes[-1] == {"faults.outer_1.width": 0.002}


def test_a_replay_that_refuses_a_fixed_parameter_keeps_its_rate(ros: None, tmp_path: Path) -> None:
    replayer = ReplayerNode(ReplayParameters(bag=str(recorded(tmp_path / "bag", 3)), rate=1.0))
    assert answer(replayer, rate=5.0, loop=True) == (False, "parameters: loop is fixed while the node runs: give it at the start")
    assert answer(replayer, loop=5) == (
        False,
        "parameters: loop = 5 is not true or false (start again at the end, endlessly, the stamps start again too)",
    )
    assert (replayer.get_parameter("rate").value, replayer._engine.gate.pacer.scale) == (1.0, 1.0)
    assert answer(replayer, rate=-1.0)[0] is False
    assert answer(replayer, rate=5.0, loop=False) == (True, "")
    assert (replayer.get_parameter("rate").value, replayer._engine.gate.pacer.scale) == (5.0, 5.0)
    replayer.destroy_node()


def test_the_clock_does_not_run_back_if_a_block_comes_during_a_report(ros: None, monkeypatch: pytest.MonkeyPatch) -> None:
    node = SimulatorNode(parameters=load_configuration(Configuration(), {"publishing.clock": True}))
    node.engine.prepare()
    published: list[int] = []
    now = itertools.count(100.0)
    monkeypatch.setattr("dcrb_ros.nodes.clock.time.monotonic", lambda: next(now))
    clock = ClockPublisher(lambda messages: published.extend(message.time_ns for message in messages))
    monkeypatch.setattr(node, "_clocks", [clock])
    monkeypatch.setattr(node, "_others", SimpleNamespace(names=[]), raising=False)

    def status(*_: object) -> Status:
        clock.write(Bundle(0, 20_000_000, ()))
        return Status("simulator", 0, "", {})

    monkeypatch.setattr(node, "_status", SimpleNamespace(status=status))
    node._publish_status()
    assert published == [20_000_000, 20_000_000]
    clock.start([])
    clock.repeat()
    assert published[2:] == [0]
    node.destroy_node()


def test_a_repeated_time_counts_for_the_rate_of_the_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    published: list[int] = []
    now = iter([100.0, 100.005, 100.009, 100.02, 100.03])
    monkeypatch.setattr("dcrb_ros.nodes.clock.time.monotonic", lambda: next(now, 100.03))
    monkeypatch.setattr("dcrb_ros.nodes.clock.PERIOD", 0.01)
    clock = ClockPublisher(lambda messages: published.extend(message.time_ns for message in messages))
    clock.repeat()
    for end_ns in (20, 40, 60):
        clock.write(Bundle(0, end_ns, ()))
    assert published == [0, 60]


@pytest.mark.parametrize("replayed", [False, True])
def test_the_last_time_of_a_run_is_published(replayed: bool, ros: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    published: list[int] = []

    def write(publisher: Publisher, messages: Iterable[Message]) -> None:
        published.extend(message.time_ns for message in messages if message.topic == CLOCK)

    monkeypatch.setattr(Publisher, "write_messages", write)
    monkeypatch.setattr("dcrb_ros.nodes.clock.PERIOD", 1e3)
    node: Any
    if replayed:
        node = ReplayerNode(ReplayParameters(bag=str(recorded(tmp_path / "bag", 3)), rate=0.0, clock=True))
        engine = node._engine
    else:
        node = SimulatorNode(0.06, parameters=load_configuration(Configuration(), {"publishing.clock": True, "time_scale": 0.0}))
        engine = node.engine
    engine.prepare()
    engine.start()
    wait_for(lambda: engine.ended)
    assert published == [20_000_000]
    node.close()
    assert published == [20_000_000, 60_000_000]
    node.destroy_node()


def test_a_failed_model_is_the_last_report(ros: None, monkeypatch: pytest.MonkeyPatch) -> None:
    published: list[Message] = []
    monkeypatch.setattr(Publisher, "write_messages", lambda publisher, messages: published.extend(messages))

    def fail(*_: object) -> None:
        raise RuntimeError("the model failed on purpose")

    node = SimulatorNode()
    node.engine.prepare()
    monkeypatch.setattr(node._source.simulation, "blocks", fail)
    node.engine.start()
    wait_for(lambda: node.engine.ended)
    node.close()
    (status,) = decode_diagnostics(published[-1].data)[1]
    assert (status.level, status.message, status.values["model"]) == (ERROR, "the model failed on purpose", "failed")
    node.destroy_node()


def test_a_change_with_a_parameter_of_ros_that_cannot_be_set_changes_nothing(node: Asked) -> None:
    width = node.get_parameter("faults.outer_1.width").value
    for name, value in (("use_sim_time", "yes"), ("start_type_description_service", False), ("qos_overrides./dcrb/x.publisher.depth", 8)):
        changed = [Parameter("faults.outer_1.width", value=0.002), Parameter(name, value=value)]
        found = node.set_parameters_atomically(changed)
        assert (found.successful, node.changes) == (False, [])
        assert found.reason.startswith(f"parameters: {name} = {value!r} cannot be set while the node runs")
        assert node.get_parameter("faults.outer_1.width").value == width
    assert answer(node, faults__outer_1__width=0.002, use_sim_time=True) == (True, "")
    assert node.get_parameter("use_sim_time").value is True
