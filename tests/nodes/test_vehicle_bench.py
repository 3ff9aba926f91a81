"""The nodes of a vehicle as processes: topics, stamps, commands, parameters, recordings, verdicts and replay."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from ros_bench import PATIENCE, GraphClient, domain, environment, node
from same_process import dcrb

from dcrb_ros.messages.joints import encode_joints
from dcrb_ros.messages.points import decode_spectrum, decode_vibration
from dcrb_ros.messages.statuses import ERROR, OK, Status, decode_diagnostics, encode_diagnostics
from dcrb_ros.messages.topics import (
    BENCH_DIAGNOSTICS,
    ENVELOPE_SPECTRUM,
    FEATURES,
    GROUND_TRUTH,
    ROLLER_STATES,
    SPEED_COMMAND,
    VIBRATION,
    Topic,
)
from dcrb_ros.messages.topics.vehicle import (
    VEHICLE_COMMANDS,
    VEHICLE_DESCRIPTION,
    VEHICLE_DIAGNOSIS,
    VEHICLE_INDICATORS,
    VEHICLE_STATE,
    VEHICLE_TRUTH,
)
from dcrb_ros.messages.vehicle import decode_description
from dcrb_ros.nodes.vehicle_bench import VehicleObserver
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.vehicle import VehicleRecording
from dcrb_ros.recordings.vehicle_recorder import VehicleRecorder
from dcrb_ros.vehicle.file import read_parameters, vehicle_of
from dcrb_ros.vehicle.simulation import VehicleSimulation
from dcrb_ros.viewer.vehicle_content import read_vehicle_content

pytestmark = [pytest.mark.node, pytest.mark.slow]

VEHICLE = """
vehicle: {bench: dry, speed_kmh: 100.0}
track: {joint_spacing: 25.0}
axle_1: {left: {faults.outer_1.width: 0.003}, right: {wheel.flat: 0.03}}
axle_2: {left: {}, right: {}}
"""
BOXES = ("axle_1/left", "axle_1/right", "axle_2/left", "axle_2/right")
OF_VEHICLE = (VEHICLE_DESCRIPTION, VEHICLE_STATE, VEHICLE_TRUTH, VEHICLE_DIAGNOSIS, VEHICLE_INDICATORS)


@pytest.fixture
def vehicle(tmp_path: Path) -> Path:
    path = tmp_path / "four.yaml"
    path.write_text(VEHICLE)
    return path


class VehicleClient(GraphClient):
    """Keeps the messages of a vehicle by topic and box."""

    simulator = "vehicle_simulator"

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.boxes: dict[tuple[Topic, str], list[bytes]] = defaultdict(list)
        for topic in OF_VEHICLE:
            self.listen(topic, f"/dcrb/{topic.name}", self.received[topic], self.published[topic])
        # The waveform of the first box last: a vehicle counts its subscribers before it sends a block.
        for topic in (FEATURES, GROUND_TRUTH, ROLLER_STATES, ENVELOPE_SPECTRUM, VIBRATION):
            for box in reversed(BOXES):
                below = topic.below(box)
                self.listen(below, f"/dcrb/{below.name}", self.boxes[topic, box], [])

    def statuses(self, topic: Topic) -> dict[str, Status]:
        """The statuses of the last message on a topic of the vehicle."""
        return {status.name: status for status in decode_diagnostics(self.received[topic][-1])[1]}

    def commanded(self) -> dict[str, float]:
        """What is commanded in the last ground truth."""
        values = self.statuses(VEHICLE_TRUTH)["vehicle"].values
        return {name: float(values[name]) for name in VEHICLE_COMMANDS}


@pytest.fixture
def client() -> Iterator[VehicleClient]:
    listener = VehicleClient(domain())
    yield listener
    listener.close()


def test_all_boxes_have_the_topics_of_a_bench_with_equal_stamps(vehicle: Path, client: VehicleClient, tmp_path: Path) -> None:
    arguments = ["--vehicle", str(vehicle), "--duration", "0.4", "--ros-args", "-p", "publishing.listeners:=1", "-p", "time_scale:=0.0"]
    with node("vehicle_simulator", arguments, environment(client.number), tmp_path / "log") as simulator:
        client.until(lambda: all(len(client.boxes[VIBRATION, box]) == 20 for box in BOXES), "20 blocks of every box")
        client.until(lambda: len(client.received[VEHICLE_TRUTH]) == 20, "the ground truth of every block")
        client.until(lambda: len(client.received[VEHICLE_STATE]) == 20, "the state after every block")
        others = [client.boxes[topic, box] for topic in (FEATURES, GROUND_TRUTH, ROLLER_STATES) for box in BOXES]
        client.until(lambda: all(others) and client.received[VEHICLE_DESCRIPTION], "all topics of every box, and the description")
        assert simulator.process.wait(PATIENCE) == 0
    stamps = {box: [VIBRATION.stamp(data) for data in client.boxes[VIBRATION, box]] for box in BOXES}
    assert all(times == [20_000_000 * k for k in range(20)] for times in stamps.values())
    assert [VEHICLE_TRUTH.stamp(data) for data in client.received[VEHICLE_TRUTH]] == stamps["axle_1/left"]
    (description, *_) = map(decode_description, client.received[VEHICLE_DESCRIPTION])
    assert [box.name for box in description.boxes] == list(BOXES)
    state = VEHICLE_STATE.decoded(client.received[VEHICLE_STATE][-1])
    assert (state.header.frame_id, state.child_frame_id) == ("odom", "base_link")
    assert state.twist.twist.linear.x == pytest.approx(100.0 / 3.6)
    assert state.pose.pose.position.x == pytest.approx(0.4 * 100.0 / 3.6, rel=1e-9)
    truth = client.statuses(VEHICLE_TRUTH)
    assert set(BOXES) < set(truth)
    assert float(truth["axle_1/left"].values["own_bearing [m/s^2]"]) > float(truth["axle_2/right"].values["own_bearing [m/s^2]"])
    flats = [s for data in client.received[VEHICLE_TRUTH] for s in decode_diagnostics(data)[1] if s.message == "flat"]
    assert {status.values["box"] for status in flats} == {"axle_1/right"}


def test_commands_act_and_those_to_a_box_are_refused_and_counted(vehicle: Path, client: VehicleClient, tmp_path: Path) -> None:
    from geometry_msgs.msg import Wrench
    from std_msgs.msg import Float64
    from std_srvs.srv import SetBool, Trigger

    publishers = {name: client.node.create_publisher(Float64, f"/dcrb/{topic.name}", 10) for name, topic in VEHICLE_COMMANDS.items()}
    speed = client.node.create_publisher(Float64, f"/dcrb/axle_1/left/{SPEED_COMMAND.name}", 10)
    load = client.node.create_publisher(Wrench, "/dcrb/axle_2/right/command/load", 10)
    arguments = ["--vehicle", str(vehicle), "--ros-args", "-p", "time_scale:=0.1"]
    with node("vehicle_simulator", arguments, environment(client.number), tmp_path / "log") as simulator:
        client.connect(*publishers.values(), speed, load)
        publishers["speed_kmh"].publish(Float64(data=90.0))
        publishers["curvature"].publish(Float64(data=0.001))
        client.until(lambda: client.commanded()["curvature"] == 0.001 and client.commanded()["speed_kmh"] == 90.0, "the commands")
        publishers["speed_kmh"].publish(Float64(data=1000.0))
        publishers["brake"].publish(Float64(data=float("nan")))
        speed.publish(Float64(data=10.0))
        load.publish(Wrench())
        client.until(lambda: client.status["rejected_commands"] == "4", "four refusals")
        assert client.commanded() == {"speed_kmh": 90.0, "curvature": 0.001, "brake": 0.0, "wind": 0.0, "cant": 0.0}
        assert client.ask(SetBool, "pause", data=True).success
        before = len(client.boxes[VIBRATION, "axle_1/left"])
        assert client.ask(Trigger, "step").success
        client.until(lambda: len(client.boxes[VIBRATION, "axle_1/left"]) > before, "one block more")
        assert client.ask(Trigger, "reset").success
        assert client.ask(SetBool, "pause", data=False).success
        client.until(lambda: client.commanded()["curvature"] == 0.0, "the vehicle at its start")
        assert simulator.end(signal.SIGINT) == 0
        output = simulator.output
    assert "axle_1/left/command/speed is refused, as the speed of a box follows from the vehicle" in output
    assert "axle_2/right/command/load is refused, as the load of a box follows from the vehicle" in output
    assert "speed_kmh = 1000 km/h is outside 5 .. 300 km/h" in output


def test_parameters_change_boxes_wheels_and_slides_or_are_refused_with_a_reason(
    vehicle: Path, client: VehicleClient, tmp_path: Path
) -> None:
    arguments = ["--vehicle", str(vehicle), "--ros-args", "-p", "time_scale:=0.1"]
    with node("vehicle_simulator", arguments, environment(client.number), tmp_path / "log"):
        client.until(lambda: client.boxes[VIBRATION, "axle_2/left"], "a block")
        accepted = client.set(axle_2__left__faults__inner_1__width=0.002, axle_2__right__wheel__flat=0.04, time_scale=0.2)
        assert accepted == (True, "")
        client.until(lambda: b"faults.inner_1" in client.boxes[GROUND_TRUTH, "axle_2/left"][-1], "the fault in its box")
        assert all(b"faults.inner_1" not in data for data in client.boxes[GROUND_TRUTH, "axle_2/right"])
        client.until(lambda: any(b"axle_2/right" in data and b"flat" in data for data in client.received[VEHICLE_TRUTH]), "the flat")
        for values, reason in (
            ({"axle_1__left__faults__outer_1__width": 5.0}, "faults.outer_1.width"),
            ({"axle_1__left__faults__outer_1__width": "wide"}, "axle_1.left.faults.outer_1.width"),
            ({"axle_1__left__bearing__rows": 1}, "cannot be set while the node runs"),
            ({"axle_1__left__wheel__flt": 0.1}, "unknown parameter 'axle_1.left.wheel.flt'; did you mean 'axle_1.left.wheel.flat'?"),
            ({"axle_1__left__operating__speed": 50.0}, "speed, weight and track: publish on vehicle/command/speed_kmh"),
            ({"vehicle__speed_kmh": 50.0}, "changes by the topic vehicle/command/speed_kmh"),
            ({"axle_2__slide": 0.9}, "axle_2.slide = 0.9 is outside 0 .. 0.2"),
            ({"axle_2__left__faults__inner_1__width": 0.001, "axle_1__left__faults__outer_1__width": 5.0}, "faults.outer_1.width"),
        ):
            done, why = client.set(**values)
            assert (done, reason in why) == (False, True), (values, why)
        assert client.set(axle_2__left__faults__inner_1__width=0.002) == (True, "")


def test_a_recorded_run_has_the_samples_of_simulate_and_the_verdicts_of_the_detector(
    vehicle: Path, client: VehicleClient, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    bag, alone = tmp_path / "bag", tmp_path / "alone"
    parameters = read_parameters(str(vehicle))
    simulation = VehicleSimulation(vehicle_of(parameters, "test"), threads=1)
    with VehicleRecorder(alone, parameters, simulation) as recorder:
        for block in simulation.blocks(3.0):
            recorder.write(block)
    arguments = ["--vehicle", str(vehicle), "--duration", "3.0", "--ros-args", "-p", "time_scale:=0.0"]
    arguments += ["-p", "publishing.listeners:=2", "-p", f"recording.path:={bag}"]
    env = environment(client.number)
    with node("vehicle_detector", [], env, tmp_path / "detector"), node("vehicle_simulator", arguments, env, tmp_path / "log") as simulator:
        client.until(lambda: VEHICLE_DIAGNOSIS.stamp(client.received[VEHICLE_DIAGNOSIS][-1]) > 2.9e9, "the last verdicts")
        client.until(lambda: simulator.process.poll() is not None, "the end")
        client.until(lambda: all(client.boxes[ENVELOPE_SPECTRUM, box] for box in BOXES), "a spectrum of every box")
        assert simulator.process.returncode == 0
    names = {status.name for data in client.received[VEHICLE_DIAGNOSIS] for status in decode_diagnostics(data)[1]}
    assert {f"{box}/{part}" for box in BOXES for part in ("bearing", "wheel", "sensor")} | {"track"} <= names
    last = client.statuses(VEHICLE_DIAGNOSIS)
    assert last["axle_1/left/bearing"].message == "outer_ring"
    for box in BOXES:
        orders, amplitude = decode_spectrum(client.boxes[ENVELOPE_SPECTRUM, box][-1])[1:3]
        assert len(orders) == len(amplitude) > 100
    assert {"verdict", "confidence", "score [dB]", "reason"} <= set(last["axle_1/left/bearing"].values)
    recording = VehicleRecording(bag)
    for name, box in recording.boxes.items():
        assert box.outcome is not None
        assert box.outcome["sha256"] == recorder.outcome.boxes[name].sha256
        assert box.outcome["samples"] == 153600
        assert box.complete
    assert next(recording.messages((VEHICLE_DIAGNOSIS,)), None) is not None
    shown = read_vehicle_content(recording).judgements
    assert {box: bool(judgements and len(judgements[-1].spectrum[0])) for box, judgements in shown.items()} == dict.fromkeys(BOXES, True)
    assert dcrb("info", str(bag)) == 0
    assert "axle_2.right" in capfd.readouterr().out


def test_a_replay_publishes_all_boxes_with_equal_stamps(vehicle: Path, client: VehicleClient, tmp_path: Path) -> None:
    bag, parameters = tmp_path / "bag", read_parameters(str(vehicle))
    simulation = VehicleSimulation(vehicle_of(parameters, "test"))
    with VehicleRecorder(bag, parameters, simulation) as recorder:
        for block in simulation.blocks(0.2):
            recorder.write(block)
    arguments = ["--ros-args", "-p", f"bag:={bag}", "-p", "rate:=0.0"]
    with node("replayer", arguments, environment(client.number), tmp_path / "log") as replayer:
        client.until(lambda: all(len(client.boxes[VIBRATION, box]) == 10 for box in BOXES), "10 blocks of every box")
        client.until(lambda: len(client.received[VEHICLE_TRUTH]) == 10, "the ground truth of every block")
        client.until(lambda: client.received[VEHICLE_DESCRIPTION], "the description")
        assert replayer.process.wait(PATIENCE) == 0
    for box in BOXES:
        recorded = [block.packed() for block in Recording(bag / box.replace("/", ".")).vibrations()]
        assert [decode_vibration(data).packed() for data in client.boxes[VIBRATION, box]] == recorded
        assert [VIBRATION.stamp(data) for data in client.boxes[VIBRATION, box]] == [20_000_000 * k for k in range(10)]


@pytest.mark.parametrize(
    ("verdicts", "line"),
    [
        (("waiting", "waiting"), "->  waiting"),
        (("healthy", "healthy"), "->  all healthy"),
        (("waiting", "healthy"), "->  1 waiting, 1 healthy"),
        (("outer_ring", "waiting"), "->  bearing outer_ring"),
        (("undecided", "undecided"), "->  bearing undecided, wheel undecided"),
    ],
)
def test_the_status_line_calls_no_part_without_a_verdict_healthy(vehicle: Path, verdicts: tuple[str, str], line: str) -> None:
    observer = VehicleObserver(vehicle_of(read_parameters(str(vehicle)), "test"))
    topics = observer.topics()
    statuses = [Status(name, OK, verdict, {}) for name, verdict in zip(("bearing", "wheel"), verdicts, strict=True)]
    topics[FEATURES.below(BOXES[0])](encode_joints(0, ("rms",), np.array([3.0]), np.zeros(0), np.zeros(0)))
    topics[VEHICLE_DIAGNOSIS](encode_diagnostics(0, statuses))
    assert observer.line().endswith(f"rms 3 - - - m/s^2  |  {line}")


FAILING = """
import sys
from dcrb_ros.nodes.programs import main
from dcrb_ros.simulation.failure import ModelFailure
from dcrb_ros.simulation.loop import Simulation
original = Simulation.step_to
def step_to(self, end):
    if self.configuration.publishing.frame == "axle_2/left/outer_ring" and end > 20000:
        raise ModelFailure("the model failed on purpose")
    return original(self, end)
