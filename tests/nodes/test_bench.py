"""Simulator and fault detector as real nodes in separate processes, over DDS."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from node_arguments import GARBAGE, parameters

pytest.importorskip("rclpy", reason="the nodes need ROS 2; everything else is tested without")

from ros_bench import PATIENCE, domain, environment, graph_client, node
from waiting import wait_for

from dcrb_ros.diagnosis.detector import Diagnosis
from dcrb_ros.messages.joints import decode_joints, encode_joints
from dcrb_ros.messages.plain import decode_text, encode_text
from dcrb_ros.messages.points import decode_vibration
from dcrb_ros.messages.statuses import OK, WARN, Status, decode_diagnostics, decode_truth, encode_diagnostics
from dcrb_ros.messages.topics import (
    ACCELERATION,
    BENCH_DIAGNOSTICS,
    DIAGNOSIS,
    FAULT_INDICATORS,
    FEATURES,
    GROUND_TRUTH,
    ROLLER_STATES,
    SENSOR,
    VIBRATION,
)
from dcrb_ros.messages.topics.diagnosis import encode_diagnosis
from dcrb_ros.messages.topics.fault_indicators import encode_indicators
from dcrb_ros.nodes import bench
from dcrb_ros.nodes.bench import Observer
from dcrb_ros.nodes.publisher import message_class, qos
from dcrb_ros.nodes.ros import spin
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.stream.events import ScenarioEvent, SpeedCommand

pytestmark = pytest.mark.node

PROGRAM = [sys.executable, "-m", "dcrb_ros.cli.program"]


@pytest.mark.parametrize(("fault", "verdict"), [("outer_1", "outer_ring"), ("", "healthy")])
def test_the_detector_finds_the_fault_over_dds(fault: str, verdict: str, tmp_path: Path) -> None:
    number = domain()
    faulty = {f"faults__{fault}__width": 0.002} if fault else {}
    with (
        graph_client(number) as client,
        node("fault_detector", [], environment(number), tmp_path / "detector.log") as detector,
        # At half the speed, blocks that the middleware sends once more, three seconds later, are still in the queue of their publisher.
        node("simulator", parameters(time_scale=0.5, **faulty), environment(number), tmp_path / "simulator.log") as simulator,
    ):

        def judged() -> list[str]:
            assert detector.process.poll() is None, detector.output
            assert simulator.process.poll() is None, simulator.output
            found = [decode_diagnostics(data)[1][0].message for data in client.received[DIAGNOSIS]]
            return [word for word in found if word != "waiting"]

        client.until(lambda: len(judged()) >= 3, "three verdicts")
        assert set(judged()) == {verdict}
        for topic in (SENSOR, VIBRATION, ACCELERATION, FEATURES, ROLLER_STATES, GROUND_TRUTH, FAULT_INDICATORS, BENCH_DIAGNOSTICS):
            client.until(lambda wanted=topic: client.received[wanted], topic.name)
        about = json.loads(decode_text(client.received[SENSOR][0]))
        indices = [decode_vibration(data).first_index(about["sampling_rate"]) for data in client.received[VIBRATION]]
        assert np.all(np.diff(indices) == about["block_size"])  # nothing is dropped
        client.until(lambda: client.status.get("energy_residual [J]", "0") != "0", "the energy account")
        assert abs(float(client.status["energy_residual [J]"])) < 10.0
        states = decode_joints(client.received[ROLLER_STATES][-1])
        assert len(states.names) == 35
        assert states.effort[:32].max() > 15e3
        assert set(decode_truth(client.received[GROUND_TRUTH][-1]).faults) == ({fault} if fault else set())


def test_commands_take_effect_and_invalid_ones_are_refused(tmp_path: Path) -> None:
    from geometry_msgs.msg import Wrench
    from std_msgs.msg import Float64

    number = domain()
    with graph_client(number) as client, node("simulator", parameters(), environment(number), tmp_path / "log") as simulator:
        speed = client.node.create_publisher(Float64, "command/speed", 10)
        load = client.node.create_publisher(Wrench, "command/load", 10)
        client.connect(speed, load)
        for value in (float("nan"), float("inf"), 1e9, -1e300):
            speed.publish(Float64(data=value))
        for part, axis, value in (("force", "y", float("nan")), ("force", "z", 1.0), ("torque", "x", 1.0)):
            wrench = Wrench()
            setattr(getattr(wrench, part), axis, value)
            load.publish(wrench)

        def rejected() -> int:
            assert simulator.process.poll() is None, simulator.output
            if not client.received[BENCH_DIAGNOSTICS]:
                return 0
            return int(decode_diagnostics(client.received[BENCH_DIAGNOSTICS][-1])[1][0].values["rejected_commands"])

        client.until(lambda: rejected() == 7, "seven refusals")
        speed.publish(Float64(data=140.0))

        def taken() -> list[int]:
            truths = [decode_truth(data) for data in client.received[GROUND_TRUTH]]
            return [truth.time_ns for truth in truths if truth.event == SpeedCommand(140.0)]

        client.until(taken, "the command in the ground truth")
        client.until(lambda: decode_truth(client.received[GROUND_TRUTH][-1]).speed == pytest.approx(140.0), "the speed commanded")
        assert len(taken()) == 1
        assert "command/speed = nan rad/s is refused" in simulator.output
        assert simulator.output.count("is refused") <= 3  # explained once, not for every message


@pytest.mark.parametrize(("kind", "number_of_signals"), [(signal.SIGINT, 1), (signal.SIGTERM, 2)])
def test_signals_close_the_recording(kind: signal.Signals, number_of_signals: int, tmp_path: Path) -> None:
    number, bag = domain(), tmp_path / "bag"
    with (
        graph_client(number) as client,
        node("simulator", parameters(recording__path=bag, time_scale=0.0), environment(number), tmp_path / "log") as simulator,
    ):
        client.until(lambda: len(client.received[VIBRATION]) > 60, "sixty blocks")
        for _ in range(number_of_signals - 1):
            simulator.process.send_signal(kind)
        assert simulator.end(kind) == 0, simulator.output
        client.serve(0.1)
    recording = Recording(bag)
    recorded = {v.stamp_ns: v for v in recording.vibrations()}
    assert recording.complete
    for data in client.received[VIBRATION]:
        block = decode_vibration(data)
        assert np.array_equal(recorded[block.stamp_ns].acceleration, block.acceleration)  # the same bytes, published and recorded


@pytest.mark.parametrize("module", ["simulator", "fault_detector"])
def test_a_missing_middleware_ends_the_node_with_one_sentence(module: str, tmp_path: Path) -> None:
    env = environment(domain(), RMW_IMPLEMENTATION="rmw_absent_cpp")
    with node(module, [], env, tmp_path / "log") as started:
        assert started.process.wait(PATIENCE) == 2, started.output
    assert "RMW_IMPLEMENTATION = rmw_absent_cpp is not installed here" in started.output
    assert "Traceback" not in started.output


def test_the_detector_reads_its_parameter_file_in_any_namespace(tmp_path: Path) -> None:
    text = (Path(__file__).parents[2] / "config" / "detector.yaml").read_text()
    changed = tmp_path / "detector.yaml"
    changed.write_text(text.replace("window: 2.0", "window: -1.0"))
    for namespace in ("/dcrb", "/wagon/box1"):
        arguments = ["--ros-args", "--params-file", str(changed), "-r", f"__ns:={namespace}"]
        with node("fault_detector", arguments, environment(domain()), tmp_path / "log") as detector:
            assert detector.process.wait(PATIENCE) == 2, detector.output
        assert "window = -1.0 s is outside" in detector.output


UNCHECKED = """
import runpy, sys
import dcrb_ros.settings.configuration as configuration

