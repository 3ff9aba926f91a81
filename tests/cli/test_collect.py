"""`dcrb collect`: measured recordings with the schema of a sweep's data set."""

from __future__ import annotations

import hashlib
import shutil
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from data_sets import made
from pyarrow import parquet
from typer.testing import CliRunner

from dcrb_ros import DataSet, Refusal, Waveform
from dcrb_ros.cli.app import app
from dcrb_ros.exchange.run_list import decimated

ABOUT = {"channels": {"ax": "a"}, "unit": "g", "sampling_rate": 12000, "orders": {"FTF": 0.398, "BPFO": 3.585, "BPFI": 5.415, "BSF": 2.357}}
SWEEP = {
    "base": "dry",
    "set": {"cage.joint": "revolute", "sensor.sampling_rate": 51200},
    "design": "random",
    "points": 3,
    "vary": {"operating.speed": {"low": 90.0, "high": 160.0}},
    "duration": 0.02,
    "windows": {"length": 256, "kind": "parquet"},
}


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two recordings of a public set, at 12 and 48 kHz, with their list."""
    folder = tmp_path_factory.mktemp("files")
    random = np.random.default_rng(1)
    np.savez(folder / "105.npz", a=random.standard_normal(12000))
    np.savez(folder / "97.npz", a=random.standard_normal(48000))
    (folder / "about.yaml").write_text(yaml.safe_dump(ABOUT | {"source": {"title": "A public set", "licence": "none"}}), encoding="utf-8")
    (folder / "files.csv").write_text(
        "file,fault,speed_rpm,width,bearing_id,split,set\n"
        "105.npz,inner_ring,1797,0.00018,b105,train,\n"
        "97.npz,healthy,1796,,b97,,sampling_rate=48000\n",
        encoding="utf-8",
    )
    return folder


@pytest.fixture(scope="module")
def measured(files: Path) -> Path:
    """The data set of the list."""
    command = ["collect", str(files / "files.csv"), "--about", str(files / "about.yaml"), "--rate", "12000", "--window", "2048"]
    done = CliRunner().invoke(app, [*command, "-o", str(files / "set"), "--licence", "CC-BY-4.0"])
    assert done.exit_code == 0, done.output
    assert "2 recordings, 1 healthy in test, 1 inner_ring in train" in done.output
    return files / "set"


@pytest.fixture(scope="module")
def simulated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A data set of a sweep with windows in Parquet."""
    folder = tmp_path_factory.mktemp("simulated") / "set"
    made(SWEEP, folder)
    return folder


def test_labels_hold_what_the_list_says_and_null_for_the_rest(measured: Path) -> None:
    inner, healthy = parquet.read_table(measured / "labels.parquet").to_pylist()
    assert (inner["fault"], inner["split"], inner["bearing_id"], inner["width"]) == ("inner_ring", "train", "b105", 0.00018)
    assert inner["speed"] == pytest.approx(1797.0 * np.pi / 30.0, rel=1e-5)
    assert inner["bpfi"] == pytest.approx(5.415 * 1797.0 / 60.0, rel=1e-5)
    assert (healthy["split"], healthy["width"], healthy["load"], healthy["sampling_rate"]) == ("test", None, None, 12000)


def test_a_decimated_recording_has_a_quarter_of_the_samples_and_the_speed(measured: Path) -> None:
    with np.load(measured / "runs" / "97.npz") as content:
        assert content["ax"].shape == (12000,)
        assert content["ax"].std() == pytest.approx(9.80665 * np.sqrt(0.25), rel=0.05)  # of white noise a quarter of the band is left
        turned = np.unwrap(content["shaft_angle"].astype(float))
        assert turned[-1] - turned[0] == pytest.approx(1796.0 * 2.0 * np.pi / 60.0 * 11999 / 12000, rel=1e-4)


