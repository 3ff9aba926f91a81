"""Wrong numbers of an import are refused or warned of."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml
from scipy.io import wavfile
from separate_process import dcrb

from dcrb_ros.exchange.files import read_external
from dcrb_ros.exchange.importing import WaveformImport
from dcrb_ros.schema.refusal import Refusal


def about(folder: Path, **changes: object) -> Path:
    known = {
        "channels": {"ax": "a"},
        "sampling_rate": 12000,
        "unit": "m/s^2",
        "bearing": {"balls": 9, "diameter": 0.008, "pitch_diameter": 0.04},
    }
    (folder / "about.yaml").write_text(yaml.safe_dump(known | changes), encoding="utf-8")
    return folder / "about.yaml"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("0,123\n0,456\n", "decimal commas"),
        ("0,123;1,5\n0,456;1,5\n", "decimal commas"),
        ("a;b\n0,123;1,5\n", "decimal commas"),
        ("a\n0.5\n#0.25\n0.125\n", "cannot be read as CSV"),
        ("a\n0.5\n0.25 # loose\n", "cannot be read as CSV"),
    ],
)
def test_decimal_commas_and_comments_inside_the_data_are_refused(text: str, words: str, tmp_path: Path) -> None:
    (tmp_path / "x.csv").write_text(text)
    with pytest.raises(Refusal, match=words):
        read_external(tmp_path / "x.csv")


def test_a_table_below_comments_is_read(tmp_path: Path) -> None:
    (tmp_path / "x.csv").write_text("# made by X\n0.5,1\n0.25,2\n")
    assert read_external(tmp_path / "x.csv").column("1").tolist() == [0.5, 0.25]


def test_a_wav_file_that_is_cut_off_is_refused(tmp_path: Path) -> None:
    wavfile.write(tmp_path / "x.wav", 12000, np.zeros(1000, np.float32))
    whole = (tmp_path / "x.wav").read_bytes()
    read_external(tmp_path / "x.wav")
    (tmp_path / "x.wav").write_bytes(whole[:-400])
    with pytest.raises(Refusal, match="states 4000 bytes, but 3600 follow"):
        read_external(tmp_path / "x.wav")


def test_a_full_scale_without_integer_samples_is_refused(tmp_path: Path) -> None:
    wavfile.write(tmp_path / "x.wav", 12000, np.zeros(1000, np.float32))
    with pytest.raises(Refusal, match=r"gives full_scale, but .* leave it out"):
        WaveformImport(tmp_path / "x.wav", about(tmp_path, channels={"ax": 1}, full_scale=50.0))


def test_an_import_prints_its_speed_and_lines_and_warns_of_implausible_ones(tmp_path: Path) -> None:
    np.savez(tmp_path / "x.npz", a=3.0 * np.sin(np.arange(24000)))
    done = dcrb("import", str(tmp_path / "x.npz"), "--about", str(about(tmp_path, speed_rpm=900)), "-o", str(tmp_path / "good"))
    assert "900 rpm, FTF 6.00, BPFO 54.00, BPFI 81.00, BSF 36.00 Hz, rms 2.121 m/s^2, 2.000 s" in done.stdout
    assert done.stderr == ""
    done = dcrb("import", str(tmp_path / "x.npz"), "--about", str(about(tmp_path, speed=900, unit="mm/s^2")), "-o", str(tmp_path / "odd"))
    assert "if rpm were meant, give speed_rpm" in done.stderr
    done = dcrb(
        "import",
        str(tmp_path / "x.npz"),
        "--about",
        str(about(tmp_path, unit="g")),
        "-o",
        str(tmp_path / "loud"),
        "--set",
        "unit=V",
        "--set",
        "sensitivity=1 mV/g",
    )
    assert "check unit and sensitivity" in done.stderr


@pytest.mark.parametrize(("load", "words"), [("-5000.0", "is negative"), ("900.0", "below 0.001 of the load rating"), ("60000.0", "")])
def test_config_check_warns_of_negative_and_very_small_loads(load: str, words: str) -> None:
    done = dcrb("config", "check", "healthy", "--set", f"operating.load={load}")
    assert done.returncode == 0
    assert words in done.stderr if words else "load" not in done.stderr


@pytest.mark.parametrize(
    ("beside", "words"),
    [
        ({"fs": 25600}, "'fs' is 25600"),
        ({"time": np.arange(2400) / 25600}, "'time' advances by 3.90625e-05"),
        ({"time": np.round(np.arange(2400) / 12000, 5)}, ""),
        ({"time": np.arange(2400) / 12000 + (np.arange(2400) > 1200)}, ""),
        ({"fs": 12000.0, "time": np.arange(2400) / 12.0}, ""),
    ],
)
def test_a_sampling_rate_that_the_file_contradicts_is_refused(beside: dict[str, object], words: str, tmp_path: Path) -> None:
    np.savez(tmp_path / "x.npz", a=np.sin(np.arange(2400)), **beside)  # type: ignore[arg-type]
    if not words:
        assert WaveformImport(tmp_path / "x.npz", about(tmp_path)).rate == 12000
        return
    with pytest.raises(Refusal, match=f"gives sampling_rate = 12000 Hz, but {words}"):
        WaveformImport(tmp_path / "x.npz", about(tmp_path))


def test_a_measured_speed_beyond_any_bearing_is_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "x.npz", a=np.sin(np.arange(2400)), n=np.full(10, 1e300))
    with pytest.raises(Refusal, match="'n' is 1e\\+300 rpm"):
        WaveformImport(tmp_path / "x.npz", about(tmp_path, channels={"ax": "a", "rpm": "n"}))