configuration._housing = lambda _: iter(())  # the check that refuses so soft a housing
sys.argv[0] = "dcrb_ros.nodes"
runpy.run_module("dcrb_ros.nodes", run_name="__main__")
"""


def test_a_failed_model_ends_the_node() -> None:
    values = parameters(operating__load=1e7, housing__stiffness=1e6, cage__land_clearance=0.005)
    command = [sys.executable, "-c", UNCHECKED, "simulator", *values]
    done = subprocess.run(command, env=environment(domain()), capture_output=True, text=True, timeout=PATIENCE, check=False)
    output = done.stdout + done.stderr
    assert done.returncode == 1, output
    assert "the bench stopped: the model failed at" in output
    assert "Traceback" not in output


def test_bench_command_ends_with_the_verdict(tmp_path: Path) -> None:
    bag, story = tmp_path / "bench", tmp_path / "story.yaml"
    story.write_text("timeline: [{at: 0.5, set: {operating.load: 95000.0}}]")
    command = [*PROGRAM, "bench", "outer_ring_defect"]
    command += ["--duration", "5", "--record", str(bag), "--scenario", str(story)]
    done = subprocess.run(command, env=environment(domain()), capture_output=True, text=True, timeout=2 * PATIENCE, check=False)
    assert done.returncode == 0, done.stderr
    assert "verdict: outer_ring" in done.stdout
    recording = Recording(bag)
    assert sum(len(v.shaft_angle) for v in recording.vibrations()) == 5 * 51200
    for topic in (DIAGNOSIS, FAULT_INDICATORS):  # the detector makes one every half second, the last one of the last samples
        assert recording.counts()[f"/dcrb/{topic.name}"] == 10
    truths = [decode_truth(message.data) for message in recording.messages((GROUND_TRUTH,))]
    assert [t.time_ns for t in truths if t.event == ScenarioEvent({"operating.load": 95000.0})] == [500_000_000]
    assert truths[-1].load[1] == pytest.approx(-95e3)
    # The detector hears the signal from its first sample on: its window of 2 s is full at 2.0 s.
    first = next(recording.messages((DIAGNOSIS,)))
    assert decode_diagnostics(first.data)[0] <= 500_000_000


@pytest.mark.parametrize(("returncode", "status"), [(0, 0), (2, 2), (-signal.SIGINT, 0), (-signal.SIGKILL, 1)])
def test_a_simulator_that_had_to_be_killed_has_failed(returncode: int, status: int) -> None:
    """It may not have finished its recording; one that a signal ends before it handles signals has none."""
    assert bench._exit_status(returncode) == status


def processes(module: str, variable: str) -> list[str]:
    """Return the processes that run a module of this package with ``variable`` in their environment."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            command, variables = (process / "cmdline").read_bytes(), (process / "environ").read_bytes()
        except OSError:
            continue
        if module.encode() in command and variable.encode() in variables:
            found.append(process.name)
    return found


