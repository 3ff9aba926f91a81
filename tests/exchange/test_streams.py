"""Temperatures and tacho pulses in files of other tools: everything an export writes comes back, and slow channels of others are read."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml
from runs import record
from scipy.io import loadmat

import dcrb_ros
from dcrb_ros.exchange.export import array_name, export
from dcrb_ros.exchange.files import channel, read_external
from dcrb_ros.exchange.importing import WaveformImport
from dcrb_ros.exchange.plausibility import implausible
from dcrb_ros.messages.topics import AMBIENT_TEMPERATURE, BOX_TEMPERATURE, FEATURES, OUTER_RING_TEMPERATURE, SENSOR, TACHO, VIBRATION
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.simulation.loop import Simulation

STREAMS = (VIBRATION, FEATURES, TACHO, OUTER_RING_TEMPERATURE, BOX_TEMPERATURE, AMBIENT_TEMPERATURE)
WARM = {"thermal.law": "network", "tacho.pulses_per_turn": 100, "operating.speed_fluctuation": 0.01}
RATE = 12000
ORDERS = {"FTF": 0.39828, "BPFO": 3.5848, "BPFI": 5.4152, "BSF": 2.35695}  # SKF 6205-2RS JEM


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a recording of a warm bearing with a tacho, over two readings of temperature."""
    configuration = dcrb_ros.load_configuration("healthy", WARM)
    return record(tmp_path_factory.mktemp("warm") / "bag", configuration, Simulation(configuration).blocks(1.05))


def sent(recording: Recording) -> list[tuple[str, int, bytes]]:
    return [(message.topic.name, message.time_ns, message.data) for message in recording.messages(STREAMS)]


@pytest.mark.parametrize("suffix", [".npz", ".csv", ".mat", ".parquet"])
def test_all_streams_come_back_byte_for_byte(suffix: str, bag: Path, tmp_path: Path) -> None:
    file, old = tmp_path / f"wave{suffix}", Recording(bag)
    beside = export(old, file)
    WaveformImport(file, beside).write(tmp_path / "new")
    new = Recording(tmp_path / "new")
    assert len(list(new.messages((TACHO,)))) == 53
    assert sorted(sent(new)) == sorted(sent(old))
    assert new.tacho().pulses_per_turn == 100
    assert new.temperatures().to_pandas().equals(old.temperatures().to_pandas())
    assert new.manifest["imported"]["labels"]["thermal"]["box [deg C]"] == old.truth().thermal("box [deg C]")[-1]
    # A second generation keeps the noise of the sensors, which its bench no longer tells.
    again = export(new, tmp_path / f"again{suffix}")
    assert yaml.safe_load(again.read_text())["temperature_deviation"] == 0.2


def test_the_angle_from_the_pulses_of_a_file_is_that_of_the_shaft(bag: Path, tmp_path: Path) -> None:
    beside = export(Recording(bag), tmp_path / "wave.npz")
    WaveformImport(tmp_path / "wave.npz", beside, ["channels.shaft_angle=null"]).write(tmp_path / "new")
    old, new = Recording(bag).waveform(), Recording(tmp_path / "new").waveform()
    assert Recording(tmp_path / "new").manifest["sensor"]["shaft_angle"] == "from pulses of a tacho, 100 per turn"
    difference = new.turns - old.turns
    # Where the signal begins is unknown to a tacho, and before the first and after the last pulse the speed is that of the nearest.
    assert np.ptp(difference[100:-100]) * 360.0 < 0.01


def test_arrays_of_the_truth_say_what_they_are(bag: Path, tmp_path: Path) -> None:
    recording = Recording(bag)
    export(recording, tmp_path / "wave.npz")
    export(recording, tmp_path / "wave.mat")
    arrays, truth = np.load(tmp_path / "wave.npz"), recording.truth()
    assert arrays["truth_row2_outer_ring_temperature"].tolist() == truth.thermal("row2/outer_ring [deg C]").tolist()
    assert arrays["truth_row1_rest_heat"].shape == arrays["truth_time"].shape == (len(truth),)
    assert arrays["truth_clearance_change"].tolist() == truth.thermal("clearance_change [m]").tolist()
    assert array_name("acceleration") == "truth_time_lapse"
    assert loadmat(tmp_path / "wave.mat")["box_temperature"].ravel().tolist() == recording.temperatures().box.tolist()


def test_a_table_has_a_reading_at_its_sample_and_nothing_elsewhere(bag: Path, tmp_path: Path) -> None:
    export(Recording(bag), tmp_path / "wave.csv")
    table = pd.read_csv(tmp_path / "wave.csv")
    known = table[["outer_ring_temperature", "box_temperature", "ambient_temperature"]].dropna()
    assert list(table["time"][known.index]) == [0.0, 1.0]
    assert known["box_temperature"].tolist() == Recording(bag).temperatures().box.tolist()