def test_a_decimated_offset_does_not_ring_at_its_ends_and_keeps_its_instants() -> None:
    constant = Waveform.from_arrays(np.full(4000, 9.81), 12000)
    waveform = decimated(replace(constant, index=constant.index + 10), 3000, "constant")
    assert np.abs(waveform.acceleration - 9.81).max() < 0.01
    assert (waveform.index[0], len(waveform)) == (3, 1000)


def test_windows_are_those_of_the_waveform(measured: Path) -> None:
    windows = parquet.read_table(measured / "windows" / "train" / "105.parquet")
    assert windows["start"].to_pylist() == [0, 2048, 4096, 6144, 8192]
    with np.load(measured / "runs" / "105.npz") as content:
        assert np.array_equal(np.concatenate(windows["ay"].to_pylist()).astype(np.float32), content["ay"][:10240])


def test_measured_and_simulated_sets_have_the_same_columns(measured: Path, simulated: Path) -> None:
    one, two = (parquet.read_schema(folder / "labels.parquet") for folder in (measured, simulated))
    assert set(two.names) - set(one.names) == {"operating.speed"}
    assert all(one.field(name).type == two.field(name).type for name in one.names)
    files = [next((folder / "windows").rglob("*.parquet")) for folder in (measured, simulated)]
    first, second = (parquet.read_schema(file) for file in files)
    assert first.names == second.names
    assert all(first.field(name).type == second.field(name).type for name in first.names if name not in ("ax", "ay"))


@pytest.mark.parametrize("kind", ["measured", "simulated"])
def test_the_head_of_the_card_and_the_description_name_files_that_exist(kind: str, request: pytest.FixtureRequest) -> None:
    folder: Path = request.getfixturevalue(kind)
    head = yaml.safe_load((folder / "README.md").read_text(encoding="utf-8").split("---\n")[1])
    assert head["license"] == "cc-by-4.0"
    assert [one["config_name"] for one in head["configs"]] == ["windows", "labels"]
    for file in (file for one in head["configs"] for file in one["data_files"]):
        assert list(folder.glob(file["path"])), file
    described = yaml.safe_load((folder / "dataset.yaml").read_text(encoding="utf-8"))
    assert described["measured"] == (kind == "measured")
    table = parquet.read_table(folder / "labels.parquet")
    assert sum(one["runs"] for one in described["splits"].values()) == len(table)
    assert set(described["labels"]["columns"]) <= set(table.schema.names)
    window = next((folder / "windows").rglob("*.parquet"))
    assert set(described["windows"]["columns"]) == set(parquet.read_schema(window).names)
    assert set(described["classes"]) == set(table["fault"].to_pylist())


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("file,faults\n105.npz,healthy\n", "lacks the columns fault: it needs file, fault; unknown is 'faults'; did you mean"),
        ("file,fault,sped\n105.npz,healthy,3\n", "unknown column 'sped'"),
        ("file,fault\n105.npz,inner\n", "fault = 'inner' is unknown"),
        ("file,fault\n106.npz,healthy\n", "line 2: there is no file"),
        ("file,fault,width\n105.npz,inner_ring,wide\n", "width = 'wide' is not a number"),
        ("file,fault,split\n105.npz,healthy,tests\n", "split = 'tests' is unknown"),
        ("file,fault\n105.npz,healthy\n105.npz,healthy\n", "two runs are called 105"),
        (
            "file,fault,name,bearing_id,split\n105.npz,healthy,a,b,test\n105.npz,healthy,b,b,train\n",
            "the bearing b is in the splits test and",
        ),
        ("file,fault\n", "the list is empty"),
        (
            "file,fault,name\n105.npz,healthy,.105\n",
            "line 2: name = '.105' is not the name of a file: give the run a name without a path or",
        ),
        ("file,fault,name\n105.npz,healthy,../../outside\n", "name = '../../outside' is not the name of a file"),
        ("file,fault,width\n105.npz,healthy,0.001\n", "line 2: width = 0.001 m, but the bearing is healthy"),
        ("file,fault,width\n105.npz,inner_ring,0.18\n", "line 2: width = 0.18 m is larger than 0.05 m: give it in metres"),
        ("file,fault,speed_rpm\n105.npz,healthy,fast\n", "line 2: "),
        ("file,fault,set\n105.npz,healthy,unit=g;unit=m/s^2\n", "line 2: unit is given more than once: give it once"),
        ("file,fault,set,speed_rpm\n105.npz,healthy,speed_rpm=10,1797\n", "line 2: speed_rpm is given more than once"),
        (f"file,fault,name\n105.npz,healthy,{'n' * 201}\n", "has more than 200 bytes, too many for the name of a file"),
    ],
)
def test_a_list_that_cannot_be_used_is_refused(files: Path, tmp_path: Path, text: str, reason: str) -> None:
    table = files / f"{tmp_path.name}.csv"
    table.write_text(text, encoding="utf-8")
    done = CliRunner().invoke(app, ["collect", str(table), "--about", str(files / "about.yaml"), "-o", str(tmp_path / "set")])
    assert isinstance(done.exception, Refusal)
    assert reason in str(done.exception)
    assert not (tmp_path / "set").exists()
    assert not list(tmp_path.rglob("outside.*"))


