"""Simulator and fault detector as real nodes in separate processes, over DDS."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="the nodes need ROS 2; everything else is tested without")

from ros_bench import PATIENCE, domain, environment, listener, node

from dcrb_ros.configuration import Configuration
from dcrb_ros.messages import decode_diagnostics, decode_joints, decode_text, decode_truth, decode_vibration
from dcrb_ros.recording import Recording
from dcrb_ros.simulation import Simulation
from dcrb_ros.topics import (
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

pytestmark = pytest.mark.node


def parameters(**values: object) -> list[str]:
    return ["--ros-args", *(word for key, value in values.items() for word in ("-p", f"{key.replace('__', '.')}:={value}"))]


@pytest.mark.parametrize(("fault", "verdict"), [("outer_1", "outer_ring"), ("inner_1", "inner_ring"), ("", "healthy")])
def test_detector_names_the_fault_over_dds(fault: str, verdict: str, tmp_path: Path) -> None:
    number = domain()
    faulty = {f"faults__{fault}__width": 0.002} if fault else {}
    with (
        listener(number) as heard,
        node("fault_detector", [], environment(number), tmp_path / "detector.log") as detector,
        node("simulator", parameters(**faulty), environment(number), tmp_path / "simulator.log") as simulator,
    ):

        def judged() -> list[str]:
            assert detector.process.poll() is None, detector.words
            assert simulator.process.poll() is None, simulator.words
            found = [decode_diagnostics(data)[1][0].message for data in heard.heard[DIAGNOSIS]]
            return [word for word in found if word != "waiting"]

        heard.until(lambda: len(judged()) >= 3, "three verdicts")
        assert set(judged()) == {verdict}
        for topic in (SENSOR, VIBRATION, ACCELERATION, FEATURES, ROLLER_STATES, GROUND_TRUTH, FAULT_INDICATORS, BENCH_DIAGNOSTICS):
            assert heard.heard[topic], topic.name
        about = json.loads(decode_text(heard.heard[SENSOR][0]))
        indices = [decode_vibration(data).first_index(about["sampling_rate"]) for data in heard.heard[VIBRATION]]
        assert np.all(np.diff(indices) == about["block_size"])  # nothing is dropped
        states = decode_joints(heard.heard[ROLLER_STATES][-1])
        assert len(states.names) == 35
        assert states.effort[:32].max() > 15e3
        assert set(decode_truth(heard.heard[GROUND_TRUTH][-1]).faults) == ({fault} if fault else set())


def test_commands_take_effect_and_bad_ones_are_refused(tmp_path: Path) -> None:
    from geometry_msgs.msg import Wrench
    from std_msgs.msg import Float64

    number = domain()
    with listener(number) as heard, node("simulator", parameters(), environment(number), tmp_path / "log") as simulator:
        speed = heard.node.create_publisher(Float64, "command/speed", 10)
        load = heard.node.create_publisher(Wrench, "command/load", 10)
        heard.until(lambda: heard.heard[VIBRATION] and speed.get_subscription_count() and load.get_subscription_count(), "the simulator")
        for value in (float("nan"), float("inf"), 1e9, -1e300):
            speed.publish(Float64(data=value))
        wrench = Wrench()
        wrench.force.y = float("nan")
        load.publish(wrench)

        def rejected() -> int:
            assert simulator.process.poll() is None, simulator.words
            if not heard.heard[BENCH_DIAGNOSTICS]:
                return 0
            return int(decode_diagnostics(heard.heard[BENCH_DIAGNOSTICS][-1])[1][0].values["rejected_commands"])

        heard.until(lambda: rejected() == 5, "five refusals")
        speed.publish(Float64(data=140.0))

        def obeyed() -> list[int]:
            truths = [decode_truth(data) for data in heard.heard[GROUND_TRUTH]]
            return [truth.time_ns for truth in truths if truth.changed == "command/speed 140.0 rad/s"]

        heard.until(obeyed, "the command in the ground truth")
        heard.until(lambda: decode_truth(heard.heard[GROUND_TRUTH][-1]).speed == pytest.approx(140.0), "the speed commanded")
        assert len(obeyed()) == 1
        assert "command/speed = nan rad/s is refused" in simulator.words
        assert simulator.words.count("is refused") <= 3  # explained, not repeated


@pytest.mark.parametrize("number_of_signals", [1, 2])
@pytest.mark.parametrize("kind", [signal.SIGINT, signal.SIGTERM])
def test_signals_close_the_recording(kind: signal.Signals, number_of_signals: int, tmp_path: Path) -> None:
    number, bag = domain(), tmp_path / "bag"
    with (
        listener(number) as heard,
        node("simulator", parameters(recording__path=bag, time_scale=0.0), environment(number), tmp_path / "log") as simulator,
    ):
        heard.until(lambda: len(heard.heard[VIBRATION]) > 60, "sixty blocks")
        for _ in range(number_of_signals - 1):
            simulator.process.send_signal(kind)
        assert simulator.end(kind) == 0, simulator.words
        heard.executor.spin_once(timeout_sec=0.1)
    recording = Recording(bag)
    recorded = {v.stamp_ns: v for v in recording.vibrations()}
    assert recording.complete
    for data in heard.heard[VIBRATION]:
        block = decode_vibration(data)
        assert np.array_equal(recorded[block.stamp_ns].acceleration, block.acceleration)  # the same bytes, published and recorded


def test_samples_do_not_depend_on_the_time_scale(tmp_path: Path) -> None:
    expected = np.concatenate([block.acceleration for block in Simulation(Configuration()).blocks(0.5)])
    for scale in (0.5, 0.0):
        bag = tmp_path / f"scale{scale}"
        arguments = ["--duration", "0.5", *parameters(recording__path=bag, time_scale=scale, publishing__block_size=700)]
        with node("simulator", arguments, environment(domain()), tmp_path / "log") as simulator:
            assert simulator.process.wait(PATIENCE) == 0, simulator.words
        assert np.array_equal(np.concatenate([v.acceleration for v in Recording(bag).vibrations()]), expected)


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"bearing__roler_radius": 0.015}, "did you mean 'bearing.roller_radius'?"),
        ({"bearing__roller_radius": 15.0}, "did you mean 0.015?"),
        ({"operating__speed": 1772}, "write 1772.0"),
        ({"cage__joint": "welded"}, "is not one of revolute"),
    ],
)
def test_wrong_parameters_end_with_a_sentence(values: dict[str, object], sentence: str, tmp_path: Path) -> None:
    with node("simulator", parameters(**values), environment(domain()), tmp_path / "log") as simulator:
        assert simulator.process.wait(PATIENCE) == 2, simulator.words
    assert sentence in simulator.words
    assert "Traceback" not in simulator.words


@pytest.mark.parametrize("module", ["simulator", "fault_detector"])
def test_absent_middleware_ends_with_a_sentence(module: str, tmp_path: Path) -> None:
    env = environment(domain(), RMW_IMPLEMENTATION="rmw_absent_cpp")
    with node(module, [], env, tmp_path / "log") as started:
        assert started.process.wait(PATIENCE) == 2, started.words
    assert "RMW_IMPLEMENTATION = rmw_absent_cpp is not installed here" in started.words
    assert "Traceback" not in started.words


def test_existing_recording_is_refused(tmp_path: Path) -> None:
    with node("simulator", parameters(recording__path=tmp_path), environment(domain()), tmp_path / "log") as simulator:
        assert simulator.process.wait(PATIENCE) == 2, simulator.words
    assert "a recording is never overwritten" in simulator.words


def test_dead_model_ends_the_node(tmp_path: Path) -> None:
    values = {"operating__load": 1e7, "housing__stiffness": 1e6}
    with node("simulator", parameters(**values), environment(domain()), tmp_path / "log") as simulator:
        assert simulator.process.wait(PATIENCE) == 1, simulator.words
    assert "the bench stopped: the model failed at" in simulator.words
    assert "Traceback" not in simulator.words


def test_bench_command_ends_with_the_verdict(tmp_path: Path) -> None:
    bag = tmp_path / "bench"
    command = [sys.executable, "-c", "from dcrb_ros.cli.app import main; main()", "bench", "outer_ring_defect"]
    command += ["--duration", "5", "--record", str(bag)]
    done = subprocess.run(command, env=environment(domain()), capture_output=True, text=True, timeout=2 * PATIENCE, check=False)
    assert done.returncode == 0, done.stderr
    assert "verdict: outer_ring" in done.stdout
    recording = Recording(bag)
    assert sum(len(v.shaft_angle) for v in recording.vibrations()) == 5 * 51200
    assert recording.counts()["/dcrb/diagnosis"] > 3


def test_time_scale_changes_while_running(tmp_path: Path) -> None:
    from rcl_interfaces.srv import SetParameters
    from rclpy.parameter import Parameter

    number = domain()
    with listener(number) as heard, node("simulator", parameters(time_scale=0.25), environment(number), tmp_path / "log"):
        client = heard.node.create_client(SetParameters, "simulator/set_parameters")
        heard.until(lambda: client.service_is_ready() and heard.heard[VIBRATION], "the parameter service")

        def ask(value: float) -> tuple[bool, str]:
            future = client.call_async(SetParameters.Request(parameters=[Parameter("time_scale", value=value).to_parameter_msg()]))
            heard.until(future.done, "the answer")
            result = future.result().results[0]
            return result.successful, result.reason

        assert not ask(-1.0)[0]
        assert ask(0.5) == (True, "")

        def asked() -> str:
            return (
                decode_diagnostics(heard.heard[BENCH_DIAGNOSTICS][-1])[1][0].values["time_scale"] if heard.heard[BENCH_DIAGNOSTICS] else ""
            )

        heard.until(lambda: asked() == "0.5", "the new time scale in /diagnostics")