def test_a_bench_without_heat_and_tacho_is_exported_as_ever(tmp_path: Path) -> None:
    beside = export(Recording(Path(__file__).parents[2] / "bags" / "healthy"), tmp_path / "wave.npz")
    assert set(np.load(tmp_path / "wave.npz").files) == {
        *("index", "time", "ax", "ay", "shaft_angle", "truth_time", "truth_speed", "truth_load", "sampling_rate", "about")
    }
    assert set(yaml.safe_load(beside.read_text())["channels"]) == {"index", "ax", "ay", "shaft_angle"}


def imported(folder: Path, channels: dict[str, str], arrays: dict[str, Any], **more: Any) -> Recording:
    """Import 3 s of noise with further channels."""
    noise = np.random.default_rng(1).normal(0.0, 1.0, 3 * RATE)
    np.savez(folder / "x.npz", a=noise, **arrays)
    about = {"channels": {"ax": "a", **channels}, "sampling_rate": RATE, "unit": "m/s^2", "orders": ORDERS, **more}
    (folder / "about.yaml").write_text(yaml.safe_dump(about))
    WaveformImport(folder / "x.npz", folder / "about.yaml").write(folder / "bag")
    return Recording(folder / "bag")


def test_a_csv_file_has_all_digits_of_a_temperature(tmp_path: Path) -> None:
    old = imported(tmp_path, {"box_temperature": "b"}, {"b": np.random.default_rng(3).normal(40.0, 1.0, 30)})
    beside = export(old, tmp_path / "wave.csv")
    WaveformImport(tmp_path / "wave.csv", beside).write(tmp_path / "new")
    assert Recording(tmp_path / "new").temperatures().box.tolist() == old.temperatures().box.tolist()


@pytest.mark.parametrize(("reading", "start"), [(95.0, 95.0), (101.0, 100.0)])
def test_a_recording_begins_with_its_first_sample_or_reading(reading: float, start: float, tmp_path: Path) -> None:
    # Its description had the time 0, so that a replay waited for the first sample.
    channels, arrays = {"box_temperature": "t", "temperature_time": "u"}, {"t": np.array([40.0]), "u": np.array([reading])}
    messages = list(imported(tmp_path, channels, arrays, first_index=100 * RATE).messages())
    assert messages[0].topic == SENSOR
    assert messages[0].time_ns == min(message.time_ns for message in messages) == start * 1e9


def test_fewer_readings_than_samples_are_spread_over_the_file(tmp_path: Path) -> None:
    found = imported(tmp_path, {"box_temperature": "t"}, {"t": np.array([40.0, np.nan, 41.0, 42.0, 43.0, 44.0])}).temperatures()
    assert found.time.tolist() == [0.0, 1.0, 1.5, 2.0, 2.5]
    assert found.box.tolist() == [40.0, 41.0, 42.0, 43.0, 44.0]
    assert np.isnan(found.outer_ring).all()
    assert np.isnan(found.ambient).all()
    assert found.to_words(0) == "outer_ring unknown, box 40 deg C, ambient unknown"
    assert repr(found).endswith("at the end outer_ring unknown, box 44 deg C, ambient unknown>")


def test_a_reading_at_every_sample_is_thinned(tmp_path: Path) -> None:
    dense = np.linspace(20.0, 23.0, 3 * RATE)
    found = imported(tmp_path, {"ambient_temperature": "t"}, {"t": dense}).temperatures()
    assert found.time.tolist() == pytest.approx(np.arange(30) / 10.0)
    assert found.ambient == pytest.approx(20.0 + found.time, abs=1e-3)


@pytest.mark.parametrize(
    ("channels", "arrays", "sentence"),
    [
        ({"box_temperature": "t"}, {"t": np.full(3, 313.0) - 600.0}, "-287 deg C, outside -273.15 .. 2000 deg C: give degrees Celsius"),
        ({"box_temperature": "t"}, {"t": np.array([20.0, 1e300])}, r"1e\+300 deg C, outside -273.15 .. 2000 deg C"),
        ({"box_temperature": "t"}, {"t": np.zeros(0)}, "'box_temperature' has no readings: give at least one"),
        ({"box_temperature": "t", "temperature_time": "u"}, {"t": np.zeros(0), "u": np.zeros(0)}, "'box_temperature' has no readings"),
        ({"box_temperature": "t"}, {"t": np.full(4 * RATE, 20.0)}, "has 48000 readings for 36000 samples"),
        ({"box_temperature": "t", "temperature_time": "u"}, {"t": np.ones(3), "u": np.ones(2)}, "has 3 readings for 2 times"),
        ({"box_temperature": "t", "temperature_time": "u"}, {"t": np.ones(2), "u": np.array([2.0, 1.0])}, "must increase"),
        (
            {"box_temperature": "t", "temperature_time": "u"},
            {"t": np.ones(2), "u": np.array([-1.0, 1.0])},
            "-1 s, outside 0 .. 2147483648 s",
        ),
        (
            {"box_temperature": "t", "temperature_time": "u"},
            {"t": np.ones(1), "u": np.array([3e9])},
            "3e\\+09 s, outside 0 .. 2147483648 s",
        ),
        ({"temperature_time": "u"}, {"u": np.ones(2)}, "gives temperature_time, but no temperature"),
    ],
)
def test_readings_without_meaning_are_refused(channels: dict[str, str], arrays: dict[str, Any], sentence: str, tmp_path: Path) -> None:
    with pytest.raises(Refusal, match=sentence):
        imported(tmp_path, channels, arrays)


