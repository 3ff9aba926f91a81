"""The live view: messages received in batches are logged as completely as those of a recording."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import rerun as rr
from rerun.blueprint import Blueprint
from rerun_documents import chunks, rows
from runs import Run, simulated

from dcrb_ros.bearing.payload import body_names
from dcrb_ros.diagnosis.detector import Diagnosis
from dcrb_ros.messages.encoder import BlockEncoder, diagnosis_messages
from dcrb_ros.messages.joints import encode_joints
from dcrb_ros.messages.plain import encode_text
from dcrb_ros.messages.points import decode_spectrum, encode_points, encode_spectrum
from dcrb_ros.messages.statuses import encode_truth
from dcrb_ros.messages.topics import (
    DIAGNOSIS,
    ENVELOPE_SPECTRUM,
    FEATURES,
    GROUND_TRUTH,
    LUBRICATION_STATE,
    ROLLER_STATES,
    SENSOR,
    VIBRATION,
    Message,
)
from dcrb_ros.messages.topics.lubrication_state import names_of
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.viewer import live_run
from dcrb_ros.viewer.blueprint import compose_live
from dcrb_ros.viewer.drawing import Drawing
from dcrb_ros.viewer.live import LiveView
from dcrb_ros.viewer.reader import series_of

ORDERS = np.arange(0.0, 30.0, 0.05)


def diagnosed(time: float, verdict: str = "outer_ring") -> list[Message]:
    """Return the messages of a detector, with a spectrum that has a line at BPFO."""
    spectrum = ORDERS, np.where(np.abs(ORDERS - 6.7) < 0.06, 50.0, 1.0)
    levels = {"BPFO": 20.0, "BPFI": 2.0, "BSF": 3.0, "FTF": 4.0}
    return diagnosis_messages(Diagnosis(0, time, verdict, f"reason at {time:g} s", levels=levels, shaft_frequency=20.0, spectrum=spectrum))  # type: ignore[arg-type]


class Bench:
    """A live view that saves every run to a file, and its warnings."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.warnings = folder, list[str]()
        self.view = LiveView(self.begin, "/dcrb", self.warnings.append)

    def begin(self, run: int) -> rr.RecordingStream:
        stream = rr.RecordingStream("dcrb")
        stream.save(self.folder / f"{run}.rrd")
        return stream

    def take(self, messages: Iterator[Message] | list[Message]) -> None:
        for message in messages:
            self.view.take(message.topic, message.data)


@pytest.fixture(scope="module")
def run() -> Run:
    return simulated(0.6, fault="outer_1", state_rate=100)


def messages(run: Run) -> list[Message]:
    encoder = BlockEncoder(run.configuration, body_names(run.configuration))
    return [*encoder.start(), *(message for block in run.blocks for message in encoder.encode(block))]


def test_every_sample_and_state_is_logged_once(run: Run, tmp_path: Path) -> None:
    bench = Bench(tmp_path)
    for number, message in enumerate(messages(run)):
        bench.take([message])
        if number % 37 == 0:
            bench.view.flush()
    bench.take([*diagnosed(0.3), *diagnosed(0.5)])
    bench.view.close()
    assert bench.warnings == []
    found, states, samples = rows(tmp_path / "1.rrd"), len(run.states), sum(len(block.shaft_angle) for block in run.blocks)
    assert found["/waveform"] == samples
    assert found["/bearing/row1/rollers"] == found["/forces/row2"] == found["/load_zone/row1/now"] == states
    assert found["/envelope_spectrum/curve"] == found["/diagnosis/verdict"] == found["/indicators/BPFO"] == 2
    values = [
        chunk.to_record_batch().column("Scalars:scalars")
        for chunk in chunks(tmp_path / "1.rrd")
        if chunk.entity_path == "/waveform" and not chunk.is_static
    ]
    flat = np.concatenate([column.flatten().to_numpy(zero_copy_only=False) for column in values])
    assert np.array_equal(np.sort(flat), np.sort(np.concatenate([block.acceleration for block in run.blocks]).reshape(-1)))


