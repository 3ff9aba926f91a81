"""The viewer: the content of Rerun files equals that of the recording, and invalid input is refused."""

from __future__ import annotations

import dataclasses
import math
import re
import subprocess
import sys
from collections import Counter
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import rerun as rr
from dry_benches import dry_bench
from mcap.writer import IndexType, Writer
from rerun_documents import chunks
from ros2_bag_record import bag_of
from runs import PAPER_SPEED, Run, record, simulated

from dcrb_ros.bearing import load_zone
from dcrb_ros.bearing.fault_lines import fault_combs
from dcrb_ros.bearing.frequencies import characteristic_orders
from dcrb_ros.bearing.payload import body_names
from dcrb_ros.cli.view import view
from dcrb_ros.diagnosis.detection import detect
from dcrb_ros.diagnosis.detector import Diagnosis
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.messages.encoder import diagnosis_messages
from dcrb_ros.messages.topics import VIBRATION
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.parameters import Bearing
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.stream.block import Truth
from dcrb_ros.viewer import order_map, palette
from dcrb_ros.viewer.blueprint import level_axis, speed_varies, waveform_axis, whole_time
from dcrb_ros.viewer.content import BenchInfo, Content, DetectorOutput, Series, TimedWaveform
from dcrb_ros.viewer.document import write_document, written
from dcrb_ros.viewer.drawing import Drawing, on_circle, quaternions, rounded_up
from dcrb_ros.viewer.live_run import completed
from dcrb_ros.viewer.reader import content_of, read_content
from dcrb_ros.viewer.row_faults import faults_of_row
from dcrb_ros.viewer.show import screenshot_time, take_picture
from dcrb_ros.viewer.spectrum import ORDER_STEP, Spectra, diagnoses, envelope_spectra, over_background, pieces, verdicts_of
from dcrb_ros.viewer.summary import markdown, shown_truths
from dcrb_ros.viewer.window import ViewerFailure

BAGS = Path(__file__).parents[2] / "bags"
DURATION = 2.5
SPEEDS = ((100.0, 0), (100.0, 500_000_000), (200.0, 1_000_000_000))
"""Speeds [rad/s] and their times [ns]."""
VULKAN_DRIVERS = [*Path("/usr/share/vulkan/icd.d").glob("*.json"), *Path("/etc/vulkan/icd.d").glob("*.json")]


@pytest.fixture(scope="module")
def run() -> Run:
    return simulated(DURATION, fault="outer_1", state_rate=100)


