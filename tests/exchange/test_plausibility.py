"""Wrong numbers of an import are refused or warned of."""

from __future__ import annotations

import math
import struct
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
import yaml
from pyarrow import parquet
from scipy.io import savemat, wavfile
from separate_process import dcrb

from dcrb_ros.exchange.files import channel, read_external
from dcrb_ros.exchange.importing import WaveformImport
from dcrb_ros.exchange.plausibility import implausible
from dcrb_ros.schema.arrays import Floats
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
        ("1,25E-02\n1,5E-02\n", "decimal commas"),
        ("+0,5\n-0,25\n", "decimal commas"),
        ("0,1,2\n0.5,1,3\n", "begins with '0,1,2', which may be samples or numbers of the columns: write the names"),
        ("1\t2\n0.5\t1\n", "which may be samples or numbers of the columns"),
        ("NA,1.5\n0.5,1\n", "begins with 'NA,1.5', which has numbers or unknown values beside words: write the names"),
        ("NA,NA\n0.5,1\n", "which has numbers or unknown values beside words"),
        ("NA,1\n0.5,1\n", "which has numbers or unknown values beside words"),
        ("a,0.5,1\n0.5,1,2\n", "which has numbers or unknown values beside words"),
        ("0.5,,1\n0.25,1,2\n", "line 1, column 2: the field is empty"),
        ("a\n0.5\n#0.25\n0.125\n", "cannot be read as CSV"),
        ("a\n0.5\n0.25 # loose\n", "cannot be read as CSV"),
        ("Rig 7\nrate,12000\na,b\n0.5,1\n", "and a # before other lines above them"),
        ("a,b\n\ng,g\n0.5,1\n", "line 3, column 1: 'g' is not a number"),
        ("# by X\na,b\n0.5,1\n0.25,\n", "line 4, column 2: the field is empty: .* nan for an unknown one"),
    ],
)
def test_decimal_commas_and_comments_inside_the_data_are_refused(text: str, words: str, tmp_path: Path) -> None:
    (tmp_path / "x.csv").write_text(text)
    with pytest.raises(Refusal, match=words):
        read_external(tmp_path / "x.csv")


def test_a_table_below_comments_is_read(tmp_path: Path) -> None:
    (tmp_path / "x.csv").write_text("# made by X\n0.5,1\n0.25,2\n")
    assert read_external(tmp_path / "x.csv").column("1").tolist() == [0.5, 0.25]


@pytest.mark.parametrize("index", ["", "time"])
def test_numbered_columns_after_an_index_are_read(index: str, tmp_path: Path) -> None:
    (tmp_path / "x.csv").write_text(f"{index},0,1\n0,0.5,1\n1,0.25,2\n")
    assert read_external(tmp_path / "x.csv").column("1").tolist() == [1.0, 2.0]


@pytest.mark.parametrize("encoding", ["latin-1", "utf-16"])
def test_a_table_in_another_encoding_is_refused_with_the_remedy(encoding: str, tmp_path: Path) -> None:
    (tmp_path / "x.csv").write_bytes("a [m/s²]\n0.5\n".encode(encoding))
    with pytest.raises(Refusal, match="not UTF-8: save it as UTF-8"):
        read_external(tmp_path / "x.csv")


@pytest.mark.parametrize(
    ("names", "words"),
    [
        ("a,b,c", "has 3 names in its first line, but 2 columns"),
        ("a,a", "has 2 columns called 'a': give the number"),
    ],
)
def test_names_that_do_not_identify_a_column_are_refused(names: str, words: str, tmp_path: Path) -> None:
    file = tmp_path / "x.csv"
    file.write_text(f"{names}\n0.5,1\n0.25,2\n")
    with pytest.raises(Refusal, match=words):
        channel(read_external(file), file, "a")
    assert channel(read_external(file), file, 2).tolist() == [1.0, 2.0]


def test_a_quoted_name_may_contain_the_delimiter(tmp_path: Path) -> None:
    file = tmp_path / "x.csv"
    file.write_text('"Time, s", "Acc, g"\n0.5,1\n0.25,2\n')
    assert channel(read_external(file), file, "Acc, g").tolist() == [1.0, 2.0]


def test_a_wav_file_that_is_cut_off_is_refused(tmp_path: Path) -> None:
    wavfile.write(tmp_path / "x.wav", 12000, np.zeros(1000, np.float32))
    whole = (tmp_path / "x.wav").read_bytes()
    read_external(tmp_path / "x.wav")
    (tmp_path / "x.wav").write_bytes(whole[:-400])
    with pytest.raises(Refusal, match="states 4000 bytes, but 3600 follow"):
        read_external(tmp_path / "x.wav")


