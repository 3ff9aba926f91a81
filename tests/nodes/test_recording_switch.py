"""Recordings of a running node: only the one who ends a recording waits for a slow disk."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest
from made_up_blocks import BODIES, blocks
from slow_recorder import SlowRecorder
from waiting import wait_for

from dcrb_ros.messages.bundle import Bundle
from dcrb_ros.messages.description import decode_range
from dcrb_ros.messages.encoder import BlockEncoder
from dcrb_ros.messages.topics import SENSOR
from dcrb_ros.nodes.bench import EXIT_TIMEOUT
from dcrb_ros.nodes.engine import CLOSE_TIMEOUT as ENGINE_TIMEOUT
from dcrb_ros.nodes.recording_switch import RecordingSwitch, free_path, wanted_path
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.recordings.recorder_thread import CLOSE_TIMEOUT, RecorderThread
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.simulation.ground_truth import commands_in
from dcrb_ros.stream.events import Event, SpeedCommand, TimedCommand

PATIENCE = 20.0
CAPACITY = 10
"""Lists of messages that the slow recorder's queue holds."""


class Log:
    """Keeps the messages instead of logging them."""

    def __init__(self) -> None:
        self.messages: list[str] = []
        self.errors: list[str] = []

    def info(self, message: str) -> None:
        self.messages.append(message)

    def error(self, message: str) -> None:
        self.errors.append(message)


class SlowDisk:
    """Creates recorders that write once they are allowed to."""

    def __init__(self) -> None:
        self.allowed = threading.Event()

    def __call__(self, path: Path, *, commands: Sequence[TimedCommand], start_ns: int) -> RecorderThread:
        recorder = SlowRecorder(path)
        recorder.allowed = self.allowed
        return RecorderThread(recorder, CAPACITY)


def fast(path: Path, *, commands: Sequence[TimedCommand], start_ns: int) -> RecorderThread:
    return RecorderThread(Recorder(path, Configuration(), BODIES, commands=commands, start_ns=start_ns), 100)


def bundles(count: int, events: dict[int, Event] | None = None) -> list[Bundle]:
    encoder = BlockEncoder(Configuration(), BODIES)
    return [Bundle(b.stamp_ns, b.end_ns, tuple(encoder.encode(b)), b, tuple(commands_in(b.truths))) for b in blocks(count, events=events)]


def slow_recording(path: Path) -> tuple[RecordingSwitch, SlowDisk, Log]:
    """Return a switch that has begun to record on a slow disk."""
    disk, log = SlowDisk(), Log()
    switch = RecordingSwitch(disk, log, path)
    switch.start([])
    return switch, disk, log


def test_only_the_callers_of_stop_wait_for_the_disk(tmp_path: Path) -> None:
    switch, disk, log = slow_recording(tmp_path / "bag")
    first, second = bundles(2)
    switch.write(first)
    ended: dict[Path | None, bool] = {}
    callers = [threading.Thread(target=lambda: ended.update({switch.stop(): disk.allowed.is_set()}), daemon=True) for _ in range(2)]
    callers[0].start()
    wait_for(lambda: switch.state == "off")
    callers[1].start()
    switch.write(second)
    assert switch.path is None
    assert not ended
    disk.allowed.set()
    for caller in callers:
        caller.join(PATIENCE)
    assert ended == {tmp_path / "bag": True, None: True}  # the second caller, such as the end of the node, waited as well
    assert len(list(Recording(tmp_path / "bag").vibrations())) == 1
    assert not log.errors


def test_stop_waits_for_a_recording_that_ended_by_an_overflow(tmp_path: Path) -> None:
    switch, disk, log = slow_recording(tmp_path / "bag")
    for bundle in bundles(12):
        switch.write(bundle)
    assert len(log.errors) == 1
    assert "the disk is slower than the bench" in switch.state
    disk.allowed.set()
    assert switch.stop() is None
    recording = Recording(tmp_path / "bag")
    assert recording.outcome is not None  # the file was finished
    assert len(list(recording.vibrations())) >= CAPACITY
    assert len(log.errors) == 1


