"""Export of recordings to files of other tools, and import of such files."""

from __future__ import annotations

import json
import os
import re
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from full_disk import files_of_at_most
from hypothesis import given, settings
from hypothesis import strategies as st
from made_up_blocks import BODIES, blocks, recorded
from scipy.io import savemat, wavfile
from separate_process import dcrb, fresh_dcrb

from dcrb_ros.exchange.description import read_description
from dcrb_ros.exchange.export import export
from dcrb_ros.exchange.files import READERS, WRITERS, channel, read_external
from dcrb_ros.exchange.importing import WaveformImport
from dcrb_ros.messages.description import decode_sensor
from dcrb_ros.messages.encoder import BlockEncoder
from dcrb_ros.messages.topics import SENSOR, VIBRATION
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration

BAGS = Path(__file__).parents[2] / "bags"
# SKF 6205-2RS JEM, the drive end of the CWRU rig: orders as its bearing data centre prints them
ORDERS = {"FTF": 0.39828, "BPFO": 3.5848, "BPFI": 5.4152, "BSF": 2.35695}
KNOWN: dict[str, Any] = {"channels": {"ax": "de"}, "sampling_rate": 12000, "unit": "g", "speed_rpm": 1797, "orders": ORDERS}


def described(folder: Path, **changes: Any) -> Path:
    about = {key: value for key, value in {**KNOWN, **changes}.items() if value is not None}
    path = folder / "about.yaml"
    path.write_text(yaml.safe_dump(about), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def noise() -> np.ndarray[Any, Any]:
    return np.random.default_rng(8).normal(0.0, 0.3, 5000)


@pytest.mark.slow
@pytest.mark.parametrize("suffix", list(WRITERS))
def test_export_and_import_round_trip(suffix: str, tmp_path: Path) -> None:
    bag = BAGS / "outer_ring_defect"
    file = tmp_path / f"wave{suffix}"
    run = fresh_dcrb if suffix == ".npz" else dcrb
    done = run("export", str(bag), "-o", str(file))
    assert done.returncode == 0, done.stderr
    again = run("import", str(file), "--about", f"{file}.yaml", "-o", str(tmp_path / "new"))
    assert again.returncode == 0, again.stderr
    old, new = Recording(bag), Recording(tmp_path / "new")
    assert [m.data for m in old.messages((VIBRATION,))] == [m.data for m in new.messages((VIBRATION,))]
    assert new.orders == old.orders
    assert new.complete
    assert new.manifest["imported"]["labels"]["faults"]["outer_1"]["width"] == 0.002
    if suffix == ".npz":
        verdict = json.loads(dcrb("detect", str(tmp_path / "new"), "--json").stdout)["verdict"]
        assert verdict == "outer_ring"
        assert "imported" in dcrb("info", str(tmp_path / "new")).stdout


@pytest.mark.parametrize("suffix", list(WRITERS))
def test_a_measurement_of_one_axis_in_an_unknown_unit_stays_one(suffix: str, noise: np.ndarray[Any, Any], tmp_path: Path) -> None:
    np.savez(tmp_path / "x.npz", de=noise)
    given = described(tmp_path, unit="relative", source={"rig": "a"}, labels={"load": 5})
    WaveformImport(tmp_path / "x.npz", given).write(tmp_path / "bag")
    old = Recording(tmp_path / "bag")
    beside = export(old, tmp_path / f"wave{suffix}")
    WaveformImport(tmp_path / f"wave{suffix}", beside).write(tmp_path / "new")
    new = Recording(tmp_path / "new")
    assert [m.data for m in old.messages((VIBRATION,))] == [m.data for m in new.messages((VIBRATION,))]
    assert new.manifest["units"] == old.manifest["units"]
    assert new.manifest["sensor"]["acceleration_unit"] == "relative"
    assert new.manifest["sensor"]["axes"]["ay"] == old.manifest["sensor"]["axes"]["ay"]
    assert new.manifest["imported"]["source"] == {"rig": "a"}
    assert new.manifest["imported"]["labels"] == {"load": 5}


@pytest.mark.parametrize("suffix", [".npz", ".csv", ".mat", ".parquet", ".wav"])
def test_gaps_are_preserved_or_refused(suffix: str, tmp_path: Path) -> None:
    bag = recorded(tmp_path / "bag", 60, split_duration=0.4)
    (bag / "bag_1.mcap").unlink()
    file = tmp_path / f"wave{suffix}"
    if suffix == ".wav":
        with pytest.raises(Refusal, match="cannot represent gaps, of which the recording has 1:"):
            export(Recording(bag), file)
        assert not file.exists()
        return
    beside = export(Recording(bag), file)
    WaveformImport(file, beside).write(tmp_path / "new")
    old, new = Recording(bag), Recording(tmp_path / "new")
    assert [m.data for m in old.messages((VIBRATION,))] == [m.data for m in new.messages((VIBRATION,))]


@pytest.mark.parametrize("suffix", list(WRITERS))
def test_an_export_in_pieces_has_all_samples_and_shows_its_stages(suffix: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    bag, shown = Recording(recorded(tmp_path / "bag", 20)), list[tuple[str, int, int]]()
    samples = bag.digests().read.count
    export(bag, tmp_path / f"whole{suffix}")
    monkeypatch.setattr("dcrb_ros.exchange.pieces.PIECE", 1000)
    export(bag, tmp_path / f"pieces{suffix}", show=lambda *stage: shown.append(stage))
    whole, pieces = (read_external(tmp_path / f"{name}{suffix}") for name in ("whole", "pieces"))
    for name in ("ax", "ay", "shaft_angle") if suffix != ".wav" else (1, 2, 3):
        first, second = (channel(external, tmp_path, name) for external in (whole, pieces))
        assert (first.dtype, first.tobytes()) == (second.dtype, second.tobytes())
    assert [stage for stage in shown if stage[0] == "reading"][-1] == ("reading", samples, samples)
    assert next(stage for stage in shown if stage[0] == "writing") == ("writing", 0, 0)
    waveform = WaveformImport(tmp_path / f"pieces{suffix}", tmp_path / f"pieces{suffix}.yaml")
    waveform.write(tmp_path / "new", lambda *stage: shown.append(stage))
    assert shown[-1] == ("writing new", samples, samples)
    assert [m.data for m in Recording(tmp_path / "new").messages((VIBRATION,))] == [m.data for m in bag.messages((VIBRATION,))]


def test_exports_carry_labels_and_manifest(tmp_path: Path) -> None:
    from pyarrow import parquet

    bag = Recording(BAGS / "inner_ring_defect")
    export(bag, tmp_path / "a.npz")
    with np.load(tmp_path / "a.npz") as file:
        about = json.loads(str(file["about"]))
        assert about["labels"]["faults"]["inner_1"]["width"] == 0.002
        assert about["manifest"]["seed"] == 1
        assert file["truth_speed"][0] == pytest.approx(125.664)
        assert file["ax"].dtype == np.float32
    export(bag, tmp_path / "b.parquet")
    assert json.loads(parquet.read_schema(tmp_path / "b.parquet").metadata[b"dcrb_ros"])["labels"]["faults"]
    flaws = {"a.npz": "a.npz exists: give another name", "a.xlsx": "must end in one of .csv", "none/a.npz": "there is no folder"}
    for name, sentence in {**{str(tmp_path / name): flaw for name, flaw in flaws.items()}, ".": "-o . has an unknown file type"}.items():
        done = dcrb("export", str(BAGS / "inner_ring_defect"), "-o", name)
        assert (done.returncode, done.stderr.count("\n")) == (2, 1)
        assert sentence in done.stderr


def test_a_table_is_exported_through_a_pipe(tmp_path: Path) -> None:
    bag = Recording(recorded(tmp_path / "bag", 3))
    os.mkfifo(tmp_path / "a.csv")
    with ThreadPoolExecutor() as readers:
        read = readers.submit((tmp_path / "a.csv").read_text)
        export(bag, tmp_path / "a.csv")
        text = read.result(timeout=60.0)
    export(bag, tmp_path / "b.csv")
    assert text == (tmp_path / "b.csv").read_text()


@pytest.mark.parametrize("suffix", [".npz", ".csv", ".mat", ".parquet"])
def test_exported_tables_have_the_time_of_each_sample(suffix: str, tmp_path: Path) -> None:
    bag = Recording(recorded(tmp_path / "bag", 30))
    export(bag, tmp_path / f"wave{suffix}")
    external = read_external(tmp_path / f"wave{suffix}")
    index = channel(external, tmp_path, "index")
    assert channel(external, tmp_path, "time") == pytest.approx(index / bag.sampling_rate, abs=1e-9)
    if suffix in (".csv", ".parquet"):
        assert external.names == ("index", "time", "ax", "ay", "shaft_angle")


def test_exports_of_one_stem_keep_their_own_descriptions(tmp_path: Path) -> None:
    first, second = (Recording(BAGS / name) for name in ("outer_ring_defect", "healthy"))
    beside = [export(first, tmp_path / "wave.wav"), export(first, tmp_path / "wave.npz"), export(second, tmp_path / "wave.mat")]
    assert [path.name for path in beside] == ["wave.wav.yaml", "wave.npz.yaml", "wave.mat.yaml"]
    assert [read_description(path).channels.ax for path in beside] == [1, "ax", "ax"]
    assert [len(read_description(path).labels["faults"]) for path in beside] == [1, 1, 0]


def test_blocks_of_slow_data_are_limited_in_duration(tmp_path: Path) -> None:
    # 1024 samples at 100 Hz last 10 s, for which the time within a block has no room.
    np.savez(tmp_path / "x.npz", de=np.sin(np.arange(3000) * 0.1))
    WaveformImport(tmp_path / "x.npz", described(tmp_path, sampling_rate=100)).write(tmp_path / "bag")
    recording = Recording(tmp_path / "bag")
    times = np.concatenate([block.stamp_ns + block.offsets_ns.astype(np.int64) for block in recording.vibrations()])
    assert np.array_equal(np.diff(times), np.full(2999, 10_000_000))
    assert recording.outcome is not None
    assert (recording.outcome["samples"], recording.outcome["end_index"]) == (3000, 3000)


def test_without_a_speed_the_angle_is_unknown(noise: np.ndarray[Any, Any], tmp_path: Path) -> None:
    np.savez(tmp_path / "x.npz", de=noise)
    found = WaveformImport(tmp_path / "x.npz", described(tmp_path, speed_rpm=None))
    assert np.isnan(found.angle).all()
    assert found.sensor()["shaft_angle"] == "unknown"


def test_a_single_axis_in_g_at_a_given_speed_is_imported(noise: np.ndarray[Any, Any], tmp_path: Path) -> None:
    """As in a CWRU file: a single variable; rate and speed are given by the description."""
    savemat(tmp_path / "97.mat", {"X097_DE_time": noise[:, None], "X097RPM": 1797.0})
    found = WaveformImport(tmp_path / "97.mat", described(tmp_path, channels={"ax": "X097_DE_time"}))
    assert found.write(tmp_path / "bag") == 5000
    recording = Recording(tmp_path / "bag")
    blocks = list(recording.vibrations())
    acceleration = np.concatenate([block.acceleration for block in blocks])
    assert np.array_equal(acceleration[:, 0], (noise * 9.80665).astype(np.float32))  # CGPM 1901
    assert np.array_equal(acceleration[:, 0], acceleration[:, 1])
    angle = np.unwrap(np.concatenate([block.shaft_angle for block in blocks]).astype(float))
    assert (angle[-1] - angle[0]) * 12000 / 4999 == pytest.approx(1797 * np.pi / 30, rel=1e-6)
    rate, orders = decode_sensor(next(recording.messages((SENSOR,))).data)
    assert (rate, orders.bpfi) == (12000, 5.4152)
    assert recording.imported
    assert "simulated" not in dcrb("info", str(tmp_path / "bag")).stdout
    assert recording.manifest["units"]["time"] == "s, index of the sample over the sampling rate"
    with pytest.raises(Refusal, match="imported data, not a run of the bench"):
        _ = recording.configuration


def test_fields_of_mat_structures_are_read(noise: np.ndarray[Any, Any], tmp_path: Path) -> None:
    """As in MFPT (bearing.gs) and Paderborn (run.Y[2].Data) files."""
    series = np.array([({"Name": "speed", "Data": np.ones(3)}), ({"Name": "vibration", "Data": noise})], dtype=object)
    savemat(tmp_path / "x.mat", {"bearing": {"gs": noise, "sr": 12000}, "run": {"Y": series}})
    external = read_external(tmp_path / "x.mat")
    for name in ("bearing.gs", "run.Y[2].Data"):
        assert np.array_equal(channel(external, tmp_path / "x.mat", name), noise)
    with pytest.raises(Refusal, match=r"'bearing\.gz'; did you mean 'bearing\.gs'.*available: bearing\.gs, bearing\.sr, run\.Y"):
        channel(external, tmp_path / "x.mat", "bearing.gz")
    with pytest.raises(Refusal, match=r"has no channel 'run\.Y\[0\]\.Data'"):  # elements count from 1
        channel(external, tmp_path / "x.mat", "run.Y[0].Data")


def test_arrays_of_objects_beside_the_channels_are_skipped(noise: np.ndarray[Any, Any], tmp_path: Path) -> None:
    np.savez(tmp_path / "x.npz", de=noise, notes=np.array([{"rig": 7}], dtype=object))
    external = read_external(tmp_path / "x.npz")
    assert np.array_equal(channel(external, tmp_path / "x.npz", "de"), noise)
    with pytest.raises(Refusal, match=r"'notes' has shape .* type object: a channel must be one row"):
        channel(external, tmp_path / "x.npz", "notes")


def test_mat_version_7_3_is_read(noise: np.ndarray[Any, Any], tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py", reason="an extra of the package")
    with h5py.File(tmp_path / "x.mat", "w", userblock_size=512) as file:
        file["run/de"], file["run/fe"] = noise[None, :], noise[None, :]
    with (tmp_path / "x.mat").open("r+b") as stream:
        stream.write(b"MATLAB 7.3 MAT-file".ljust(124) + bytes([0, 2]) + b"IM")
    found = WaveformImport(tmp_path / "x.mat", described(tmp_path, channels={"ax": "run.de"}, unit="m/s^2"))
    assert np.array_equal(found.acceleration[:, 0], noise.astype(np.float32))
    starred = WaveformImport(tmp_path / "x.mat", described(tmp_path, channels={"ax": "r*.de"}, unit="m/s^2"))
    assert np.array_equal(starred.acceleration, found.acceleration)


def test_only_numbers_are_channels_of_a_mat_version_7_3(noise: np.ndarray[Any, Any], tmp_path: Path) -> None:
    """MATLAB stores text and references to objects as integers, and the shape of an empty array in its place."""
    h5py = pytest.importorskip("h5py", reason="an extra of the package")
    words = np.frombuffer("drive end bearing of the rig".encode("utf-16-le"), np.uint16)[:, None]
    variables = {"de": (noise, "double"), "label": (words, "char"), "of": (words, "string"), "none": (np.zeros(2, np.uint64), "double")}
    with h5py.File(tmp_path / "x.mat", "w", userblock_size=512) as file:
        for name, (content, kind) in variables.items():
            file[name] = content
            file[name].attrs["MATLAB_class"] = np.bytes_(kind)
        file["none"].attrs["MATLAB_empty"] = np.uint8(1)
    with (tmp_path / "x.mat").open("r+b") as stream:
        stream.write(b"MATLAB 7.3 MAT-file".ljust(124) + bytes([0, 2]) + b"IM")
    external = read_external(tmp_path / "x.mat")
    assert np.array_equal(channel(external, tmp_path / "x.mat", "de"), noise)
    for name in ("label", "of"):
        with pytest.raises(Refusal, match=rf"has no channel '{name}' \(available: de, none\)"):
            channel(external, tmp_path / "x.mat", name)
    assert len(channel(external, tmp_path / "x.mat", "none")) == 0


def test_mat_version_7_3_without_h5py_is_refused_with_the_remedy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "h5py", None)
    (tmp_path / "x.mat").write_bytes(b"MATLAB 7.3 MAT-file".ljust(124) + bytes([0, 2]) + b"IM" + b"\x89HDF\r\n\x1a\n" + bytes(600))
    with pytest.raises(Refusal, match="pip install h5py"):
        read_external(tmp_path / "x.mat")


def test_wav_with_integer_samples_requires_full_scale(noise: np.ndarray[Any, Any], tmp_path: Path) -> None:
    path = tmp_path / "x.wav"
    wavfile.write(path, 12000, np.array([0, 16384, -32768, 8192] * 40, np.int16))
    with pytest.raises(Refusal, match="add full_scale to"):
        WaveformImport(path, described(tmp_path, channels={"ax": 1}))
    found = WaveformImport(path, described(tmp_path, channels={"ax": 1}, full_scale=50.0, unit="m/s^2", sampling_rate=None))
    assert found.rate == 12000
    assert found.acceleration[:4, 0].tolist() == [0.0, 25.0, -50.0, 12.5]
    with pytest.raises(Refusal, match=r"sampling_rate = 48000 Hz, but .*x\.wav contains 12000 Hz"):
        WaveformImport(path, described(tmp_path, channels={"ax": 1}, full_scale=50.0, sampling_rate=48000))


@pytest.mark.parametrize(
    ("header", "sentence"),
    [
        (b"RIFF\0\0\0\0WAVE{fmt}data@\x01\0\0", "its chunk b'RIFF' states 0 bytes, but "),
        (b"RIFF\x64\x01\0\0WAVE{fmt}data\0\0\0\0", "its chunk b'data' states 0 bytes, but 320 follow; copy the file again, or, if "),
        (b"RIFF\x64\x01\0\0WAVE{fmt}data\xff\xff\xff\xff", "its chunk b'data' states 4294967295 bytes, but 320 follow"),
        (b"RF64\xff\xff\xff\xffWAVEds64\x1c\0\0\0" + bytes(28) + b"{fmt}data\xff\xff\xff\xff", "its chunk b'RIFF' states 0 bytes"),
        (b"RIFF\x64\x01\0\0WAVE{fmt}LIST@\x01\0\0", "has no chunk data: copy the file again"),
        (b"RIFF\x64\x01\0\0WAVEdata@\x01\0\0", "has no chunk fmt : copy the file again"),
    ],
    ids=["no size of the file", "no size of the data", "largest size", "no size of 64 bits", "no data", "no format"],
)
def test_a_wav_file_that_was_never_finished_is_refused(header: bytes, sentence: str, tmp_path: Path) -> None:
    wavfile.write(tmp_path / "whole.wav", 12000, np.zeros(160, np.int16))
    whole = (tmp_path / "whole.wav").read_bytes()
    (tmp_path / "x.wav").write_bytes(header.replace(b"{fmt}", whole[12:36]) + whole[44:])
    with pytest.raises(Refusal, match=re.escape(sentence)):
        read_external(tmp_path / "x.wav")


@pytest.mark.parametrize("suffix", list(WRITERS))
def test_an_export_to_a_pipe_arrives_or_is_refused(suffix: str, tmp_path: Path) -> None:
    bag, pipe = Recording(recorded(tmp_path / "bag", 20)), tmp_path / f"pipe{suffix}"
    export(bag, tmp_path / f"file{suffix}")
    os.mkfifo(pipe)
    with ThreadPoolExecutor(1) as reader:
        received = reader.submit(pipe.read_bytes)
        if suffix in (".wav", ".mat"):
            with pytest.raises(Refusal, match="cannot be written: Illegal seek; write a regular file or give another file"):
                export(bag, pipe)
            return
        export(bag, pipe)
        whole = (tmp_path / f"file{suffix}").read_bytes()
        assert len(received.result(20.0)) == pytest.approx(len(whole), abs=500)


@pytest.mark.parametrize("text", ["de;fe\n1.5;2\n3;4\n", "# a rig\n1.5 2\n3 4\n", '"de","fe"\n1.5,2\n3,4\n', "1.5\t2\n3\t4\n"])
def test_csv_dialects_are_read(text: str, tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    path.write_text(text, encoding="utf-8")
    external = read_external(path)
    name: str | int = "de" if "de" in text else 1
    assert channel(external, path, name).tolist() == [1.5, 3.0]


def test_a_csv_file_that_was_cut_off_is_refused_in_words_of_the_file(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    path.write_text("de,fe\n1.5,2\n3.0", encoding="utf-8")
    with pytest.raises(Refusal, match=r"line 3: .* from 2 to 1; a file that was cut off lacks columns .* copy it again") as caught:
        read_external(path)
    assert "usecols" not in str(caught.value)


def test_a_csv_file_that_was_cut_off_inside_its_last_number_is_refused(tmp_path: Path) -> None:
    path, whole = tmp_path / "x.csv", "de\n" + "".join(f"{-(0.5 ** (k % 5)):.6f}\n" for k in range(150))
    for text in (whole, whole[:-1], f"{whole}0.5\n", whole[:-20]):
        path.write_text(text, encoding="utf-8")
        assert len(channel(read_external(path), path, "de")) >= 147
    for missing in range(2, 9):
        path.write_text(whole[:-missing], encoding="utf-8")
        with pytest.raises(Refusal, match=r"may be cut off: it ends with .* fewer decimals .* copy it again, or end or delete"):
            read_external(path)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"sampling_rate": None}, "has no sampling_rate, and .* it is never guessed"),
        ({"unit": None}, "has no unit: add unit, one of"),
        ({"unit": "volt"}, "unit = 'volt' is refused"),
        ({"speed": 188.0}, "gives speed and speed_rpm: give one of them, or neither"),
        ({"channels": {"ax": "de", "rpm": "de"}}, "gives rpm and speed_rpm: give one of them"),
        ({"pulses_per_turn": 2}, "gives pulses_per_turn, but no channel tacho"),
        ({"unit": "mV"}, "has the unit mV and no sensitivity: give one such as 100 mV/g"),
        ({"unit": "V", "sensitivity": "100 mV"}, "sensitivity = '100 mV': give one such as"),
        ({"unit": "mV", "sensitivity": "1.0.2 mV/g"}, "sensitivity = '1.0.2 mV/g': give one such as"),
        ({"sensitivity": "100 mV/g"}, "gives a sensitivity, but unit = g"),
        ({"gap": 1.0}, "gives gap = 1 s, but there is one file"),
        ({"channels": {"ax": "x*"}}, r"has no channel like 'x\*', but one is needed \(available: de\)"),
        ({"orders": {**ORDERS, "BPFO": ORDERS["BPFI"], "BPFI": ORDERS["BPFO"]}}, "they may be swapped"),
        ({"orders": {**ORDERS, "FTF": 11.9, "BPFO": 107.4, "BPFI": 162.2}}, "these may be frequencies in Hz"),
        ({"orders": {**ORDERS, "FTF": 0.35}}, r"BPFO = 3.5848 is not 9 FTF = 3.15"),
        ({"orders": {**ORDERS, "BPFI": 4.9}}, "is not the number of rolling elements"),
        ({"orders": {**ORDERS, "BSF": 2.0 * ORDERS["BSF"]}}, "may be the ball defect frequency, so halve it"),
        ({"orders": None}, "has neither bearing nor orders"),
        ({"orders": {**ORDERS, "BPFo": 3.6}}, r"unknown key 'orders\.BPFo'; did you mean 'BPFO'\?"),
        ({"channels": {"ax": "de", "shaft-angle": "fe"}}, r"unknown key 'channels\.shaft-angle'; did you mean 'shaft_angle'\?"),
        ({"channels": {"ax": True}}, r"channels\.ax = True is refused: a channel is a name, or a number from 1"),
        ({"channels": {"ax": 0}}, r"channels\.ax = 0 is refused: a channel is a name, or a number from 1"),
        ({"orders": {"FTF": 0.4}}, r"orders\.BPFO is refused: field required"),
        ({"sampling_rate": 1000.4}, "sampling_rate = 1000.4 Hz is refused: a recording has an integer rate"),
        ({"sampling_rate": "fast"}, "sampling_rate = 'fast' is refused"),
        ({"sampling_rate": 0}, "sampling_rate = 0 is refused"),
        ({"channels": None}, "channels is refused: field required"),
        ({"channels": {"ax": "fe"}}, r"has no channel 'fe'; did you mean 'de'\?|has no channel 'fe'"),
        ({"first_index": 10**15}, r"first_index = 10{15} gives sample 1e\+15, after 2147483648 s at 12000 Hz"),
        ({"first_index": 10**30}, r"first_index = 10{30} gives sample 1e\+30"),
        ({"labels": {"x": float("nan")}}, "nan is not a finite number: write null"),
        ({"speeed": 3.0}, r"unknown key 'speeed'; did you mean 'speed'\?"),
        (
            {"orders": None, "bearing": {"rollers_per_row": 9, "roller_radius": 0.02, "pitch_radius": 0.0195}},
            "must be below pitch_radius",
        ),
        ({"bearing": {"balls": 9, "diameter": 0.00794, "pitch_diameter": 0.03904}}, "has both bearing and orders"),
        (
            {"orders": None, "bearing": {"balls": 9, "diameter": 7.94, "pitch_diameter": 39.04}},
            "39.04 m is too large: lengths are in metres",
        ),
        ({"orders": None, "bearing": {"balls": 9, "rollers": 9}}, "number of the balls or rollers gives balls and rollers: give one"),
        ({"orders": None, "bearing": {"balls": 9, "diameter": 0.00794}}, "pitch circle of the balls or rollers is missing"),
        (
            {"orders": None, "bearing": {"balls": 16, "diameter": 0.00794, "pitch_diameter": 0.03904}},
            "do not fit on 39.04 mm: at most 15 do",
        ),
    ],
)
def test_missing_information_is_refused(changes: dict[str, Any], sentence: str, noise: np.ndarray[Any, Any], tmp_path: Path) -> None:
    np.savez(tmp_path / "x.npz", de=noise)
    with pytest.raises(Refusal, match=sentence):
        WaveformImport(tmp_path / "x.npz", described(tmp_path, **changes))