def riff(path: Path, kind: bytes = b"RIFF", *, rate: int = 12000, extra: bytes = b"") -> Path:
    """Write a WAV file of 100 numbers of 16 bits, with ``extra`` chunks before them."""
    samples = np.arange(100, dtype="<i2").tobytes()
    stated = 2**32 - 1 if kind == b"RF64" else len(samples)
    form = struct.pack("<4sIHHIIHH", b"fmt ", 16, 1, 1, rate, 2 * rate, 2, 16)
    body = b"WAVE" + extra + form + struct.pack("<4sI", b"data", stated) + samples
    path.write_bytes(kind + struct.pack("<I", 2**32 - 1 if kind == b"RF64" else len(body)) + body)
    return path


def test_a_wav_file_with_sizes_of_64_bits_is_read(tmp_path: Path) -> None:
    sizes = struct.pack("<4sIQQQI", b"ds64", 28, 280, 200, 100, 0)
    assert len(read_external(riff(tmp_path / "x.wav", b"RF64", extra=sizes)).column(1)) == 100


def test_chunks_of_one_name_may_have_different_sizes(tmp_path: Path) -> None:
    chunks = struct.pack("<4sI20s4sI4s", b"LIST", 20, bytes(20), b"LIST", 4, bytes(4))
    assert len(read_external(riff(tmp_path / "x.wav", extra=chunks)).column(1)) == 100


def test_chunks_without_samples_print_nothing(tmp_path: Path, recwarn: pytest.WarningsRecorder) -> None:
    assert len(read_external(riff(tmp_path / "x.wav", extra=struct.pack("<4sI4s", b"note", 3, b"abc"))).column(1)) == 100
    assert not recwarn.list


@pytest.mark.parametrize("rate", [0, 50, 20_000_000])
def test_a_rate_of_the_file_outside_the_range_is_refused(rate: int, tmp_path: Path) -> None:
    described = about(tmp_path, channels={"ax": 1}, full_scale=50.0, sampling_rate=None)
    with pytest.raises(Refusal, match=rf"x.wav states a sampling rate of {rate:g} Hz, outside 100 .. 10000000 Hz".replace("+", r"\+")):
        WaveformImport(riff(tmp_path / "x.wav", rate=rate), described)


def test_a_file_of_another_format_is_no_wav_file(tmp_path: Path) -> None:
    (tmp_path / "x.wav").write_text("hello world, this is a letter")
    with pytest.raises(Refusal, match="is not a WAV file: it begins with b'hello world,'"):
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


@pytest.mark.parametrize(("source", "step"), [("shaft_angle", 360.0 * 20.0 / 12000.0), ("rpm", 0.0)])
def test_a_speed_that_follows_from_another_unit_is_a_warning(source: str, step: float, tmp_path: Path) -> None:
    np.savez(tmp_path / "x.npz", a=np.sin(np.arange(2400)), s=20_000.0 + step * np.arange(2400))  # degrees, or mHz
    (sentence,) = implausible(WaveformImport(tmp_path / "x.npz", about(tmp_path, channels={"ax": "a", source: "s"})))
    assert sentence.startswith(f"{source} gives {7200 if step else 2094} rad/s, ")
    assert sentence.endswith("which is implausible: check its unit")


@pytest.mark.parametrize("stated", [{"speed_rpm": -1e6}, {"speed": 37700.0}])
def test_a_speed_of_half_a_turn_per_sample_is_refused(stated: dict[str, float], tmp_path: Path) -> None:
    np.savez(tmp_path / "x.npz", a=np.sin(np.arange(2400)))
    with pytest.raises(Refusal, match=r"speed.* = .* is half a turn or more per sample at 12000 Hz: correct one of them"):
        WaveformImport(tmp_path / "x.npz", about(tmp_path, **stated))
    assert WaveformImport(tmp_path / "x.npz", about(tmp_path, speed=37690.0)).shaft_source == "speed"


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
        ({"time": np.round(np.arange(2400) / 25600, 3)}, "'time' advances by 3.91"),
        ({"time": np.round((np.arange(2400) + 600.5) / 12000, 1)}, ""),  # from 0.1 to 0.2 s
        ({"time": -np.arange(2400) / 12000}, "'time' does not increase in"),
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