Simulation.step_to = step_to
main("vehicle_simulator", sys.argv[1:])
"""

LOADING = """
import pathlib, sys, time
from dcrb_ros.nodes.programs import main
from dcrb_ros.vehicle import simulation
original = simulation.VehicleSimulation.__init__
def set_up(*arguments, **options):
    while not pathlib.Path(sys.argv[1]).exists():
        time.sleep(0.01)
    original(*arguments, **options)
simulation.VehicleSimulation.__init__ = set_up
main("vehicle_simulator", sys.argv[2:])
"""


@contextmanager
def altered(code: str, arguments: list[str], env: dict[str, str], log: Path) -> Iterator[subprocess.Popen[bytes]]:
    """Run a simulator that is altered and started by Python ``code``."""
    with log.open("wb") as output:
        command = [sys.executable, "-c", code, *arguments]
        process = subprocess.Popen(command, env=env, stdout=output, stderr=subprocess.STDOUT)
    try:
        yield process
    finally:
        process.kill()
        process.wait(PATIENCE)


def others_go_on(client: VehicleClient) -> None:
    """Wait until a box that has not failed has sent some more blocks."""
    sent = len(client.boxes[VIBRATION, "axle_1/left"])
    client.until(lambda: len(client.boxes[VIBRATION, "axle_1/left"]) > sent + 3, "blocks of the others")


def test_a_box_whose_model_fails_is_silent_and_the_others_go_on(vehicle: Path, client: VehicleClient, tmp_path: Path) -> None:
    arguments = ["--vehicle", str(vehicle), "--ros-args", "-p", "vehicle.on_failure:=continue", "-p", "time_scale:=0.2"]
    with altered(FAILING, arguments, environment(client.number), tmp_path / "log"):
        client.until(lambda: client.status["silent"] == "axle_2.left", "the report of a silent box")
        client.until(lambda: client.statuses(VEHICLE_TRUTH)["axle_2/left"].level == ERROR, "the ground truth without this box")
        others_go_on(client)  # the topics are not ordered among one another: the last block of the silent box may come after the report
        sent = len(client.boxes[VIBRATION, "axle_2/left"])
        others_go_on(client)
        assert len(client.boxes[VIBRATION, "axle_2/left"]) == sent
        truth = client.statuses(VEHICLE_TRUTH)
        assert (truth["axle_2/left"].level, truth["axle_2/left"].message) == (ERROR, "its model failed: silent")
        assert decode_diagnostics(client.received[BENCH_DIAGNOSTICS][-1])[1][0].message == "silent: axle_2.left"
    assert "axle_2.left: the model failed on purpose; this box is silent" in (tmp_path / "log").read_text()


def test_a_model_that_fails_ends_the_node_with_a_sentence(vehicle: Path, tmp_path: Path) -> None:
    arguments = ["--vehicle", str(vehicle), "--ros-args", "-p", "time_scale:=0.0"]
    with altered(FAILING, arguments, environment(domain()), tmp_path / "log") as process:
        assert process.wait(PATIENCE) == 1
    output = (tmp_path / "log").read_text()
    assert "axle_2.left: the model failed on purpose" in output
    assert "Traceback" not in output


def test_the_command_refuses_what_does_not_belong_to_a_vehicle(capsys: pytest.CaptureFixture[str]) -> None:
    assert dcrb("bench", "healthy", "--vehicle", "bogie") == 2
    assert "leave out CONFIG" in capsys.readouterr().err
    assert dcrb("bench") == 2
    assert dcrb("bench", "--vehicle", "no_such") == 2
    assert "there is no vehicle 'no_such'" in capsys.readouterr().err


def test_the_status_says_that_the_vehicle_is_loading(vehicle: Path, client: VehicleClient, tmp_path: Path) -> None:
    arguments = [str(tmp_path / "go"), "--vehicle", str(vehicle)]
    with altered(LOADING, arguments, environment(client.number), tmp_path / "log"):
        client.until(lambda: client.status["model"] == "loading", "the report of a vehicle that is set up")
        assert client.status["blocks"] == "0"
        (tmp_path / "go").touch()
        client.until(lambda: client.status["model"] == "running", "the first block")
