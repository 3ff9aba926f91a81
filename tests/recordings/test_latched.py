"""Recordings without a manifest are read by the latched description of the sensor, in every storage and compression of rosbag2."""

from __future__ import annotations

import json
import re
import struct
import tempfile
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from made_up_blocks import recorded
from ros2_bag_record import FORMS, WALL_NS, bag_of, messages_of
from typer.testing import CliRunner

from dcrb_ros.cli.app import app
from dcrb_ros.diagnosis.detection import detect
from dcrb_ros.exchange.export import export
from dcrb_ros.messages.plain import encode_text
from dcrb_ros.messages.topics import FEATURES, GROUND_TRUTH, SENSOR, VIBRATION, Message
from dcrb_ros.recordings import latched
from dcrb_ros.recordings.latched import header_time, in_order
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recovery import recover
from dcrb_ros.recordings.replay import Replay, ReplayParameters
from dcrb_ros.schema.refusal import AlteredSamples, Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.viewer.reader import read_content

pytestmark = pytest.mark.slow

REAL = Path(__file__).parents[3] / "shared" / "rosbag2"
"""Recordings that rosbag2 made beside a running bench with an outer-ring defect."""
BLOCKS = 130


@pytest.fixture(scope="module")
def own(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same blocks, recorded by the bench itself."""
    return recorded(tmp_path_factory.mktemp("own") / "own", BLOCKS)


@pytest.fixture(scope="module", params=FORMS)
def bag(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return bag_of(tmp_path_factory.mktemp("bags") / "bag", messages_of(BLOCKS), request.param)


def spoken(*arguments: object) -> str:
    """Return what a command prints."""
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert result.exit_code == 0, result.output
    return result.stdout


def test_the_messages_are_those_of_the_recorder_with_its_times(bag: Path, own: Path) -> None:
    recording = Recording(bag)
    expected = [(m.topic, m.time_ns, m.data) for m in Recording(own).messages() if m.topic != SENSOR]
    assert [(m.topic, m.time_ns, m.data) for m in recording.messages() if m.topic != SENSOR] == expected
    assert recording.complete
    assert recording.counts() == Recording(own).counts()


def test_waveform_truth_and_verdict_are_those_of_the_recorder(bag: Path, own: Path) -> None:
    recording, known = Recording(bag), Recording(own)
    assert (recording.sampling_rate, recording.orders, recording.bearing) == (known.sampling_rate, known.orders, known.bearing)
    assert np.array_equal(recording.waveform().acceleration, known.waveform().acceleration)
    assert recording.waveform().sensor_range == 5000.0
    assert len(recording.truth()) == len(known.truth()) == BLOCKS
    found, expected = detect(recording), detect(known)
    assert (found.last.verdict, found.last.levels, found.duration) == (expected.last.verdict, expected.last.levels, expected.duration)


def test_a_replay_sends_the_messages_of_the_recorder(bag: Path, own: Path) -> None:
    def sent(path: Path) -> list[tuple[int, list[bytes]]]:
        return [
            (bundle.end_ns, [message.data for message in bundle.messages]) for bundle in Replay(ReplayParameters(bag=str(path))).bundles()
        ]

    assert sent(bag) == sent(own)


def test_commands_answer_for_every_storage(bag: Path, own: Path, tmp_path: Path) -> None:
    about = json.loads(spoken("info", bag, "--json"))
    assert about["manifest"]["described_by"] == "/dcrb/outer_ring/sensor"
    assert about["messages"] == json.loads(spoken("info", own, "--json"))["messages"]
    words = spoken("info", bag)
    assert f"{BLOCKS * 1024} samples from 0.000 to {BLOCKS * 0.02:.3f} s" in words
    assert "no manifest" in words
    assert "configuration" not in words
    found, expected = (json.loads(spoken("detect", path, "--json")) for path in (bag, own))
    assert (found.pop("recording"), expected.pop("recording")) == (str(bag), str(own))
    assert found == expected
    spoken("export", bag, "-o", tmp_path / "wave.npz")
    with np.load(tmp_path / "wave.npz") as wave:
        assert np.array_equal(wave["index"], np.arange(BLOCKS * 1024))


def test_the_contents_of_a_bag_without_a_waveform_are_printed(tmp_path: Path) -> None:
    bag = bag_of(tmp_path / "bag", [message for message in messages_of(5) if message.topic != VIBRATION])
    said = spoken("info", bag)
    assert "no waveform" in said
    assert "outer_ring/features" in said


def test_a_recovered_bag_holds_every_message(bag: Path, tmp_path: Path) -> None:
    salvage = recover(bag, tmp_path / "new")
    recording = Recording(bag)
    assert (salvage.messages, salvage.damage) == (sum(recording.counts().values()), ())
    assert Recording(tmp_path / "new").counts() == recording.counts()
    assert [m.data for m in Recording(tmp_path / "new").messages()] == [m.data for m in recording.messages()]
    about = yaml.safe_load((tmp_path / "new" / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert (about["storage_identifier"], about["starting_time"]["nanoseconds_since_epoch"]) == ("mcap", WALL_NS)


def test_the_bench_of_any_namespace_is_found(tmp_path: Path) -> None:
    for namespace in ("/plant/axle_3", "/"):
        recording = Recording(bag_of(tmp_path / f"bag{len(namespace)}", messages_of(3), namespace=namespace))
        assert recording.namespace == namespace
        assert len(list(recording.vibrations())) == 3


def test_without_a_description_the_recording_is_refused(tmp_path: Path) -> None:
    bag = bag_of(tmp_path / "bag", [message for message in messages_of(2) if message.topic != SENSOR])
    with pytest.raises(Refusal, match=r"has no manifest of the bench and no message on outer_ring/sensor: give a recording made by"):
        Recording(bag)


@pytest.mark.parametrize("text", ["[1", "{}", '{"sampling_rate": 0, "orders": {"FTF": 1, "BPFO": 1, "BPFI": 1, "BSF": 1}}'])
def test_an_invalid_description_is_refused_with_its_topic(text: str, tmp_path: Path) -> None:
    bag = bag_of(tmp_path / "bag", [Message(SENSOR, 0, encode_text(text)), *messages_of(2)[1:]])
    with pytest.raises(
        Refusal, match=r"has no manifest of the bench, and /dcrb/outer_ring/sensor cannot take its place: the sensor's desc"
    ):
        Recording(bag)


def test_several_benches_in_one_bag_are_refused_by_name(tmp_path: Path) -> None:
    second = replace(SENSOR, name="/other/outer_ring/sensor")
    messages = messages_of(2)
    bag = bag_of(tmp_path / "bag", [*messages, replace(messages[0], topic=second)])
    with pytest.raises(
        Refusal, match=r"contains several benches, /dcrb/outer_ring/sensor, /other/outer_ring/sensor: record the topics of one"
    ):
        Recording(bag)


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [("sampling_rate", 25600, "25600 Hz"), ("orders", {"FTF": 0.4, "BPFO": 5.0, "BPFI": 7.0, "BSF": 3.0}, "BPFO 5,")],
)
def test_a_second_bench_after_the_first_is_refused(key: str, value: object, words: str, tmp_path: Path) -> None:
    # Its samples would be read with rate and orders of the first.
    first, *others = messages_of(60)
    second = replace(first, data=encode_text(json.dumps({**json.loads(first.data[8:-1]), key: value})))
    recording = Recording(bag_of(tmp_path / "bag", [first, *others, second, *others]))
    for topics in ((VIBRATION,), (SENSOR, VIBRATION), None):
        with pytest.raises(Refusal, match=f"/bag contains two benches one after the other, .*{words}.*: record them separately"):
            list(recording.messages(topics))


@pytest.mark.parametrize(("blocks", "missed"), [(300, 0), (60, 0), (200, 15)])
def test_two_runs_one_after_the_other_are_refused(blocks: int, missed: int, tmp_path: Path) -> None:
    # The samples of the second run, which have the indices of the first, were left out, exported and drawn beside them, or not replayed.
    second = [message for message in messages_of(300) if message.time_ns >= missed * 20_000_000]
    bag = bag_of(tmp_path / "bag", messages_of(blocks) + second)
    sentence = f"{bag} contains two runs one after the other: after the block at .* s, the time continues at {missed * 0.02:.3f} s"
    reads: tuple[Callable[[Recording], object], ...] = (
        Recording.waveform,
        detect,
        lambda recording: list(recording.pieces()),
        lambda recording: export(recording, tmp_path / "wave.npz"),
        read_content,
        lambda recording: list(Replay(ReplayParameters(bag=str(recording.path))).bundles()),
    )
    for read in reads:
        with pytest.raises(Refusal, match=sentence):
            read(Recording(bag))
    assert re.search(sentence, spoken("info", bag))


def test_blocks_that_are_late_are_of_the_same_run(tmp_path: Path) -> None:
    messages = [message for message in messages_of(200) if message.topic in (SENSOR, VIBRATION)]
    late = [message for message in messages if 300_000_000 <= message.time_ns < 800_000_000]
    assert len(late) == latched.MOST_LATE
    others = [message for message in messages if message not in late]
    found = Recording(bag_of(tmp_path / "bag", others[:150] + late + others[150:])).messages((VIBRATION,))
    assert sorted(message.time_ns for message in found) == [20_000_000 * k for k in range(200)]


def test_a_description_in_between_that_is_invalid_changes_nothing(tmp_path: Path) -> None:
    first, *others = messages_of(60)
    middle = [*others[:100], replace(first, data=encode_text("{}")), *others[100:]]
    found = Recording(bag_of(tmp_path / "bag", [first, *middle])).messages((VIBRATION,))
    assert [message.data for message in found] == [message.data for message in others if message.topic == VIBRATION]


def test_a_run_without_a_configuration_is_not_reproduced(tmp_path: Path) -> None:
    recording = Recording(bag_of(tmp_path / "bag", messages_of(2)))
    assert (recording.described, recording.configured, recording.imported) == (True, False, False)
    assert "no manifest" in repr(recording)
    with pytest.raises(Refusal, match="has no manifest, so the configuration of its bench is unknown"):
        _ = recording.configuration
    done = CliRunner().invoke(app, ["simulate", "--from", str(tmp_path / "bag")])
    assert isinstance(done.exception, Refusal)


def test_a_description_without_a_bearing_leaves_it_unknown(tmp_path: Path) -> None:
    first, *others = messages_of(2)
    about: dict[str, Any] = json.loads(first.data[8:-1])
    for bearing in (None, {"pitch_radius": "wide"}):
        changed = replace(first, data=encode_text(json.dumps({**about, "bearing": bearing})))
        assert Recording(bag_of(tmp_path / str(bearing is None), [changed, *others])).bearing is None
    assert Recording(bag_of(tmp_path / "whole", [first, *others])).bearing == Configuration().bearing


def test_a_part_that_begins_late_is_read_by_the_next_description(tmp_path: Path) -> None:
    """As `ros2 bag record` leaves it when it starts or splits beside a running bench, or `ros2 bag play --start-offset` sends it."""
    later = [message for message in messages_of(BLOCKS) if message.time_ns >= 1_500_000_000]
    assert later[0].topic != SENSOR
    recording = Recording(bag_of(tmp_path / "bag", later))
    assert recording.waveform().index[0] == 75 * 1024
    assert len(recording.waveform().index) == (BLOCKS - 75) * 1024


def test_the_time_of_a_header_is_read_in_both_byte_orders() -> None:
    assert header_time(Message(FEATURES, 0, b"\0\1\0\0" + struct.pack("<iI", 3, 5))) == 3_000_000_005
    assert header_time(Message(FEATURES, 0, b"\0\0\0\0" + struct.pack(">iI", 3, 5))) == 3_000_000_005
    with pytest.raises(Refusal, match=r"a message of 11 bytes on outer_ring/features is not a valid .*: it has no header"):
        header_time(Message(FEATURES, 0, bytes(11)))


@pytest.mark.skipif(not REAL.is_dir(), reason=f"the recordings of rosbag2 itself are not at {REAL}")
@pytest.mark.parametrize("form", ["mcap", "mcap_zstd_file", "mcap_zstd_messages", "sqlite3"])
def test_recordings_of_rosbag2_itself_are_read_whole(form: str) -> None:
    recording = Recording(REAL / form)
    about = yaml.safe_load((REAL / form / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    expected = {topic["topic_metadata"]["name"]: topic["message_count"] for topic in about["topics_with_message_count"]}
    assert recording.counts() == {name: count for name, count in expected.items() if count}
    assert recording.complete
    assert detect(recording).last.verdict == "outer_ring"
    assert set(recording.truth().faults) == {"outer_1"}
    assert {verdict.verdict for verdict in recording.verdicts()} == {"outer_ring"}
    index = [piece.first_index for piece in recording.pieces()]
    assert index == sorted(index)
    first = next(iter(recording.messages((VIBRATION,))))
    assert 0 < first.time_ns < 60_000_000_000  # simulated, not the wall clock
    sent = [message for bundle in Replay(ReplayParameters(bag=str(REAL / form))).bundles() for message in bundle.messages]
    assert len([message for message in sent if message.topic == VIBRATION]) == recording.counts()[VIBRATION.resolved("/dcrb")]
    assert any(message.topic == GROUND_TRUTH for message in sent)


def test_a_damaged_manifest_is_reported_and_replaced(own: Path, tmp_path: Path) -> None:
    broken = bytearray((own / "own_0.mcap").read_bytes())
    at = broken.index(b'"format"')
    broken[at] = ord("?")
    (tmp_path / "x.mcap").write_bytes(broken)
    recording = Recording(tmp_path / "x.mcap")
    assert recording.described
    (sentence,) = recording.damage
    assert sentence.startswith("x.mcap: the record dcrb_ros is not valid JSON")
    assert np.array_equal(recording.waveform().acceleration, Recording(own).waveform().acceleration)


def at(*times: float) -> list[Message]:
    """Return messages whose headers have some times [s]."""
    return [Message(FEATURES, 0, b"\0\1\0\0" + struct.pack("<iI", *divmod(round(time * 1e9), 1_000_000_000))) for time in times]


def ordered(*times: float) -> list[float]:
    return [message.time_ns * 1e-9 for message in in_order(at(*times))]


def test_messages_that_arrived_in_another_order_are_put_in_that_of_their_stamps() -> None:
    assert ordered(0.0, 0.02, 0.06, 0.04, 0.08) == pytest.approx([0.0, 0.02, 0.04, 0.06, 0.08])
    assert ordered(3.0, 3.5, 2.0, 4.1, 4.2) == pytest.approx([2.0, 3.0, 3.5, 4.1, 4.2])
    assert ordered(3.0, 4.5, 2.0, 4.6) == pytest.approx([3.0, 2.0, 4.5, 4.6])  # more than a second late


def test_times_before_zero_are_put_in_order() -> None:
    assert ordered(-10.0, -9.98, -9.96, -2.0) == pytest.approx([-10.0, -9.98, -9.96, -2.0])


def test_the_run_after_a_reset_follows_the_one_before() -> None:
    assert ordered(7.0, 7.5, 0.0, 0.5) == pytest.approx([7.0, 7.5, 0.0, 0.5])


def test_messages_of_one_time_keep_their_order_and_a_bounded_number_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    same = [replace(message, data=message.data + bytes([number])) for number, message in enumerate(at(*[1.0] * 200))]
    assert [message.data[-1] for message in in_order(same)] == list(range(200))
    monkeypatch.setattr(latched, "MAX_WAITING", 3)
    taken = iter(same)
    found = in_order(taken)
    next(found)
    assert len(list(taken)) == 200 - 4


def test_blocks_that_were_exchanged_while_recording_are_no_gap(tmp_path: Path) -> None:
    """Threads that compress messages exchange neighbours."""
    messages = messages_of(BLOCKS)
    first, second = (
        number for number, message in enumerate(messages) if message.topic == VIBRATION and message.time_ns in (10**9, 1_020_000_000)
    )
    messages[first], messages[second] = messages[second], messages[first]
    bag = bag_of(tmp_path / "bag", messages)
    assert detect(Recording(bag)).last.gaps == 0
    recover(bag, tmp_path / "recovered")
    with warnings.catch_warnings():
        warnings.simplefilter("error", AlteredSamples)
        recovered = Recording(tmp_path / "recovered").waveform()
    assert np.array_equal(recovered.acceleration, Recording(bag).waveform().acceleration)


def test_the_replay_of_a_compressed_bag_leaves_no_unpacked_copy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # A node ends its process at once, without the destructors.
    bag = bag_of(tmp_path / "bag", messages_of(5), "mcap_zstd_file")
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    replay = Replay(ReplayParameters(bag=str(bag)))
    assert list((tmp_path / "temporary").iterdir())
    replay.close()
    assert not list((tmp_path / "temporary").iterdir())
