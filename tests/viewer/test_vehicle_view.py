"""The view of a vehicle: waveforms aligned by the wheelbase, colours of boxes, documents of a recording and of a running bench."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import rerun as rr
from rerun_documents import rows
from synthetic_bogie import DESCRIPTION as BOGIE
from synthetic_bogie import SECONDS, bogie

from dcrb_ros.bearing.temperature_readings import TemperatureReadings
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.vehicle.detector import BoxBlock, VehicleDetector
from dcrb_ros.messages.joints import encode_features
from dcrb_ros.messages.plain import encode_text
from dcrb_ros.messages.points import encode_spectrum, encode_vibration, encode_waveform
from dcrb_ros.messages.statuses import ERROR, OK, WARN, Status, encode_diagnostics, encode_truth
from dcrb_ros.messages.topics import ENVELOPE_SPECTRUM, FEATURES, GROUND_TRUTH, SENSOR, VIBRATION, Message
from dcrb_ros.messages.topics.vehicle import VEHICLE_DESCRIPTION, VEHICLE_DIAGNOSIS, VEHICLE_TRUTH
from dcrb_ros.messages.vehicle import encode_vehicle_truth
from dcrb_ros.recordings.storage import StoredFile
from dcrb_ros.recordings.vehicle_recorder import VehicleRecorder
from dcrb_ros.stream.block import Block, Truth
from dcrb_ros.stream.vehicle_description import VehicleDescription
from dcrb_ros.vehicle.block import VehicleTruth
from dcrb_ros.vehicle.description import described
from dcrb_ros.vehicle.file import read_parameters, read_vehicle, vehicle_of
from dcrb_ros.vehicle.frame import TrackEvent
from dcrb_ros.vehicle.simulation import VehicleSimulation
from dcrb_ros.viewer import live_run, palette, show
from dcrb_ros.viewer.content import Series, TimedWaveform
from dcrb_ros.viewer.plan_view import DOUBTFUL, HEALTHY, WAITING, colour_of, text_of, worst
from dcrb_ros.viewer.vehicle_content import VehicleContent, Verdicts, diagnoses_of, events_in, lead_times, read_vehicle_content
from dcrb_ros.viewer.vehicle_document import picture_time, write_vehicle_document
from dcrb_ros.viewer.vehicle_live import VehicleLiveView

RATE = 51200
DESCRIPTION = described(read_vehicle("healthy_bogie"))
BOXES = [box.name for box in DESCRIPTION.boxes]
WHEELBASE, RADIUS = 2.56, 0.46  # healthy_bogie: x = 1.28 and -1.28 m


def rolled(speed: np.ndarray, rate: int = RATE) -> TimedWaveform:
    """Return a waveform of noise over a course of speed [m/s]."""
    angle = np.mod(np.cumsum(speed) / rate / RADIUS, 2.0 * math.pi).astype(np.float32)
    noise = np.random.default_rng(1).standard_normal((len(speed), 2)).astype(np.float32)
    time_ns = (np.arange(len(speed)) * 1_000_000_000) // rate
    return TimedWaveform(time_ns, noise, angle, rate)


def test_the_leading_wheelset_keeps_its_time() -> None:
    waveform = rolled(np.full(5000, 30.0))
    assert np.array_equal(lead_times(DESCRIPTION, "axle_1/left", waveform), waveform.time_ns)


@pytest.mark.parametrize("kmh", [20.0, 120.0, 300.0])
def test_the_other_one_is_moved_by_the_wheelbase_over_the_speed(kmh: float) -> None:
    waveform = rolled(np.full(2 * RATE, kmh / 3.6))
    lag = (waveform.time_ns - lead_times(DESCRIPTION, "axle_2/left", waveform)) * 1e-9
    # T4 of bogie.md: 3932.2 samples at 120 km/h. Every sample is moved alike, those before the wheelbase was run, too.
    assert lag == pytest.approx(np.full(len(lag), WHEELBASE / (kmh / 3.6)), abs=2.0 / RATE)


def test_a_joint_coincides_while_the_vehicle_accelerates() -> None:
    speed = np.linspace(10.0, 40.0, 4 * RATE)
    waveform, place = rolled(speed), np.cumsum(speed) / RATE
    lead, trail = (int(np.searchsorted(place, joint)) for joint in (50.0, 50.0 + WHEELBASE))
    moved = lead_times(DESCRIPTION, "axle_2/right", waveform)
    assert moved[trail] == pytest.approx(waveform.time_ns[lead], abs=3e9 / RATE)


def test_a_later_part_continues_the_alignment() -> None:
    whole = rolled(np.linspace(20.0, 30.0, 2 * RATE))

    def part(first: int, last: int) -> TimedWaveform:
        return TimedWaveform(whole.time_ns[first:last], whole.acceleration[first:last], whole.shaft_angle[first:last], RATE)

    middle = len(whole.time_ns) // 2
    late = lead_times(DESCRIPTION, "axle_2/left", part(middle, len(whole.time_ns)), part(0, middle))
    assert late == pytest.approx(lead_times(DESCRIPTION, "axle_2/left", whole)[middle:], abs=2)


def test_without_a_tacho_or_at_standstill_the_time_is_kept() -> None:
    for waveform in (rolled(np.zeros(1000)), replace(rolled(np.full(1000, 30.0)), shaft_angle=np.full(1000, np.nan, np.float32))):
        assert np.array_equal(lead_times(DESCRIPTION, "axle_2/left", waveform), waveform.time_ns)


def test_a_box_is_framed_by_its_most_serious_verdict() -> None:
    statuses = {
        "axle_1/left/bearing": Status("axle_1/left/bearing", OK, "healthy", {}),
        "axle_1/left/wheel": Status("axle_1/left/wheel", ERROR, "flat", {}),
        "axle_1/left/sensor": Status("axle_1/left/sensor", OK, "healthy", {}),
        "axle_2/left/bearing": Status("axle_2/left/bearing", WARN, "undecided", {}),
        "axle_2/right/bearing": Status("axle_2/right/bearing", OK, "healthy", {}),
    }
    colours = {box: colour_of(worst(statuses, box)) for box in BOXES}
    assert colours == {"axle_1/left": palette.DEFECT, "axle_1/right": WAITING, "axle_2/left": DOUBTFUL, "axle_2/right": HEALTHY}
    assert text_of(statuses, "axle_1/left") == "axle_1/left: wheel flat"
    assert text_of(statuses, "axle_1/right") == "axle_1/right: waiting"
    assert text_of(statuses, "axle_2/right") == "axle_2/right: healthy"


def truth(number: int) -> bytes:
    boxes = [name.replace("/", ".") for name in BOXES]
    event = TrackEvent(number * 0.02 + 0.005, 25.0 * number, "axle_1.right", "flat", 0.2)
    return encode_vehicle_truth(
        VehicleTruth(
            number * 20_000_000,
            30.0,
            0.6 * number,
            dict.fromkeys(boxes, 45e3),
            dict.fromkeys(boxes, (1.0, 2.0, 3.0)),
            {"axle_1": 0.0, "axle_2": 0.0},
            (event,),
            {},
        )
    )


def blocks(number: int) -> Block:
    whole = rolled(np.full(1024 * (number + 1), 30.0))
    last = slice(1024 * number, None)
    acceleration = whole.acceleration[last]
    return Block(1024 * number, RATE, acceleration, whole.shaft_angle[last], acceleration)


def test_samples_after_a_gap_are_judged_at_their_own_time() -> None:
    """Without the samples of 0.3 s, a hop later than the gap still ends where it does without one."""
    signals, kept = bogie({"axle_1/right": {"outer": 900.0}}), np.ones(round(SECONDS * BOGIE.sampling_rate), bool)
    kept[40000:55360] = False
    time_ns = (np.flatnonzero(kept) * 1_000_000_000 + BOGIE.sampling_rate // 2) // BOGIE.sampling_rate
    waveforms = {
        name: TimedWaveform(time_ns, acceleration[kept], angle[kept], BOGIE.sampling_rate)
        for name, (acceleration, angle) in signals.items()
    }
    detector, expected = VehicleDetector(BOGIE), []
    for first, last in ((0, 40000), (55360, len(kept))):
        part = {name: BoxBlock(first, acceleration[first:last], angle[first:last]) for name, (acceleration, angle) in signals.items()}
        expected += [diagnosis] if (diagnosis := detector.add(part)) else []
    shown = diagnoses_of(VehicleContent("gap", BOGIE, waveforms))
    assert shown[-1].time == expected[-1].time
    assert shown[-1].statuses == expected[-1].statuses


def test_the_verdicts_shown_are_those_by_temperatures_and_by_the_present_ranges(monkeypatch: pytest.MonkeyPatch) -> None:
    """One box is hot. The range of another one is 8 m/s^2 from 0.5 s on, and its samples reach it from there on."""
    signals, hot, box, first = bogie(), "axle_1/left", "axle_2/right", 25600
    signals[box][0][first:] = np.clip(signals[box][0][first:], -8.0, 8.0)
    known = replace(BOGIE, boxes=tuple(replace(each, sensor_range=5000.0) for each in BOGIE.boxes))
    time = np.arange(1.0, SECONDS, 0.2)
    none, warm = TemperatureReadings.none(), np.full(len(time), 170.0)
    readings = {hot: TemperatureReadings(time=time, outer_ring=warm, box=time * np.nan, ambient=np.full(len(time), 20.0))}
    received = [
        Message(SENSOR.below(box), 500_000_000, encode_text(json.dumps({"range": 8.0}))),
        Message(GROUND_TRUTH.below(hot), 0, encode_truth(Truth(0, 1.0, (0.0, 0.0), {}, {}, thermal={"acceleration": 200.0}))),
        *(
            Message(VIBRATION.below(name), 0, encode_waveform(0, BOGIE.sampling_rate, acceleration, angle))
            for name, (acceleration, angle) in signals.items()
        ),
    ]
    recording: Any = SimpleNamespace(
        path=Path("run"),
        description=known,
        boxes={name.replace("/", "."): SimpleNamespace(temperatures=readings.get(name, none)) for name in signals},
        messages=lambda topics: (message for message in received if message.topic in topics),
    )
    lapses = list[float]()

    def detector(description: VehicleDescription, box_parameters: DetectorParameters) -> VehicleDetector:
        lapses.append(box_parameters.heat_time_lapse)
        return VehicleDetector(description, box_parameters=box_parameters)

    monkeypatch.setattr("dcrb_ros.viewer.vehicle_content.VehicleDetector", detector)
    statuses = read_vehicle_content(recording).verdicts[-1].statuses
    assert statuses[f"{hot}/bearing"].message == "overheating"
    assert statuses[f"{box}/sensor"].message == "healthy"
    assert lapses == [200.0]


def test_events_have_time_place_and_wheel() -> None:
    (event,) = events_in(truth(2))
    assert (event.time_ns, event.cause, event.where, event.place, event.jump) == (45_000_000, "flat", "axle_1/right", 50.0, 0.2)


def test_a_document_shows_every_box_and_the_picture_an_event(tmp_path: Path) -> None:
    waveform = rolled(np.full(RATE, 30.0))
    times = np.arange(50, dtype=np.int64) * 20_000_000
    features = Series(times, ("rms",), np.linspace(1.0, 5.0, 50)[:, None])
    healthy = Status("axle_1/left/bearing", OK, "healthy", {"reason": "quiet"})
    events = tuple(event for number in range(50) for event in events_in(truth(number)))
    content = VehicleContent(
        "run",
        DESCRIPTION,
        dict.fromkeys(BOXES, waveform),
        dict.fromkeys(BOXES, features),
        (Verdicts(500_000_000, {healthy.name: healthy}),),
        events,
    )
    assert picture_time(content) == events[-1].time_ns + 10_000_000
    path = tmp_path / "run.rrd"
    write_vehicle_document(content, path)
    count = rows(path)
    for box in DESCRIPTION.boxes:
        assert count[f"/aligned/{box.side}/{box.axle}"] == RATE
        assert count[f"/plan/{box.name}/fill"] == 50
        assert count[f"/plan/{box.name}/frame"] == 2
    # Marks stay for longer than the flat takes to return: one appearance, with its repetitions, and one end.
    assert count["/plan/axle_1/right/event"] == 51
    assert count["/plan/axle_1/left/event"] == 0
    assert count["/events"] == 50


def test_rerun_is_given_the_readable_messages_of_a_damaged_recording(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its own reader does not return from a file with a damaged chunk."""
    bag, parameters = tmp_path / "run", read_parameters("healthy_bogie", {"vehicle.bench": "dry"})
    simulation = VehicleSimulation(vehicle_of(parameters, "test"))
    with VehicleRecorder(bag, parameters, simulation) as recorder:
        for block in simulation.blocks(0.2):
            recorder.write(block)
    (file,) = bag.glob("*.mcap")
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 0xFF
    file.write_bytes(content)
    damage: list[str] = []
    topics: set[str] = set()

    def write(content: VehicleContent, path: Path, *, native: tuple[Path, ...]) -> None:
        topics.update(stored.channel.topic for copy in native for stored in StoredFile(copy).messages(damage))

    monkeypatch.setattr(show, "write", write)
    assert not show.view_recording(bag, save=tmp_path / "run.rrd", screenshot=None, web=False)[1]
    assert damage == []
    assert {f"/dcrb/{box}/outer_ring/vibration" for box in BOXES} < topics