@pytest.mark.parametrize(
    ("time", "words"),
    [
        (np.arange(2400) / 12000 + (np.arange(2400) > 1200), "advances by 1.00008 after sample 1200, but by 8.33333e-05 elsewhere"),
        (np.mod(np.arange(2400), 1200) / 12000, "advances by -0.0999167 after sample 1199"),
        (np.round(np.arange(2400) / 12000, 3), ""),
        (np.round(np.arange(2400) / 12000, 4), ""),
        (np.round(np.arange(2400) / 12000, 5), ""),
    ],
)
def test_a_time_that_jumps_is_a_warning_unless_an_index_has_the_gaps(time: np.ndarray, words: str, tmp_path: Path) -> None:
    np.savez(tmp_path / "x.npz", a=np.sin(np.arange(2400)), time=time, i=np.arange(2400) + 12000 * (np.arange(2400) > 1200))
    warnings = implausible(WaveformImport(tmp_path / "x.npz", about(tmp_path)))
    assert [words in sentence for sentence in warnings] == [True] * bool(words)
    assert not implausible(WaveformImport(tmp_path / "x.npz", about(tmp_path, channels={"ax": "a", "index": "i"})))


@pytest.mark.parametrize("digits", [3, 9])
@pytest.mark.parametrize("jump", [1.0, -0.05])
def test_a_time_with_a_jump_is_compared_beside_it(digits: int, jump: float, tmp_path: Path) -> None:
    """A gap, or a time of day that begins again, is warned of and does not change the steps beside it."""
    time = np.round(np.arange(2400) / 12000, digits) + jump * (np.arange(2400) > 1200)
    np.savez(tmp_path / "x.npz", a=np.sin(np.arange(2400)), time=time)
    assert WaveformImport(tmp_path / "x.npz", about(tmp_path)).rate == 12000
    with pytest.raises(Refusal, match=r"'time' advances by .* or rename what is no time"):
        WaveformImport(tmp_path / "x.npz", about(tmp_path, sampling_rate=10000))


@pytest.mark.parametrize("name", [2, "t*", "T"])
def test_a_described_temperature_is_no_time(name: str | int, tmp_path: Path) -> None:
    rows = "\n".join(f"{math.sin(k)},25.3" for k in range(2400))
    (tmp_path / "x.csv").write_text(f"a,T\n{rows}\n")
    described = {"ax": 1, "box_temperature": name.upper() if isinstance(name, str) else name}
    assert WaveformImport(tmp_path / "x.csv", about(tmp_path, channels=described)).rate == 12000


@pytest.mark.parametrize("values", [np.full(2400, 25.3), np.round(25.3 + 1e-4 * np.arange(2400), 1), np.full(24, 25.3)])
def test_a_temperature_that_is_not_described_is_no_time(values: Floats, tmp_path: Path) -> None:
    np.savez(tmp_path / "x.npz", a=np.sin(np.arange(2400)), T=values)
    assert WaveformImport(tmp_path / "x.npz", about(tmp_path)).rate == 12000


def test_a_time_stamp_of_parquet_is_compared_in_seconds(tmp_path: Path) -> None:
    for rate in (12000, 25600):
        stamps = (1_795_337_999_000_000_000 + np.arange(2400) * 1_000_000_000 // rate).astype("datetime64[ns]")
        parquet.write_table(pa.table({"a": np.sin(np.arange(2400)), "time": stamps}), tmp_path / f"{rate}.parquet")
    assert WaveformImport(tmp_path / "12000.parquet", about(tmp_path)).rate == 12000
    with pytest.raises(Refusal, match=r"'time' advances by 3\.9062"):
        WaveformImport(tmp_path / "25600.parquet", about(tmp_path))


@pytest.mark.parametrize("rate", ["fs", "sr"])
def test_a_rate_in_the_structure_of_the_data_is_compared(rate: str, tmp_path: Path) -> None:
    """As in MFPT files, whose baseline has twice the rate of the others."""
    signal = np.sin(np.arange(2400))
    savemat(tmp_path / "x.mat", {"bearing": {"gs": signal, rate: 24000.0}, "other": {"gs": signal, rate: 12000.0}})
    with pytest.raises(Refusal, match=rf"gives sampling_rate = 12000 Hz, but 'bearing\.{rate}' is 24000"):
        WaveformImport(tmp_path / "x.mat", about(tmp_path, channels={"ax": "bear*.gs"}))
    assert WaveformImport(tmp_path / "x.mat", about(tmp_path, channels={"ax": "other.gs"})).rate == 12000


def test_a_measured_speed_beyond_any_bearing_is_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "x.npz", a=np.sin(np.arange(2400)), n=np.full(10, 1e300))
    with pytest.raises(Refusal, match="'n' is 1e\\+300 rpm"):
        WaveformImport(tmp_path / "x.npz", about(tmp_path, channels={"ax": "a", "rpm": "n"}))
