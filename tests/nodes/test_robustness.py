"""Arbitrary input, slow subscribers and signals: the bench continues, and ends when it is asked to."""

from __future__ import annotations

import math
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

pytest.importorskip("rclpy", reason="the nodes need ROS 2; everything else is tested without")

from node_arguments import GARBAGE, parameters
from ros_bench import PATIENCE, GraphClient, domain, environment, graph_client, node

from dcrb_ros.messages.points import decode_vibration
from dcrb_ros.messages.statuses import decode_truth
from dcrb_ros.messages.topics import BENCH_DIAGNOSTICS, GROUND_TRUTH, VIBRATION
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.settings.files import parameter_fields

pytestmark = [pytest.mark.node, pytest.mark.slow]
ROOT = Path(__file__).parents[2]

ODD = st.sampled_from([math.nan, math.inf, -math.inf, 5e-324, -0.0, 1e308, -1e308, 1e4, 0.0, 100.0, 0.002])
NUMBERS = st.one_of(ODD, st.floats(width=64))
KEYS = st.one_of(st.sampled_from([field.key for field in parameter_fields()]), st.text("abc._/ é", min_size=1, max_size=20))
VALUES = st.one_of(
    NUMBERS, st.booleans(), st.integers(-(2**63), 2**63 - 1), st.text("row1/ba,5\n", max_size=12), st.lists(NUMBERS, max_size=3)
)
ACTIONS = st.lists(
    st.one_of(
        st.tuples(st.just("speed"), NUMBERS),
        st.tuples(st.just("load"), NUMBERS, NUMBERS),
        st.tuples(st.just("garbage"), st.sampled_from(GARBAGE)),
        st.tuples(st.just("set"), st.dictionaries(KEYS, VALUES, min_size=1, max_size=3)),
        st.tuples(st.just("pause"), st.booleans()),
        st.tuples(st.just("step")),
        st.tuples(st.just("reset")),
        st.tuples(st.just("record"), st.booleans()),
    ),
    max_size=9,
)


class Sender:
    """Sends anything that a bench can receive."""

    def __init__(self, client: GraphClient) -> None:
        from geometry_msgs.msg import Wrench
        from std_msgs.msg import Float64

        self.client = client
        self.refused = {"parameters": 0, "calls": 0}
        self._speed = client.node.create_publisher(Float64, "command/speed", 100)
        self._load = client.node.create_publisher(Wrench, "command/load", 100)
        client.connect(self._speed, self._load)

    def send(self, kind: str, *values: Any) -> None:
        from geometry_msgs.msg import Wrench
        from std_msgs.msg import Float64
        from std_srvs.srv import SetBool, Trigger

        if kind == "speed":
            self._speed.publish(Float64(data=values[0]))
        elif kind == "load":
            wrench = Wrench()
            wrench.force.x, wrench.force.y = values
            self._load.publish(wrench)
        elif kind == "garbage":
            self._speed.publish(values[0])
        elif kind == "set":
            self.refused["parameters"] += not self._set(values[0])
        else:
            request = (SetBool, {"data": values[0]}) if values else (Trigger, {})
            self.refused["calls"] += not self.client.ask(request[0], kind, **request[1]).success

    def _set(self, values: dict[str, Any]) -> bool:
        from rcl_interfaces.srv import SetParametersAtomically
        from rclpy.parameter import Parameter

        kinds = {bool: Parameter.Type.BOOL, int: Parameter.Type.INTEGER, float: Parameter.Type.DOUBLE, str: Parameter.Type.STRING}
        wanted = [
            Parameter(key, kinds.get(type(value), Parameter.Type.DOUBLE_ARRAY), value).to_parameter_msg() for key, value in values.items()
        ]
        found = self.client.ask(SetParametersAtomically, "simulator/set_parameters_atomically", parameters=wanted).result
        assert found.successful or found.reason
        assert len(found.reason) <= 400
        return bool(found.successful)


def test_the_bench_continues_after_any_input(tmp_path: Path) -> None:
    from std_srvs.srv import SetBool

    number = domain()
    values = {"recording__path": tmp_path / "bag", "publishing__block_size": 2048, "time_scale": 1.0}
    with graph_client(number) as client, node("simulator", parameters(**values), environment(number), tmp_path / "log") as simulator:
        client.until(lambda: client.received[VIBRATION], "the first block")
        sender = Sender(client)

        @settings(max_examples=25, suppress_health_check=list(HealthCheck), database=None)
        @given(ACTIONS)
        def fuzz(actions: list[tuple[Any, ...]]) -> None:
            for action in actions:
                sender.send(*action)
                assert simulator.process.poll() is None, simulator.output

        fuzz()
        assert client.ask(SetBool, "pause", data=False).success
        assert client.set(time_scale=1.0)[0]
        blocks = len(client.received[VIBRATION])
        client.until(lambda: len(client.received[VIBRATION]) > blocks + 10, "blocks after the storm")
        client.reports(1)
        said = client.status
        assert said["model"] == "running"
        assert {key: int(said[f"rejected_{key}"]) for key in sender.refused} == sender.refused
        assert "Traceback" not in simulator.output
        assert "a callback failed" not in simulator.output
        assert simulator.output.count("[WARN]") <= 20  # each kind at its first, tenth and hundredth refusal
        assert simulator.end(signal.SIGINT) == 0, simulator.output
    for bag in tmp_path.glob("bag*"):
        recording = Recording(bag)
        stamps = [message.time_ns for message in recording.messages((VIBRATION,))]
        assert recording.complete
        assert stamps == sorted(stamps)


