"""The recorder's thread: when it is woken, what it does at the end and after a failure."""

from __future__ import annotations

import threading
from collections.abc import Iterable
from pathlib import Path

import pytest
from slow_recorder import SlowRecorder
from waiting import PATIENCE, wait_for

from dcrb_ros.messages.topics import FEATURES, Message
from dcrb_ros.recordings import recorder_thread
from dcrb_ros.recordings.recorder_thread import RecorderThread
from dcrb_ros.recordings.splitting import RecordingFailed
from dcrb_ros.runtime.threads import NamedThread

MS = 1_000_000


class Log:
    """A recorder that keeps the times of the messages, or fails."""

    def __init__(self, failure: Exception | None = None) -> None:
        self.path, self.failure = Path("bag"), failure
        self.times: list[int] = []
        self.closed = 0

    def write_messages(self, messages: Iterable[Message]) -> None:
        if self.failure is not None:
            raise self.failure
        self.times += [message.time_ns // MS for message in messages]

    def close(self) -> None:
        self.closed += 1


class Waiting(Log):
    """A recorder that fails once it is allowed to."""

    def __init__(self, failure: Exception) -> None:
        super().__init__(failure)
        self.allowed = threading.Event()

    def write_messages(self, messages: Iterable[Message]) -> None:
        self.allowed.wait(PATIENCE)
        super().write_messages(messages)


class Idle(NamedThread):
    """A thread that does not run."""

    def start(self) -> None:
        pass

    def is_alive(self) -> bool:
        return False

    def join(self, timeout: float | None = None) -> None:
        pass


def at(*times: int) -> list[Message]:
    return [Message(FEATURES, time * MS, b"") for time in times]


@pytest.fixture
def idle(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recorder_thread, "NamedThread", Idle)


def woken(queued: RecorderThread, messages: Iterable[Message]) -> bool:
    """Write messages; return whether this wakes the thread."""
    queued._wake.clear()
    queued.write_messages(messages)
    return queued._wake.is_set()


@pytest.mark.usefixtures("idle")
def test_the_thread_is_woken_every_tenth_of_a_second_of_simulated_time() -> None:
    queued = RecorderThread(Log(), 1000)  # type: ignore[arg-type]
    times = [50, 99, 100, 120, 199, 200, 350, 449, 450]
    assert [time for time in times if woken(queued, at(0, time))] == [100, 200, 350, 450]
    assert not woken(queued, [Message(FEATURES, 550 * MS - 1, b"")])
    assert woken(queued, [Message(FEATURES, 550 * MS, b"")])
    assert not woken(queued, [])


@pytest.mark.usefixtures("idle")
def test_the_first_batch_ends_after_a_tenth_of_a_second() -> None:
    for time_ns, wakes in ((100 * MS - 1, False), (100 * MS, True)):
        assert woken(RecorderThread(Log(), 1000), [Message(FEATURES, time_ns, b"")]) == wakes  # type: ignore[arg-type]


@pytest.mark.usefixtures("idle")
def test_the_thread_is_woken_when_more_than_a_quarter_of_the_queue_is_full() -> None:
    queued = RecorderThread(Log(), 20)  # type: ignore[arg-type]
    assert [woken(queued, at(0)) for _ in range(7)] == [False] * 5 + [True] * 2


@pytest.mark.usefixtures("idle")
def test_a_full_queue_ends_the_recording_and_says_so_once() -> None:
    queued = RecorderThread(Log(), 10)  # type: ignore[arg-type]
    for time in range(10):
        queued.write_messages(at(time))
    with pytest.raises(RecordingFailed, match=r"bag ended at 2\.5 s: the disk is slower than the bench, 10 blocks were waiting"):
        queued.write_messages(at(2500))
    queued.write_messages(at(2520))
    queued.close()


def test_a_failure_after_a_full_queue_is_raised_at_the_end() -> None:
    log = Waiting(RecordingFailed("the disk is full"))
    queued = RecorderThread(log, 1)  # type: ignore[arg-type]
    queued.write_messages(at(100))
    wait_for(lambda: not queued._queue)
    queued.write_messages(at(200))
    with pytest.raises(RecordingFailed, match="the disk is slower than the bench"):
        queued.write_messages(at(300))
    assert not queued.settled
    log.allowed.set()
    wait_for(lambda: not queued.writing)
    assert not queued.settled
    with pytest.raises(RecordingFailed, match=r"^the disk is full$"):
        queued.close(PATIENCE)
    assert queued.settled
    queued.close(PATIENCE)


def test_messages_are_written_in_their_order_and_the_recorder_is_closed_once() -> None:
    log = Log()
    queued = RecorderThread(log, 1000)  # type: ignore[arg-type]
    for time in range(300):
        queued.write_messages(at(time))
    assert queued.writing
    queued.close(PATIENCE)
    assert (log.times, log.closed) == (list(range(300)), 1)
    assert not queued.writing
    assert queued.path == Path("bag")
    queued.write_messages(at(1))
    queued.close(PATIENCE)
    assert (log.times, log.closed) == (list(range(300)), 1)


def test_queued_messages_are_written_although_no_others_follow() -> None:
    log = Log()
    queued = RecorderThread(log, 1000)  # type: ignore[arg-type]
    queued.write_messages(at(1))
    wait_for(lambda: log.times == [1])
    assert log.closed == 0
    queued.close(PATIENCE)


def test_a_thread_that_was_woken_waits_again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recorder_thread, "WAKE_PERIOD", PATIENCE)
    log = Log()
    queued = RecorderThread(log, 1000)  # type: ignore[arg-type]
    queued.write_messages(at(100))
    wait_for(lambda: log.times == [100])
    wait_for(lambda: not queued._wake.is_set())
    queued.close(PATIENCE)


@pytest.mark.parametrize(("failure", "reason"), [(RecordingFailed("the disk is full"), "the disk is full"), (ValueError(), "ValueError")])
def test_a_failure_in_the_thread_is_raised_once_and_closes_the_recorder(failure: Exception, reason: str) -> None:
    log = Log(failure)
    queued = RecorderThread(log, 1000)  # type: ignore[arg-type]
    queued.write_messages(at(100))
    wait_for(lambda: not queued.writing)
    with pytest.raises(RecordingFailed, match=f"^{reason}$"):
        queued.write_messages(at(200))
    queued.write_messages(at(300))
    queued.close()
    assert (log.times, log.closed) == ([], 1)


def test_a_disk_that_does_not_finish_in_time_is_reported(tmp_path: Path) -> None:
    slow = SlowRecorder(tmp_path / "bag")
    queued = RecorderThread(slow, 1000)
    queued.write_messages(at(100))
    with pytest.raises(RecordingFailed, match="could not be finished in time: the disk takes more than 3 s"):
        queued.close(0.0)
    with pytest.raises(RecordingFailed, match="could not be finished in time"):
        queued.close(0.0)
    slow.allowed.set()
    queued.close(PATIENCE)
    assert not queued.writing
