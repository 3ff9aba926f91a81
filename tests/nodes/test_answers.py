"""Waiting for the answers of a detector, with a made-up clock, and with processes."""

from __future__ import annotations

import signal
import threading
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

pytest.importorskip("rclpy", reason="the nodes need ROS 2; everything else is tested without")

from made_up_blocks import recorded
from node_arguments import parameters
from ros_bench import PATIENCE, GraphClient, Node, domain, environment, graph_client, node
from waiting import wait_for

from dcrb_ros.messages.statuses import decode_diagnostics
from dcrb_ros.messages.topics import DIAGNOSIS, FAULT_INDICATORS, VIBRATION
from dcrb_ros.nodes import answers as answers_module
from dcrb_ros.nodes.answers import AHEAD, FIRST_TIMEOUT, RECORDED_TIMEOUT, TIMEOUT, Answers
from dcrb_ros.nodes.gate import Gate
from dcrb_ros.nodes.pacing import Pacer
from dcrb_ros.nodes.replayer import ReplayerNode
from dcrb_ros.nodes.simulator import SimulatorNode
from dcrb_ros.stream.diagnosis import Diagnosis

BAGS = Path(__file__).parents[2] / "bags"
BLOCK_NS = 20_000_000


class Clock:
    """A clock of wall time that a test sets."""

    time = 100.0

    def __call__(self) -> float:
        return self.time


def diagnosis(time_s: float) -> bytes:
    encoded = DIAGNOSIS.encode(Diagnosis(round(time_s * 51200), time_s, "healthy", "made up"), "outer_ring")
    assert encoded is not None
    return encoded


def test_a_signal_is_answered_when_the_next_diagnosis_would_be_later_than_its_end() -> None:
    clock = Clock()
    answers = Answers(lambda: 1, lambda sentence: None, clock)
    answers.take(diagnosis(0.5))
    answers.take(b"nonsense")
    assert not answers.complete(3_000_000_000)
    for stamp in (1.0, 1.5, 2.0, 2.5):
        answers.take(diagnosis(stamp))
        assert not answers.complete(3_000_000_000)
    answers.take(diagnosis(3.0))
    assert answers.complete(3_200_000_000)
    assert not answers.complete(3_500_000_000)


def test_a_signal_is_answered_when_the_last_diagnosis_is_recorded_with_its_indicators() -> None:
    clock = Clock()
    answers = Answers(lambda: 1, lambda sentence: None, clock)
    for topic in (DIAGNOSIS, FAULT_INDICATORS):
        answers.take_recorded(topic, 500_000_000)
    answers.take(diagnosis(0.5))
    answers.take(diagnosis(1.0))  # the subscription that records is served later
    for topic in (DIAGNOSIS, FAULT_INDICATORS):
        assert not answers.complete(1_000_000_000)
        answers.take_recorded(topic, 1_000_000_000)
    assert answers.complete(1_000_000_000)
    answers.take_recorded(FAULT_INDICATORS, 0)  # as of a detector without indicators
    assert not answers.complete(1_000_000_000)
    clock.time += 1.1 * RECORDED_TIMEOUT
    assert answers.complete(1_000_000_000)


def test_the_interval_of_diagnoses_is_the_shortest_one() -> None:
    answers = Answers(lambda: 1, lambda sentence: None, Clock())
    for stamp in (0.5, 1.0, 3.0):  # the detector has missed blocks in between
        answers.take(diagnosis(stamp))
    assert not answers.complete(3_500_000_000)
    assert answers.complete(3_480_000_000)


def test_silence_and_the_absence_of_a_detector_end_the_wait() -> None:
    clock, detectors = Clock(), 1
    answers = Answers(lambda: detectors, lambda sentence: None, clock)
    assert not answers.complete(3_000_000_000)
    clock.time += 0.9 * FIRST_TIMEOUT
    assert not answers.complete(3_000_000_000)
    answers.take(diagnosis(1.0))
    clock.time += 0.9 * TIMEOUT
    assert not answers.complete(3_000_000_000)  # the silence counts from the last diagnosis
    clock.time += 0.2 * TIMEOUT
    assert answers.complete(3_000_000_000)
    answers.take(diagnosis(1.0))
    assert not answers.complete(3_000_000_000)
    detectors = 0
    assert answers.complete(3_000_000_000)


@pytest.mark.parametrize("kind", [ReplayerNode, SimulatorNode])
def test_a_node_ends_with_the_diagnosis_of_its_last_block(kind: type[ReplayerNode | SimulatorNode]) -> None:
    answers = Answers(lambda: 1, lambda sentence: None, Clock())
    for stamp in (0.5, 1.0):
        answers.take(diagnosis(stamp))
    engine = SimpleNamespace(ended=True, failure=None, gate=SimpleNamespace(closed=False))
    progress = SimpleNamespace(time_ns=1_800_000_000)
    node = SimpleNamespace(engine=engine, _engine=engine, progress=progress, _progress=progress, _answers=answers)
    assert not kind.ended.fget(node)  # type: ignore[attr-defined]
    answers.take(diagnosis(1.5))
    assert kind.ended.fget(node)  # type: ignore[attr-defined]


