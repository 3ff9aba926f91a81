"""The recorder: splitting, chosen topics, slow and full disks, a killed process."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
import yaml
from full_disk import files_of_at_most
from made_up_blocks import BODIES, blocks, encoded, recorded
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from slow_recorder import SlowRecorder

from dcrb_ros.messages.encoder import BlockEncoder
from dcrb_ros.messages.topics import DETECTED, NAMESPACE, SENSOR, SIMULATED, VIBRATION
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recorder import Recorder, channel_of, check_topics, chosen_topics
from dcrb_ros.recordings.recorder_thread import RecorderThread
from dcrb_ros.recordings.splitting import RecordingFailed
from dcrb_ros.recordings.verification import metadata_flaw
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.stream.events import SpeedCommand

pytestmark = pytest.mark.slow

WAVEFORM = VIBRATION.resolved(NAMESPACE)


def about(bag: Path) -> dict[str, object]:
    found: dict[str, object] = yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    return found


def test_the_offered_profiles_are_those_of_rosbag2() -> None:
    """Without a limit, a duration has the most nanoseconds that 64 bits hold."""
    for topic, durability in ((VIBRATION, "volatile"), (SENSOR, "transient_local")):
        (profile,) = channel_of(topic, NAMESPACE).profiles()
        assert list(profile)[:4] == ["history", "depth", "reliability", "durability"]
        for name in ("deadline", "lifespan", "liveliness_lease_duration"):
            duration = profile.pop(name)
            assert duration["sec"] * 10**9 + duration["nsec"] == 2**63 - 1
            assert duration["nsec"] < 10**9
        assert profile == {
            "history": "keep_last",
            "depth": topic.depth,
            "reliability": "reliable",
            "durability": durability,
            "liveliness": "automatic",
            "avoid_ros_namespace_conventions": False,
        }


def test_definitions_are_those_of_ros_2() -> None:
    definition = channel_of(VIBRATION, NAMESPACE).definition
    assert "builtin_interfaces/Time stamp" in definition
    assert "uint32 seq" not in definition  # of ROS 1


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("ground_truth", {"ground_truth", "outer_ring/sensor"}),
        (" ground_truth ,diagnosis  outer_ring/features", {"ground_truth", "diagnosis", "outer_ring/features", "outer_ring/sensor"}),
        ("", {topic.name for topic in (*SIMULATED, *DETECTED)}),
        (" , ", {topic.name for topic in (*SIMULATED, *DETECTED)}),
    ],
)
def test_topics_are_separated_by_commas_or_blanks(text: str, names: set[str]) -> None:
    assert {topic.name for topic in chosen_topics(text)} == names


def test_topics_that_a_run_never_records_are_refused() -> None:
    def check(topics: str, *, contacts: bool = False, detector: bool = False) -> None:
        given = {"publishing.contacts": contacts, "recording.topics": topics}
        other = {**given, "publishing.contacts": False}
        check_topics(load_configuration("dry", other), load_configuration("dry", given), detector=detector)

    check("")
    check("roller_contacts, ground_truth", contacts=True)
    check("diagnosis fault_indicators", detector=True)
    for name, detector in (("roller_contacts", True), ("lubrication/state", True), ("envelope_spectrum", True), ("diagnosis", False)):
        with pytest.raises(Refusal, match=f"recording.topics: this run does not record '{name}': leave it out"):
            check(f"outer_ring/vibration, {name}", detector=detector)
    with pytest.raises(Refusal, match=r"recording.topics: there is no topic 'ground_thruth'; did you mean"):
        check("ground_thruth")


@pytest.mark.parametrize(("given", "start_ns"), [({}, 0), ({"start_ns": 5}, 5)])
def test_the_sensor_description_is_on_the_disk_from_the_start(given: dict[str, int], start_ns: int, tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "bag", Configuration(), BODIES, **given)  # type: ignore[arg-type]
    assert [(message.topic, message.time_ns) for message in Recording(tmp_path / "bag").messages()] == [(SENSOR, start_ns)]
    recorder.close()


@pytest.mark.parametrize("count", [0, 1])
def test_a_recording_that_is_stopped_before_its_first_sample_leaves_nothing(count: int, tmp_path: Path) -> None:
    with suppress(KeyboardInterrupt), Recorder(tmp_path / "bag", Configuration(), BODIES) as recorder:
        for block in blocks(count):
            recorder.write(block)
        raise KeyboardInterrupt
    assert (tmp_path / "bag").exists() is (count > 0)


def test_a_closed_recorder_ignores_blocks_and_its_outcome_stays(tmp_path: Path) -> None:
    made = list(blocks(60))
    recorder = Recorder(tmp_path / "bag", Configuration.model_validate({"recording": {"split_duration": 0.5}}), BODIES)
    for block in made[:50]:
        recorder.write(block)
    recorder.close()
    for block in made[50:]:
        recorder.write(block)
    recorder.close()
    assert recorder.outcome.samples == 50 * 1024
    assert sum(1 for _ in Recording(tmp_path / "bag").vibrations()) == 50
    assert recorder.file == tmp_path / "bag" / "bag_0.mcap"


@pytest.mark.parametrize("keys", [{"split_duration": 0.5}, {"split_size": 1_000_000, "compression": "none"}])
def test_a_recording_is_split_into_files(tmp_path: Path, keys: dict[str, object]) -> None:
    bag = recorded(tmp_path / "bag", 160, **keys)
    names = about(bag)["relative_file_paths"]
    assert isinstance(names, list)
    assert len(names) >= 3
    files = about(bag)["files"]
    assert isinstance(files, list)
    assert [file["path"] for file in files] == names
    assert sum(file["message_count"] for file in files) == about(bag)["message_count"]
    starts = [file["starting_time"]["nanoseconds_since_epoch"] for file in files]
    assert starts == sorted(set(starts))
    with AnyReader([bag]) as reader:
        assert sum(1 for _ in reader.messages([c for c in reader.connections if c.topic == WAVEFORM])) == 160
    for name in names:  # every file has the manifest
        assert Recording(bag / name).manifest["seed"] == 1
    recording = Recording(bag)
    assert [block.first_index(51200) for block in recording.vibrations()] == [1024 * k for k in range(160)]
    assert recording.complete
    assert metadata_flaw(bag) == ""


def test_more_than_ten_files_are_read_in_order(tmp_path: Path) -> None:
    bag = recorded(tmp_path / "bag", 75, split_duration=0.1)
    assert len(Recording(bag).files) > 11
    assert [block.first_index(51200) for block in Recording(bag).vibrations()] == [1024 * k for k in range(75)]


@pytest.mark.parametrize("compression", ["zstd", "lz4", "none"])
def test_other_readers_read_each_compression(tmp_path: Path, compression: str) -> None:
    bag = recorded(tmp_path / "bag", 60, compression=compression)
    with (bag / "bag_0.mcap").open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        assert {index.compression for index in summary.chunk_indexes} == {"" if compression == "none" else compression}
        assert all(index.uncompressed_size < 300_000 for index in summary.chunk_indexes)
        assert sum(1 for _, channel, _ in reader.iter_messages() if channel.topic == WAVEFORM) == 60
    with AnyReader([bag]) as other:
        assert {c.topic: c.msgcount for c in other.connections}[WAVEFORM] == 60


def test_only_chosen_topics_are_recorded_and_the_hash_covers_all_samples(tmp_path: Path) -> None:
    bag = recorded(tmp_path / "bag", 10, topics="outer_ring/features, ground_truth", events={3: SpeedCommand(130.0)})
    recording = Recording(bag)
    assert set(recording.counts()) == {"/dcrb/outer_ring/features", "/dcrb/ground_truth", "/dcrb/outer_ring/sensor"}
    assert recording.outcome is not None
    assert recording.outcome["samples"] == 10 * 1024
    assert recording.outcome["sha256"] == Recording(recorded(tmp_path / "all", 10)).outcome["sha256"]  # type: ignore[index]


@pytest.mark.parametrize(
    ("setting", "sentence"),
    [
        ("recording.split_size=5", "below 1000000 B"),
        ("recording.split_duration=0.01", r"below 0\.1 s"),
        ("recording.compression=zip", "is not one of zstd, lz4, none"),
        ("recording.queue=1", r"is outside 10 \.\. 100000 blocks"),
    ],
)
def test_invalid_settings_are_refused(setting: str, sentence: str) -> None:
    with pytest.raises(Refusal, match=sentence):
        load_configuration("dry", [setting])


def test_an_unknown_topic_is_refused_before_the_folder_is_created(tmp_path: Path) -> None:
    with pytest.raises(Refusal, match=r"no topic 'ground_thruth'; did you mean 'ground_truth'\?"):
        recorded(tmp_path / "bag", 1, topics="ground_thruth")
    assert not (tmp_path / "bag").exists()


def test_a_slow_disk_ends_the_recording_without_blocking_the_writer(tmp_path: Path) -> None:
    slow = SlowRecorder(tmp_path / "bag")
    thread, encoder = RecorderThread(slow, 10), BlockEncoder(Configuration(), BODIES)
    written, failures = 0, []
    for block in blocks(40):
        try:
            thread.write_messages(encoder.encode(block))
            written += 1
        except RecordingFailed as error:
            failures.append(str(error))
    assert len(failures) == 1  # raised once
    assert "the disk is slower than the bench, 10 blocks were waiting" in failures[0]
    slow.allowed.set()
    thread.close()
    recording = Recording(tmp_path / "bag")
    kept = sum(1 for _ in recording.vibrations())
    assert 10 <= kept <= 11  # queued messages were still written
    assert recording.complete


def test_a_full_disk_is_raised_once_by_the_thread_and_the_file_has_an_end(tmp_path: Path) -> None:
    encoder = BlockEncoder(Configuration(), BODIES)
    thread = RecorderThread(Recorder(tmp_path / "bag", Configuration(), BODIES), 500)
    failures = []
    with files_of_at_most(700_000):
        for block in blocks(300):
            try:
                thread.write_messages(encoder.encode(block))
            except RecordingFailed as error:
                failures.append(str(error))
        try:
            thread.close()
        except RecordingFailed as error:
            failures.append(str(error))
    assert len(failures) == 1
    assert "File too large" in failures[0]
    recording = Recording(tmp_path / "bag")
    kept = sum(1 for _ in recording.vibrations())
    assert kept > 10
    assert not recording.complete
    with (tmp_path / "bag" / "bag_0.mcap").open("rb") as stream:  # a valid file for other readers, too
        assert sum(1 for _, channel, _ in make_reader(stream).iter_messages() if channel.topic == WAVEFORM) == kept
    assert about(tmp_path / "bag")["message_count"] >= kept  # type: ignore[operator]


def test_a_disk_that_is_full_at_a_split_leaves_the_earlier_files_complete(tmp_path: Path) -> None:
    bag = tmp_path / "bag"
    recorder = Recorder(bag, Configuration.model_validate({"recording": {"split_duration": 0.5}}), BODIES)
    (bag / "bag_1.mcap").symlink_to("/dev/full")
    with pytest.raises(RecordingFailed, match=r"ended at 0\.5 s: No space left on device; free some space or give another folder"):
        recorder.write_messages(encoded(60))
    assert sorted(file.name for file in bag.iterdir()) == ["bag_0.mcap", "metadata.yaml"]
    assert about(bag)["relative_file_paths"] == ["bag_0.mcap"]
    with (bag / "bag_0.mcap").open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None  # not cut off
    assert summary.statistics is not None
    assert summary.statistics.message_count == about(bag)["message_count"]
    recording = Recording(bag)
    assert sum(1 for _ in recording.vibrations()) == 25
    assert recording.complete


def test_an_error_that_the_disk_reports_late_fails_the_recording(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file system may accept a write that it cannot carry out, and say so only when it is asked for the data on the disk."""

    def fsync(_descriptor: int) -> None:
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    recorder = Recorder(tmp_path / "bag", Configuration(), BODIES)
    recorder.write_messages(encoded(10))
    monkeypatch.setattr(os, "fsync", fsync)
    with pytest.raises(RecordingFailed, match="could not be finished: Input/output error; check the disk or give another folder"):
        recorder.close()
    monkeypatch.undo()
    assert sum(1 for _ in Recording(tmp_path / "bag").vibrations()) == 10


