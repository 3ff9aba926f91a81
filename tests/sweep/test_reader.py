"""`dcrb_ros.DataSet`: arrays, classes and labels of a data set, each file checked; and data sets that are extended."""

from __future__ import annotations

import contextlib
import hashlib
import json
import pickle
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml
from attacked_files import ATTACKS, flip
from data_sets import made
from folder_contents import contents
from typer.testing import CliRunner

from dcrb_ros import DataSet, Refusal
from dcrb_ros.cli.app import app
from dcrb_ros.sweep.extension import _with_history
from dcrb_ros.sweep.kinds import plan_of
from dcrb_ros.sweep.loader import read_sweep, sweep_of
from dcrb_ros.sweep.sums import SUMS

TREE: dict[str, Any] = {
    "base": "dry",
    "set": {"cage.joint": "revolute"},
    "design": "latin_hypercube",
    "points": 4,
    "vary": {"operating.speed": {"low": 90.0, "high": 160.0}},
    "cases": {"healthy": {}, "outer": {"faults.outer_1.width": {"low": 0.001, "high": 0.002}}},
    "duration": 0.02,
    "windows": {"length": 256, "overlap": 0.5},
}


def read(folder: Path) -> DataSet:
    """Read a data set whose bearing is in all splits."""
    with pytest.warns(UserWarning, match="in more than one split"):
        return DataSet(folder)


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Ignore warnings."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A data set with windows."""
    folder = tmp_path_factory.mktemp("sets") / "set"
    made(TREE, folder)
    return folder


@pytest.fixture
def copied(folder: Path, tmp_path: Path) -> Path:
    """A copy of it that a test may change."""
    import shutil

    return Path(shutil.copytree(folder, tmp_path / "copied"))


def test_windows_are_arrays_with_the_classes_of_the_set(folder: Path) -> None:
    data_set = read(folder)
    assert data_set.classes == ("healthy", "outer_ring")
    assert data_set.splits == {"train": 4, "validation": 2, "test": 2}
    windows = data_set.windows("train")
    x, y = windows.arrays()
    assert x.shape == (4 * 7, 2, 256)
    assert sorted(y.tolist()) == [0] * 14 + [1] * 14
    table = data_set.labels("train")
    with np.load(folder / table["file"][0]) as content:
        assert np.array_equal(x[1, 1], content["ay"][128:384])
    assert y[0] == data_set.classes.index(table["fault"][0])
    assert all(np.array_equal(x[k], window) and y[k] == number for k, (window, number) in enumerate(windows))
    assert np.array_equal(windows[-1][0], x[-1])
    with pytest.raises(IndexError):
        windows[len(windows)]
    assert np.array_equal(pickle.loads(pickle.dumps(windows))[3][0], x[3])


def test_windows_of_another_length_are_those_of_the_waveform(folder: Path) -> None:
    data_set = read(folder)
    windows = data_set.windows("test", length=500, hop=100)
    assert len(data_set.windows("test", length=np.int64(500), hop=np.int32(100))) == len(windows)  # type: ignore[arg-type]
    waveform = data_set.waveform(data_set.labels("test")["run"][0])
    assert len(windows) == 2 * 6
    assert np.array_equal(windows[2][0], waveform.acceleration[200:700].T)
    assert waveform.orders.bpfo == pytest.approx(6.78, abs=0.3)


def test_with_a_hop_alone_windows_keep_the_length_of_those_of_the_set(folder: Path, copied: Path) -> None:
    assert read(folder).windows("test", hop=64).arrays()[0].shape == (2 * 13, 2, 256)
    edited_table(copied, "windows", None)
    (copied / SUMS).unlink()
    with quiet():
        assert len(DataSet(copied).windows("test", hop=64)) == 0  # 4096 samples, longer than a run


@pytest.mark.parametrize("kind", ["npz", "parquet"])
def test_a_measured_set_and_parquet_load_alike(kind: str, folder: Path, tmp_path: Path) -> None:
    made({**TREE, "output": kind, "windows": {"length": 256, "overlap": 0.5, "kind": kind}}, tmp_path / "set")
    for split in ("train", "test"):
        x, y = read(tmp_path / "set").windows(split).arrays()
        known = read(folder).windows(split).arrays()
        assert np.array_equal(x, known[0])
        assert np.array_equal(y, known[1])