@contextmanager
def bench_at(moment: str, number: int, folder: Path, *arguments: str) -> Iterator[subprocess.Popen[bytes]]:
    """Run `dcrb bench` with its output in ``log`` and its temporary files in ``tmp`` until it prints ``moment``; yield the process."""
    log, temporary = folder / "log", folder / "tmp"
    temporary.mkdir()
    env = environment(number, TMPDIR=str(temporary))
    with log.open("wb") as output:
        bench = subprocess.Popen([*PROGRAM, "bench", "healthy", *arguments], env=env, stdout=output, stderr=subprocess.STDOUT)
    try:
        end = time.monotonic() + PATIENCE
        while moment not in log.read_text():
            assert time.monotonic() < end, log.read_text()
            assert bench.poll() is None, log.read_text()
            time.sleep(0.05)
        yield bench
    finally:
        bench.kill()
        bench.wait(PATIENCE)


@pytest.mark.parametrize(
    ("kind", "moment"), [(signal.SIGINT, "as ROS 2 nodes"), (signal.SIGHUP, "x real time"), (signal.SIGTERM, "x real time")]
)
def test_signals_to_the_bench_command_end_its_nodes(kind: signal.Signals, moment: str, tmp_path: Path) -> None:
    number, log = domain(), tmp_path / "log"
    with bench_at(moment, number, tmp_path) as bench:
        bench.send_signal(kind)
        assert bench.wait(PATIENCE) in (0, 1, 130), log.read_text()
        assert not processes("dcrb_ros.nodes", f"ROS_DOMAIN_ID={number}\0")
    assert "Traceback" not in log.read_text()


