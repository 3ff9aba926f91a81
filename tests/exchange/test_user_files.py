"""Import as users have their data: tacho, speed, volts, unknown units, fractional rates, several files, bearings by geometry."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from jittered_impacts import Floats, Machine
from separate_process import dcrb

from dcrb_ros.diagnosis.detection import detect
from dcrb_ros.exchange.export import export
from dcrb_ros.exchange.importing import WaveformImport
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.schema.refusal import Refusal

SPEED = 25.0


def machine() -> Machine:
    # 9 balls of 8 mm on a pitch circle of 40 mm at 12 kHz
    return Machine(3, speed=SPEED)


def about(folder: Path, **changes: Any) -> Path:
    known: dict[str, Any] = {
        "channels": {"ax": "a"},
        "sampling_rate": 12000,
        "unit": "m/s^2",
        "bearing": {"balls": 9, "diameter": 0.008, "pitch_diameter": 0.04},
    }
    path = folder / "about.yaml"
    path.write_text(yaml.safe_dump({key: value for key, value in {**known, **changes}.items() if value is not None}), encoding="utf-8")
    return path


def struck(seconds: float = 4.0) -> Floats:
    one = machine()
    return one.healthy(seconds) + one.impacts(seconds, "outer_ring")


def test_a_defect_is_named_if_only_the_third_axis_shows_it(tmp_path: Path) -> None:
    quiet, random = machine().healthy(4.0), np.random.default_rng(5)
    axes = {"a": quiet, "b": quiet + 0.3 * random.normal(size=len(quiet)), "c": struck()}
    np.savez(tmp_path / "x.npz", **axes)
    chosen = {"channels": {"ax": "a", "ay": "b", "az": "c"}, "speed_rpm": 60.0 * SPEED}
    recording = imported(tmp_path, WaveformImport(tmp_path / "x.npz", about(tmp_path, **chosen)))
    assert np.array_equal(recording.waveform().acceleration, np.column_stack(list(axes.values())).astype(np.float32))
    assert detect(recording).verdict == "outer_ring"
    plain = detect(np.column_stack(list(axes.values())), 12000, bearing=machine().orders, shaft_angle=recording.waveform().shaft_angle)
    assert plain.history[-1].scores == pytest.approx(detect(recording).history[-1].scores)
    two = {**chosen, "channels": {"ax": "a", "ay": "b"}}
    without = WaveformImport(tmp_path / "x.npz", about(tmp_path, **two)).acceleration
    assert detect(without, 12000, bearing=machine().orders, shaft_angle=recording.waveform().shaft_angle).verdict == "healthy"
    description = export(recording, tmp_path / "again.wav")
    again = WaveformImport(tmp_path / "again.wav", description)
    assert np.array_equal(again.acceleration, recording.waveform().acceleration)
    with pytest.raises(Refusal, match="az is given without ay"):
        WaveformImport(tmp_path / "x.npz", about(tmp_path, **{**chosen, "channels": {"ax": "a", "az": "c"}}))


def imported(folder: Path, waveform: WaveformImport) -> Recording:
    waveform.write(folder / "bag")
    return Recording(folder / "bag")


@pytest.mark.parametrize("source", ["tacho", "rpm", "shaft_angle", "speed_rpm"])
def test_a_defect_is_named_whatever_tells_the_speed(source: str, tmp_path: Path) -> None:
    signal = struck()
    turns = SPEED / 12000 * np.arange(len(signal))
    angle = np.mod(turns, 1.0) * 2.0 * np.pi
    angle[10_000:10_200] = np.nan
    arrays = {"tacho": 3.0 + 2.0 * (np.mod(4.0 * turns, 1.0) < 0.1), "rpm": np.full(400, 60.0 * SPEED), "shaft_angle": angle}
    chosen = {source: 60.0 * SPEED} if source == "speed_rpm" else {"channels": {"ax": "a", source: "s"}}
    more = {"pulses_per_turn": 4} if source == "tacho" else {}
    np.savez(tmp_path / "x.npz", a=signal, s=arrays.get(source, angle))
    recording = imported(tmp_path, WaveformImport(tmp_path / "x.npz", about(tmp_path, **chosen, **more)))
    found = detect(recording)
    assert found.verdict == "outer_ring"
    assert found.last.shaft_frequency == pytest.approx(SPEED, rel=1e-3)
    assert recording.manifest["sensor"]["shaft_angle"] != "unknown"


@pytest.mark.parametrize(
    ("unit", "sensitivity", "factor"),
    [
        ("mV", "100 mV/g", 9.80665 / 100.0),  # IEPE accelerometer of 100 mV per standard gravity
        ("V", "100 mV/g", 98.0665),
        ("V", "0.01 V/(m/s^2)", 100.0),
        ("mV", "10.2 mV/m/s^2", 1.0 / 10.2),
        ("relative", None, 1.0),
    ],
)
def test_volts_become_accelerations(unit: str, sensitivity: str | None, factor: float, tmp_path: Path) -> None:
    signal = struck(0.1)
    np.savez(tmp_path / "x.npz", a=signal)
    found = WaveformImport(tmp_path / "x.npz", about(tmp_path, unit=unit, sensitivity=sensitivity))
    assert found.acceleration[:, 0] == pytest.approx(signal * factor, rel=1e-6)
    unknown = unit == "relative"
    assert found.sensor()["acceleration_unit"] == ("relative" if unknown else "m/s^2")
    assert any("unit is unknown" in remark for remark in found.remarks()) == unknown


def test_a_fractional_rate_keeps_the_speed(tmp_path: Path) -> None:
    rate, signal = 48828.125, np.sin(np.arange(100_000) * 0.1)  # 100 MHz over 2048
    np.savez(tmp_path / "x.npz", a=signal)
    found = WaveformImport(tmp_path / "x.npz", about(tmp_path, sampling_rate=rate, speed_rpm=1500.0))
    recording = imported(tmp_path, found)
    assert (recording.sampling_rate, found.sensor()["measured_sampling_rate"]) == (48828, rate)
    assert found.remarks() == ["the sampling rate of 48828.125 Hz is recorded as 48828 Hz, since stamps count whole samples"]
    turns = np.unwrap(found.angle.astype(float))[-1] / (2.0 * np.pi)
    assert turns == pytest.approx(25.0 * 99_999 / rate, rel=1e-7)
    exported = tmp_path / "again.npz"
    again = WaveformImport(exported, export(recording, exported))
    assert (again.measured_rate, again.rate) == (rate, 48828)
    with np.load(exported) as arrays:
        assert (float(arrays["sampling_rate"]), arrays["time"][-1]) == (rate, 99_999 / rate)
    assert WaveformImport(tmp_path / "again.wav", export(recording, tmp_path / "again.wav")).rate == 48828


def test_files_are_joined_with_the_gap_between_them(tmp_path: Path) -> None:
    signal = struck(4.0)
    files = [tmp_path / f"{k}.npz" for k in range(4)]
    for file, part in zip(files, np.split(signal, 4), strict=True):
        np.savez(file, a=part)
    with pytest.raises(Refusal, match="has no gap between 4 files: add gap"):
        WaveformImport(files, about(tmp_path))
    whole = WaveformImport(files, about(tmp_path, gap=0.0, speed_rpm=60.0 * SPEED))
    assert np.array_equal(whole.acceleration[:, 0], signal.astype(np.float32))
    assert whole.remarks() == []
    assert detect(imported(tmp_path, whole)).verdict == "outer_ring"
    apart = WaveformImport(files, about(tmp_path, gap=0.5, speed_rpm=60.0 * SPEED))
    assert [int(step) for step in np.diff(apart.index) if step != 1] == [6001, 6001, 6001]
    assert apart.remarks() == ["the waveform has 3 gaps"]
    assert apart.manifest()["imported"]["files"] == ["0.npz", "1.npz", "2.npz", "3.npz"]


def test_times_that_begin_again_in_each_file_are_named(tmp_path: Path) -> None:
    np.savez(tmp_path / "x.npz", a=np.ones(12000), b=np.array([40.0, 41.0]), u=np.array([0.0, 0.5]))
    channels = {"ax": "a", "box_temperature": "b", "temperature_time": "u"}
    with pytest.raises(Refusal, match=r"0 s follows 0\.5 s: .* in several files the times count from sample 0 of the first one"):
        WaveformImport([tmp_path / "x.npz"] * 2, about(tmp_path, channels=channels, gap=0))


def test_gaps_beyond_the_range_of_time_stamps_are_named(tmp_path: Path) -> None:
    np.savez(tmp_path / "x.npz", a=np.ones(10))
    with pytest.raises(Refusal, match=r"first_index = 0 and gap = 1e\+08 s gives sample .*: start at 0, with shorter gaps"):
        WaveformImport([tmp_path / "x.npz"] * 30, about(tmp_path, gap=1e8))


def test_files_of_other_rates_or_channels_are_not_joined(tmp_path: Path) -> None:
    from scipy.io import wavfile

    for name, rate in (("a.wav", 12000), ("b.wav", 25600)):
        wavfile.write(tmp_path / name, rate, np.ones(100, np.float32))
    description = about(tmp_path, sampling_rate=None, gap=0.0, channels={"ax": 1})
    with pytest.raises(Refusal, match=r"a\.wav and .*b\.wav have different sampling rates, 12000 and 25600"):
        WaveformImport([tmp_path / "a.wav", tmp_path / "b.wav"], description)
    np.savez(tmp_path / "a.npz", a=np.ones(100))
    np.savez(tmp_path / "b.npz", b=np.ones(100))
    with pytest.raises(Refusal, match=r"b\.npz has no channel 'a'"):
        WaveformImport([tmp_path / "a.npz", tmp_path / "b.npz"], about(tmp_path, gap=0.0))


def test_the_contact_angle_changes_the_orders(tmp_path: Path) -> None:
    np.savez(tmp_path / "x.npz", a=np.ones(100))
    # Rexnord ZA-2115 of the IMS rig: 16 rollers of 0.331 inches on 2.815 inches, 15.17 degrees (Qiu et al. 2006); BPFO 7.09 orders
    bearing = {"rollers": 16, "diameter": 0.0084074, "pitch_diameter": 0.071501, "contact_angle_deg": 15.17}
    orders = WaveformImport(tmp_path / "x.npz", about(tmp_path, bearing=bearing)).orders
    # 236.4, 296.9 and 139.9 Hz (BSF) at 33.3 Hz, as papers on this rig give them
    assert (orders.bpfo, orders.bpfi, orders.bsf) == pytest.approx((236.4 / 33.33, 296.9 / 33.33, 139.9 / 33.33), rel=2e-3)


def test_a_star_stands_for_the_part_of_a_name_that_changes(tmp_path: Path) -> None:
    from scipy.io import savemat

    savemat(tmp_path / "105.mat", {"X105_DE_time": np.ones(100), "X105_FE_time": np.zeros(100), "X105RPM": 1797.0})
    description = about(tmp_path, channels={"ax": "X*_DE_time", "rpm": "X*RPM"})
    found = WaveformImport(tmp_path / "105.mat", description)
    assert found.acceleration[:, 0].tolist() == [1.0] * 100
    assert np.unwrap(found.angle.astype(float))[-1] == pytest.approx(1797.0 * np.pi / 30.0 * 99 / 12000, rel=1e-5)
    savemat(tmp_path / "99.mat", {"X098_DE_time": np.ones(100), "X099_DE_time": np.ones(100), "X099RPM": 1797.0})
    with pytest.raises(Refusal, match=r"has the channels X098_DE_time, X099_DE_time like 'X\*_DE_time', but one is needed"):
        WaveformImport(tmp_path / "99.mat", description)


def test_settings_change_a_description(tmp_path: Path) -> None:
    np.savez(tmp_path / "x.npz", a=struck(2.0), b=np.ones(3))
    description = about(tmp_path, channels={"ax": "b", "rpm": "c"})
    found = WaveformImport(tmp_path / "x.npz", description, ["channels.ax=a", "channels.rpm=null", "speed_rpm=1500"])
    assert len(found.angle) == 24000
    for setting, sentence in (
        ("speed_rpm", "is not KEY=VALUE"),
        ("unit.x=1", "unit is not a group of keys"),
        ("unit=[", "not valid YAML"),
        ("spead=1", "unknown key 'spead'"),
    ):
        with pytest.raises(Refusal, match=sentence):
            WaveformImport(tmp_path / "x.npz", description, [setting])


def test_an_output_that_cannot_be_made_is_refused_before_the_files_are_read(tmp_path: Path) -> None:
    (tmp_path / "bag").mkdir()
    done = dcrb("import", str(tmp_path / "none.csv"), "--about", str(about(tmp_path)), "-o", str(tmp_path / "bag"))
    assert done.returncode == 2
    assert "exists: give another name, or --force" in done.stderr
    done = dcrb("import", str(tmp_path / "none.csv"), "--about", str(about(tmp_path)), "-o", "/proc/bag")
    assert done.returncode == 2
    assert "no folder can be created in /proc: " in done.stderr


def test_the_command_says_what_is_not_as_it_was_measured(tmp_path: Path) -> None:
    for name in ("a", "b"):
        np.savez(tmp_path / f"{name}.npz", a=struck(0.5))
    files = [str(tmp_path / "a.npz"), str(tmp_path / "b.npz")]
    settings = ("--set", "gap=10.0", "--set", "unit=relative")
    done = dcrb("import", *files, "--about", str(about(tmp_path)), "-o", str(tmp_path / "bag"), *settings)
    assert done.returncode == 0, done.stderr
    assert "12000 samples, 1.000 s at 12000 Hz" in done.stdout
    assert "the waveform has 1 gap" in done.stdout
    assert "the unit is unknown" in done.stdout
    info = json.loads(dcrb("info", str(tmp_path / "bag"), "--json").stdout)
    assert "relative" in json.dumps(info)
    for arguments in ((), (files[0],), ("--list", files[0]), (files[0], "--about", "unheard-of", "-o", "x")):
        done = dcrb("import", *arguments)
        assert (done.returncode, done.stderr.count("\n")) == (2, 1)