def test_a_fault_that_ends_before_its_run_is_a_class(tmp_path: Path) -> None:
    (tmp_path / "plug.yaml").write_text(
        "timeline: [{at: 0.005, set: {sensor.fault: stuck}}, {at: 0.012, set: {sensor.fault: none}}]", encoding="utf-8"
    )
    made({**TREE, "cases": {"healthy": {}, "plug": {"scenario": str(tmp_path / "plug.yaml")}}}, tmp_path / "set")
    data_set = read(tmp_path / "set")
    assert set(data_set.labels()["fault"]) == {"healthy"}
    assert data_set.classes == ("healthy", "sensor")
    assert set(data_set.windows("train").arrays()[1].tolist()) == {0, 1}
    assert yaml.safe_load((tmp_path / "set" / "dataset.yaml").read_text())["classes"] == ["healthy", "sensor"]
    assert "| split | conditions | healthy | sensor | runs |" in (tmp_path / "set" / "README.md").read_text()


def test_the_classes_are_those_of_the_set(copied: Path) -> None:
    # The loader of the examples had a list of its own and failed on a class that the list did not have.
    (copied / SUMS).unlink()
    table = pd.read_parquet(copied / "labels.parquet").drop(columns="window_faults")  # as of an earlier version
    table.loc[table["fault"] == "healthy", "fault"] = "lubrication"
    table.to_parquet(copied / "labels.parquet")
    with quiet():
        data_set = DataSet(copied)
    assert data_set.classes == ("lubrication", "outer_ring")
    assert set(data_set.windows("train", length=512).arrays()[1].tolist()) == {0, 1}


