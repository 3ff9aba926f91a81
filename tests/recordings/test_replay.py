"""A recording as a source of messages: parameters, bundles and the sensor description."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from made_up_blocks import BODIES, encoded, narrowed, recorded, written
from pydantic import ValidationError
from same_process import dcrb

from dcrb_ros.messages.description import decode_range, sensor_text
from dcrb_ros.messages.plain import decode_text
from dcrb_ros.messages.topics import FEATURES, GROUND_TRUTH, SENSOR, SIMULATED, VIBRATION, Message
from dcrb_ros.messages.topics.vehicle import VEHICLE_DIAGNOSIS
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.recordings.replay import Replay, ReplayParameters
from dcrb_ros.recordings.vehicle_recorder import VehicleRecorder
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.vehicle.file import read_parameters, vehicle_of
from dcrb_ros.vehicle.simulation import VehicleSimulation

BLOCK_NS = 20_000_000


def replay_of(path: Path, messages: Sequence[Message], **parameters: Any) -> Replay:
    """Record messages after the sensor description at the time 0, and replay them."""
    with Recorder(path, Configuration(), BODIES) as recorder:
        recorder.write_messages(messages)
    return Replay(ReplayParameters(bag=str(path), **parameters))


def at(*times: int) -> list[Message]:
    return [Message(FEATURES, time, b"%d" % time) for time in times]


def bundled(replay: Replay) -> list[tuple[int, int, list[int]]]:
    """Return begin, end and the times of the messages of each bundle."""
    return [(bundle.begin_ns, bundle.end_ns, [message.time_ns for message in bundle.messages]) for bundle in replay.bundles()]


def test_parameters_have_the_documented_defaults() -> None:
    assert ReplayParameters().model_dump() == {
        "bag": "",
        "rate": 1.0,
        "loop": False,
        "offset": 0.0,
        "clock": False,
        "topics": "",
        "listeners": 1,
        "wait": 3.0,
    }


@pytest.mark.parametrize(("name", "low", "high"), [("rate", 0.0, 1e3), ("offset", 0.0, 1e6), ("listeners", 0, 1000), ("wait", 0.0, 1e4)])
def test_parameters_are_accepted_within_their_limits_only(name: str, low: float, high: float) -> None:
    step = 1 if isinstance(low, int) else 0.5
    for value in (low, high, low + step, high - step):
        assert getattr(ReplayParameters.model_validate({name: value}), name) == value
    for value in (low - step, high + step):
        with pytest.raises(ValidationError):
            ReplayParameters.model_validate({name: value})


def test_only_the_rate_can_change_while_a_replay_runs() -> None:
    extra = {name: field.json_schema_extra for name, field in ReplayParameters.model_fields.items()}
    assert [name for name, about in extra.items() if isinstance(about, dict) and about["run_time"]] == ["rate"]


def test_a_replay_without_a_recording_is_refused() -> None:
    with pytest.raises(Refusal, match="there is nothing to replay"):
        Replay(ReplayParameters())


def test_messages_of_one_time_are_sent_together(tmp_path: Path) -> None:
    replay = replay_of(tmp_path / "bag", at(10, 10, 30, 30, 30, 70))
    assert bundled(replay) == [(10, 10, [10, 10]), (10, 30, [30, 30, 30]), (30, 70, [70])]


def test_a_message_that_was_recorded_late_is_sent_with_the_next_ones(tmp_path: Path) -> None:
    replay = replay_of(tmp_path / "bag", at(10, 30, 20, 40))
    assert bundled(replay) == [(10, 10, [10]), (10, 30, [30, 20]), (30, 40, [40])]


def test_blocks_are_due_at_their_end_with_the_messages_in_them(tmp_path: Path) -> None:
    replay = Replay(ReplayParameters(bag=str(recorded(tmp_path / "bag", 5))))
    bundles = list(replay.bundles())
    assert [bundle.end_ns for bundle in bundles] == [BLOCK_NS * k for k in range(1, 6)]
    assert [bundle.begin_ns for bundle in bundles] == [BLOCK_NS * k for k in range(5)]
    assert [bundle.messages[0].topic for bundle in bundles] == [VIBRATION] * 5
    assert sum(len(bundle.messages) for bundle in bundles) == sum(replay.recording.counts().values()) - 1


@pytest.mark.parametrize(("offset", "first"), [(0.0, 50), (20e-9, 70), (21e-9, 90), (40e-9, 90)])
def test_an_offset_counts_from_the_first_message(offset: float, first: int, tmp_path: Path) -> None:
    replay = replay_of(tmp_path / "bag", at(50, 70, 90), offset=offset)
    assert next(bundle.messages[0].time_ns for bundle in replay.bundles()) == first


def test_an_offset_beyond_the_end_is_refused(tmp_path: Path) -> None:
    replay = replay_of(tmp_path / "bag", at(50, 70, 90), offset=2.5)
    with pytest.raises(Refusal, match=r"has no message later than 2\.5 s after its start: lower the offset"):
        list(replay.bundles())


def test_a_check_reads_the_first_bundle_and_changes_nothing(tmp_path: Path) -> None:
    bag = narrowed(tmp_path / "bag", 6, at=3, limit=20.0)
    checked, replay = (Replay(ReplayParameters(bag=str(bag), offset=0.1)) for _ in range(2))
    checked.check()
    assert checked.start() == replay.start()
    assert list(checked.bundles()) == list(replay.bundles())
    with pytest.raises(Refusal, match="has no message later than 9 s after its start: lower the offset"):
        Replay(ReplayParameters(bag=str(bag), offset=9.0)).check()


def test_the_command_refuses_such_an_offset_before_it_starts_ros(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("dcrb_ros.nodes.programs.run", lambda *_, **__: pytest.fail("a node was started"))
    assert dcrb("replay", str(recorded(tmp_path / "bag", 5)), "--offset", "9") == 2
    assert "has no message later than 9 s after its start: lower the offset" in capsys.readouterr().err


def test_a_recording_without_the_topics_is_refused(tmp_path: Path) -> None:
    with pytest.raises(Refusal, match="has no message on the topics to replay: dcrb info lists the topics that it has"):
        replay_of(tmp_path / "bag", []).check()


def test_the_description_of_the_sensor_alone_is_refused(tmp_path: Path) -> None:
    bag = str(recorded(tmp_path / "bag", 3))
    with pytest.raises(
        Refusal, match="topics: outer_ring/sensor is replayed beside every other topic: name another one, such as outer_ring/v"
    ):
        Replay(ReplayParameters(bag=bag, topics="outer_ring/sensor"))


@pytest.mark.parametrize(
    ("topics", "awaited"),
    [
        ("", VIBRATION),
        ("ground_truth, outer_ring/vibration", VIBRATION),
        ("outer_ring/sensor, outer_ring/features, ground_truth", FEATURES),
    ],
)
def test_the_waveform_is_awaited_or_else_the_first_topic(topics: str, awaited: object, tmp_path: Path) -> None:
    assert Replay(ReplayParameters(bag=str(recorded(tmp_path / "bag", 3)), topics=topics)).awaited == awaited


def test_a_topic_without_messages_is_not_awaited(tmp_path: Path) -> None:
    assert replay_of(tmp_path / "bag", at(50, 70)).awaited == FEATURES


@pytest.mark.parametrize(
    ("topics", "expected"),
    [
        ("", [topic for topic in SIMULATED if topic.name in ("outer_ring/vibration", "outer_ring/features", "ground_truth")]),
        ("outer_ring/features", [FEATURES]),
        ("ground_truth, outer_ring/vibration", [GROUND_TRUTH, VIBRATION]),
    ],
)
def test_only_chosen_topics_are_replayed(topics: str, expected: list[object], tmp_path: Path) -> None:
    replay = Replay(ReplayParameters(bag=str(recorded(tmp_path / "bag", 3)), topics=topics))
    found = {message.topic for bundle in replay.bundles() for message in bundle.messages}
    assert found == set(expected)
    assert [topic.name for topic in replay.topics] == (
        [topic.name for topic in SIMULATED] if not topics else [SENSOR.name, *topics.split(", ")]
    )


def test_a_named_topic_without_messages_is_refused(tmp_path: Path) -> None:
    bag = recorded(tmp_path / "bag", 3)
    Replay(ReplayParameters(bag=str(bag), topics="outer_ring/vibration, outer_ring/sensor")).check()
    with pytest.raises(Refusal, match=r"^topics: .*bag has no message on diagnosis, fault_indicators: dcrb info lists the topics that"):
        Replay(ReplayParameters(bag=str(bag), topics="fault_indicators, outer_ring/vibration, diagnosis")).check()


def test_separators_alone_name_no_topic(tmp_path: Path) -> None:
    bag = str(recorded(tmp_path / "bag", 3))
    assert Replay(ReplayParameters(bag=bag, topics=" , ")).topics == Replay(ReplayParameters(bag=bag)).topics


@pytest.fixture(scope="module")
def vehicle(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Record a vehicle: its description, the vibration of one box, and a judgement of the vehicle."""
    path, parameters = tmp_path_factory.mktemp("vehicle") / "run", read_parameters("healthy_bogie", ())
    with VehicleRecorder(path, parameters, VehicleSimulation(vehicle_of(parameters, "test"))) as recorder:
        vibration = next(message for message in encoded(1) if message.topic == VIBRATION)
        recorder.write_messages([Message(VIBRATION.below("axle_2/right"), 0, vibration.data), Message(VEHICLE_DIAGNOSIS, 50, b"")])
    return path