def test_a_bench_command_names_the_signal_that_killed_its_simulator(tmp_path: Path) -> None:
    number = domain()
    with bench_at("x real time", number, tmp_path) as bench:
        (simulator,) = processes("\0simulator\0", f"ROS_DOMAIN_ID={number}\0")
        os.kill(int(simulator), signal.SIGKILL)
        assert bench.wait(PATIENCE) == 1
    assert (tmp_path / "log").read_text().splitlines().count("the simulator was killed by signal 9 (Killed)") == 1


def test_a_killed_bench_command_leaves_neither_nodes_nor_files(tmp_path: Path) -> None:
    number, bag = domain(), tmp_path / "bag"
    with bench_at("x real time", number, tmp_path, "--record", str(bag)) as bench:
        wait_for(lambda: len(processes("dcrb_ros.nodes", f"ROS_DOMAIN_ID={number}\0")) == 2, PATIENCE)
        bench.kill()
        bench.wait(PATIENCE)
        wait_for(lambda: not processes("dcrb_ros.nodes", f"ROS_DOMAIN_ID={number}\0"), PATIENCE)
    assert not list((tmp_path / "tmp").iterdir())
    assert Recording(bag).complete


def test_no_sample_is_lost_to_the_listeners_that_are_waited_for(tmp_path: Path) -> None:
    number = domain()
    given = parameters(publishing__listeners=1, publishing__wait=PATIENCE)
    with node("simulator", given, environment(number), tmp_path / "log") as simulator:
        wait_for(lambda: "waiting for 1 subscriber" in simulator.output, PATIENCE)  # it is ready before anybody listens
        with graph_client(number) as client:
            client.until(lambda: len(client.received[VIBRATION]) > 20, "blocks")
            indices = [decode_vibration(data).first_index(51200) for data in client.received[VIBRATION]]
            assert indices[0] == 0
            assert np.all(np.diff(indices) == 1024)


def test_missing_listeners_are_reported_and_not_waited_for_any_longer(tmp_path: Path) -> None:
    given = ["--duration", "0.1", *parameters(publishing__listeners=2, publishing__wait=0.5)]
    with node("simulator", given, environment(domain()), tmp_path / "log") as simulator:
        assert simulator.process.wait(PATIENCE) == 0, simulator.output
    assert "0 of 2 subscribers to outer_ring/vibration have joined within 0.5 s" in simulator.output


def test_two_simulators_in_one_namespace_warn_of_each_other(tmp_path: Path) -> None:
    number = domain()
    with (
        node("simulator", parameters(), environment(number), tmp_path / "first") as first,
        node("simulator", parameters(), environment(number), tmp_path / "second") as second,
        graph_client(number) as client,
    ):
        warning = "/dcrb/simulator also publishes on /dcrb/outer_ring/vibration"
        client.until(lambda: all(warning in simulator.output for simulator in (first, second)), "both warnings")
        client.until(lambda: client.status["other_publishers"] == "/dcrb/simulator", "the status")