def test_a_recording_that_is_finished_too_late_does_not_fail_the_next(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dcrb_ros.nodes.recording_switch.CLOSE_TIMEOUT", 0.05)
    switch, disk, log = slow_recording(tmp_path / "bag")
    switch.write(bundles(1)[0])
    switch.stop()
    assert "could not be finished in time" in switch.state
    assert switch.record(tmp_path / "bag") == tmp_path / "bag-2"
    assert (switch.state, switch.failed, len(log.errors)) == ("recording", False, 1)
    assert "could not be finished in time" in switch.first_failure  # the exit status of the node
    disk.allowed.set()
    switch.stop()


def test_a_recording_begun_later_contains_the_earlier_commands_and_starts_with_its_first_bundle(tmp_path: Path) -> None:
    switch = RecordingSwitch(fast, Log())
    switch.start([])
    earlier, *later = bundles(3, {0: SpeedCommand(100.0), 2: SpeedCommand(120.0)})
    switch.write(earlier)
    assert switch.record(tmp_path / "bag") == tmp_path / "bag"
    assert switch.record(tmp_path / "other") == tmp_path / "bag"  # the running one
    for bundle in later:
        switch.write(bundle)
    assert switch.stop() == tmp_path / "bag"
    recording = Recording(tmp_path / "bag")
    assert recording.commands() == [TimedCommand(0, SpeedCommand(100.0)), TimedCommand(40_000_000, SpeedCommand(120.0))]
    assert min(message.time_ns for message in recording.messages()) == 20_000_000


def test_a_recording_begun_later_starts_with_the_present_description(tmp_path: Path) -> None:
    switch = RecordingSwitch(fast, Log())
    switch.start([])
    encoder = BlockEncoder(Configuration(), BODIES)
    narrow = [replace(block, range=20.0) for block in blocks(4)]
    *earlier, last = (Bundle(block.stamp_ns, block.end_ns, tuple(encoder.encode(block)), block) for block in narrow)
    for bundle in earlier:
        switch.write(bundle)
    switch.record(tmp_path / "bag")
    switch.write(last)
    switch.stop()
    *_, described = Recording(tmp_path / "bag").messages((SENSOR,))
    assert (decode_range(described.data), described.time_ns) == (20.0, 60_000_000)


def test_a_reset_continues_in_a_new_recording_without_the_earlier_commands(tmp_path: Path) -> None:
    log = Log()
    switch = RecordingSwitch(fast, log, tmp_path / "bag")
    switch.start([])
    for bundle in bundles(2, {1: SpeedCommand(100.0)}):
        switch.write(bundle)
    switch.start([])
    switch.write(bundles(1)[0])
    assert switch.stop() == tmp_path / "bag-2"
    assert log.messages == [f"reset: {tmp_path / 'bag'} is finished, {tmp_path / 'bag-2'} records from the start"]
    assert [len(list(Recording(tmp_path / name).vibrations())) for name in ("bag", "bag-2")] == [2, 1]
    assert Recording(tmp_path / "bag-2").commands() == []
    switch.start([])  # nothing was recorded, so nothing is
    assert (switch.path, switch.state) == (None, "off")


def test_no_recording_begins_when_the_node_ends_during_a_reset(tmp_path: Path) -> None:
    switch, disk, log = slow_recording(tmp_path / "bag")
    switch.write(bundles(1)[0])
    reset = threading.Thread(target=switch.start, args=([],), daemon=True)
    reset.start()
    wait_for(lambda: switch.state == "off")  # the reset waits for the disk
    end = threading.Thread(target=switch.close, daemon=True)
    end.start()
    wait_for(lambda: switch._closed)
    disk.allowed.set()
    for thread in (reset, end):
        thread.join(PATIENCE)
    assert (switch.state, switch.first_failure, log.errors) == ("off", "", [])
    assert [path.name for path in tmp_path.iterdir()] == ["bag"]
    assert Recording(tmp_path / "bag").complete
    with pytest.raises(Refusal, match="no recording begins any more"):
        switch.record(tmp_path / "bag")


def test_a_recording_without_a_block_is_removed(tmp_path: Path) -> None:
    log = Log()
    switch = RecordingSwitch(fast, log, tmp_path / "bag")
    switch.start([])
    switch.start([])  # a reset before the first block
    assert log.messages == [f"reset: {tmp_path / 'bag'} records from the start"]
    (bundle,) = bundles(1)
    switch.write(bundle)
    assert switch.stop() == tmp_path / "bag"
    assert switch.record(tmp_path / "bag") == tmp_path / "bag-2"  # a description precedes its first block
    assert switch.stop() == tmp_path / "bag-2"
    assert [path.name for path in tmp_path.iterdir()] == ["bag"]
    assert not log.errors


def test_a_path_is_free_with_the_next_number(tmp_path: Path) -> None:
    for name in ("bag", "bag-2"):
        assert free_path(tmp_path / "bag") == tmp_path / name
        (tmp_path / name).mkdir()
    assert free_path(tmp_path / "bag") == tmp_path / "bag-3"


def test_a_node_ends_before_the_bench_kills_it() -> None:
    assert ENGINE_TIMEOUT + CLOSE_TIMEOUT < EXIT_TIMEOUT - 1.0  # and a second to leave the graph


def test_a_node_started_again_records_to_the_next_free_name(tmp_path: Path) -> None:
    wanted = tmp_path / "bag"
    for number, name in enumerate(("bag", "bag-2", "bag-3")):
        log = Log()
        switch = RecordingSwitch(fast, log, wanted)
        switch.start([])
        assert switch.path == tmp_path / name
        assert log.messages == ([f"{wanted} exists and is kept: recording to {tmp_path / name}"] if number else [])
        for bundle in bundles(number + 1):
            switch.write(bundle)
        switch.stop()
    assert [len(list(Recording(tmp_path / name).vibrations())) for name in ("bag", "bag-2", "bag-3")] == [1, 2, 3]


@pytest.mark.parametrize("configured", ["", "drive", "/drive"])
def test_the_answer_names_the_whole_path(configured: str) -> None:
    path = wanted_path(configured, "/wagon/box1")
    assert path.is_absolute()
    assert configured in str(path)
    assert bool(configured) or path.name.startswith("wagon-box1-")


def test_a_path_in_the_home_folder_needs_no_shell(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    assert wanted_path("~/drive", "/dcrb") == tmp_path / "drive"
    assert wanted_path("./~/drive", "/dcrb") == Path("~", "drive").absolute()
    with pytest.raises(Refusal, match=r"^~nobody-here/drive begins with the home folder of an unknown user: give the whole path"):
        wanted_path("~nobody-here/drive", "/dcrb")
