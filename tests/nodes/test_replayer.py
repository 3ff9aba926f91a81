"""The replayer as a process: subscribers cannot distinguish it from the live bench."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="the nodes need ROS 2; everything else is tested without")

from altered_recording import altered
from made_up_blocks import recorded
from node_arguments import parameters
from ros_bench import PATIENCE, domain, environment, graph_client, node
from waiting import wait_for

from dcrb_ros.messages.points import decode_vibration
from dcrb_ros.messages.statuses import WARN, decode_diagnostics
from dcrb_ros.messages.topics import BENCH_DIAGNOSTICS, CLOCK, DIAGNOSIS, FEATURES, GROUND_TRUTH, ROLLER_STATES, SENSOR, VIBRATION
from dcrb_ros.nodes.publisher import message_class, qos
from dcrb_ros.recordings.reader import Recording

pytestmark = [pytest.mark.node, pytest.mark.slow]

BAGS = Path(__file__).parents[2] / "bags"


@pytest.mark.parametrize(("name", "verdict"), [("outer_ring_defect", "outer_ring"), ("inner_ring_defect", "inner_ring")])
def test_the_detector_diagnoses_a_replay_like_the_live_bench(name: str, verdict: str, tmp_path: Path) -> None:
    number = domain()
    with (
        graph_client(number) as client,
        node("fault_detector", [], environment(number), tmp_path / "detector.log") as detector,
    ):
        client.until(lambda: client.node.count_subscribers(VIBRATION.resolved("/dcrb")) >= 2, "the detector")
        given = parameters(bag=str(BAGS / name), rate=2.0, listeners=2, wait=PATIENCE)
        with node("replayer", given, environment(number), tmp_path / "replayer.log") as replayer:

            def verdicts() -> list[str]:
                assert detector.process.poll() is None, detector.output
                assert replayer.process.poll() in (None, 0), replayer.output
                found = [decode_diagnostics(data)[1][0].message for data in client.received[DIAGNOSIS]]
                return [word for word in found if word != "waiting"]

            client.until(lambda: len(client.received[VIBRATION]) == 150, "every block")
            client.until(verdicts, "a verdict")
            assert set(verdicts()) == {verdict}
            client.until(lambda: client.received[BENCH_DIAGNOSTICS], "a status of the replayer")
            # The same bytes in the same order; the middleware pads them to a multiple of four.
            for topic in (VIBRATION, FEATURES, ROLLER_STATES, GROUND_TRUTH):
                recording = [message.data + bytes(-len(message.data) % 4) for message in Recording(BAGS / name).messages((topic,))]
                client.until(lambda t=topic, expected=recording: len(client.received[t]) >= len(expected), topic.name)
                assert client.received[topic] == recording, topic.name
            # Of a latched topic, a subscriber that is slow may miss messages that were replaced.
            described = [message.data + bytes(-len(message.data) % 4) for message in Recording(BAGS / name).messages((SENSOR,))]
            client.until(lambda: client.received[SENSOR][-1] == described[-1], "the last description")
            assert set(client.received[SENSOR]) <= set(described)
            assert replayer.process.wait(PATIENCE) == 0
    assert decode_diagnostics(client.received[BENCH_DIAGNOSTICS][-1])[1][0].name == "/dcrb/replayer"


def test_the_command_says_once_that_a_recording_is_unverified() -> None:
    command = [sys.executable, "-c", "from dcrb_ros.cli.app import main; main()", "replay", str(BAGS / "outer_ring_defect")]
    options = ["--rate", "0", "--wait", "0"]
    done = subprocess.run([*command, *options], env=environment(domain()), capture_output=True, text=True, timeout=PATIENCE, check=True)
    assert done.stderr.count("unverified: no digest in manifest and outcome record") == 1


def test_node_and_command_warn_once_of_samples_that_do_not_match(tmp_path: Path) -> None:
    sentence = "the recording's samples do not match its own digest"
    bag = recorded(tmp_path / "bag", 20)
    for path, warnings in ((bag, 0), (altered(bag, tmp_path / "altered"), 1)):
        with node("replayer", parameters(bag=str(path), rate=0.0, wait=0.0), environment(domain()), tmp_path / "log") as replayer:
            assert replayer.process.wait(PATIENCE) == 0
            assert replayer.output.count(sentence) == warnings
        command = [sys.executable, "-c", "from dcrb_ros.cli.app import main; main()", "replay", str(path), "--rate", "0", "--wait", "0"]
        done = subprocess.run(command, env=environment(domain()), capture_output=True, text=True, timeout=PATIENCE, check=True)
        assert done.stderr.count(sentence) == warnings


def test_a_stopped_replay_does_not_read_the_rest_of_the_samples(tmp_path: Path) -> None:
    bag = altered(recorded(tmp_path / "bag", 20), tmp_path / "altered")
    command = [sys.executable, "-c", "from dcrb_ros.cli.app import main; main()", "replay", str(bag), "--wait", str(PATIENCE)]
    with subprocess.Popen(command, env=environment(domain()), stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        assert any("waiting for 1 subscriber" in line for line in process.stderr)
        process.send_signal(signal.SIGINT)
        _, output = process.communicate(timeout=PATIENCE)
    assert (process.returncode, output) == (0, "")


def test_a_replay_of_a_recording_that_was_cut_off_says_so_once(tmp_path: Path) -> None:
    bag = recorded(tmp_path / "bag", 20)
    file = bag / "bag_0.mcap"
    file.write_bytes(file.read_bytes()[:-200])  # a part of the summary
    with node("replayer", parameters(bag=str(bag), rate=0.0, wait=0.0), environment(domain()), tmp_path / "log") as replayer:
        assert replayer.process.wait(PATIENCE) == 0
        (said,) = (line for line in replayer.output.splitlines() if "[WARN]" in line and "reaches beyond the end of the file" in line)
        assert said.endswith(": the readable part is replayed")


def test_a_replay_waits_until_its_subscriber_knows_it(tmp_path: Path) -> None:
    bag, number = recorded(tmp_path / "bag", 20), domain()
    given = parameters(bag=str(bag), rate=0.0, listeners=1, wait=PATIENCE)
    with node("replayer", given, environment(number), tmp_path / "log") as replayer:
        wait_for(lambda: "waiting for 1 subscriber" in replayer.output, PATIENCE)  # it is ready before anybody listens
        with graph_client(number) as client:
            client.until(lambda: len(client.received[VIBRATION]) == 20, "every block")
            assert replayer.process.wait(PATIENCE) == 0, replayer.output


def test_a_replay_without_the_waveform_waits_for_a_subscriber_to_its_first_topic(tmp_path: Path) -> None:
    bag, number = recorded(tmp_path / "bag", 20), domain()
    given = parameters(bag=str(bag), rate=0.0, topics="outer_ring/features, ground_truth", listeners=2, wait=PATIENCE)
    with node("replayer", given, environment(number), tmp_path / "log") as replayer, graph_client(number) as client:

        def state() -> str:
            return decode_diagnostics(client.received[BENCH_DIAGNOSTICS][-1])[1][0].message

        client.until(lambda: state() == "waiting", "the status")
        assert "waiting for 2 subscribers to outer_ring/features" in replayer.output
        client.node.create_subscription(message_class(FEATURES), "outer_ring/features", lambda data: None, qos(FEATURES), raw=True)
        client.until(lambda: len(client.received[FEATURES]) == 20, "every message")
        assert replayer.process.wait(PATIENCE) == 0, replayer.output
    assert not client.received[VIBRATION]


def test_a_replay_keeps_the_recorded_pace_times_its_rate(tmp_path: Path) -> None:
    bag, number = recorded(tmp_path / "bag", 150), domain()
    with graph_client(number) as client:
        given = parameters(bag=str(bag), rate=2.0, listeners=1, wait=PATIENCE)
        with node("replayer", given, environment(number), tmp_path / "log") as replayer:
            client.until(lambda: len(client.received[VIBRATION]) == 150, "every block")
            assert replayer.process.wait(PATIENCE) == 0
    times = np.array(client.published[VIBRATION][1:])
    asked = 0.02 / 2.0
    assert times[-1] - times[0] > 0.9 * 148 * asked  # never early
    assert np.min(times[20:] - times[:-20]) < 1.5 * 20 * asked  # on a busy machine it may be late, but not always


STALLING = """
import rclpy
from sensor_msgs.msg import PointCloud2
rclpy.init()
node = rclpy.create_node("stalling", namespace="dcrb")
node.create_subscription(PointCloud2, "outer_ring/vibration", lambda message: print("received", flush=True), 200)
rclpy.spin(node)
"""


def test_the_last_messages_reach_a_subscriber_that_stalls(tmp_path: Path) -> None:
    bag, number, log = recorded(tmp_path / "bag", 150), domain(), tmp_path / "stalling.log"
    with log.open("wb") as output:
        stalling = subprocess.Popen([sys.executable, "-c", STALLING], env=environment(number), stdout=output)
    try:
        given = parameters(bag=str(bag), rate=0.0, listeners=1, wait=PATIENCE)
        with node("replayer", given, environment(number), tmp_path / "log") as replayer:
            wait_for(lambda: "received" in log.read_text(), PATIENCE)
            stalling.send_signal(signal.SIGSTOP)
            threading.Event().wait(0.3)  # the stall, in which more is sent than the middleware buffers
            stalling.send_signal(signal.SIGCONT)
            assert replayer.process.wait(PATIENCE) == 0, replayer.output
        wait_for(lambda: log.read_text().count("received") == 150, 60.0)
    finally:
        stalling.kill()
        stalling.wait(PATIENCE)


def test_loop_offset_and_clock(tmp_path: Path) -> None:
    bag, number, clock = recorded(tmp_path / "bag", 40), domain(), []
    with graph_client(number) as client:
        client.node.create_subscription(message_class(CLOCK), "/clock", clock.append, qos(CLOCK), raw=True)
        given = parameters(bag=str(bag), rate=10.0, loop="true", offset=0.5, clock="true", wait=PATIENCE)
        with node("replayer", given, environment(number), tmp_path / "log") as replayer:
            client.until(lambda: len(client.received[VIBRATION]) > 100 and clock, "several passes and the clock")
            assert replayer.end(signal.SIGINT) == 0
    indices = [decode_vibration(data).first_index(51200) for data in client.received[VIBRATION]]
    assert min(indices) == 25 * 1024  # the first block that begins half a second in or later
    assert indices[:16] == [1024 * k for k in (*range(25, 40), 25)]


@pytest.mark.parametrize(
    ("given", "sentence"),
    [({"offset": 9.0}, "no message later than 9 s after its start"), ({"topics": "diagnosis"}, "dcrb info lists the topics")],
)
def test_the_node_refuses_a_replay_of_nothing_before_it_waits(given: dict[str, object], sentence: str, tmp_path: Path) -> None:
    arguments = parameters(bag=str(recorded(tmp_path / "bag", 10)), wait=PATIENCE, **given)
    with node("replayer", arguments, environment(domain()), tmp_path / "log") as replayer:
        assert replayer.process.wait(PATIENCE / 10) == 2
        assert sentence in replayer.output
        assert "waiting for" not in replayer.output


def test_two_replays_in_one_namespace_report_each_other(tmp_path: Path) -> None:
    number, given = domain(), parameters(bag=str(recorded(tmp_path / "bag", 40)), loop="true", wait=0.0)
    with (
        node("replayer", given, environment(number), tmp_path / "first"),
        node("replayer", given, environment(number), tmp_path / "second"),
        graph_client(number) as client,
    ):
        client.until(lambda: client.status["other_publishers"] == "/dcrb/replayer", "the status")
        status = decode_diagnostics(client.received[BENCH_DIAGNOSTICS][-1])[1][0]
        assert (status.level, status.message) == (WARN, "others publish on the same topics")


def test_the_command_replays_and_refuses(tmp_path: Path) -> None:
    bag, number = recorded(tmp_path / "bag", 10), domain()
    command = [sys.executable, "-c", "from dcrb_ros.cli.app import main; main()", "replay"]
    done = subprocess.run(
        [*command, str(bag), "--rate", "5", "--listeners", "2", "--wait", "0.5"],
        env=environment(number),
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "0 of 2 subscribers to outer_ring/vibration have joined within 0.5 s" in done.stderr
    for arguments, sentence in (
        (["nothing"], "there is no recording nothing"),
        ([str(bag), "--rate", "-1"], "rate = -1.0 is outside 0 .. 1000"),
        ([str(bag), "--rate", "nan"], "--rate nan is not a finite number"),
        ([str(bag), "--topics", "vibration"], "there is no topic 'vibration'"),
        ([str(bag), "--offset", "9"], "lower the offset"),
        ([str(bag), "--listeners", "-1"], "listeners = -1 is outside 0 .. 1000"),
        ([str(bag), "--wait", "inf"], "--wait inf is not a finite number"),
    ):
        done = subprocess.run(
            [*command, *arguments], env=environment(number), capture_output=True, text=True, timeout=PATIENCE, check=False
        )
        assert done.returncode == 2, done.stderr
        assert sentence in done.stderr
        assert "Traceback" not in done.stderr