@pytest.mark.parametrize(
    ("row", "reason"),
    [
        ("none.npz,roller,,,,", "there is no file"),
        ("97.npz,roller,wide,,,", "width = 'wide' is not a number"),
        ("97.npz,rolls,,,,", "97: fault = 'rolls' is unknown; did you mean 'roller'?: give one of"),
        ("97.npz,roller,,tests,,", "97: split = 'tests' is unknown"),
        ("97.npz,roller,,,about,", "two runs are called about"),
        ("97.npz,roller,,,a/b,", "name = 'a/b' is not the name of a file"),
        ("97.npz,roller,,,,untis=g", "ABOUT: unknown key 'untis'; did you mean 'unit'?"),
        ("97.npz,roller,,,,unit=V", "ABOUT has the unit V and no sensitivity"),
        ("97.npz,roller,,,,speed=1;speed_rpm=1", "ABOUT gives speed and speed_rpm"),
        ("97.npz,roller,,,,orders=null", "ABOUT has neither bearing nor orders"),
    ],
)
def test_all_rows_are_checked_before_a_file_is_read(row: str, reason: str, files: Path, tmp_path: Path) -> None:
    table = files / f"{tmp_path.name}.csv"
    table.write_text(f"file,fault,width,split,name,set\nabout.yaml,healthy,,,,\n{row}\n", encoding="utf-8")
    reason = reason.replace("ABOUT", str(files / "about.yaml"))
    done = CliRunner().invoke(app, ["collect", str(table), "--about", str(files / "about.yaml"), "-o", str(tmp_path / "set")])
    assert f"line 3: {reason}" in str(done.exception)


def test_an_implausible_recording_is_named(files: Path, tmp_path: Path) -> None:
    table = files / f"{tmp_path.name}.csv"
    table.write_text("file,fault,set\n105.npz,healthy,unit=mm/s^2\n97.npz,healthy,unit=V;sensitivity=0.001 mV/g\n", encoding="utf-8")
    done = CliRunner().invoke(app, ["collect", str(table), "--about", str(files / "about.yaml"), "-o", str(tmp_path / "set")])
    assert done.exit_code == 0, done.exception
    assert done.stderr.count("warning: ") == 1
    assert done.stderr.startswith(f"warning: {table}, line 3: an acceleration of ")
    assert "m/s^2 rms is outside 0.0001 .. 2000 m/s^2: check unit" in done.stderr


