"""The replayer as a process: subscribers cannot distinguish it from the live bench."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="the nodes need ROS 2; everything else is tested without")

from made_up_blocks import narrowed, recorded
from node_arguments import parameters
from ros_bench import PATIENCE, domain, environment, graph_client, node

from dcrb_ros.messages.description import decode_range
from dcrb_ros.messages.points import decode_vibration
from dcrb_ros.messages.statuses import decode_diagnostics
from dcrb_ros.messages.topics import BENCH_DIAGNOSTICS, CLOCK, DIAGNOSIS, FEATURES, GROUND_TRUTH, ROLLER_STATES, SENSOR, VIBRATION
from dcrb_ros.nodes.publisher import message_class, qos
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.replay import Replay, ReplayParameters

pytestmark = pytest.mark.node

BAGS = Path(__file__).parents[2] / "bags"


@pytest.mark.parametrize(("name", "verdict"), [("outer_ring_defect", "outer_ring"), ("inner_ring_defect", "inner_ring")])
def test_the_detector_diagnoses_a_replay_like_the_live_bench(name: str, verdict: str, tmp_path: Path) -> None:
    number = domain()
    with (
        graph_client(number) as client,
        node("fault_detector", [], environment(number), tmp_path / "detector.log") as detector,
    ):
        client.until(lambda: client.node.count_subscribers(VIBRATION.resolved("/dcrb")) >= 2, "the detector")
        given = parameters(bag=str(BAGS / name), rate=2.0, listeners=2, wait=60.0)
        with node("replayer", given, environment(number), tmp_path / "replayer.log") as replayer:

            def verdicts() -> list[str]:
                assert detector.process.poll() is None, detector.output
                assert replayer.process.poll() in (None, 0), replayer.output
                found = [decode_diagnostics(data)[1][0].message for data in client.received[DIAGNOSIS]]
                return [word for word in found if word != "waiting"]

            client.until(lambda: len(client.received[VIBRATION]) == 150, "every block")
            client.until(verdicts, "a verdict")
            assert set(verdicts()) == {verdict}
            assert replayer.process.wait(PATIENCE) == 0
        # The same bytes in the same order; the middleware pads them to a multiple of four.
        for topic in (VIBRATION, FEATURES, ROLLER_STATES, GROUND_TRUTH, SENSOR):
            recording = [message.data + bytes(-len(message.data) % 4) for message in Recording(BAGS / name).messages((topic,))]
            client.until(lambda t=topic, expected=recording: len(client.received[t]) >= len(expected), topic.name)
            assert client.received[topic] == recording, topic.name
    assert decode_diagnostics(client.received[BENCH_DIAGNOSTICS][-1])[1][0].name == "/dcrb/replayer"


def test_a_replay_keeps_the_recorded_pace_times_its_rate(tmp_path: Path) -> None:
    bag, number, stamps = recorded(tmp_path / "bag", 150), domain(), []
    with graph_client(number) as client:
        client.node.create_subscription(
            message_class(VIBRATION), VIBRATION.resolved("/dcrb"), lambda data: stamps.append(time.monotonic()), qos(VIBRATION), raw=True
        )
        given = parameters(bag=str(bag), rate=2.0, listeners=2, wait=60.0)
        with node("replayer", given, environment(number), tmp_path / "log") as replayer:
            client.until(lambda: len(stamps) == 150, "every block")
            assert replayer.process.wait(PATIENCE) == 0
    asked = 148 * 0.02 / 2.0
    assert 0.9 * asked < stamps[-1] - stamps[1] < 3.0 * asked  # never early; on a busy machine it may be late


def test_loop_offset_and_clock(tmp_path: Path) -> None:
    bag, number, clock = recorded(tmp_path / "bag", 40), domain(), []
    with graph_client(number) as client:
        client.node.create_subscription(message_class(CLOCK), "/clock", clock.append, qos(CLOCK), raw=True)
        given = parameters(bag=str(bag), rate=10.0, loop="true", offset=0.5, clock="true", wait=60.0)
        with node("replayer", given, environment(number), tmp_path / "log") as replayer:
            client.until(lambda: len(client.received[VIBRATION]) > 100 and clock, "several passes and the clock")
            assert replayer.end(signal.SIGINT) == 0
    indices = [decode_vibration(data).first_index(51200) for data in client.received[VIBRATION]]
    assert min(indices) == 25 * 1024  # the first block that begins half a second in or later
    assert indices[:16] == [1024 * k for k in (*range(25, 40), 25)]


def test_the_command_replays_and_refuses(tmp_path: Path) -> None:
    bag, number = recorded(tmp_path / "bag", 10), domain()
    command = [sys.executable, "-c", "from dcrb_ros.cli.app import main; main()", "replay"]
    done = subprocess.run(
        [*command, str(bag), "--rate", "5"], env=environment(number), capture_output=True, text=True, timeout=PATIENCE, check=False
    )
    assert done.returncode == 0, done.stderr
    for arguments, sentence in (
        (["nothing"], "there is no recording nothing"),
        ([str(bag), "--rate", "-1"], "rate = -1.0 is outside 0 .. 1000"),
        ([str(bag), "--rate", "nan"], "--rate nan is not a finite number"),
        ([str(bag), "--topics", "vibration"], "there is no topic 'vibration'"),
        ([str(bag), "--offset", "9"], "lower the offset"),
    ):
        done = subprocess.run(
            [*command, *arguments], env=environment(number), capture_output=True, text=True, timeout=PATIENCE, check=False
        )
        assert done.returncode == 2, done.stderr
        assert sentence in done.stderr
        assert "Traceback" not in done.stderr


def test_bundles_are_due_at_the_end_of_their_block(tmp_path: Path) -> None:
    replay = Replay(ReplayParameters(bag=str(recorded(tmp_path / "bag", 5))))
    bundles = list(replay.bundles())
    assert [bundle.end_ns for bundle in bundles] == [20_000_000 * k for k in range(1, 6)]
    assert [bundle.messages[0].topic for bundle in bundles] == [VIBRATION] * 5
    assert sum(len(bundle.messages) for bundle in bundles) == sum(replay.recording.counts().values()) - 1
    assert np.all(np.diff([bundle.begin_ns for bundle in bundles]) > 0)


@pytest.mark.parametrize(("offset", "passed"), [(0.0, 3), (0.1, 0)])
def test_a_changed_range_is_replayed_with_its_block(offset: float, passed: int, tmp_path: Path) -> None:
    bag = narrowed(tmp_path / "bag", 6, at=3, limit=20.0)
    replay = Replay(ReplayParameters(bag=str(bag), offset=offset, topics=VIBRATION.name))
    assert [decode_range(message.data) for message in replay.start()] == [5000.0]
    first, again = ([bundle.messages for bundle in replay.bundles()] for _ in range(2))
    told = [[decode_range(message.data) for message in bundle if message.topic == SENSOR] for bundle in first]
    assert told == [[]] * passed + [[20.0]] + [[]] * (5 - round(50 * offset) - passed)
    assert [message.topic for message in first[passed]] == [SENSOR, VIBRATION]
    # A loop starts with the first range again; after an offset beyond the change there is only the second.
    assert [message.topic for message in again[0]] == ([VIBRATION] if offset else [SENSOR, VIBRATION])