def test_a_disk_that_is_full_at_the_beginning_is_refused_and_nothing_is_left(tmp_path: Path) -> None:
    Recorder(tmp_path / "whole", Configuration(), BODIES)
    size = (tmp_path / "whole" / "whole_0.mcap").stat().st_size
    full = r"(cannot be written|ended at 0\.0 s): File too large; free some space or give another folder"
    for limit in range(0, size, size // 20):
        with files_of_at_most(limit), pytest.raises(Refusal, match=full):
            Recorder(tmp_path / "bag", Configuration(), BODIES)
        assert not (tmp_path / "bag").exists()


WRITER = """
import os, sys
from pathlib import Path
from made_up_blocks import BODIES, blocks
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.recordings.recorder import Recorder
recorder = Recorder(Path(sys.argv[1]), Configuration.model_validate({"recording": {"split_duration": 3.0}}), BODIES)
for block in blocks(100000):
    recorder.write(block)
    os.write(1, b"%d\\n" % block.end_ns)
"""


@pytest.mark.parametrize("seed", range(8))
def test_a_killed_writer_loses_a_second_at_most(tmp_path: Path, seed: int) -> None:
    bag = tmp_path / "bag"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(Path(__file__).parents[1] / "support"), *sys.path])}
    writer = subprocess.Popen([sys.executable, "-c", WRITER, str(bag)], stdout=subprocess.PIPE, env=environment)
    assert writer.stdout is not None
    count = int(np.random.default_rng(seed).integers(30, 600))  # the first chunk is full by then
    lines = [writer.stdout.readline() for _ in range(count)]
    writer.send_signal(signal.SIGKILL)
    rest, _ = writer.communicate(timeout=400.0)
    written_ns = int(b"".join([*lines, rest]).rstrip(b"\n").split(b"\n")[-1])
    recording = Recording(bag)
    last = [(block.stamp_ns + int(block.offsets_ns[-1])) for block in recording.vibrations()][-1]
    assert not recording.complete
    assert written_ns - last <= 1_000_000_000