def test_a_repeated_refusal_is_rarely_logged(tmp_path: Path) -> None:
    number = domain()
    with graph_client(number) as client, node("simulator", parameters(), environment(number), tmp_path / "log") as simulator:
        client.until(lambda: client.received[VIBRATION], "the first block")
        sender = Sender(client)

        def rejected() -> int:
            for _ in range(5):  # the queue holds ten; some of a flood are lost
                sender.send("speed", math.nan)
            return int(client.status.get("rejected_commands", "0"))

        client.until(lambda: rejected() >= 200, "200 refusals")
        assert 1 <= simulator.output.count("is refused") <= 4
        assert client.received[VIBRATION]


def span(client: GraphClient, seconds: float) -> float:
    """Return the wall time that simulated ``seconds`` take from now on [s]."""
    began, first = time.monotonic(), decode_vibration(client.received[VIBRATION][-1]).stamp_ns
    client.until(lambda: decode_vibration(client.received[VIBRATION][-1]).stamp_ns >= first + seconds * 1e9, f"{seconds} s of blocks")
    return time.monotonic() - began


def test_a_slow_subscriber_does_not_slow_the_bench(tmp_path: Path) -> None:
    number = domain()
    code = (
        "import rclpy; from sensor_msgs.msg import PointCloud2\n"
        "rclpy.init(); n = rclpy.create_node('slow', namespace='dcrb')\n"
        "n.create_subscription(PointCloud2, 'outer_ring/vibration', lambda m: print('received', flush=True), 200)\n"
        "rclpy.spin(n)"
    )
    slow = subprocess.Popen([sys.executable, "-c", code], env=environment(number), stdout=subprocess.PIPE, text=True)
    try:
        # At half the speed, blocks that the middleware sends once more, three seconds later, are still in the queue of their publisher.
        given = parameters(time_scale=0.5)
        with graph_client(number) as client, node("simulator", given, environment(number), tmp_path / "log"):
            assert slow.stdout is not None
            assert slow.stdout.readline() == "received\n"
            client.until(lambda: len(client.received[BENCH_DIAGNOSTICS]) >= 2, "reports")
            before = span(client, 3.0)
            slow.send_signal(signal.SIGSTOP)  # it stays connected but acknowledges and reads nothing
            took = span(client, 6.0)  # more than its queue holds
            indices = [decode_vibration(data).first_index(51200) for data in client.received[VIBRATION]]
            assert np.all(np.diff(indices) == 1024)
            slow.send_signal(signal.SIGCONT)
            after = span(client, 3.0)
            assert took < 4.0 * max(before, after) + 1.0  # as fast as before or after, with a margin for a busy machine
    finally:
        slow.kill()
        slow.wait(PATIENCE)