@pytest.fixture(scope="module")
def bag(run: Run, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return record(tmp_path_factory.mktemp("bags") / "outer", run.configuration, run.blocks)


@pytest.fixture(scope="module")
def content(bag: Path) -> Content:
    return read_content(Recording(bag))


@pytest.fixture(scope="module")
def document(bag: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("documents") / "outer.rrd"
    view(bag, save=path)
    return path


def values(document: Path, entity: str, component: str) -> npt.NDArray[np.float64]:
    """Return a component of an entity over time, its instances flattened."""
    parts = [
        chunk.to_record_batch().column(component).flatten().to_numpy(zero_copy_only=False)
        for chunk in chunks(document)
        if chunk.entity_path == entity and not chunk.is_static and component in chunk.to_record_batch().schema.names
    ]
    return np.concatenate(parts)


def texts(chunk: Any, component: str) -> list[str]:
    """Return the texts of a component over time; none if the chunk lacks it."""
    batch = chunk.to_record_batch()
    return [text for row in batch.column(component).to_pylist() for text in row] if component in batch.schema.names else []


def rerun(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-m", "rerun_cli", *arguments], capture_output=True, text=True, timeout=400, check=False)


# --- geometry: azimuth from the load line, counter-clockwise; Rerun's Y points down ---


def test_a_broken_bar_is_marked_through_the_gap_between_its_rollers() -> None:
    drawing = Drawing(Bearing(), 1.0)
    mark, azimuth = drawing.broken_bar(3), 2.5 * 2.0 * math.pi / 16
    assert mark @ [math.cos(azimuth), -math.sin(azimuth)] == pytest.approx(0.0, abs=1e-9)
    radii = np.hypot(*mark.T)
    assert drawing.inner_raceway < radii[0] < radii[1] < drawing.outer_raceway
    assert radii[1] - radii[0] > 1.5 * drawing.roller  # long enough to be seen between two rollers


@pytest.mark.parametrize(("azimuth", "place"), [(0.0, (0, 1)), (math.pi / 2, (1, 0)), (math.pi, (0, -1)), (-math.pi / 2, (-1, 0))])
def test_azimuth_is_measured_from_the_load_line(azimuth: float, place: tuple[float, float]) -> None:
    assert on_circle(1.0, azimuth) == pytest.approx(np.array(place), abs=1e-12)


@pytest.mark.parametrize("angle", [-2.0, 0.3, 1.7])
def test_rotation_moves_a_mark_to_its_azimuth(angle: float) -> None:
    *_, z, w = quaternions(np.array([angle]))[0]
    turned = math.atan2(2.0 * w * z, 1.0 - 2.0 * z * z)
    x, y = on_circle(1.0, 0.4)
    rotated = [math.cos(turned) * x - math.sin(turned) * y, math.sin(turned) * x + math.cos(turned) * y]
    assert rotated == pytest.approx(on_circle(1.0, 0.4 + angle))


def test_length_of_force_bars_is_proportional_to_the_force() -> None:
    drawing = Drawing(Bearing(), 40e3)
    bars = drawing.bars(np.array([0.0, 1.0]), np.array([40e3, 10e3]))
    lengths = np.linalg.norm(bars[:, 1] - bars[:, 0], axis=1)
    assert lengths == pytest.approx([drawing.bars_length, 0.25 * drawing.bars_length])


def test_cage_bars_lie_between_the_pockets() -> None:
    bars = Drawing(Bearing(), 40e3).cage_bars()
    azimuths = np.concatenate([np.arctan2(bar[:, 0], bar[:, 1]) for bar in bars])
    pitch = 2.0 * math.pi / Bearing().rollers_per_row
    from_pocket = np.abs(np.remainder(azimuths + 0.5 * pitch, pitch) - 0.5 * pitch)
    assert len(bars) == Bearing().rollers_per_row
    assert from_pocket.min() > math.asin(0.015 / 0.094)  # a roller of Table 1 seen from the centre


@pytest.mark.parametrize(("value", "expected"), [(35.2e3, 40e3), (30e3, 30e3), (0.0, 1.0), (0.0107, 0.012), (9.1, 10.0)])
def test_scale_ends_on_a_round_number(value: float, expected: float) -> None:
    assert rounded_up(value) == pytest.approx(expected)


def test_colours_become_lighter_with_force_and_idle_rollers_are_grey() -> None:
    colours = palette.force_colours(np.array([0.0, 1.0, 10e3, 20e3, 30e3, 40e3, 90e3]), 40e3).astype(float)
    lightness = colours[1:, :3] @ [0.2126, 0.7152, 0.0722]
    assert tuple(colours[0]) == palette.UNLOADED
    assert (np.diff(lightness[:-1]) > 0.0).all()
    assert (colours[-1] == colours[-2]).all()


# --- spectrum ---


def test_combs_are_at_the_fault_orders() -> None:
    combs = {comb.name: comb.orders for comb in fault_combs(characteristic_orders(Bearing()), 30.0)}
    # Eqs. 43 to 45 of Fan et al. 2025 with Table 1 at 20 Hz (section 3.2 prints 8.4, 134.5, 185.5 Hz), and twice BSF.
    assert [20.0 * combs[name][0] for name in ("FTF", "BPFO", "BPFI", "2BSF")] == pytest.approx([8.404, 134.47, 185.53, 122.14], abs=0.01)
    assert [len(combs[name]) for name in ("FTF", "BPFO", "BPFI", "2BSF")] == [4, 4, 3, 4]


def test_level_is_relative_to_the_local_median() -> None:
    amplitude = np.full((1, 400), 2.0)
    amplitude[0, 200] = 200.0
    level = over_background(amplitude)[0]
    assert level[200] == pytest.approx(40.0)
    assert np.delete(level, 200) == pytest.approx(0.0)


def test_spectrum_of_an_outer_defect_peaks_at_bpfo(content: Content) -> None:
    spectra = envelope_spectra(content.detector_output.diagnoses)
    assert spectra is not None
    comb = spectra.orders > 3.0  # above the first shaft orders
    bpfo = 16.0 * 0.07886 / (2.0 * 0.094)  # 16 f_C with pins at the pitch radius, f_C = f_r r_I / (2 r_M); Table 1 of Fan et al. 2025
    harmonic = spectra.orders[comb][np.argmax(spectra.level[-1][comb])] / bpfo
    assert harmonic == pytest.approx(round(harmonic), abs=2.0 * ORDER_STEP / bpfo)
    assert spectra.shaft_frequency == pytest.approx(PAPER_SPEED / (2.0 * math.pi), rel=1e-4)


def test_a_stationary_shaft_and_a_short_waveform_have_no_spectrum(content: Content) -> None:
    orders = characteristic_orders(Bearing())
    still = dataclasses.replace(content.waveform, shaft_angle=np.zeros_like(content.waveform.shaft_angle))
    assert envelope_spectra(diagnoses(still, orders)) is None
    short = TimedWaveform(*(array[:5000] for array in (still.time_ns, still.acceleration, still.shaft_angle)), rate=still.rate)
    assert diagnoses(short, orders) == []


def test_pieces_do_not_span_gaps() -> None:
    ticks = np.concatenate([np.arange(0, 100), np.arange(150, 400)])
    waveform = TimedWaveform(ticks * 1_000_000, np.zeros((350, 2), np.float32), np.zeros(350, np.float32), 1000)
    found = [ticks[piece] for piece in pieces(waveform, 64)]
    assert np.concatenate(found).tolist() == ticks.tolist()
    assert all((np.diff(piece) == 1).all() and len(piece) <= 64 for piece in found)


@pytest.mark.parametrize(
    ("seconds", "windows"), [(0.4, 0), (4.0, 16), (30.0, 20), (60.0, round(60.0 / min(3.0, DetectorParameters().window)))]
)
def test_number_of_windows_depends_on_the_duration(seconds: float, windows: int) -> None:
    count = round(seconds * 6400)
    noise = np.random.default_rng(1).standard_normal((count, 2)).astype(np.float32)
    angle = np.mod(PAPER_SPEED * np.arange(count) / 6400, 2.0 * math.pi).astype(np.float32)
    waveform = TimedWaveform(np.arange(count) * 10**9 // 6400, noise, angle, 6400)
    assert len(diagnoses(waveform, characteristic_orders(Bearing()))) == windows


@pytest.mark.parametrize("name", ["healthy", "outer_ring_defect"])
def test_the_verdict_on_a_whole_and_a_short_signal_is_that_of_detect(name: str) -> None:
    recording = Recording(BAGS / name)
    whole = read_content(recording)
    assert whole.detector_output.verdicts[-1].name == detect(recording).verdict == name.removesuffix("_defect")
    waveform, count = whole.waveform, round(1.5 * whole.waveform.rate)
    short = TimedWaveform(*(array[:count] for array in (waveform.time_ns, waveform.acceleration, waveform.shaft_angle)), rate=waveform.rate)
    judged = diagnoses(short, recording.orders, bearing=recording.bearing)[-1]
    assert judged.verdict == detect(recording).verdict


# --- content of a recording ---


def test_content_has_every_sample_and_state(run: Run, content: Content) -> None:
    assert content.waveform.acceleration.tolist() == np.concatenate([block.acceleration for block in run.blocks]).tolist()
    assert content.waveform.shaft_angle.tolist() == np.concatenate([block.shaft_angle for block in run.blocks]).tolist()
    assert content.motion is not None
    assert content.motion.azimuth == pytest.approx(run.series("azimuth"))
    assert content.motion.force == pytest.approx(run.series("inner_force"))
    assert content.motion.time_ns.tolist() == [states.time_ns for states in run.states]


def test_the_title_is_the_name_of_the_recording(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = record(tmp_path / "run.v1", run.configuration, run.blocks)
    monkeypatch.chdir(path)
    for given, title in ((path, "run.v1"), (path / "run.v1_0.mcap", "run.v1_0"), (Path(), "run.v1")):
        assert read_content(Recording(given)).title == title


def test_sample_times_follow_the_sampling_rate(content: Content) -> None:
    expected = np.arange(len(content.waveform.time_ns)) * 1_000_000_000 // 51200
    assert np.abs(content.waveform.time_ns - expected).max() <= 1


def test_summary_contains_verdict_and_ground_truth(content: Content) -> None:
    page = markdown(content, content.truths[-1])
    assert "outer ring defect" in page
    assert "outer_1: 2 mm wide, both rows" in page
    assert f"{PAPER_SPEED * 30 / math.pi:.1f} rpm, 100 kN" in page
    assert "2 x 16 rolling elements of 30 mm on a pitch circle of 188 mm" in page


def test_a_fault_that_comes_between_two_summary_pages_has_one_of_its_own() -> None:
    truths = [Truth(k, 100.0, (0.0, 1e5), {}, {"outer_1": {}} if k in (7, 8) else {}) for k in range(100)]
    assert [truth.time_ns for truth in shown_truths(truths, 10)] == [0, 7, 9, *range(10, 100, 10)]


def test_a_recorded_verdict_takes_precedence_over_a_computed_one(run: Run, tmp_path: Path) -> None:
    published = Diagnosis(51199, 1.0, "inner_ring", "reason given by the test", levels={"BPFO": 1.0, "BPFI": 2.0, "BSF": 3.0, "FTF": 4.0})
    path = tmp_path / "judged"
    with Recorder(path, run.configuration, body_names(run.configuration)) as recorder:
        for block in run.blocks:
            recorder.write(block)
        recorder.write_messages(diagnosis_messages(published))
    content = read_content(Recording(path))
    assert [(verdict.name, verdict.level) for verdict in content.detector_output.verdicts] == [("inner_ring", 2)]
    indicators = content.detector_output.indicators
    assert indicators is not None
    assert dict(zip(indicators.names, indicators.values[0], strict=True)) == published.levels
    assert "reason given by the test" in markdown(content, None)


def test_several_faults_are_named_in_the_summary(run: Run, tmp_path: Path) -> None:
    scores = {"outer_ring": 13.4, "inner_ring": 6.6, "roller": -4.9, "cage": 0.0}
    path = tmp_path / "judged"
    with Recorder(path, run.configuration, body_names(run.configuration)) as recorder:
        recorder.write(run.blocks[0])
        recorder.write_messages(diagnosis_messages(Diagnosis(1023, 0.02, "compound", "because", scores=scores)))
    content = read_content(Recording(path))
    assert "**several faults: outer ring defect, inner ring defect, cage fault**" in markdown(content, None)


def test_states_of_another_bearing_are_refused(run: Run, tmp_path: Path) -> None:
    smaller = Configuration.model_validate({"bearing": {"rollers_per_row": 15}})
    path = tmp_path / "mixed"
    with Recorder(path, smaller, body_names(run.configuration)) as recorder:
        recorder.write(run.blocks[0])
    with pytest.raises(Refusal, match=r"has \[35\] values for 35 bodies, but the bearing of the manifest has 33"):
        read_content(Recording(path))


def test_faults_are_assigned_to_their_rows() -> None:
    fault = {"row": 2.0, "width": 0.001, "depth": 0.0003, "azimuth": 0.5, "onset": 0.0}
    bar = {"row": 1.0, "bar": 15.0, "onset": 0.0}
    roller = {"row": 2.0, "roller": 3.0, "width": 0.002, "depth": 0.0003, "azimuth": 0.0, "onset": 0.0}
    truth = Truth(0, 100.0, (0.0, -1e5), {}, {"inner_1": fault, "broken_bars.row1/bar15": bar, "roller_1": roller})
    assert faults_of_row(truth, 0) == ((), (15,), ("bar 15 broken",))
    assert faults_of_row(truth, 1) == ((("inner_ring", 0.5, 0.001),), (), ("inner_1: 1 mm wide", "roller_1: 2 mm wide on roller 3"))


def test_summary_contains_every_fault(tmp_path: Path) -> None:
    configuration = dry_bench("compound")
    content = read_content(Recording(record(tmp_path / "compound", configuration, Simulation(configuration).blocks(0.2))))
    found = markdown(content, content.truths[-1])
    for words in ("outer_1: 2 mm wide, row 1", "inner_1: 2 mm wide, row 2", "bar 15 broken, row 1"):
        assert words in found


@pytest.mark.parametrize(
    ("rows", "faults", "words"),
    [
        (2, {"outer_1": {"row": 0, "width": 0.002}, "sensor.stuck": {"severity": 1.0}}, "outer_1: 2 mm wide, both rows, sensor stuck |"),
        (1, {"outer_1": {"row": 0, "width": 0.002}, "inner_1": {"row": 1, "width": 0.001}}, "inner_1: 1 mm wide, outer_1: 2 mm wide |"),
    ],
)
def test_summary_names_rows_only_where_there_are_two(content: Content, rows: int, faults: Any, words: str) -> None:
    truth = Truth(0, 100.0, (0.0, -1e5), {}, faults)
    bearing = content.bearing.model_copy(update={"rows": rows})
    assert f"| Ground truth | {words}" in markdown(dataclasses.replace(content, bearing=bearing), truth)


@pytest.mark.parametrize(
    ("scores", "words"),
    [
        ({"outer_ring": 4.0, "inner_ring": 0.5, "roller": -3.0, "cage": -8.0}, "several faults: outer ring defect, inner ring defect"),
        ({}, "several faults"),
    ],
)
def test_summary_names_the_faults_of_the_verdict_compound(content: Content, scores: dict[str, float], words: str) -> None:
    judged: Future[DetectorOutput] = Future()
    judged.set_result(
        dataclasses.replace(content.detector_output, verdicts=verdicts_of([Diagnosis(1, 1.0, "compound", "lines", scores=scores)]))
    )
    assert f"| Detector's verdict | **{words}** |" in markdown(dataclasses.replace(content, pending_output=judged), None)


def test_screenshot_time_is_that_of_the_largest_force(content: Content) -> None:
    time_ns = screenshot_time(content)
    assert content.motion is not None
    at = content.motion.time_ns.tolist().index(time_ns)
    late = content.motion.force[content.motion.time_ns >= content.start_ns + 2 * (content.end_ns - content.start_ns) // 3, :32]
    assert content.motion.force[at, :32].max() == late.max()


# --- the Rerun file, read back ---


def test_rerun_verifies_the_file(document: Path) -> None:
    assert rerun("rrd", "verify", str(document)).returncode == 0


def test_file_has_recording_and_arrangement(document: Path) -> None:
    from rerun.chunk import RrdReader

    reader = RrdReader(str(document))
    assert [store.kind for store in (*reader.recordings(), *reader.blueprints())] == ["recording", "blueprint"]


def test_the_summary_follows_the_cursor(content: Content, tmp_path: Path) -> None:
    halves = [dataclasses.replace(truth, speed=speed, time_ns=time_ns) for truth in content.truths[:1] for speed, time_ns in SPEEDS]
    path = tmp_path / "two.rrd"
    write_document(dataclasses.replace(content, truths=tuple(halves)), path)
    pages = [text for chunk in chunks(path) if chunk.entity_path == "/summary" for text in texts(chunk, "TextDocument:text")]
    assert [re.search(r"([\d.]+) rpm", page)[1] for page in pages] == ["954.9", "1909.9"]  # type: ignore[index]


def test_the_spectrum_names_the_shaft_frequency_of_its_window(content: Content, document: Path) -> None:
    spectra = envelope_spectra(content.detector_output.diagnoses)
    assert spectra is not None
    named = [t for c in chunks(document) if c.entity_path == "/envelope_spectrum/meaning" for t in texts(c, "Points2D:labels")]
    assert named == [f"multiples of the shaft frequency ({frequency:.2f} Hz)" for frequency in spectra.shaft_frequency]


def test_file_contains_drawn_and_native_topics(run: Run, document: Path) -> None:
    rows: Counter[str] = Counter()
    for chunk in chunks(document):
        rows[chunk.entity_path] += 0 if chunk.is_static else chunk.num_rows
    samples, states = round(DURATION * 51200), len(run.states)
    assert rows["/waveform"] == samples
    assert rows["/bearing/row1/rollers"] == rows["/bearing/row2/normal_force"] == rows["/forces/row1"] == states
    assert rows["/dcrb/roller_states"] == states
    assert not any(entity.startswith("/dcrb/outer_ring/vibration") for entity in rows)  # once is enough
    assert rows["/indicators/BPFO"] > 0
    assert {"/envelope_spectrum/curve", "/envelope_spectrum/BPFO/peaks", "/summary", "/features/rms", "/diagnosis/verdict"} <= set(rows)


def test_waveform_in_the_file_equals_the_recorded_one(run: Run, document: Path) -> None:
    found = values(document, "/waveform", "Scalars:scalars")
    expected = np.concatenate([block.acceleration for block in run.blocks]).reshape(-1)
    assert len(found) == 2 * round(DURATION * 51200)
    assert (found == expected).all()


def test_rollers_in_the_file_are_at_their_azimuths(run: Run, document: Path) -> None:
    points = np.stack(values(document, "/bearing/row1/rollers", "Points2D:positions")).reshape(-1, 16, 2)
    azimuth = run.series("azimuth")[:, :16]
    assert np.hypot(points[..., 0], points[..., 1]) == pytest.approx(np.full(azimuth.shape, 94.0), rel=1e-5)  # r_M, Table 1 [mm]
    turned = np.arctan2(points[..., 0], points[..., 1]) - azimuth
    assert np.abs(np.remainder(turned + math.pi, 2.0 * math.pi) - math.pi).max() < 1e-5


def test_a_recording_without_states_shows_its_waveform(run: Run, tmp_path: Path) -> None:
    bare = (dataclasses.replace(block, states=(), truths=()) for block in run.blocks[:30])
    view(record(tmp_path / "bare", run.configuration, bare), save=tmp_path / "bare.rrd")
    rows = Counter(chunk.entity_path for chunk in chunks(tmp_path / "bare.rrd"))
    assert rows["/waveform"] > 0
    assert not any(entity.startswith("/bearing") for entity in rows)


def test_the_readable_part_of_a_truncated_recording_is_shown(bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    whole = next(bag.glob("*.mcap")).read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole[: len(whole) * 2 // 3])
    view(cut, save=tmp_path / "cut.rrd")
    assert "is truncated" in capsys.readouterr().err
    assert 0 < len(values(tmp_path / "cut.rrd", "/waveform", "Scalars:scalars")) < 2 * round(DURATION * 51200)
    assert any(chunk.entity_path == "/dcrb/roller_states" for chunk in chunks(tmp_path / "cut.rrd"))  # with the other topics


def without_summary(bag: Path, path: Path) -> Path:
    """Write the messages of a recording to a file without chunks and summary, as a plain writer does."""
    damage: list[str] = []
    with path.open("wb") as stream:
        nothing = {"repeat_channels": False, "repeat_schemas": False, "use_statistics": False, "use_summary_offsets": False}
        writer = Writer(stream, use_chunking=False, index_types=IndexType.NONE, **nothing)
        writer.start(profile="ros2")
        channels: dict[int, int] = {}
        for stored in Recording(bag).stored[0].messages(damage):
            channel, schema, message = stored.channel, stored.schema, stored.message
            assert schema is not None
            if channel.id not in channels:
                known = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.id] = writer.register_channel(channel.topic, channel.message_encoding, known, channel.metadata)
            writer.add_message(channels[channel.id], message.log_time, message.data, message.publish_time)
        for metadata in Recording(bag).stored[0].metadata():
            writer.add_metadata(metadata.name, dict(metadata.metadata))
        writer.finish()
    return path


@pytest.mark.parametrize("form", ["no summary", "sqlite3"])
def test_files_that_rerun_does_not_read_are_shown_with_all_their_topics(form: str, run: Run, bag: Path, tmp_path: Path) -> None:
    source = without_summary(bag, tmp_path / "x.mcap") if form == "no summary" else bag_of(tmp_path / "x", Recording(bag).messages(), form)
    view(source, save=tmp_path / "x.rrd")
    rows: Counter[str] = Counter()
    for chunk in chunks(tmp_path / "x.rrd"):
        rows[chunk.entity_path] += 0 if chunk.is_static else chunk.num_rows
    assert rows["/waveform"] == round(DURATION * 51200)
    assert rows["/bearing/row1/rollers"] == rows["/dcrb/roller_states"] == len(run.states)


# --- refusals ---


def test_nothing_is_printed_about_a_document_that_is_given_up(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    def write() -> None:
        with written(tmp_path / "a.rrd", ()):
            rr.log("waveform", rr.Scalars([1.0]))
            raise Refusal("the rest is damaged")

    with pytest.raises(Refusal, match="the rest is damaged"):
        write()
    assert capfd.readouterr().err == ""


def test_existing_output_is_refused(bag: Path, document: Path, tmp_path: Path) -> None:
    before = document.read_bytes()
    with pytest.raises(Refusal, match=r"exists: give another name"):
        view(bag, save=document)
    assert document.read_bytes() == before


@pytest.mark.parametrize(
    ("name", "message"), [("picture.jpg", r"must end in one of \.png"), ("absent/picture.png", r"there is no folder .*absent")]
)
def test_unusable_output_is_refused(bag: Path, tmp_path: Path, name: str, message: str) -> None:
    with pytest.raises(Refusal, match=message):
        view(bag, screenshot=tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_a_path_that_is_not_a_recording_is_refused(tmp_path: Path) -> None:
    text = tmp_path / "notes.mcap"
    text.write_text("not a recording")
    with pytest.raises(Refusal, match=r"is not an MCAP file"):
        view(text, save=tmp_path / "notes.rrd")
    with pytest.raises(Refusal, match=r"there is no recording"):
        view(tmp_path / "absent", save=tmp_path / "absent.rrd")


def test_a_recording_without_manifest_is_refused(tmp_path: Path) -> None:
    foreign = tmp_path / "foreign.mcap"
    writer = Writer(str(foreign))
    writer.start(profile="ros2", library="another")
    writer.finish()
    with pytest.raises(Refusal, match=r"has no manifest"):
        view(foreign, save=tmp_path / "foreign.rrd")


def test_recording_without_waveform_is_refused(tmp_path: Path) -> None:
    empty = record(tmp_path / "empty", Configuration(), [])
    with pytest.raises(Refusal, match=r"no block on /dcrb/outer_ring/vibration"):
        view(empty, save=tmp_path / "empty.rrd")
    assert not (tmp_path / "empty.rrd").exists()


def test_rerun_is_imported_lazily() -> None:
    code = "import sys, dcrb_ros.cli.view; sys.exit(bool({'rerun', 'numpy', 'mcap', 'scipy'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], timeout=400, check=False).returncode == 0


# --- the picture ---


@pytest.mark.skipif(
    not VULKAN_DRIVERS or sys.version_info < (3, 11), reason="needs a Vulkan driver (mesa-vulkan-drivers) and the viewer for Python 3.11"
)
def test_screenshot_shows_bearing_and_defect(bag: Path, tmp_path: Path) -> None:
    from PIL import Image

    view(bag, screenshot=tmp_path / "picture.png")
    with Image.open(tmp_path / "picture.png") as image:
        pixels = np.asarray(image.convert("RGB")).astype(int)
    assert pixels.shape == (1000, 1600, 3)
    bearing, spectrum = pixels[30:500, :880], pixels[30:400, 910:]
    for part, colour in ((bearing, palette.DEFECT), (bearing, palette.LOAD), (spectrum, palette.FAULT_LINES["BPFO"])):
        near = np.abs(part - np.array(colour[:3])).max(axis=2) < 12
        assert near.sum() > 40, colour


def test_a_missing_driver_is_reported_in_one_sentence(content: Content, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("VK_ICD_FILENAMES", "VK_DRIVER_FILES"):
        monkeypatch.setenv(name, str(tmp_path / "none.json"))
    monkeypatch.setenv("WGPU_BACKEND", "vulkan")
    with pytest.raises(ViewerFailure, match=r"mesa-vulkan-drivers"):
        take_picture(content, tmp_path / "picture.png")
    assert not (tmp_path / "picture.png").exists()


def test_mean_force_is_computed_by_sector() -> None:
    azimuth = np.array([[0.01, 0.02, -0.01], [0.03, 3.13, -3.13]])
    force = np.array([[10.0, 20.0, 5.0], [30.0, 0.0, 7.0]])
    mean = load_zone.mean_force(azimuth, force)
    assert mean[load_zone.SECTORS // 2] == pytest.approx(20.0)
    assert mean[load_zone.SECTORS // 2 - 1] == pytest.approx(5.0)
    assert mean[0] == pytest.approx(7.0)
    assert np.count_nonzero(mean) == 3
    assert load_zone.sector_azimuths()[load_zone.SECTORS // 2] > 0.0


def test_load_zone_is_below_the_shaft(content: Content) -> None:
    assert content.motion is not None
    rollers = content.bodies.rows * content.bodies.rollers_per_row
    mean = load_zone.mean_force(content.motion.azimuth[:, :rollers], content.motion.force[:, :rollers])
    loaded = np.abs(load_zone.sector_azimuths()[mean > 0.05 * mean.max()])
    assert loaded.max() < np.pi / 2  # with a radial gap the zone is narrower than half a turn


def test_spectra_are_shown_up_to_an_order_at_which_lines_can_be_told_apart() -> None:
    for last, shown in ((60.0, 31.0), (20.0, 20.0)):
        orders = np.arange(0.0, last + 0.01, 0.02)
        diagnosis = Diagnosis(0, 1.0, "healthy", "", spectrum=(orders, np.ones_like(orders)), shaft_frequency=20.0)
        spectra = envelope_spectra([diagnosis])
        assert spectra is not None
        assert spectra.highest_order == pytest.approx(shown, abs=0.03)


def test_order_map_is_brightest_at_the_lines_of_the_defect(content: Content) -> None:
    spectra = envelope_spectra(content.detector_output.diagnoses)
    assert spectra is not None
    picture = order_map.picture(spectra, 30.0)
    assert picture.shape == (300, 1000, 3)
    brightness = picture.astype(float).sum(axis=(0, 2))
    pixel = characteristic_orders(content.bearing).bpfo / spectra.highest_order * 1000.0
    harmonic = int(np.argmax(brightness)) / pixel
    assert harmonic == pytest.approx(round(harmonic), abs=0.02)


def test_the_messages_of_the_waveform_are_not_kept_beside_its_samples() -> None:
    recording = Recording(BAGS / "healthy")
    messages = {VIBRATION: [message.data for message in recording.messages((VIBRATION,))]}
    bench = BenchInfo("healthy", Bearing(), recording.orders, recording.sampling_rate)
    shown = content_of(messages, bench, lambda _: completed(DetectorOutput(None, (), ())))
    assert len(shown.waveform.time_ns) == recording.digests().read.count
    assert messages == {}


def test_the_order_map_is_empty_where_there_was_no_spectrum() -> None:
    seconds = np.array([1.0, 2.0, 3.0, 8.0, 9.0, 10.0])
    level = np.full((len(seconds), 1000), 30.0)
    spectra = Spectra((seconds * 1e9).astype(np.int64), np.arange(1, 1001) * 0.03, level, np.full(len(seconds), 20.0))
    empty = (order_map.picture(spectra, 30.0) == palette.BACKGROUND[:3]).all(axis=(1, 2))
    # The 300 rows are 10 s; the window that ends at 8 s reaches back by one and a half steps at most.
    assert np.flatnonzero(empty).tolist() == list(range(90, 195))


@pytest.mark.parametrize(
    ("frequencies", "varies"), [((20.0, 20.0), False), ((20.0, 21.9), False), ((20.0, 22.1), True), ((0.0, 20.0), False), ((), False)]
)
def test_the_order_map_comes_first_where_the_speed_varies(content: Content, frequencies: tuple[float, ...], varies: bool) -> None:
    found = tuple(Diagnosis(0, 0.0, "healthy", "", shaft_frequency=frequency) for frequency in frequencies)
    assert speed_varies(dataclasses.replace(content, pending_output=completed(DetectorOutput(None, (), found)))) == varies


def test_the_axis_of_levels_ends_at_labelled_values() -> None:
    times = np.arange(2)
    for values, ends in (
        ((3.0, 18.7), (0.0, 20.0)),
        ((-2.0, 20.0), (-10.0, 20.0)),
        ((0.0, 0.0), (0.0, 10.0)),
        ((math.nan, 18.7), (0.0, 20.0)),
        ((-math.inf, math.inf), (0.0, 10.0)),
    ):
        axis = level_axis(Series(times, ("BPFO",), np.array(values)[:, None]))
        assert axis.range is not None
        assert axis.range.as_arrow_array().to_pylist() == [list(ends)]


@pytest.mark.parametrize(
    ("peak", "end"), [(940.0, 1000.0), (1000.0, 1000.0), (1001.0, 2000.0), (2400.0, 3000.0), (3100.0, 10000.0), (0.19, 0.2), (5e-9, 1e-8)]
)
def test_the_axis_of_the_waveform_ends_where_at_least_three_values_are_labelled(peak: float, end: float) -> None:
    axis = waveform_axis(np.array([[0.0, 0.3 * peak], [-peak, 0.0]]))
    assert axis is not None
    assert axis.range is not None
    assert axis.range.as_arrow_array().to_pylist()[0] == pytest.approx([-end, end])


@pytest.mark.parametrize("value", [0.0, np.nan, np.inf])
def test_a_waveform_without_finite_peak_has_the_axis_of_the_viewer(value: float) -> None:
    assert waveform_axis(np.full((3, 2), value)) is None
    assert waveform_axis(np.zeros((0, 2))) is None


def test_plots_of_the_whole_recording_have_a_margin_for_their_labels(content: Content) -> None:
    margin = round(0.06 * (content.end_ns - content.start_ns))
    shown = whole_time(content).view_range
    assert shown is not None
    assert shown.as_arrow_array().to_pylist() == [{"start": content.start_ns - margin, "end": content.end_ns + margin}]