@pytest.mark.parametrize(
    ("rate", "reason"),
    [
        (99, "--rate 99 is below 100 Hz, the lowest sampling rate"),
        (7000, "line 2: {}/105.npz is sampled at 12000 Hz, which is not a whole"),
    ],
)
def test_a_rate_that_cannot_be_reached_is_refused(rate: int, reason: str, files: Path, tmp_path: Path) -> None:
    command = ["collect", str(files / "files.csv"), "--about", str(files / "about.yaml"), "--rate", str(rate), "-o", str(tmp_path / "set")]
    assert reason.format(files) in str(CliRunner().invoke(app, command).exception)


def test_the_output_may_be_an_address_on_this_machine(files: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    command = ["collect", str(files / "files.csv"), "--about", str(files / "about.yaml"), "-o"]
    done = CliRunner().invoke(app, [*command, f"file://{tmp_path}/set"])
    assert done.exit_code == 0, done.exception
    assert len(DataSet(tmp_path / "set")) == 2
    assert "memory://set is not on this machine" in str(CliRunner().invoke(app, [*command, "memory://set"]).exception)
    assert [path.name for path in tmp_path.iterdir()] == ["set"]


def test_the_output_is_no_file(files: Path) -> None:
    command = ["collect", str(files / "files.csv"), "--about", str(files / "about.yaml"), "-o", str(files / "files.csv")]
    assert "is a file: give an empty or a new folder" in str(CliRunner().invoke(app, command).exception)


@pytest.mark.parametrize("source", ["speed", "rpm"])
def test_the_speed_of_a_row_replaces_that_of_the_description(files: Path, tmp_path: Path, source: str) -> None:
    """As in the example of the page: the column speed_rpm beside a description that names a channel of the speed."""
    folder = shutil.copytree(files, tmp_path / "files")
    about = {key: value for key, value in ABOUT.items() if key != "speed_rpm"}
    about |= {"speed": 10.0} if source == "speed" else {"channels": {**ABOUT["channels"], "rpm": "rpm"}}
    (folder / "about.yaml").write_text(yaml.safe_dump(about), encoding="utf-8")
    (folder / "list.csv").write_text("file,fault,speed_rpm\n105.npz,healthy,1500\n", encoding="utf-8")
    command = ["collect", str(folder / "list.csv"), "--about", str(folder / "about.yaml"), "-o", str(tmp_path / "set")]
    done = CliRunner().invoke(app, command)
    assert done.exit_code == 0, done.exception
    assert parquet.read_table(tmp_path / "set" / "labels.parquet")["speed"][0].as_py() == pytest.approx(1500.0 * np.pi / 30.0, rel=1e-5)


def test_recordings_without_a_window_are_counted(files: Path, tmp_path: Path) -> None:
    command = ["collect", str(files / "files.csv"), "--about", str(files / "about.yaml"), "--window", "20000", "-o", str(tmp_path / "set")]
    done = CliRunner().invoke(app, command)
    assert done.exit_code == 0, done.output
    assert "warning: 1 of 2 recordings have no 20000 samples without a gap, and thus no window" in done.output


def test_a_machine_in_two_splits_is_named_and_the_set_has_hashes(files: Path, measured: Path, tmp_path: Path) -> None:
    table = files / "machines.csv"
    table.write_text(
        "file,fault,bearing_id,machine,split,set\n105.npz,inner_ring,b1,m1,train,\n97.npz,healthy,b2,m1,test,sampling_rate=48000\n",
        encoding="utf-8",
    )
    done = CliRunner().invoke(app, ["collect", str(table), "--about", str(files / "about.yaml"), "-o", str(tmp_path / "set")])
    assert done.exit_code == 0, done.output
    assert "1 machine is in more than one split (machine)" in done.stderr
    assert "1 machine is in more than one split (machine)" in (tmp_path / "set" / "README.md").read_text()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        data_set = DataSet(measured)
    assert data_set.classes == ("healthy", "inner_ring")
    x, y = data_set.windows("train").arrays()
    assert (x.shape, y.tolist()) == ((5, 2, 2048), [1] * 5)


def test_an_edited_measured_set_is_named(measured: Path, tmp_path: Path) -> None:
    copied = Path(shutil.copytree(measured, tmp_path / "copied"))
    table = parquet.read_table(copied / "labels.parquet")
    parquet.write_table(table.slice(0, 1), copied / "labels.parquet")
    with pytest.raises(Refusal, match=r"labels\.parquet has been changed"):
        DataSet(copied)


@pytest.mark.parametrize(
    ("second", "reason"),
    [
        ("inner_ring,test,", "is healthy in test, not inner_ring in test: give the right file, or the same fault and split"),
        ("healthy,train,", "is healthy in test, not healthy in train"),
        ("healthy,test,", ""),
        ("inner_ring,train,channels.ax=b", ""),
    ],
)
def test_one_content_has_one_fault_and_split(second: str, reason: str, tmp_path: Path) -> None:
    signals = np.random.default_rng(1).standard_normal((2, 6000))
    for name in "xy":
        np.savez(tmp_path / f"{name}.npz", a=signals[0], b=signals[1])
    (tmp_path / "about.yaml").write_text(yaml.safe_dump(ABOUT), encoding="utf-8")
    table = tmp_path / "list.csv"
    table.write_text(f"file,fault,split,set\nx.npz,healthy,,\ny.npz,{second}\n", encoding="utf-8")
    done = CliRunner().invoke(app, ["collect", str(table), "--about", str(tmp_path / "about.yaml"), "-o", str(tmp_path / "set")])
    assert (done.exit_code == 0) is not bool(reason)
    if reason:
        assert f"{table}, line 3: {tmp_path / 'y.npz'} has the same content as {tmp_path / 'x.npz'} in line 2, which {reason}" in str(
            done.exception
        )


def test_a_file_with_another_hash_than_listed_is_refused(files: Path, tmp_path: Path) -> None:
    actual = hashlib.sha256((files / "105.npz").read_bytes()).hexdigest()
    shutil.copytree(files, tmp_path / "files")
    listed = tmp_path / "files" / "files.csv"
    arguments = ["collect", str(listed), "--about", str(files / "about.yaml"), "-o"]
    for number, given in enumerate((actual.upper(), "")):  # an empty value is none, as in the other columns
        listed.write_text(f"file,fault,speed_rpm,sha256\n105.npz,inner_ring,1797,{given}\n", encoding="utf-8")
        assert CliRunner().invoke(app, [*arguments, str(tmp_path / f"set_{number}")]).exit_code == 0
    listed.write_text(f"file,fault,speed_rpm,sha256\n105.npz,inner_ring,1797,{'0' * 64}\n", encoding="utf-8")
    refused = CliRunner().invoke(app, [*arguments, str(tmp_path / "other")])
    assert isinstance(refused.exception, Refusal)
    assert f"has the SHA-256 {actual} instead of {'0' * 64}" in str(refused.exception)


def test_a_description_in_the_list_is_a_file_beside_it(files: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = shutil.copytree(files, tmp_path / "files")
    (folder / "list.csv").write_text("file,fault,about\n105.npz,healthy,about.yaml\n", encoding="utf-8")
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "about.yaml").write_text("channels: {ax: none}\n", encoding="utf-8")
    monkeypatch.chdir(elsewhere)
    done = CliRunner().invoke(app, ["collect", str(folder / "list.csv"), "-o", str(tmp_path / "set")])
    assert done.exit_code == 0, done.output
    (folder / "list.csv").write_text("file,fault,about\n105.npz,healthy,nowhere.yaml\n", encoding="utf-8")
    done = CliRunner().invoke(app, ["collect", str(folder / "list.csv"), "-o", str(tmp_path / "other")])
    assert isinstance(done.exception, Refusal)
    assert "list.csv, line 2: there is no description" in str(done.exception)