def test_malformed_commands_are_counted_and_the_bench_continues(tmp_path: Path) -> None:
    from geometry_msgs.msg import Wrench
    from std_msgs.msg import Float64

    number, bag = domain(), tmp_path / "bag"
    with (
        graph_client(number) as client,
        node("simulator", parameters(recording__path=bag), environment(number), tmp_path / "log") as simulator,
    ):
        speed = client.node.create_publisher(Float64, "command/speed", 10)
        load = client.node.create_publisher(Wrench, "command/load", 10)
        client.connect(speed, load)
        for data in GARBAGE:
            speed.publish(data)
            load.publish(data)
        client.until(lambda: client.status.get("rejected_commands") == str(2 * len(GARBAGE)), "the refusals")
        blocks = len(client.received[VIBRATION])
        speed.publish(Float64(data=140.0))
        client.until(lambda: decode_truth(client.received[GROUND_TRUTH][-1]).speed == pytest.approx(140.0), "the speed commanded")
        client.until(lambda: len(client.received[VIBRATION]) > blocks, "more blocks")
        assert simulator.end_promptly(signal.SIGINT) == 0, simulator.output
    assert "command/speed: a message of" in simulator.output
    assert "command/load: a message of" in simulator.output
    assert simulator.output.count("is not a valid") <= 4  # explained once, not for every message
    assert "Traceback" not in simulator.output
    assert Recording(bag).complete


def test_a_signal_ends_the_node_during_compilation(tmp_path: Path) -> None:
    from std_msgs.msg import Float64

    number, bag = domain(), tmp_path / "bag"
    env = environment(number, NUMBA_CACHE_DIR=str(tmp_path / "kernels"))
    with graph_client(number) as client, node("simulator", parameters(recording__path=bag), env, tmp_path / "log") as simulator:
        speed = client.node.create_publisher(Float64, "command/speed", 10)
        client.until(speed.get_subscription_count, "the simulator")
        client.until(lambda: "compiling the kernels" in simulator.output, "the compiler")
        client.until(lambda: client.status.get("model") == "starting", "the start in /diagnostics")
        client.reports(1)  # the first one may precede the compiler
        status = decode_diagnostics(client.received[BENCH_DIAGNOSTICS][-1])[1][0]
        assert (status.level, status.values["real_time_factor"]) == (WARN, "")
        assert status.message.startswith("compiling the kernels")
        assert simulator.end_promptly(signal.SIGTERM) == 0, simulator.output
        client.until(lambda: not processes("dcrb_ros.core.compilation", str(tmp_path)), "the end of the process that compiles with it")
    assert not client.received[VIBRATION]
    assert not bag.exists()  # a recording without a block is removed


def test_only_diagnoses_of_this_run_are_recorded(tmp_path: Path) -> None:
    number, bag = domain(), tmp_path / "bag"
    early, good, late = (Diagnosis(0, seconds, "healthy", "test") for seconds in (-1.0, 0.01, 1e6))
    with (
        graph_client(number) as client,
        node("simulator", parameters(recording__path=bag), environment(number), tmp_path / "log") as simulator,
    ):
        publishers = [client.node.create_publisher(message_class(topic), topic.name, qos(topic)) for topic in (DIAGNOSIS, FAULT_INDICATORS)]
        client.connect(*publishers, count=2)  # the simulator and the listener itself
        for publisher, encode in zip(publishers, (encode_diagnosis, encode_indicators), strict=True):
            for data in (*GARBAGE, encode(early), encode(good), encode(late)):  # the refusal of the last one follows all the others
                publisher.publish(data)

        def rejected() -> str:
            assert simulator.process.poll() is None, simulator.output
            return client.status.get("rejected_messages", "")

        client.until(lambda: rejected() == str(2 * (len(GARBAGE) + 2)), "the refusals")
        assert client.status["rejected_commands"] == "0"
        assert simulator.end(signal.SIGINT) == 0, simulator.output
    assert "diagnosis: a message of" in simulator.output
    assert simulator.output.count("[WARN]") <= 4  # explained once, not for every message
    recording = Recording(bag)
    assert recording.complete
    assert recording.counts()["/dcrb/diagnosis"] == 1
    assert recording.counts()["/dcrb/fault_indicators"] == 1