def test_tensors_are_those_of_the_arrays(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # The names of PyTorch that are used; the environment of the tests has no PyTorch.
    data, torch = ModuleType("torch.utils.data"), ModuleType("torch")
    data.TensorDataset = lambda *tensors: SimpleNamespace(tensors=tensors)  # type: ignore[attr-defined]
    torch.from_numpy = lambda array: array  # type: ignore[attr-defined]
    for name, module in {"torch": torch, "torch.utils": ModuleType("torch.utils"), "torch.utils.data": data}.items():
        monkeypatch.setitem(sys.modules, name, module)
    x, y = read(folder).windows("train").torch().tensors
    assert (x.shape, y.dtype) == ((28, 2, 256), np.int64)
    monkeypatch.setitem(sys.modules, "torch", None)
    with pytest.raises(Refusal, match="pip install torch"):
        read(folder).windows("train").torch()


def test_tensors_feed_a_loader_of_pytorch(folder: Path) -> None:
    torch = pytest.importorskip("torch", reason="PyTorch is not installed: pip install torch")
    windows = read(folder).windows("train")
    x, y = windows.arrays()
    tensors = windows.torch().tensors
    assert [tensor.dtype for tensor in tensors] == [torch.float32, torch.int64]
    for source in (windows.torch(), windows):  # all in memory, and read one by one
        batches = list(torch.utils.data.DataLoader(source, batch_size=8))
        assert np.array_equal(torch.cat([batch for batch, _ in batches]).numpy(), x)
        assert np.array_equal(torch.cat([classes for _, classes in batches]).numpy(), y)


def test_a_set_without_leakage_is_read_without_a_warning(tmp_path: Path) -> None:
    vary = {"surfaces.seed": {"low": 1, "high": 1000}, "structure.seed": {"low": 1, "high": 1000}}
    made({**TREE, "base": "healthy", "set": {}, "points": 3, "vary": vary}, tmp_path / "set")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert DataSet(tmp_path / "set").splits == {"train": 2, "validation": 2, "test": 2}


def edited_table(folder: Path, column: str, value: Any) -> None:
    table = pd.read_parquet(folder / "labels.parquet")
    table[column] = value
    table.to_parquet(folder / "labels.parquet")


DAMAGE: dict[str, tuple[Callable[[Path], object], str]] = {
    "an edited fault": (lambda folder: edited_table(folder, "fault", "healthy"), "labels.parquet has been changed"),
    "a flipped bit in the windows": (
        lambda folder: flip(next(folder.glob("windows/train/*"))),
        "has been changed: its SHA-256 is not the one",
    ),
    "missing windows": (lambda folder: [path.unlink() for path in folder.glob("windows/train/*")], "is missing"),
    "damaged hashes": (lambda folder: (folder / SUMS).write_text("none"), f"{SUMS} is damaged"),
    "no table": (lambda folder: (folder / "labels.parquet").unlink(), "has no labels.parquet"),
}


@pytest.mark.parametrize("kind", DAMAGE)
def test_a_changed_file_is_named(kind: str, copied: Path) -> None:
    damage, sentence = DAMAGE[kind]
    damage(copied)
    with quiet(), pytest.raises(Refusal, match=sentence):
        DataSet(copied).windows("train").arrays()


def test_an_old_set_without_hashes_is_read_with_a_warning(copied: Path) -> None:
    (copied / SUMS).unlink()
    with pytest.warns(UserWarning, match="has no SHA256SUMS|in more than one split") as warned:
        assert len(DataSet(copied)) == 8
    assert "has no SHA256SUMS" in str(warned[0].message)


@pytest.fixture
def lives(copied: Path) -> Path:
    """A data set with a table of lives, which only a sweep of kind life has, and its hash."""
    table = pd.DataFrame({"bearing_id": ["a", "b"], "failure": [900.0, 2500.0], "censored": [False, True]})
    table.to_parquet(copied / "lives.parquet")
    with (copied / SUMS).open("a") as sums:
        sums.write(f"{hashlib.sha256((copied / 'lives.parquet').read_bytes()).hexdigest()}  lives.parquet\n")
    return copied


@pytest.mark.parametrize("attack", ATTACKS)
@pytest.mark.timeout(60)  # a pipe would be waited for
def test_a_changed_table_of_lives_is_refused(attack: str, lives: Path) -> None:
    with quiet():
        data_set = DataSet(lives)
        assert data_set.lives()["failure"].tolist() == [900.0, 2500.0]
        ATTACKS[attack](lives / "lives.parquet")
        with pytest.raises(Refusal, match=r"lives\.parquet"):
            DataSet(lives).lives()


def test_other_lives_are_refused_and_named_even_without_hashes(lives: Path) -> None:
    table = pd.read_parquet(lives / "lives.parquet")
    table.assign(failure=table["failure"] * 10.0).to_parquet(lives / "lives.parquet")
    with quiet(), pytest.raises(Refusal, match=r"lives\.parquet has been changed: its SHA-256 is not the one in SHA256SUMS"):
        DataSet(lives).lives()
    (lives / SUMS).unlink()
    with pytest.warns(UserWarning, match="changes of its labels are not found|in more than one split"):
        DataSet(lives).lives()
    (lives / "lives.parquet").write_bytes(b"PAR1")
    with quiet(), pytest.raises(Refusal, match=r"lives\.parquet is damaged"):
        DataSet(lives).lives()


@pytest.mark.parametrize(
    ("column", "value", "sentence"),
    [
        ("files", "{", "the files of the run .* are no records"),
        ("files", "[]", "the files of the run .* are no records"),
        ("file", "../../etc/passwd", "outside the data set"),
        ("samples", 51_200_000_000_000, "samples instead of"),
        ("split", "exam", "no valid split"),
        ("samples", 0, "no valid split"),
    ],
)
def test_a_row_of_an_old_set_that_cannot_be_true_is_refused(column: str, value: Any, sentence: str, copied: Path) -> None:
    (copied / SUMS).unlink()
    edited_table(copied, column, value)
    run = str(pd.read_parquet(copied / "labels.parquet")["run"][0])
    with quiet(), pytest.raises(Refusal, match=sentence):
        DataSet(copied).waveform(run)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda data_set: data_set.windows("trian"), "did you mean 'train'"),
        (lambda data_set: data_set.windows("train", length=0), "length = 0 is not a number of samples"),
        (lambda data_set: data_set.windows("train", length=10**400), "0 is not a number of samples: give a whole number within 1"),
        (lambda data_set: data_set.windows("train", hop=True), "hop = True is not a number of samples"),
        (lambda data_set: data_set.windows("train", length=100, hop=200), "hop = 200 samples is above length"),
        (lambda data_set: data_set.waveform("nothing"), "has no run 'nothing'"),
        (lambda data_set: data_set.lives(), "has no lives.parquet"),
        (
            lambda data_set: data_set.windows("train", length=5000).arrays(),
            "the windows of 5000 samples are longer than every run of this split in .*: give a",
        ),
    ],
)
def test_unknown_names_and_impossible_windows_are_refused(call: Callable[[DataSet], object], sentence: str, folder: Path) -> None:
    with pytest.raises(Refusal, match=sentence):
        call(read(folder))
    with pytest.raises(Refusal, match="is not a finished data set"):
        DataSet(folder / "nowhere")