@pytest.mark.parametrize(
    ("topics", "sentence"),
    [
        ("outer_ring/features", r"run has no message on outer_ring/features: dcrb info"),
        (
            "axle_1/left/outer_ring/features",
            r"belongs to one box: name outer_ring/features for all boxes, or replay .*run/axle_1\.left alone",
        ),
        ("vehicle/state", "vehicle/state of a vehicle is replayed in any case: leave it out"),
        ("vehicle/indicators", "vehicle/indicators is replayed with diagnosis: name that"),
        ("axle_3/left/outer_ring/features", "there is no topic 'axle_3/left/outer_ring/features'"),
    ],
)
def test_topics_that_a_vehicle_does_not_have_are_refused(topics: str, sentence: str, vehicle: Path) -> None:
    with pytest.raises(Refusal, match=f"^topics: .*{sentence}"):
        Replay(ReplayParameters(bag=str(vehicle), topics=topics)).check()


@pytest.mark.parametrize("topics", ["outer_ring/vibration", "diagnosis", ""])
def test_a_topic_of_one_box_or_of_the_vehicle_is_enough(topics: str, vehicle: Path) -> None:
    Replay(ReplayParameters(bag=str(vehicle), topics=topics)).check()


def test_an_unknown_topic_is_refused_by_the_name_of_the_parameter(tmp_path: Path) -> None:
    bag = recorded(tmp_path / "bag", 3)
    with pytest.raises(Refusal, match=r"^topics: there is no topic 'diagnoses'; did you mean 'diagnosis'"):
        Replay(ReplayParameters(bag=str(bag), topics="diagnoses"))