def test_the_detector_survives_malformed_messages(tmp_path: Path) -> None:
    number = domain()
    endless = '{"sampling_rate": Infinity, "orders": {"FTF": 1, "BPFO": 1, "BPFI": 1, "BSF": 1}}'
    with graph_client(number) as client, node("fault_detector", [], environment(number), tmp_path / "log") as detector:
        # The description last: the detector has discovered the other publisher when it answers the description.
        publishers = [client.node.create_publisher(message_class(topic), topic.name, qos(topic)) for topic in (VIBRATION, SENSOR)]
        client.until(lambda: all(p.get_subscription_count() == 2 for p in publishers), "the detector")
        vibration, sensor = publishers
        sensor.publish(encode_text(endless))
        client.until(lambda: "Infinity is not a finite number" in detector.output, "the refusal of the rate")
        for data in GARBAGE:
            vibration.publish(data)
        sensor.publish(GARBAGE[3])
        client.until(lambda: "2 so far" in detector.output, "the refusal of the bytes")
        assert detector.end_promptly(signal.SIGINT) == 0, detector.output
    assert "Traceback" not in detector.output
    assert "a callback failed" not in detector.output


def test_failing_callback_does_not_end_the_node(capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    import rclpy

    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain()))
    monkeypatch.delenv("DCRB_DEBUG", raising=False)
    stop, end, calls = threading.Event(), time.monotonic() + PATIENCE, 0

    def fail() -> None:
        nonlocal calls
        calls += 1
        if calls == 5:
            stop.set()
        raise KeyError("absent")

    rclpy.init(args=[])
    try:
        failing = rclpy.create_node("failing")
        failing.create_timer(0.001, fail)
        spin(failing, lambda: time.monotonic() > end, stop)
        failing.destroy_node()
    finally:
        rclpy.try_shutdown()
    words = capfd.readouterr().err
    assert calls == 5
    assert [words.count(f"a callback failed ({n} so far") for n in range(1, 6)] == [1, 1, 0, 1, 0]
    assert "KeyError: 'absent'" in words


class FakeNode:
    """Keeps the callbacks of subscriptions, without ROS."""

    def __init__(self) -> None:
        self.callbacks: dict[str, Any] = {}

    def create_subscription(self, kind: Any, name: str, callback: Any, quality: Any, *, raw: bool) -> None:
        assert raw
        self.callbacks[name] = callback


def test_the_observer_ignores_foreign_messages() -> None:
    fake, observer = FakeNode(), Observer()
    observer.subscribe(fake)
    foreign = encode_diagnostics(0, [Status("battery", OK, "full", {})])
    nothing = encode_diagnostics(0, [])
    joints = encode_joints(0, ["elbow"], np.zeros(1), np.zeros(0), np.zeros(0))
    for data in GARBAGE:
        for name in ("diagnosis", "/diagnostics", "outer_ring/features"):
            fake.callbacks[name](data)
    for name, data in (("diagnosis", foreign), ("diagnosis", nothing), ("outer_ring/features", joints)):
        fake.callbacks[name](data)
    assert observer.refused == 3 * len(GARBAGE) + 3
    for data in (foreign, nothing):  # others may report there
        fake.callbacks["/diagnostics"](data)
    assert observer.refused == 3 * len(GARBAGE) + 3
    assert (observer.verdict, observer.bench, observer.features) == (None, None, None)
    assert observer.line() == "waiting for the first block ..."
    fake.callbacks["diagnosis"](encode_diagnosis(Diagnosis(0, 1.0, "healthy", "test")))
    assert observer.verdict is not None
    assert observer.verdict.message == "healthy"


@pytest.mark.parametrize(("factor", "pace"), [("", []), ("0.998", ["0.998 x real time, 3 late"])])
def test_the_pace_is_shown_once_there_is_one(factor: str, pace: list[str]) -> None:
    fake, observer = FakeNode(), Observer()
    observer.subscribe(fake)
    status = Status("/dcrb/simulator", OK, "running", {"real_time_factor": factor, "late_blocks": "3"})
    fake.callbacks["/diagnostics"](encode_diagnostics(0, [status]))
    assert observer.pace() == pace