# Extension


@pytest.mark.slow
@pytest.mark.parametrize("design", ["latin_hypercube", "random"])
def test_more_points_add_runs_and_keep_the_others(design: str, tmp_path: Path) -> None:
    first = made({**TREE, "design": design, "seeds": 2}, tmp_path / "set")
    before = contents(tmp_path / "set")
    splits = read(tmp_path / "set").labels().set_index("run")["split"]
    added = made({**TREE, "design": design, "seeds": 2, "points": 7}, tmp_path / "set")
    assert (len(first), len(added)) == (16, 12)
    after, table = contents(tmp_path / "set"), read(tmp_path / "set").labels().set_index("run")
    assert all(after[name] == value for name, value in before.items() if name.split("/")[0] in ("runs", "labels", "windows"))
    assert table.loc[splits.index, "split"].equals(splits)
    assert set(table["split"][added]) == {"train", "validation", "test"}
    assert table["condition"].nunique() == 7
    # Once more: the same command makes nothing, and the kept sweep file makes the same data set at once.
    assert made({**TREE, "design": design, "seeds": 2, "points": 7}, tmp_path / "set") == []
    assert contents(tmp_path / "set") == after
    kept = read_sweep(tmp_path / "set" / "sweep.yaml")
    assert len(made(plan_of(kept), tmp_path / "again")) == 28
    assert contents(tmp_path / "again") == after


GRID: dict[str, Any] = {key: value for key, value in TREE.items() if key not in ("points", "design", "vary")} | {
    "cases": {"healthy": {}, "outer": {"faults.outer_1.width": [0.001]}}
}


def grid(*speeds: float, loads: Sequence[float] = (-1e5,), **changed: Any) -> dict[str, Any]:
    return {**GRID, "vary": {"operating.speed": list(speeds), "operating.load": list(loads)}, **changed}


def test_more_values_of_a_grid_add_runs_and_keep_the_others(tmp_path: Path) -> None:
    first = made(grid(100.0, 110.0, 120.0), tmp_path / "set")
    before, splits = contents(tmp_path / "set"), read(tmp_path / "set").labels().set_index("run")["split"]
    added = made(grid(100.0, 110.0, 120.0, 130.0, loads=(-1e5, -8e4)), tmp_path / "set")
    assert (len(first), len(added)) == (6, 10)
    after, table = contents(tmp_path / "set"), read(tmp_path / "set").labels().set_index("run")
    assert all(after[name] == value for name, value in before.items() if name.split("/")[0] in ("runs", "labels", "windows"))
    assert table.loc[splits.index, "split"].equals(splits)
    assert table["place"].tolist() == list(range(16))
    # A third time with a history of two, then the kept sweep file at once.
    more = made(grid(100.0, 110.0, 120.0, 130.0, 140.0, loads=(-1e5, -8e4)), tmp_path / "set")
    assert len(more) == 4
    kept = read_sweep(tmp_path / "set" / "sweep.yaml")
    assert kept.file.extended == [{"operating.speed": 3, "operating.load": 1}, {"operating.speed": 4, "operating.load": 2}]
    assert len(made(plan_of(kept), tmp_path / "again")) == 20
    assert contents(tmp_path / "again") == contents(tmp_path / "set")
    read(tmp_path / "again")


@pytest.mark.parametrize(
    "other",
    [
        grid(90.0, 100.0, 110.0),
        grid(100.0),
        grid(110.0, 100.0, 120.0),
        grid(100.0, 110.0, 120.0, seeds=2),
        {**grid(100.0, 110.0), "vary": {"operating.speed": [100.0, 110.0]}},
        {**grid(100.0, 110.0), "vary": {"operating.speed": {"low": 100.0, "high": 110.0, "count": 3}, "operating.load": [-1e5]}},
        grid(100.0, 110.0, 120.0, extended=[{"operating.speed": 1, "operating.load": 1}]),
    ],
)
def test_a_grid_without_the_earlier_values_at_their_places_is_another_one(other: dict[str, Any], tmp_path: Path) -> None:
    made(grid(100.0, 110.0), tmp_path / "set")
    before = contents(tmp_path / "set")
    with pytest.raises(Refusal, match="was made with another sweep"):
        made(other, tmp_path / "set")
    assert contents(tmp_path / "set") == before