@pytest.mark.parametrize(
    ("arrays", "sentence"),
    [
        ({"de": np.array([1.0, np.nan, 2.0])}, "1 of 3 samples of 'de' are not finite"),
        ({"de": np.zeros((3, 4))}, "a channel must be one row of numbers"),
        ({"de": np.array(["a", "b"])}, "a channel must be one row of numbers"),
        ({"de": np.zeros(0)}, "not be empty"),
        ({"de": np.array([1.0, 1e300])}, r"sample 1 of 'de' is 1e\+300, above 3e\+38 m/s\^2, the range of a message"),
    ],
)
def test_unusable_channels_are_refused(arrays: dict[str, Any], sentence: str, tmp_path: Path) -> None:
    np.savez(tmp_path / "x.npz", **arrays)
    with pytest.raises(Refusal, match=sentence):
        WaveformImport(tmp_path / "x.npz", described(tmp_path))


@pytest.mark.parametrize(
    ("index", "sentence"),
    [
        (np.arange(3) * 1.7, "'i' is not an index: 1.7 is not an integer"),
        (np.array([0.0, 1.0, 1e300]), r"'i' gives sample 1e\+300, after 2147483648 s"),
        (np.array([0, 2, 1]), "must start at 0 or later and increase"),
        (np.array([-1, 0, 1]), "must start at 0 or later and increase"),
    ],
)
def test_an_invalid_index_is_refused(index: np.ndarray[Any, Any], sentence: str, tmp_path: Path) -> None:
    np.savez(tmp_path / "x.npz", de=np.ones(3), i=index)
    with pytest.raises(Refusal, match=sentence):
        WaveformImport(tmp_path / "x.npz", described(tmp_path, channels={"ax": "de", "index": "i"}))