@pytest.mark.parametrize(("offset", "passed"), [(0.0, 3), (0.1, 0)])
def test_a_range_that_changes_is_replayed_with_its_block(offset: float, passed: int, tmp_path: Path) -> None:
    bag = narrowed(tmp_path / "bag", 6, at=3, limit=20.0)
    replay = Replay(ReplayParameters(bag=str(bag), offset=offset, topics=VIBRATION.name))
    assert [decode_range(message.data) for message in replay.start()] == [5000.0]
    first, again = ([bundle.messages for bundle in replay.bundles()] for _ in range(2))
    told = [[decode_range(message.data) for message in bundle if message.topic == SENSOR] for bundle in first]
    assert told == [[]] * passed + [[20.0]] + [[]] * (5 - round(50 * offset) - passed)
    assert [message.topic for message in first[passed]] == [SENSOR, VIBRATION]
    # A loop begins with the first range again; an offset behind the change has only the second.
    assert [message.topic for message in again[0]] == ([VIBRATION] if offset else [SENSOR, VIBRATION])


@pytest.mark.parametrize("described", [True, False])
def test_without_a_recorded_description_that_of_the_manifest_is_sent(described: bool, tmp_path: Path) -> None:
    sensor = {"sampling_rate": 51200, "range": 7.0, "frame": "a"} if described else None
    bag = written(tmp_path / "bag", encoded(2), outcome=None, sensor=sensor)
    (message,) = Replay(ReplayParameters(bag=str(bag))).start()
    assert (message.topic, message.time_ns) == (SENSOR, 0)
    expected = '{"frame": "a", "range": 7.0, "sampling_rate": 51200}' if described else sensor_text(Configuration())
    assert decode_text(message.data) == expected


def test_a_recorded_description_is_sent_as_it_is(tmp_path: Path) -> None:
    replay = Replay(ReplayParameters(bag=str(narrowed(tmp_path / "bag", 2, at=0, limit=20.0))))
    (message,) = replay.start()
    assert message == next(replay.recording.messages((SENSOR,)))
    assert np.isclose(decode_range(message.data), 5000.0)


def test_an_offset_in_seconds_is_exact_in_nanoseconds(tmp_path: Path) -> None:
    replay = replay_of(tmp_path / "bag", at(0, 999_999_999, 1_000_000_000, 1_000_000_001), offset=1.0)
    assert next(bundle.messages[0].time_ns for bundle in replay.bundles()) == 1_000_000_000


def test_a_description_that_was_recorded_again_is_sent_again(tmp_path: Path) -> None:
    """Whoever joins or records the replay late finds one in time."""
    bag = recorded(tmp_path / "bag", 110, split_duration=1.5)
    for offset, expected in ((0.0, [1.0, 1.5, 2.0]), (1.2, [1.5, 2.0])):
        replay = Replay(ReplayParameters(bag=str(bag), offset=offset))
        times = [bundle.begin_ns * 1e-9 for bundle in replay.bundles() if any(message.topic == SENSOR for message in bundle.messages)]
        assert times == pytest.approx(expected)
    assert len(replay.start()) == 1


def test_a_later_part_of_a_split_recording_can_be_replayed_alone(tmp_path: Path) -> None:
    bag = recorded(tmp_path / "bag", 110, split_duration=1.5)
    part = Replay(ReplayParameters(bag=str(bag / "bag_1.mcap")))
    assert decode_range(part.start()[0].data) == 5000.0
    assert next(part.bundles()).begin_ns == 1_500_000_000


def test_a_later_part_of_a_split_recording_begins_with_its_own_range(tmp_path: Path) -> None:
    bag = narrowed(tmp_path / "bag", 110, at=20, limit=20.0, split_duration=1.5)
    part = Replay(ReplayParameters(bag=str(bag / "bag_1.mcap")))
    assert [decode_range(message.data) for message in part.start()] == [20.0]
