"""Recordings, read by this package and by others: complete, cut off and invalid ones."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
import yaml
from made_up_blocks import encoded, narrowed, recorded, written
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from runs import Run, simulated

from dcrb_ros.bearing.frequencies import characteristic_orders
from dcrb_ros.cli.detect import detect
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.exam.detector_run import shipped_detector
from dcrb_ros.messages.points import SAMPLE
from dcrb_ros.messages.topics import ACCELERATION, FEATURES, GROUND_TRUTH, MANIFEST, NAMESPACE, ROLLER_STATES, SENSOR, VIBRATION
from dcrb_ros.recordings import storage
from dcrb_ros.recordings.manifest import OUTCOME, record_text
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.recordings.recovery import recover
from dcrb_ros.recordings.splitting import Bag
from dcrb_ros.recordings.verification import metadata_flaw
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.stream.event_text import encode_command
from dcrb_ros.stream.events import SpeedCommand, TimedCommand
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
        SENSOR: 1 + (run.blocks[-1].end_ns - 1) // 1_000_000_000,  # at the start and every second
        VIBRATION: len(run.blocks),
        FEATURES: len(run.blocks),
        ROLLER_STATES: len(run.states),
        GROUND_TRUTH: sum(len(block.truths) for block in run.blocks),
        ACCELERATION: sum(len(block.preview_ns) for block in run.blocks),
    }
    return {topic.resolved(NAMESPACE): count for topic, count in counts.items()}


def shipped(counts: Mapping[str, int], run: Run) -> dict[str, int]:
    """Return the counts of the shipped topics, without a topic that an extension has added."""
    return {topic: counts.get(topic, 0) for topic in expected_counts(run)}


def points(data: npt.NDArray[np.uint8] | bytes) -> npt.NDArray[np.float32]:
    cloud = np.frombuffer(bytes(data), SAMPLE)
    return np.column_stack([cloud["ax"], cloud["ay"], cloud["shaft_angle"]])


def test_rosbags_reads_the_same(run: Run, bag: Path) -> None:
    with AnyReader([bag]) as other:
        assert shipped({c.topic: c.msgcount for c in other.connections}, run) == expected_counts(run)
        waveform = [c for c in other.connections if c.topic == WAVEFORM]
        read = [points(other.deserialize(raw, c.msgtype).data) for c, _, raw in other.messages(waveform)]
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
    assert shipped(counts, run) == expected_counts(run)
    assert np.array_equal(np.concatenate(read), samples(run))


def test_rerun_reads_a_recording_without_warnings(bag: Path) -> None:
    command = [str(Path(sys.executable).with_name("rerun")), "mcap", "check", "--full", str(bag / "outer_0.mcap")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=400, check=False)
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
    counts = {topic["topic_metadata"]["name"]: topic["message_count"] for topic in about["topics_with_message_count"]}
    assert about["message_count"] == sum(counts.values())
    assert shipped(counts, run) == expected_counts(run)
    for topic in about["topics_with_message_count"]:
        assert isinstance(topic["topic_metadata"]["offered_qos_profiles"], list)
        assert topic["topic_metadata"]["type_description_hash"].startswith("RIHS01_")


def test_the_manifest_describes_the_recording(run: Run, bag: Path) -> None:
    recording = Recording(bag)
    assert recording.configuration == run.configuration
    assert recording.manifest["seed"] == 1
    assert shipped(recording.counts(), run) == expected_counts(run)
    assert recording.complete


def test_the_intact_part_of_a_cut_off_recording_is_read(run: Run, bag: Path, tmp_path: Path) -> None:
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


def test_foreign_and_invalid_files_are_refused(bag: Path, tmp_path: Path) -> None:
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


def test_flipped_bytes_never_cause_a_traceback(bag: Path, tmp_path: Path) -> None:
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


def test_existing_and_invalid_outputs_are_refused(run: Run, bag: Path, tmp_path: Path) -> None:
    with pytest.raises(Refusal, match="exists: give another name"):
        Recorder(bag, run.configuration, BodyNames(2, 16))
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    with pytest.raises(Refusal, match="cannot be created"):
        Recorder(blocked / "bag", run.configuration, BodyNames(2, 16))


def test_a_changed_range_is_read_with_its_blocks(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bag = narrowed(tmp_path / "bag", 175, at=75, limit=20.0)
    assert [span for _, span in Recording(bag).ranged_vibrations()] == [5000.0] * 75 + [20.0] * 100
    detect([bag], as_json=True)
    verdicts = [found["verdict"] for found in json.loads(capsys.readouterr().out)["history"]]
    assert verdicts == [diagnosis.verdict for diagnosis in shipped_detector(DetectorParameters()).diagnose(Recording(bag)).received]
    assert "sensor" not in verdicts


def made(path: Path, outcome: Mapping[str, object] | None = None, **changes: object) -> Recording:
    """Return a recording of three blocks whose manifest has some other entries; None removes an entry."""
    return Recording(written(path, encoded(3, events={1: SpeedCommand(130.0)}), outcome=outcome, **changes))


@pytest.mark.parametrize("number", [1, None, 0, 2, 3])
def test_an_outcome_is_expected_from_the_second_format_on(number: int | None, tmp_path: Path) -> None:
    recording = made(tmp_path / "bag", format=number)
    old = number in (1, None)
    assert recording.complete == old
    assert recording.damage == ([] if old else ["bag_0.mcap: the end is missing, the recording was cut off"])
    assert made(tmp_path / "whole", {"samples": 3072}, format=number).complete


def test_the_end_that_is_missing_is_that_of_the_last_file(tmp_path: Path) -> None:
    bag = recorded(tmp_path / "bag", 35, split_duration=0.2)
    assert len(Recording(bag).files) == 4
    last = bag / "bag_3.mcap"
    whole = last.read_bytes()
    last.write_bytes(whole[: len(whole) // 2])
    assert Recording(bag).damage[-1] == "bag_3.mcap: the end is missing, the recording was cut off"


def test_representation_states_length_rate_content_and_damage(tmp_path: Path) -> None:
    summary = Configuration().summary
    for outcome, changes, expected in (
        ({"samples": 3072}, {}, f"0.06 s at 51.2 kHz, {summary}"),
        ({"samples": 3072}, {"imported": {}}, "0.06 s at 51.2 kHz, imported data"),
        ({"samples": 3072}, {"sampling_rate": None}, f"of unknown length at 0 kHz, {summary}"),
        ({}, {}, f"of unknown length at 51.2 kHz, {summary}"),
        (None, {}, f"of unknown length at 51.2 kHz, {summary}, damaged"),
    ):
        path = tmp_path / str(len(list(tmp_path.iterdir())))
        assert repr(made(path, outcome, **changes)) == f"<Recording {path}: {expected}>"


@pytest.mark.parametrize(
    ("rate", "accepted"), [(1, True), (51200, True), (10_000_000, True), (0, False), (-1, False), (10_000_001, False), (None, False)]
)
def test_sampling_rates_up_to_10_mhz_are_accepted(rate: int | None, accepted: bool, tmp_path: Path) -> None:
    recording = made(tmp_path / "bag", {}, sampling_rate=rate)
    if accepted:
        assert recording.sampling_rate == rate
    else:
        with pytest.raises(Refusal, match=f"gives a sampling rate of {rate} Hz: it must be a whole number within 1 .. 10000000 Hz"):
            _ = recording.sampling_rate


def test_imported_data_have_orders_and_no_configuration(tmp_path: Path) -> None:
    recording = made(tmp_path / "bag", {}, imported={}, configuration=None)
    assert recording.imported
    assert recording.orders.as_dict() == made(tmp_path / "run", {}).orders.as_dict()
    assert not made(tmp_path / "bench", {}).imported
    with pytest.raises(Refusal, match="contains imported data, not a run of the bench"):
        _ = recording.configuration
    with pytest.raises(Refusal, match="gives no fault orders: import the data again"):
        _ = made(tmp_path / "none", {}, imported={}, orders={}).orders


def test_orders_of_a_run_are_those_of_its_configuration(tmp_path: Path) -> None:
    assert made(tmp_path / "bag", {}, orders={}).orders == characteristic_orders(Configuration().bearing)


@pytest.mark.parametrize(
    ("outcome", "speeds", "damage"),
    [
        ({"commands": [encode_command(TimedCommand(5, SpeedCommand(1.5)))]}, [1.5], 0),
        ({"commands": []}, [], 0),
        ({"commands": None}, [130.0], 0),
        ({"commands": [7]}, [130.0], 1),
        (None, [130.0], 1),
    ],
)
def test_commands_come_from_the_outcome_or_else_from_the_ground_truth(
    outcome: dict[str, object] | None, speeds: list[float], damage: int, tmp_path: Path
) -> None:
    recording = made(tmp_path / "bag", outcome)
    for _ in range(2):
        assert [timed.command for timed in recording.commands()] == [SpeedCommand(speed) for speed in speeds]
        assert len(recording.damage) == damage  # each sentence once


def test_messages_are_those_of_the_topics_in_the_namespace(tmp_path: Path) -> None:
    recording = made(tmp_path / "bag", {})
    assert {message.topic for message in recording.messages()} == {VIBRATION, FEATURES, GROUND_TRUTH}
    assert {message.topic for message in recording.messages((FEATURES,))} == {FEATURES}
    assert list(recording.messages(())) == list(recording.messages([])) == []
    assert list(recording.messages(namespace="/other")) == []
    assert [message.time_ns for message in recording.messages((VIBRATION,))] == [0, 20_000_000, 40_000_000]
    assert made(tmp_path / "elsewhere", {}, namespace="/other").counts() == recording.counts()
    assert list(Recording(tmp_path / "elsewhere").messages()) == []


def test_a_recording_without_a_waveform_is_refused(tmp_path: Path) -> None:
    with pytest.raises(Refusal, match="contains no messages on /other/outer_ring/vibration"):
        list(made(tmp_path / "bag", {}, namespace="/other").vibrations())


@pytest.mark.parametrize(
    ("sensor", "expected"),
    [
        ({"range": 20.0}, 20.0),
        ({"range": 7}, 7.0),
        ({"range": 0.5}, 0.5),
        ({"range": 0.0}, 0.0),
        ({"range": -20.0}, 0.0),
        ({"range": -0.5}, 0.0),
        ({"range": "20"}, 0.0),
        ({"frame": "a"}, 0.0),
        (None, 5000.0),
    ],
)
def test_the_first_range_is_that_of_the_manifest(sensor: dict[str, object] | None, expected: float, tmp_path: Path) -> None:
    recording = made(tmp_path / "bag", {}, sensor=sensor)
    assert [limit for _, limit in recording.ranged_vibrations()] == [expected] * 3


def test_a_manifest_that_is_damaged_in_the_first_file_is_read_from_the_next(tmp_path: Path) -> None:
    for number, text in enumerate(("[]", '{"namespace": 7}', "{", None)):
        about = made(tmp_path / f"bag{number}", {}).manifest | {"seed": 99}
        entries = [{"manifest": text}] if text is not None else [{"other": "{}"}]
        folder = tmp_path / f"split{number}"
        folder.mkdir()
        for file, entry in enumerate([*entries, {"manifest": record_text(about)}]):
            Bag(tmp_path / f"part{number}{file}", opening={MANIFEST: entry}, closing=lambda: {OUTCOME: {"outcome": "{}"}}).close()
            (tmp_path / f"part{number}{file}" / f"part{number}{file}_0.mcap").rename(folder / f"split_{file}.mcap")
        assert Recording(folder).manifest["seed"] == 99


def test_the_outcome_is_the_last_one_in_the_last_file(tmp_path: Path) -> None:
    bag = recorded(tmp_path / "bag", 35, split_duration=0.2)
    of_files = [(Recording(file).outcome or {})["samples"] for file in Recording(bag).files]
    assert of_files == sorted(set(of_files))  # of the run so far
    assert (Recording(bag).outcome or {})["samples"] == of_files[-1] == 35 * 1024


def test_a_configuration_of_another_version_is_refused_with_the_reason(tmp_path: Path) -> None:
    later = Configuration().model_dump() | {"gear": 3}
    recording = made(tmp_path / "bag", {}, configuration=later, dcrb_ros="0.0.1")
    with pytest.raises(Refusal, match=r"\(dcrb_ros 0\.0\.1\) is damaged or not understood by .* \(gear: .*\): read it"):
        recording.configuration  # noqa: B018 - a property
    assert recording.bearing == Configuration().bearing
    assert "of another version" in repr(recording)
    assert recover(tmp_path / "bag", tmp_path / "new").messages == sum(recording.counts().values())
    with pytest.raises(Refusal, match=r"\(dcrb_ros unknown\) is damaged or not understood by .* \('configuration'\): read it with"):
        made(tmp_path / "none", {}, configuration=None, dcrb_ros=None)


@pytest.mark.parametrize("thermal", [None, "none", {"law": "none"}, {}])
def test_temperatures_are_read_whatever_the_thermal_group_of_another_version_is(thermal: object, tmp_path: Path) -> None:
    recording = made(tmp_path / "bag", {}, configuration=Configuration().model_dump() | {"thermal": thermal})
    assert len(recording.temperatures.time) == 0


def test_a_bearing_of_another_version_is_refused_when_the_recording_is_opened(tmp_path: Path) -> None:
    later = {**Configuration().model_dump(), "bearing": {**Configuration().bearing.model_dump(), "rows": 9}}
    with pytest.raises(Refusal, match=r"is damaged or not understood by .* \(bearing\.rows: .*\): read it"):
        made(tmp_path / "bag", {}, configuration=later)


def edited(bag: Path, old: bytes, new: bytes) -> Path:
    """Replace bytes in the file of a recording by others of the same length."""
    file = next(bag.glob("*.mcap"))
    content = file.read_bytes()
    assert old in content
    assert len(old) == len(new)
    file.write_bytes(content.replace(old, new))
    return bag


def test_another_number_in_the_manifest_is_named_and_not_used(tmp_path: Path) -> None:
    """The description of the sensor, which a checksum covers, takes the place of the manifest."""
    bag = recorded(tmp_path / "bag", 3)
    orders = Recording(bag).orders
    damaged = Recording(edited(bag, b'"rollers_per_row": 16', b'"rollers_per_row": 17'))
    assert "the record dcrb_ros is damaged" in damaged.damage[0]
    assert damaged.orders == orders


def test_another_number_in_the_outcome_is_named(tmp_path: Path) -> None:
    damaged = Recording(edited(recorded(tmp_path / "bag", 3), b'"samples": 3072', b'"samples": 3071'))
    assert damaged.outcome is None
    assert "the record dcrb_ros_outcome is damaged" in damaged.damage[0]


def test_a_manifest_without_a_digest_that_contradicts_itself_is_refused(tmp_path: Path) -> None:
    orders = {**made(tmp_path / "bag", {}).manifest["orders"], "BPFO": 7.0}
    with pytest.raises(Refusal, match=r"was changed: its BPFO is 7, but 6\.7\d* follows from its bearing"):
        made(tmp_path / "other", {}, orders=orders)


def test_metadata_must_name_every_file(tmp_path: Path) -> None:
    bag = recorded(tmp_path / "bag", 15, split_duration=0.1)
    assert metadata_flaw(bag) == ""
    assert metadata_flaw(bag / "bag_0.mcap") == ""  # a file needs none
    (bag / "bag_7.mcap").write_bytes((bag / "bag_0.mcap").read_bytes())
    (bag / "bag_8.mcap").write_bytes((bag / "bag_0.mcap").read_bytes())
    assert metadata_flaw(bag) == "metadata.yaml does not name bag_7.mcap, bag_8.mcap"


@pytest.mark.parametrize("excess", [0, 1])
def test_metadata_up_to_the_limit_are_read(excess: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    bag = recorded(tmp_path / "bag", 1)
    size = (bag / "metadata.yaml").stat().st_size
    monkeypatch.setattr(storage, "LARGEST_METADATA", size - excess)
    assert metadata_flaw(bag) == (f"metadata.yaml has {size} bytes; at most {size - 1} are read" if excess else "")


def test_huge_metadata_is_not_read(tmp_path: Path) -> None:
    bag = recorded(tmp_path / "bag", 2)
    with (bag / "metadata.yaml").open("ab") as stream:
        stream.truncate(1 << 33)
    assert "bytes; at most 4000000 are read" in metadata_flaw(bag)
    (bag / "metadata.yaml").unlink()
    assert "No such file" in metadata_flaw(bag)