def test_bundles_wait_for_room_in_the_queue_of_the_detector() -> None:
    gate = Gate(Pacer(0.0, time.monotonic), time.monotonic)
    answers = Answers(lambda: 1, lambda sentence: None, Clock())  # no time passes, so that silence does not end the wait
    sent = []

    def send() -> None:
        for number in range(AHEAD + 10):
            answers.await_room(gate, 1e-9 * BLOCK_NS)
            sent.append(number)
            answers.expect(number * BLOCK_NS, (number + 1) * BLOCK_NS)

    thread = threading.Thread(target=send, daemon=True)
    thread.start()
    wait_for(lambda: len(sent) >= AHEAD)
    assert len(sent) == AHEAD
    answers.take(diagnosis(9 * BLOCK_NS * 1e-9))
    wait_for(lambda: len(sent) >= AHEAD + 9)
    assert len(sent) == AHEAD + 9
    gate.close()
    thread.join(PATIENCE)
    assert not thread.is_alive()


def said_while_sending(blocks: int, block_ns: int, pace: float, every: int | None = None) -> list[str]:
    """Send blocks to a detector that diagnoses ``every`` so many of them, or never; return what is logged.

    Blocks beyond the room in the queue are sent at a ``pace`` [s].
    """
    gate, said = Gate(Pacer(0.0, time.monotonic), time.monotonic), list[str]()
    answers = Answers(lambda: 1, said.append)
    for number in range(1, blocks + 1):
        answers.await_room(gate, pace)
        answers.expect((number - 1) * block_ns, number * block_ns)
        if every and number % every == 0:
            answers.take(diagnosis(1e-9 * number * block_ns))
    return said


def test_blocks_of_which_a_hop_has_more_than_the_queue_are_sent_at_their_own_pace() -> None:
    begin = time.monotonic()
    assert said_while_sending(10 * AHEAD, 1_000_000, 1e-3, every=5 * AHEAD) == []
    assert time.monotonic() - begin > 1e-3 * 2 * 4 * AHEAD


def test_one_silence_is_enough_to_learn_that_a_detector_needs_more_signal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(answers_module, "FIRST_TIMEOUT", 0.1)
    (said,) = said_while_sending(10 * AHEAD, BLOCK_NS, 0.0, every=3 * AHEAD)
    assert said == "no diagnosis within 0.1 s: the next blocks are sent at their own pace, up to 20 s of signal beyond the last diagnosis"


def test_a_detector_that_never_answers_does_not_stop_the_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(answers_module, "FIRST_TIMEOUT", 0.1)
    first, last = said_while_sending(20 * AHEAD, BLOCK_NS, 0.0)
    assert first.startswith("no diagnosis within 0.1 s")
    assert last == "still no diagnosis: the blocks no longer wait for the detector, which may lose some"


def assert_it_ends_after_the_last_diagnosis(client: GraphClient, process: Node, seconds: float) -> None:
    """Require that the last diagnosis, later than some ``seconds`` of signal, was published before a process had ended.

    `launch` ends the detector at the end of the other node: a later diagnosis would be lost.
    """
    client.until(lambda: process.process.poll() is not None, "the end of the process")
    ended = time.time()
    client.until(lambda: decode_diagnostics(client.received[DIAGNOSIS][-1])[0] > seconds * 1e9, "the last diagnosis")
    assert client.published[DIAGNOSIS][-1] < ended


@pytest.mark.node
@pytest.mark.slow
def test_a_replay_as_fast_as_possible_loses_no_block_and_ends_with_the_last_diagnosis(tmp_path: Path) -> None:
    bag, number = recorded(tmp_path / "bag", 600), domain()  # three times the queue of the detector
    with (
        graph_client(number) as client,
        node("fault_detector", [], environment(number), tmp_path / "detector.log") as detector,
    ):
        client.until(lambda: client.node.count_subscribers(VIBRATION.resolved("/dcrb")) >= 2, "the detector")
        given = parameters(bag=str(bag), rate=0.0, listeners=2, wait=PATIENCE)
        with node("replayer", given, environment(number), tmp_path / "replayer.log") as replayer:
            assert_it_ends_after_the_last_diagnosis(client, replayer, 11.9)
            assert (replayer.process.returncode, detector.end(signal.SIGINT)) == (0, 0), replayer.output
    values = [decode_diagnostics(data)[1][0].values for data in client.received[DIAGNOSIS]]
    assert {value["gaps"] for value in values} == {"0"}
    assert len(values) == 24


@pytest.mark.node
@pytest.mark.slow
def test_a_simulator_of_a_stated_duration_ends_with_the_last_diagnosis(tmp_path: Path) -> None:
    number = domain()
    with (
        graph_client(number) as client,
        node("fault_detector", [], environment(number), tmp_path / "detector.log") as detector,
    ):
        client.until(lambda: client.node.count_subscribers(VIBRATION.resolved("/dcrb")) >= 2, "the detector")
        given = ["--duration", "3.3", *parameters(publishing__listeners=2, publishing__wait=PATIENCE, time_scale=0.0)]
        with node("simulator", given, environment(number), tmp_path / "simulator.log") as simulator:
            assert_it_ends_after_the_last_diagnosis(client, simulator, 2.9)
            assert (simulator.process.returncode, detector.end(signal.SIGINT)) == (0, 0), simulator.output