@pytest.mark.parametrize("kind", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize(
    "values",
    [{}, {"time_scale": 1e-5, "publishing__listeners": 1, "publishing__wait": PATIENCE}, {"time_scale": 0.0}],
    ids=["running", "in a long wait", "flat out"],
)
def test_signals_end_the_node_at_once(kind: signal.Signals, values: dict[str, float], tmp_path: Path) -> None:
    number, bag = domain(), tmp_path / "bag"
    given_values = {**values, "recording__path": bag}
    with graph_client(number) as client, node("simulator", parameters(**given_values), environment(number), tmp_path / "log") as simulator:
        client.until(lambda: client.received[VIBRATION], "the first block")
        assert simulator.end_promptly(kind) == 0, simulator.output
    assert Recording(bag).complete


def test_discovery_stays_on_this_machine(tmp_path: Path) -> None:
    env = environment(domain())
    del env["ROS_AUTOMATIC_DISCOVERY_RANGE"]
    code = (
        "import os, rclpy.node as r; begin = r.Node.__init__\n"
        "def report(*a, **k): print('range', os.environ.get('ROS_AUTOMATIC_DISCOVERY_RANGE'), flush=True); raise SystemExit(0)\n"
        "r.Node.__init__ = report\n"
        "import sys; from dcrb_ros.nodes import {module}; {module}.run([])"
    )
    for module in ("simulator", "fault_detector"):
        for asked, found in ((None, "LOCALHOST"), ("SUBNET", "SUBNET")):
            wanted = env if asked is None else {**env, "ROS_AUTOMATIC_DISCOVERY_RANGE": asked}
            done = subprocess.run(
                [sys.executable, "-c", code.format(module=module)],
                env=wanted,
                capture_output=True,
                text=True,
                timeout=PATIENCE,
                check=False,
            )
            assert f"range {found}" in done.stdout, done.stderr


def test_the_example_turns_blocks_into_numpy(tmp_path: Path) -> None:
    number, example = domain(), Path(__file__).parents[2] / "examples" / "subscriber.py"
    with graph_client(number) as client, node("simulator", parameters(), environment(number), tmp_path / "log"):
        client.until(lambda: client.received[VIBRATION], "a block")
        subscriber = subprocess.Popen([sys.executable, str(example)], env=environment(number), stdout=subprocess.PIPE, text=True)
        try:
            assert subscriber.stdout is not None
            assert re.fullmatch(r" *\d+\.\d{3} s  1024 samples  rms +\d+\.\d m/s\^2\n", subscriber.stdout.readline())
            subscriber.send_signal(signal.SIGINT)
            assert subscriber.wait(PATIENCE) == 0
        finally:
            subscriber.kill()


def test_the_example_commands_the_bench(tmp_path: Path) -> None:
    number, example = domain(), ROOT / "examples" / "control.py"
    with (
        graph_client(number) as client,
        node("fault_detector", [], environment(number), tmp_path / "detector.log"),
        node("simulator", parameters(), environment(number), tmp_path / "log"),
    ):
        client.until(lambda: client.received[VIBRATION], "a block")
        control = subprocess.Popen([sys.executable, str(example)], env=environment(number), stdout=subprocess.PIPE, text=True)
        try:
            client.until(lambda: control.poll() is not None, "the end of the example")
            assert control.stdout is not None
            lines = control.stdout.read().splitlines()
        finally:
            control.kill()
            control.wait(PATIENCE)
        client.until(lambda: decode_truth(client.received[GROUND_TRUTH][-1]).speed > 139.0, "the speed")
        client.until(lambda: "outer_1" in decode_truth(client.received[GROUND_TRUTH][-1]).faults, "the fault")
    words = ("paused at", '{"acceleration_unit"', "one block further", "the fault is accepted", "running from")
    assert [line.startswith(word) for line, word in zip(lines, words, strict=False)] == [True] * 5, lines
    assert lines[5] in {"waiting", "healthy", "outer_ring"}


def test_the_example_that_waits_for_a_bench_ends_at_ctrl_c(tmp_path: Path) -> None:
    number, example = domain(), ROOT / "examples" / "control.py"
    with graph_client(number) as client:
        control = subprocess.Popen([sys.executable, str(example)], env=environment(number), stderr=subprocess.PIPE, text=True)
        try:
            client.until(lambda: "control" in client.node.get_node_names(), "the node of the example")
            control.send_signal(signal.SIGINT)
            assert control.communicate(timeout=PATIENCE)[1] == "stopped\n"
            assert control.returncode == 1
        finally:
            control.kill()
            control.wait(PATIENCE)


DURING_IMPORT = """
import importlib, os, signal
from dcrb_ros.nodes import programs

imported = importlib.import_module

def interrupted(*arguments, **named):
    os.kill(os.getpid(), signal.SIGINT)
    return imported(*arguments, **named)

importlib.import_module = interrupted
programs.{program}()
"""


@pytest.mark.parametrize("program", ["simulator", "fault_detector", "replayer", "viewer"])
def test_a_program_interrupted_during_its_import_ends_without_output(program: str, tmp_path: Path) -> None:
    bag = ROOT / "bags" / "healthy"
    values = {"simulator": ["-p", f"recording.path:={tmp_path / 'bag'}"], "replayer": ["-p", f"bag:={bag}"]}
    command = [sys.executable, "-c", DURING_IMPORT.format(program=program), "--ros-args", *values.get(program, [])]
    done = subprocess.run(command, env=environment(domain()), capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert not list(tmp_path.iterdir())


AT_AN_IMPORT = """
import os, signal, sys
from dcrb_ros.nodes import programs

imports = 0

def interrupt(event, arguments):
    global imports
    imports += event == "import"
    if event == "import" and imports == {number}:
        os.kill(os.getpid(), signal.SIGINT)

sys.addaudithook(interrupt)
programs.{program}()
"""


@pytest.mark.parametrize("program", ["simulator", "fault_detector"])
@pytest.mark.parametrize("number", [1, 2, 5, 20, 100, 300, 1000])
def test_an_interrupt_at_any_import_leaves_no_output(program: str, number: int, tmp_path: Path) -> None:
    command = [sys.executable, "-c", AT_AN_IMPORT.format(program=program, number=number), "--ros-args", "--params-file", "none"]
    done = subprocess.run(command, env=environment(domain()), cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE, check=False)
    ended = f"{program}: --params-file none: there is no such file" in done.stderr  # after the imports
    assert (done.returncode, done.stderr if not ended else "") == (2 if ended else 0, "")


def test_no_signal_is_unhandled_while_modules_of_the_library_load() -> None:
    code = "import sys; before = set(sys.modules); import dcrb_ros.nodes.programs; print(sorted(set(sys.modules) - before))"
    loaded = subprocess.run([sys.executable, "-S", "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=PATIENCE, check=True)
    assert "threading" not in loaded.stdout
    assert "contextlib" not in loaded.stdout
    assert "typing" not in loaded.stdout