def test_a_range_of_a_grid_keeps_its_count_while_another_axis_grows(tmp_path: Path) -> None:
    span = {"low": 100.0, "high": 120.0, "count": 3}
    made({**GRID, "vary": {"operating.speed": span, "operating.load": [-1e5]}}, tmp_path)
    assert len(made({**GRID, "vary": {"operating.speed": span, "operating.load": [-1e5, -8e4]}}, tmp_path)) == 6


@pytest.mark.parametrize(
    "history",
    [[2], [{}], [{"operating.speed": 2}], [{"operating.speed": 2, "operating.load": 1}], [{"operating.speed": 0, "operating.load": 1}]],
)
def test_a_history_of_a_grid_that_does_not_rise_is_refused(history: list[Any]) -> None:
    with pytest.raises(Refusal, match="extended = "):
        plan_of(sweep_of(grid(100.0, 110.0, extended=history), "sweep.yaml"))


def test_a_set_is_extended_by_the_command_and_never_shrinks(tmp_path: Path) -> None:
    def sweep(points: int) -> Any:
        file.write_text(yaml.safe_dump({**TREE, "points": points}), encoding="utf-8")
        return CliRunner().invoke(app, ["sweep", str(file), "-o", str(tmp_path / "set"), "--workers", "1"])

    file = tmp_path / "sweep.yaml"
    assert sweep(2).exit_code == 0
    done = sweep(3)
    assert "is extended: its 4 finished runs and their splits are kept" in done.stderr
    assert "6 done" in done.stdout
    assert json.loads((tmp_path / "set" / "sweep.json").read_text())["sweep"]["extended"] == [2]
    done = sweep(2)
    assert isinstance(done.exception, Refusal)
    assert "was made with another sweep (extended, points differ)" in str(done.exception)


def test_more_lives_keep_the_splits_of_the_others() -> None:
    from dcrb_ros.sweep.extension import extended_plan

    tree: dict[str, Any] = yaml.safe_load((Path(__file__).parents[2] / "config" / "sweeps" / "ten_lives.yaml").read_text())
    plan = plan_of(sweep_of(tree, "lives"))
    more = extended_plan(plan_of(sweep_of({**tree, "lives": 15}, "lives", text="lives: 15\n")), {"sweep": plan.sweep.inputs})
    old, new = ({run.name: (run.position, run.split) for run in one.runs()} for one in (plan, more))
    assert {name: new[name] for name in old} == old
    assert len({run.condition for run in more.runs()}) == 15
    assert more.sweep.text == "lives: 15\nextended: [10]\n"
    again = plan_of(sweep_of({**tree, "lives": 15, "extended": [10]}, "lives"))
    assert {run.name: (run.position, run.split) for run in again.runs()} == new


@pytest.mark.parametrize(
    "text",
    [
        "{base: dry, points: 8}",
        "points: 8\n...\n",  # the end of the document
        "points: 8\nlicence: |\n  mine\n  extended: 3\n...\n",
    ],
)
def test_a_text_to_which_no_line_can_be_added_is_not_extended(text: str) -> None:
    with pytest.raises(Refusal, match="the sweep file cannot be extended as it is written: write one key per line without braces"):
        _with_history(text, [2, 4])


@pytest.mark.parametrize("history", ["[2]\n", "\n- 2\n", "[2,\n  3]\n", "\n  - operating.speed: 2\n    operating.load: 1\n"])
def test_a_text_is_extended_however_its_history_is_written(history: str) -> None:
    assert _with_history(f"extended: {history}points: 8  # eight\n", [2, 4]) == "points: 8  # eight\nextended: [2, 4]\n"


@pytest.mark.parametrize("tree", [{"extended": [4]}, {"extended": [9]}, {"extended": [3, 2]}, {"extended": [0]}])
def test_a_history_that_does_not_rise_is_refused(tree: dict[str, Any]) -> None:
    with pytest.raises(Refusal, match="extended = "):
        plan_of(sweep_of({**TREE, **tree}, "sweep.yaml"))
