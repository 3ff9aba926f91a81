"""Recordings: written, read back by ourselves and by others, cut off, refused."""

from __future__ import annotations

import json
import resource
import subprocess
import sys
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
import yaml
from made_up_blocks import narrowed
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from runs import Run, simulated

from dcrb_ros.cli.detect import detect
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.exam.detector_run import run_shipped_detector
from dcrb_ros.messages.points import SAMPLE
from dcrb_ros.messages.topics import ACCELERATION, FEATURES, GROUND_TRUTH, NAMESPACE, ROLLER_STATES, SENSOR, VIBRATION
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recorder import Recorder, RecordingFailed
from dcrb_ros.runtime.refusal import Refusal
from dcrb_ros.stream.states import BodyNames

WAVEFORM = VIBRATION.resolved(NAMESPACE)


@pytest.fixture(scope="module")
def run() -> Run:
    return simulated(2.0, fault="outer_1", state_rate=100)


@pytest.fixture(scope="module")
def bag(run: Run, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("bags") / "outer"
    with Recorder(path, run.configuration, BodyNames(2, 16)) as recorder:
        for block in run.blocks:
            recorder.write(block)
    return path


def samples(run: Run) -> npt.NDArray[np.float32]:
    return np.concatenate([np.column_stack([block.acceleration, block.shaft_angle]) for block in run.blocks])


def expected_counts(run: Run) -> dict[str, int]:
    counts = {
        SENSOR: 1,
        VIBRATION: len(run.blocks),
        FEATURES: len(run.blocks),
        ROLLER_STATES: len(run.states),
        GROUND_TRUTH: sum(len(block.truths) for block in run.blocks),
        ACCELERATION: sum(len(block.preview_ns) for block in run.blocks),
    }
    return {topic.resolved(NAMESPACE): count for topic, count in counts.items()}


def points(data: npt.NDArray[np.uint8] | bytes) -> npt.NDArray[np.float32]:
    cloud = np.frombuffer(bytes(data), SAMPLE)
    return np.column_stack([cloud["ax"], cloud["ay"], cloud["shaft_angle"]])


def test_rosbags_reads_the_same(run: Run, bag: Path) -> None:
    with AnyReader([bag]) as reader:
        assert {c.topic: c.msgcount for c in reader.connections} == expected_counts(run)
        waveform = [c for c in reader.connections if c.topic == WAVEFORM]
        read = [points(reader.deserialize(raw, c.msgtype).data) for c, _, raw in reader.messages(waveform)]
    assert np.array_equal(np.concatenate(read), samples(run))


def test_mcap_ros2_reads_the_same(run: Run, bag: Path) -> None:
    counts: dict[str, int] = {}
    read = []
    with (bag / "outer_0.mcap").open("rb") as stream:
        for _, channel, message, decoded in make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages():
            counts[channel.topic] = counts.get(channel.topic, 0) + 1
            assert message.log_time == message.publish_time
            if channel.topic == WAVEFORM:
                read.append(points(decoded.data))
    assert counts == expected_counts(run)
    assert np.array_equal(np.concatenate(read), samples(run))


def test_rerun_finds_nothing_to_remark(bag: Path) -> None:
    command = [str(Path(sys.executable).with_name("rerun")), "mcap", "check", "--full", str(bag / "outer_0.mcap")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    words = done.stdout + done.stderr
    assert done.returncode == 0, words
    remarks = [line for line in words.splitlines() if any(word in line.lower() for word in ("warn", "error", "fail", "unordered"))]
    assert all("unordered" in line.lower() and "vibration" in line for line in remarks), words


def test_metadata_has_every_key_of_version_9(bag: Path, run: Run) -> None:
    about = yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert about["version"] == 9
    assert set(about) == {
        "version", "storage_identifier", "duration", "starting_time", "message_count", "topics_with_message_count",
        "compression_format", "compression_mode", "relative_file_paths", "files", "custom_data", "ros_distro",
    }  # fmt: skip
    assert about["message_count"] == sum(expected_counts(run).values())
    for topic in about["topics_with_message_count"]:
        assert isinstance(topic["topic_metadata"]["offered_qos_profiles"], list)
        assert topic["topic_metadata"]["type_description_hash"].startswith("RIHS01_")


def test_recording_explains_itself(run: Run, bag: Path) -> None:
    recording = Recording(bag)
    assert recording.configuration == run.configuration
    assert recording.manifest["seed"] == 1
    assert recording.counts() == expected_counts(run)
    assert recording.complete


def test_cut_off_recordings_give_what_is_there(run: Run, bag: Path, tmp_path: Path) -> None:
    whole = (bag / "outer_0.mcap").read_bytes()
    full, reached = samples(run), []
    for share in (0.99, 0.7, 0.4, 0.15):
        cut = tmp_path / f"cut{share}.mcap"
        cut.write_bytes(whole[: int(share * len(whole))])
        recording = Recording(cut)
        read = [np.column_stack([v.acceleration, v.shaft_angle]) for v in recording.vibrations()]
        joined = np.concatenate(read)
        assert np.array_equal(joined, full[: len(joined)])
        assert not recording.complete
        reached.append(len(joined))
    assert len(full) - reached[0] <= 51200  # a second at most, as the recorder flushes every second
    assert reached == sorted(reached, reverse=True)


def test_foreign_and_broken_files_are_refused(bag: Path, tmp_path: Path) -> None:
    with pytest.raises(Refusal, match="there is no recording"):
        Recording(tmp_path / "nothing")
    empty = tmp_path / "empty"
    empty.mkdir()
    with pytest.raises(Refusal, match=r"contains no \.mcap file"):
        Recording(empty)
    text = tmp_path / "text.mcap"
    text.write_text("not a recording")
    with pytest.raises(Refusal, match="is not an MCAP file"):
        Recording(text)
    head = tmp_path / "head.mcap"
    head.write_bytes((bag / "outer_0.mcap").read_bytes()[:40])
    with pytest.raises(Refusal, match="has no manifest"):
        Recording(head)


def test_flipped_bytes_never_end_in_a_traceback(bag: Path, tmp_path: Path) -> None:
    whole = bytearray((bag / "outer_0.mcap").read_bytes())
    random = np.random.default_rng(3)
    for at in random.integers(0, min(len(whole), 300_000), 60):
        broken = bytearray(whole)
        broken[at] ^= 0xFF
        path = tmp_path / "flipped.mcap"
        path.write_bytes(broken)
        try:
            count = sum(1 for _ in Recording(path).vibrations())
        except Refusal as refusal:
            assert str(refusal)  # noqa: PT017 - a refusal is one of the two right answers
        else:
            assert 0 < count <= 100


def test_existing_and_impossible_outputs_are_refused(run: Run, bag: Path, tmp_path: Path) -> None:
    with pytest.raises(Refusal, match="exists: give another name"):
        Recorder(bag, run.configuration, BodyNames(2, 16))
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    with pytest.raises(Refusal, match="cannot be created"):
        Recorder(blocked / "bag", run.configuration, BodyNames(2, 16))


def test_a_disk_without_room_leaves_nothing_behind(run: Run, tmp_path: Path) -> None:
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, hard))
    try:
        with pytest.raises(Refusal, match="cannot be written: File too large; make room"):
            Recorder(tmp_path / "none", run.configuration, BodyNames(2, 16))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert not (tmp_path / "none").exists()


def record_all(recorder: Recorder, run: Run) -> None:
    for block in run.blocks * 3:
        recorder.write(block)


def test_full_disk_ends_with_a_reason_and_a_readable_file(run: Run, tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "full", run.configuration, BodyNames(2, 16))
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (500_000, hard))
    try:
        with pytest.raises(RecordingFailed, match="ended at"):
            record_all(recorder, run)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    recorder.close()
    recording = Recording(tmp_path / "full")
    assert sum(1 for _ in recording.vibrations()) > 10
    assert not recording.complete


def test_a_range_that_changes_is_followed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bag = narrowed(tmp_path / "bag", 175, at=75, limit=20.0)
    assert [span for _, span in Recording(bag).ranged_vibrations()] == [5000.0] * 75 + [20.0] * 100
    detect(bag, as_json=True)
    verdicts = [found["verdict"] for found in json.loads(capsys.readouterr().out)["history"]]
    assert verdicts == [diagnosis.verdict for diagnosis in run_shipped_detector(bag, DetectorParameters())]
    assert "sensor" not in verdicts