@pytest.mark.parametrize("boxes", [BOXES, BOXES[::-1]])  # the node receives the first box last
@pytest.mark.parametrize("batch", [1, 3])  # of 3 blocks, the second contains the reset
def test_a_running_vehicle_is_shown_and_a_reset_begins_a_new_recording(
    batch: int, boxes: Sequence[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(live_run, "EARLY_NS", 20_000_000)  # a block
    files: list[Path] = []
    warnings: list[str] = []

    def begin(number: int) -> rr.RecordingStream:
        stream = rr.RecordingStream("dcrb")
        files.append(tmp_path / f"live-{number}.rrd")
        stream.save(files[-1])
        return stream

    view = VehicleLiveView(begin, "/dcrb", warnings.append)
    view.flush()
    assert view.description is None
    view.take(VEHICLE_DESCRIPTION, encode_text("{}"))
    view.take(VEHICLE_DESCRIPTION, encode_text(DESCRIPTION.to_json()))
    for run in range(2):
        for number in range(4):
            block = blocks(number)
            for box in boxes:
                view.take(VIBRATION.below(box), encode_vibration(block, block.acceleration))
                view.take(FEATURES.below(box), encode_features(block))
            # The second spectrum rises beyond the axes of the first.
            amplitude = np.where(np.arange(4000) % 100 == 0, 10.0 ** (number + 1.0), 1.0)
            spectrum = encode_spectrum(number * 20_000_000, np.arange(4000) * 0.01, amplitude, 10.0, BOXES[1])
            view.take(ENVELOPE_SPECTRUM.below(BOXES[1]), spectrum)
            view.take(VEHICLE_TRUTH, truth(number))
            if (4 * run + number + 1) % batch == 0:
                view.flush()
            level, verdict = (ERROR, "outer_ring") if number > 1 else (OK, "healthy")
            statuses = [Status(f"{BOXES[0]}/bearing", OK, "healthy", {}), Status(f"{BOXES[1]}/bearing", level, verdict, {})]
            view.take(VEHICLE_DIAGNOSIS, encode_diagnostics(number * 20_000_000, statuses, "base"))
    view.close()
    assert len(files) == 2
    for file in files:
        count = rows(file)
        assert {box.name: count[f"/aligned/{box.side}/{box.axle}"] for box in DESCRIPTION.boxes} == dict.fromkeys(BOXES, 4096)
        assert count["/events"] == 4
        assert count["/verdicts"] == 3  # two at first, and one that changes
        assert count[f"/spectra/{BOXES[1]}/curve"] == 4
        assert count[f"/spectra/{BOXES[0]}/curve"] == 0
    assert len(warnings) == 1
    assert "format" in warnings[0]
