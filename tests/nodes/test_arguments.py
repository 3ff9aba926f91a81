"""Arguments of nodes that are refused before the node does anything, and the first lines of their logs."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="the nodes need ROS 2; everything else is tested without")

from ros_bench import PATIENCE, domain, environment, node
from waiting import wait_for

from dcrb_ros.nodes.ros import check_domain

pytestmark = [pytest.mark.node, pytest.mark.slow]


BAG = Path(__file__).parents[2] / "bags" / "healthy"


@pytest.mark.parametrize(
    ("command", "sentence"),
    [
        ("simulator --ros-args -p time_scale:=0.0 --duration 1", "'--duration 1' follows --ros-args but is no argument of ROS"),
        ("simulator --ros-args --params-file missing.yaml", "--params-file missing.yaml: there is no such file"),
        ("replayer --ros-args --params-file missing.yaml", "--params-file missing.yaml: there is no such file"),
        ("fault_detector --ros-args --params-file /dev/zero", "/dev/zero is a device: give a regular file"),
        ("fault_detector --ros-args --params-file nothing.yaml", "Couldn't parse params file: '--params-file nothing.yaml'"),
        ("hot_box_detector --ros-args -p learn", "Couldn't parse parameter override rule"),
        ("fault_detector --ros-args -p window:=[]", "fault_detector: parameters: window has no value, as an empty list: give one, or"),
        ("simulator --ros-args -p time_scale:=[]", "simulator: parameters: time_scale has no value, as an empty list: give one, or"),
        ("simulator --ros-args -p recording.topics:=ground_thruth", "recording.topics: there is no topic 'ground_thruth'; did you mean"),
        ("simulator --ros-args -p bearing.roler_radius:=0.015", "did you mean 'bearing.roller_radius'?"),
        ("simulator --ros-args -p operating.speed:=1772", "is outside -1000 .. 1000 rad/s"),
        ("simulator --duration nan", "--duration nan s is not a finite number"),
        ("simulator --scenario nowhere", "there is no scenario 'nowhere': give a YAML file or one of bogie_ride, braking, burn_off"),
        ("vehicle_simulator", "there is no vehicle: give --vehicle"),
        ("vehicle_simulator --vehicle no_such", "there is no vehicle 'no_such'"),
        ("vehicle_simulator --vehicle bogie --ros-args -p vehicle.speed_kmh:=1.0", "speed_kmh = 1.0"),
        ("vehicle_simulator --vehicle bogie --ros-args -p axle_1.left.faults.outer_1.widht:=0.002", "widht"),
        ("viewer --save view.rrd --ros-args -p window:=1.0", "viewer: parameters: unknown parameter 'window'"),
        ("viewer --connect nonsense", "--connect nonsense is not the address of a viewer"),
        ("viewer --connect rerun+http://127.0.0.1:1/proxy", "no viewer answers at 127.0.0.1:1"),
        ("viewer --connect rerun+http://127.0.0.1:99999/proxy", "is not the address of a viewer"),
        (f"simulator --duration 0.02 --ros-args -p recording.path:={'x' * 300}", "x cannot be used: File name too long; give another path"),
        ("simulator --duration 1 --scenario late.yaml", "simulator: the scenario late.yaml changes nothing in a run of 1 s, its first"),
        (
            "vehicle_simulator --vehicle bogie --duration 1 --scenario ride.yaml",
            "vehicle_simulator: the scenario ride.yaml changes nothing in a run of 1 s, its first entry is at 1 s: increase --duration or",
        ),
    ],
)
def test_an_argument_that_is_not_understood_is_refused_in_a_sentence(command: str, sentence: str, tmp_path: Path) -> None:
    (tmp_path / "nothing.yaml").write_text("not: [parameters", encoding="utf-8")
    (tmp_path / "late.yaml").write_text("timeline: [{at: 1.0, set: {operating.speed: 100.0}}]", encoding="utf-8")
    (tmp_path / "ride.yaml").write_text("timeline: [{at: 1.0, set: {vehicle.speed_kmh: 60.0}}]", encoding="utf-8")
    words = [sys.executable, "-m", "dcrb_ros.nodes", *command.split()]
    done = subprocess.run(words, env=environment(domain()), cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert done.returncode == 2, done.stderr
    assert sentence in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert " at /" not in done.stderr


@pytest.mark.parametrize("number", ["300", "-1", "seven", "0x100"])
@pytest.mark.parametrize("command", ["dcrb_ros.nodes simulator --duration 0.02", "dcrb_ros.cli.program bench dry --duration 0.02"])
def test_an_invalid_domain_is_refused_in_a_sentence(command: str, number: str) -> None:
    words = [sys.executable, "-m", *command.split()]
    env = {**environment(1), "ROS_DOMAIN_ID": number}
    done = subprocess.run(words, env=env, capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert (done.returncode, len(done.stderr.splitlines())) == (2, 1), done.stderr
    assert f"ROS_DOMAIN_ID = {number} is not a whole number within 0 .. 232: unset it" in done.stderr


@pytest.mark.parametrize("number", ["", "0", "232", " 7", "0x10", "010"])
def test_a_domain_that_ros_understands_is_taken(number: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", number)
    check_domain()


def test_a_bench_without_discovery_is_refused_in_a_sentence() -> None:
    words = [sys.executable, "-m", "dcrb_ros.cli.program", "bench", "dry", "--duration", "0.02"]
    env = environment(domain(), ROS_AUTOMATIC_DISCOVERY_RANGE="OFF")
    done = subprocess.run(words, env=env, capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert (done.returncode, len(done.stderr.splitlines())) == (2, 1), done.stderr
    assert "ROS_AUTOMATIC_DISCOVERY_RANGE = OFF hides the nodes of the bench from each other" in done.stderr


@pytest.mark.parametrize("name", ["", "simulato"])
def test_a_node_that_does_not_exist_is_wrong_usage(name: str) -> None:
    words = [sys.executable, "-m", "dcrb_ros.nodes", *name.split()]
    done = subprocess.run(words, capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith("usage: python -m dcrb_ros.nodes [--with-parent] {simulator,")


@pytest.mark.parametrize("name", ["simulator", "replayer", "fault_detector", "vehicle_detector", "hot_box_detector", "viewer"])
def test_an_unknown_word_is_refused(name: str) -> None:
    words = [sys.executable, "-m", "dcrb_ros.nodes", name, "speed", "--ros-args", "-p", f"bag:={BAG}"]
    done = subprocess.run(words, env=environment(domain()), capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert done.returncode == 2, done.stderr
    assert f"{name}: error: unrecognized arguments: speed" in done.stderr


@pytest.mark.parametrize(
    ("command", "sentence"),
    [
        ("fault_detector", "waiting for messages on /dcrb/outer_ring/sensor and /dcrb/outer_ring/vibration"),
        ("fault_detector --ros-args -r __ns:=/wagon/box2", "waiting for messages on /wagon/box2/outer_ring/sensor and"),
        ("fault_detector --managed", "waiting for the transition configure"),
        ("hot_box_detector", "waiting for messages on /dcrb/ground_truth"),
        ("viewer --save view.rrd", "waiting for messages on /dcrb/outer_ring/vibration"),
        ("simulator --ros-args -p publishing.listeners:=2", "waiting for 2 subscribers to outer_ring/vibration, at most"),
        (f"replayer --ros-args -p bag:={BAG} -p wait:=100.0", "waiting for 1 subscriber to outer_ring/vibration, at most 100 s"),
    ],
)
def test_a_node_says_what_it_waits_for(command: str, sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    name, *arguments = command.split()
    monkeypatch.chdir(tmp_path)
    with node(name, arguments, environment(domain()), tmp_path / "log") as started:
        wait_for(lambda: sentence in started.output, PATIENCE)
        assert started.end(signal.SIGINT) == 0