def test_a_first_index_beside_another_index_is_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "x.npz", de=np.ones(3), i=np.arange(5, 8))
    with pytest.raises(Refusal, match="gives first_index = 7, but 'i' begins with 5: leave out first_index"):
        WaveformImport(tmp_path / "x.npz", described(tmp_path, channels={"ax": "de", "index": "i"}, first_index=7))
    about = described(tmp_path, channels={"ax": "de", "index": "i"}, first_index=5)
    assert WaveformImport(tmp_path / "x.npz", about).index.tolist() == [5, 6, 7]


def test_descriptions_accept_the_same_yaml_as_configurations(tmp_path: Path) -> None:
    path = tmp_path / "about.yaml"
    text = "{channels: {ax: de}, speed: 1e2, sampling_rate: 5.12e4, labels: {2026-01-02: ok, 3: {when: 2026-01-03}}}"
    path.write_text(text, encoding="utf-8")
    found = read_description(path)
    assert (found.sampling_rate, found.speed) == (51200, 100.0)
    assert json.dumps(found.labels) == '{"2026-01-02": "ok", "3": {"when": "2026-01-03"}}'
    path.write_text("channels: {ax: de}\nsampling_rate: 12000\nsampling_rate: 25600\n", encoding="utf-8")
    with pytest.raises(Refusal, match="the key 'sampling_rate' occurs twice"):
        read_description(path)