def test_readings_outside_the_waveform_and_their_loss_in_a_table_are_named(tmp_path: Path) -> None:
    times = {"box_temperature": "t", "temperature_time": "u"}
    recording = imported(tmp_path, times, {"t": np.full(5, 20.0), "u": np.array([0.0, 2.0, 3.0, 4.0, 1000.0])})
    warnings = implausible(WaveformImport(tmp_path / "x.npz", tmp_path / "about.yaml"))
    assert len(warnings) == 1
    assert warnings[0].startswith("2 of 5 readings of box_temperature are later than the waveform, which ends at 3 s, up to 1000 s: check")
    for suffix, words in (
        (".csv", "3 of 5 readings of temperature"),
        (".parquet", "3 of 5"),
        (".wav", "neither temperatures"),
        (".npz", ""),
    ):
        notes = list[str]()
        export(recording, tmp_path / f"wave{suffix}", notes=notes)
        assert [words in note for note in notes] == [True] * bool(words)


@pytest.mark.parametrize("suffix", [".npz", ".csv"])
@pytest.mark.parametrize("timed", [True, False])
def test_a_reading_keeps_its_sample_at_a_fractional_rate(timed: bool, suffix: str, tmp_path: Path) -> None:
    rate, place, signal = 5000.4, 30_000, np.sin(np.arange(40_000) * 0.1)
    channels = {"ax": "a", "box_temperature": "t"} | ({"temperature_time": "u"} if timed else {})
    beside = np.full(len(signal), np.nan)
    beside[place] = 40.0
    arrays = {"t": np.array([40.0]), "u": np.array([place / rate])} if timed else {"t": beside}
    np.savez(tmp_path / "x.npz", a=signal, **arrays)
    about = {"channels": channels, "sampling_rate": rate, "unit": "m/s^2", "orders": ORDERS}
    (tmp_path / "about.yaml").write_text(yaml.safe_dump(about))
    file, described = tmp_path / "x.npz", tmp_path / "about.yaml"
    for folder in ("first", "again"):
        waveform = WaveformImport(file, described)
        assert not any("later than" in sentence for sentence in implausible(waveform))
        waveform.write(tmp_path / folder)
        recording = Recording(tmp_path / folder)
        assert recording.temperatures().time == pytest.approx([place / 5000])
        file = tmp_path / f"{folder}{suffix}"
        described = export(recording, file)
    written = read_external(file)
    if suffix == ".npz":
        assert channel(written, file, "temperature_time") == pytest.approx([place / rate])
    else:
        assert np.flatnonzero(np.isfinite(channel(written, file, "box_temperature"))).tolist() == [place]


def test_a_channel_of_temperatures_without_a_reading_is_a_warning(tmp_path: Path) -> None:
    imported(tmp_path, {"box_temperature": "t"}, {"t": np.full(5, np.nan)})
    warnings = implausible(WaveformImport(tmp_path / "x.npz", tmp_path / "about.yaml"))
    assert [sentence.startswith("box_temperature has no reading") for sentence in warnings] == [True]


def test_a_deviation_without_readings_is_refused(tmp_path: Path) -> None:
    with pytest.raises(Refusal, match="gives temperature_deviation, but no temperature: name a channel of"):
        imported(tmp_path, {}, {}, temperature_deviation=0.5)


def test_pulses_of_a_measured_tacho_are_recorded_as_well(tmp_path: Path) -> None:
    turns = 30.0 * np.arange(3 * RATE) / RATE
    recording = imported(tmp_path, {"tacho": "s"}, {"s": 5.0 * (np.mod(4.0 * turns + 0.3, 1.0) < 0.3)}, pulses_per_turn=4)
    assert len(recording.tacho()) == 360
    assert recording.tacho().speed == pytest.approx(60.0 * np.pi, rel=2e-3)
