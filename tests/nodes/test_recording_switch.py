"""The tape of a running node: nobody waits for a slow disk but who ends the recording."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest
from made_up_blocks import BODIES, blocks
from slow_recorder import SlowRecorder
from waiting import wait_for

from dcrb_ros.messages.encoder import BlockEncoder
from dcrb_ros.messages.topics import Message
from dcrb_ros.nodes.bench import CHILD_END
from dcrb_ros.nodes.recording_switch import Tape
from dcrb_ros.nodes.simulator import LAST_BLOCK
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recorder_thread import LAST_WRITE, QueuedRecorder
from dcrb_ros.settings.configuration import Configuration

PATIENCE = 20.0


@pytest.fixture(scope="module")
def encoded() -> list[list[Message]]:
    encoder = BlockEncoder(Configuration(), BODIES)
    return [encoder.encode(block) for block in blocks(12)]


def begun(path: Path) -> tuple[Tape, SlowRecorder, list[str]]:
    """Return a tape that records on a disk that does not answer, and what it logs."""
    slow, log = SlowRecorder(path), list[str]()
    tape = Tape(log.append)
    tape.start(lambda: QueuedRecorder(slow, 10))
    return tape, slow, log


def test_nobody_waits_for_a_recording_that_ends_but_who_ends_it(encoded: list[list[Message]], tmp_path: Path) -> None:
    tape, slow, log = begun(tmp_path / "bag")
    tape.write_messages(encoded[0])
    ended: dict[Path | None, bool] = {}
    ends = [threading.Thread(target=lambda: ended.update({tape.stop(): slow.allowed.is_set()}), daemon=True) for _ in range(2)]
    ends[0].start()
    wait_for(lambda: tape.state == "off")
    ends[1].start()
    tape.write_messages(encoded[1])
    assert tape.path is None
    assert not ended
    slow.allowed.set()
    for end in ends:
        end.join(PATIENCE)
    assert ended == {tmp_path / "bag": True, None: True}  # the second, the node's end say, waited as well
    assert len(list(Recording(tmp_path / "bag").vibrations())) == 1
    assert not log


def test_the_end_waits_for_a_recording_that_ended_by_an_overflow(encoded: list[list[Message]], tmp_path: Path) -> None:
    tape, slow, log = begun(tmp_path / "bag")
    for messages in encoded:
        tape.write_messages(messages)
    assert len(log) == 1
    assert "the disk is slower than the bench" in tape.state
    slow.allowed.set()
    assert tape.stop() is None
    recording = Recording(tmp_path / "bag")
    assert recording.outcome is not None  # written to its end
    assert len(list(recording.vibrations())) >= 10
    assert len(log) == 1


def test_a_recording_that_is_late_does_not_blame_the_next(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dcrb_ros.recordings.recorder_thread.LAST_WRITE", 0.05)
    tape, slow, log = begun(tmp_path / "bag")
    tape.write_messages(BlockEncoder(Configuration(), BODIES).start())
    tape.stop()
    assert "could not be finished in time" in tape.state
    tape.start(lambda: QueuedRecorder(SlowRecorder(tmp_path / "bag-2"), 10))
    assert (tape.state, tape.failed, len(log)) == ("recording", False, 1)
    slow.allowed.set()


def test_a_node_ends_before_the_bench_loses_its_patience() -> None:
    assert LAST_BLOCK + LAST_WRITE < CHILD_END - 1.0  # and a second to leave the graph