def test_a_failed_import_or_export_leaves_no_files(noise: np.ndarray[Any, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    np.savez(tmp_path / "x.npz", de=noise)
    whole = WaveformImport(tmp_path / "x.npz", described(tmp_path))
    monkeypatch.setattr(WaveformImport, "blocks", stopped)
    with pytest.raises(KeyboardInterrupt):
        whole.write(tmp_path / "bag")
    monkeypatch.undo()
    whole.write(tmp_path / "bag")
    recording = Recording(tmp_path / "bag")
    before = set(tmp_path.iterdir())
    for suffix in WRITERS:
        with files_of_at_most(1000), pytest.raises(Refusal, match=rf"out{suffix} cannot be written: .*; free some space"):
            export(recording, tmp_path / f"out{suffix}")
        assert set(tmp_path.iterdir()) == before
    export(recording, tmp_path / "out.csv")


def stopped(_: WaveformImport) -> Any:
    raise KeyboardInterrupt


def test_orders_follow_from_the_geometry(noise: np.ndarray[Any, Any], tmp_path: Path) -> None:
    np.savez(tmp_path / "x.npz", de=noise)
    # 6205: 9 balls of 7.94 mm on 39.04 mm, CWRU's bearing data; the orders are those printed there
    geometry = {"rollers_per_row": 9, "roller_radius": 0.00397, "pitch_radius": 0.01952}
    orders = WaveformImport(tmp_path / "x.npz", described(tmp_path, orders=None, bearing=geometry)).orders
    assert (orders.ftf, orders.bpfo, orders.bpfi) == pytest.approx((0.39828, 3.5848, 5.4152), rel=1e-3)


@given(st.sampled_from(list(READERS)), st.binary(max_size=200))
@settings(max_examples=150)
def test_any_file_is_read_or_refused(tmp_path_factory: pytest.TempPathFactory, suffix: str, content: bytes) -> None:
    path = tmp_path_factory.mktemp("external") / f"x{suffix}"
    path.write_bytes(content)
    try:
        read_external(path)
    except Refusal as refusal:
        assert "\n" not in str(refusal)  # noqa: PT017 - a refusal is one of the two right answers


@given(st.text(max_size=60))
def test_any_description_is_read_or_refused(tmp_path_factory: pytest.TempPathFactory, text: str) -> None:
    path = tmp_path_factory.mktemp("about") / "x.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(Refusal):
        read_description(path)


@pytest.mark.parametrize("suffix", [".npz", ".mat", ".parquet", ".h5.mat"])
def test_a_small_file_with_large_channels_is_refused(suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import pyarrow
    from pyarrow import parquet

    path, zeros = tmp_path / f"x{suffix}", np.zeros(100_000)
    if suffix == ".npz":
        np.savez_compressed(path, de=zeros)
    elif suffix == ".mat":
        savemat(path, {"de": zeros}, do_compression=True)
    elif suffix == ".parquet":
        parquet.write_table(pyarrow.table({"de": zeros}), path)
    else:
        with pytest.importorskip("h5py").File(path, "w", userblock_size=512) as file:
            file.create_dataset("de", data=zeros, compression="gzip")
        with path.open("r+b") as stream:
            stream.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")
    monkeypatch.setattr("dcrb_ros.exchange.files.MOST_RATIO", 1)
    assert len(channel(read_external(path), path, "de")) == 100_000
    monkeypatch.setattr("dcrb_ros.exchange.files.LEAST_LOADED", 700_000)
    with pytest.raises(Refusal, match=r"has \d+ bytes, but its channels have 80\d+; at most 700000 are loaded"):
        read_external(path)


def test_a_line_without_end_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    path.write_text("a" * 100_000)
    with pytest.raises(Refusal, match="has a line of 100000 characters or more"):
        read_external(path)


@pytest.mark.parametrize("suffix", list(WRITERS))
def test_doubled_and_disordered_blocks_are_exported_once_and_in_order(suffix: str, tmp_path: Path) -> None:
    encoder, made = BlockEncoder(Configuration(), BODIES), list(blocks(5))
    ordered, disordered = tmp_path / "ordered", tmp_path / "disordered"
    for path, numbers in ((ordered, (0, 1, 2, 3, 4)), (disordered, (0, 1, 1, 3, 2, 4))):
        with Recorder(path, Configuration(), BODIES) as recorder:
            for number in numbers:
                recorder.write_messages([message for message in encoder.encode(made[number]) if message.topic == VIBRATION])
        notes: list[str] = []
        export(Recording(path), tmp_path / f"{path.name}{suffix}", notes=notes)
        assert notes == (
            ["samples came twice or too late, 1024 of them twice: each is written once, in its place"] if path == disordered else []
        )
    first, second = (
        WaveformImport(tmp_path / f"{path.name}{suffix}", tmp_path / f"{path.name}{suffix}.yaml") for path in (ordered, disordered)
    )
    assert np.array_equal(first.index, second.index)
    assert np.array_equal(first.acceleration, second.acceleration)