def test_fixed_shapes_and_summary_are_logged(run: Run, tmp_path: Path) -> None:
    bench = Bench(tmp_path)
    bench.take(messages(run))
    bench.take(diagnosed(0.4))
    bench.view.close()
    still = {chunk.entity_path for chunk in chunks(tmp_path / "1.rrd") if chunk.is_static}
    assert {
        "/bearing/row1/outer_ring",
        "/bearing/scale",
        "/load_zone/row2/mean",
        "/order_map/levels",
        "/envelope_spectrum/grid",
    } <= still
    texts = [chunk.to_record_batch().column("TextDocument:text") for chunk in chunks(tmp_path / "1.rrd") if chunk.entity_path == "/summary"]
    page = str(texts[-1].flatten().to_pylist()[-1])
    for words in ("outer ring defect", "outer_1: 2 mm wide, both rows", "reason at 0.4 s", "/dcrb"):
        assert words in page


def test_temperatures_have_a_plot_also_if_they_arrive_after_the_first_films(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench, arranged = Bench(tmp_path), list[dict[str, bool]]()

    def composed(drawing: Drawing | None, **shown: bool) -> Blueprint:
        arranged.append(shown)
        return compose_live(drawing, **shown)

    monkeypatch.setattr(live_run, "compose_live", composed)
    bench.take([message for message in messages(run) if message.topic is SENSOR])
    names, empty = names_of(2), np.zeros(0)
    truth = replace(run.blocks[0].truths[0], thermal={"box [deg C]": 40.0})
    for topic, data in (
        (LUBRICATION_STATE, encode_joints(0, names, np.ones(len(names)), empty, empty)),
        (GROUND_TRUTH, encode_truth(truth)),
        (GROUND_TRUTH, encode_truth(truth)),
    ):
        bench.view.take(topic, data)
        bench.view.flush()
    bench.view.close()
    assert arranged == [{}, {"lubricated": True, "warm": False}, {"lubricated": True, "warm": True}]
    assert rows(tmp_path / "1.rrd")["/temperatures"] == 2


def test_messages_received_before_the_sensor_description_are_kept(run: Run, tmp_path: Path) -> None:
    bench, first = Bench(tmp_path), messages(run)
    bench.take([message for message in first if message.topic is not SENSOR])
    bench.view.flush()
    assert list(tmp_path.iterdir()) == []
    bench.take([message for message in first if message.topic is SENSOR])
    bench.view.close()
    assert rows(tmp_path / "1.rrd")["/waveform"] == sum(len(block.shaft_angle) for block in run.blocks)


def test_a_reset_starts_a_new_recording(run: Run, tmp_path: Path) -> None:
    bench = Bench(tmp_path)
    bench.take(messages(run))
    bench.take(messages(run)[:10])
    bench.view.close()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["1.rrd", "2.rrd"]
    assert rows(tmp_path / "1.rrd")["/waveform"] > rows(tmp_path / "2.rrd")["/waveform"] > 0


@pytest.mark.parametrize(
    "bearing",
    ["null", '{"balls": 9, "diameter": 8e-3, "pitch_diameter": 0.04}', '{"rollers": 9, "roller_radius": 4e-3, "pitch_radius": 0.02}'],
)
def test_imported_data_are_shown_without_a_bearing(bearing: str, run: Run, tmp_path: Path) -> None:
    bench = Bench(tmp_path)
    orders = '{"FTF": 0.4, "BPFO": 3.6, "BPFI": 5.4, "BSF": 2.4}'
    sensor = encode_text(f'{{"sampling_rate": 51200, "orders": {orders}, "bearing": {bearing}}}')
    bench.take([Message(SENSOR, 0, sensor), *(message for message in messages(run) if message.topic is VIBRATION)])
    bench.view.close()
    found = rows(tmp_path / "1.rrd")
    assert found["/waveform"] > 0
    assert not any(entity.startswith("/bearing") for entity in found)


def test_invalid_messages_are_reported_and_skipped(run: Run, tmp_path: Path) -> None:
    bench = Bench(tmp_path)
    bench.take(messages(run))
    bench.view.flush()
    for topic in (VIBRATION, ROLLER_STATES, DIAGNOSIS, ENVELOPE_SPECTRUM, SENSOR):
        for data in (b"", b"junk", bytes(64)):
            bench.view.take(topic, data)
            bench.view.flush()
    bench.view.close()
    assert bench.view.refused >= 8
    assert all(warning.startswith("not shown: ") for warning in bench.warnings)
    assert rows(tmp_path / "1.rrd")["/waveform"] == sum(len(block.shaft_angle) for block in run.blocks)


@pytest.mark.parametrize(
    "data",
    [encode_joints(0, names, np.array(values), np.zeros(0), np.zeros(0)) for names, values in ((["rms"], []), ([], []), ([], [1.0]))],
)
def test_features_without_a_value_for_each_name_are_left_out(data: bytes, run: Run, tmp_path: Path) -> None:
    assert series_of([data]) is None
    own = [message.data for message in messages(run) if message.topic is FEATURES]
    found = series_of([data, *own])
    assert found is not None
    assert len(found.values) == len(own)
    bench = Bench(tmp_path)
    bench.take([*messages(run), Message(FEATURES, 0, data)])
    bench.view.close()
    assert bench.warnings == []


def test_an_invalid_message_leaves_out_its_topic_alone(run: Run, tmp_path: Path) -> None:
    bench = Bench(tmp_path)
    bench.take([*messages(run), Message(ROLLER_STATES, 0, bytes(64)), Message(SENSOR, 0, encode_text("{}"))])
    bench.view.flush()
    assert bench.view.refused == 1
    bench.take(messages(run)[:1])
    bench.view.close()
    assert bench.view.refused == 2
    found = rows(tmp_path / "1.rrd")
    assert found["/waveform"] == sum(len(block.shaft_angle) for block in run.blocks)
    assert "/bearing/row1/rollers" not in found


def test_spectrum_round_trip() -> None:
    message = next(message for message in diagnosed(0.25) if message.topic is ENVELOPE_SPECTRUM)
    time_ns, orders, amplitude, frequency = decode_spectrum(message.data)
    assert (time_ns, frequency) == (250_000_000, pytest.approx(20.0))
    assert orders == pytest.approx(ORDERS, abs=1e-6)
    assert amplitude.max() == 50.0
    with pytest.raises(Refusal, match=r"is not a squared envelope spectrum"):
        decode_spectrum(message.data.replace(b"amplitude", b"amplitudo"))
    with pytest.raises(Refusal, match=r"is not a squared envelope spectrum: .* little endian"):
        decode_spectrum(encode_points(np.zeros(2, [("frequency", "<f4"), ("order", "<u4"), ("amplitude", "<f4")]), 0))
    for unordered in ([2.0, 1.0], [1.0, np.nan], [1.0, np.inf]):
        with pytest.raises(Refusal, match=r"orders .* are not finite and increasing"):
            decode_spectrum(encode_spectrum(0, np.array(unordered), np.ones(2), 20.0))


def test_a_spectrum_below_the_orders_shown_is_not_drawn(run: Run, tmp_path: Path) -> None:
    bench = Bench(tmp_path)
    bench.take(messages(run))
    bench.view.take(ENVELOPE_SPECTRUM, encode_spectrum(0, np.array([0.0, 0.001]), np.ones(2), 20.0))
    bench.take(diagnosed(0.4))
    bench.view.close()
    assert bench.warnings == []
    assert rows(tmp_path / "1.rrd")["/envelope_spectrum/curve"] == 1
