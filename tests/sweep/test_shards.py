"""Shards come out of their index bit for bit."""

from __future__ import annotations

import io
import json
import shutil
import tarfile
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from attacked_files import ATTACKS
from data_sets import made

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.sweep.data_set import open_data_set
from dcrb_ros.sweep.kinds import plan_of
from dcrb_ros.sweep.loader import read_sweep, sweep_of
from dcrb_ros.sweep.plan import Plan
from dcrb_ros.sweep.shards import INDEX, RECIPE, Shard, pack, remake_shard, shards, write_shards
from dcrb_ros.sweep.store import Store
from dcrb_ros.sweep.sums import write_sums
from dcrb_ros.sweep.sweep_file import ABOUT

TREE: dict[str, Any] = {
    "base": "dry",
    "set": {"cage.joint": "revolute"},
    "design": "random",
    "points": 5,
    "vary": {"operating.speed": {"low": 90.0, "high": 160.0}},
    "cases": {"healthy": {}, "outer": {"faults.outer_1.width": {"low": 0.001, "high": 0.002}}},
    "duration": 0.02,
}


@pytest.fixture(scope="module")
def data_set(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a small data set."""
    folder = tmp_path_factory.mktemp("data") / "set"
    made(TREE, folder)
    return folder


def test_every_run_is_in_one_shard_of_its_split(data_set: Path, tmp_path: Path) -> None:
    write_shards(data_set, tmp_path / "shards", 3)
    index = json.loads((tmp_path / "shards" / INDEX).read_text())
    held = [run for shard in index["shards"].values() for run in shard["runs"]]
    assert sorted(held) == sorted(path.stem for path in (data_set / "runs").iterdir())
    for name, shard in index["shards"].items():
        labels = [json.loads((data_set / "labels" / f"{run}.json").read_text()) for run in shard["runs"]]
        assert {label["split"] for label in labels} == {name.rpartition("-")[0]}


def test_a_member_is_the_waveform_and_its_label(data_set: Path, tmp_path: Path) -> None:
    name = write_shards(data_set, tmp_path / "shards", 3)[0]
    with tarfile.open(tmp_path / "shards" / name) as tar:
        members = tar.getnames()
        run = members[0].partition(".")[0]
        assert members[:2] == [f"{run}.npz", f"{run}.json"]
        stored, label = (tar.extractfile(member) for member in members[:2])
        assert stored is not None
        assert label is not None
        with np.load(io.BytesIO(stored.read())) as content, np.load(data_set / "runs" / f"{run}.npz") as original:
            assert np.array_equal(content["ay"], original["ay"])
        assert json.loads(label.read())["run"] == run


def test_a_shard_is_made_again_from_the_index_alone(data_set: Path, tmp_path: Path) -> None:
    names = write_shards(data_set, tmp_path / "shards", 3)
    index = tmp_path / "elsewhere" / INDEX
    index.parent.mkdir()
    index.write_bytes((tmp_path / "shards" / INDEX).read_bytes())
    for name in names[:2]:
        remake_shard(index, name, tmp_path / name)
        assert (tmp_path / name).read_bytes() == (tmp_path / "shards" / name).read_bytes()


def test_a_shard_is_written_run_by_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    runs, megabyte = tuple(SimpleNamespace(name=f"run{number:02d}") for number in range(16)), 1 << 20
    (tmp_path / "runs").mkdir()
    for run in runs:
        (tmp_path / "runs" / f"{run.name}.npz").write_bytes(bytes(megabyte))
    monkeypatch.setattr("dcrb_ros.sweep.shards.flaw", lambda store, run: None)
    monkeypatch.setattr("dcrb_ros.sweep.shards.read_label", lambda store, run: {"status": "done", "file": f"runs/{run}.npz"})
    tracemalloc.start()
    pack(Store(str(tmp_path)), Shard("a.tar", (runs,)), tmp_path / "a.tar")  # type: ignore[arg-type]
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert (tmp_path / "a.tar").stat().st_size > 16 * megabyte
    assert peak < 4 * megabyte


@pytest.mark.slow
def test_the_index_of_half_a_million_shards_is_read(data_set: Path, tmp_path: Path) -> None:
    write_shards(data_set, tmp_path / "shards", 3)
    index = tmp_path / "shards" / INDEX
    about = json.loads(index.read_text())
    assert index.read_text() == json.dumps(about)  # without spaces to indent a line for each run
    record = {"size": 10_000_000, "sha256": "0" * 64, "runs": ["0" * 20]}
    about["shards"] = {f"train-{number:06d}.tar": record for number in range(500_000)}
    index.write_text(json.dumps(about))
    with pytest.raises(Refusal, match=r"has no shard 'none': it has 500000"):
        remake_shard(index, "none", tmp_path / "a.tar")


def test_other_bytes_and_other_versions_are_refused(data_set: Path, tmp_path: Path) -> None:
    name = write_shards(data_set, tmp_path / "shards", 3)[0]
    index = tmp_path / "shards" / INDEX
    about = json.loads(index.read_text())
    with pytest.raises(Refusal, match=r"has no shard 'train-000099\.tar'"):
        remake_shard(index, "train-000099.tar", tmp_path / "a.tar")
    about["shards"][name]["sha256"] = "0" * 64
    index.write_text(json.dumps(about))
    with pytest.raises(Refusal, match="as in the index"):
        remake_shard(index, name, tmp_path / "a.tar")
    about |= {"plan": "another", "model": "another"}
    index.write_text(json.dumps(about))
    with pytest.raises(Refusal, match="install that version"):
        remake_shard(index, name, tmp_path / "a.tar")
    assert not (tmp_path / "a.tar").exists()


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda index: index.update(zz_unknown=1), "zz_unknown: extra inputs are not permitted"),
        (lambda index: index.update(shards=[]), "shards: input should be"),
        (lambda index: index["software"].update(numpy=1), "software.numpy: input should be a valid string"),
        (lambda index: index.update(runs_per_shard=0), "runs_per_shard: input should be greater than or equal to 1"),
        (lambda index: index["recipe"].pop("base.yaml"), "its recipe must have sweep.yaml, base.yaml, sweep.json"),
        (lambda index: index.update(runs_per_shard=5), "are not those of its recipe"),
        (lambda index: next(iter(index["shards"].values()))["runs"].pop(), "are not those of its recipe"),
        (lambda index: next(iter(index["shards"].values())).update(size=1), r"train-000000\.tar has \d+ bytes, not 1"),
        (lambda index: index.update(recipe={key: text.replace("160.0", "170.0") for key, text in index["recipe"].items()}), "not follow"),
        (lambda index: index["recipe"].update({"base.yaml": "bearing: {rows: 1}"}), "its plan does not follow from its recipe; get"),
        (lambda index: index["recipe"].update({"sweep.yaml": "{]"}), r"was changed: its recipe sweep\.yaml is not valid YAML in line 1"),
        (lambda index: index["recipe"].update({"sweep.yaml": "machine: ../../../etc/passwd"}), "are both a configuration"),
        (lambda index: index["recipe"].update({"sweep.yaml": "- a list"}), "is not a sweep"),
    ],
)
def test_an_index_that_was_changed_is_refused(change: Callable[[Any], object], sentence: str, data_set: Path, tmp_path: Path) -> None:
    name = write_shards(data_set, tmp_path / "shards", 3)[0]
    file = tmp_path / "shards" / INDEX
    index = json.loads(file.read_text())
    change(index)
    file.write_text(json.dumps(index))
    with pytest.raises(Refusal, match=sentence):
        remake_shard(file, name, tmp_path / "a.tar")
    assert not (tmp_path / "a.tar").exists()


@pytest.mark.parametrize("attack", ["folder", "pipe", "broken link", "truncated", "empty"])
@pytest.mark.timeout(60)  # a pipe would be waited for
def test_something_else_in_place_of_an_index_is_refused(attack: str, data_set: Path, tmp_path: Path) -> None:
    name = write_shards(data_set, tmp_path / "shards", 3)[0]
    ATTACKS[attack](tmp_path / "shards" / INDEX)
    with pytest.raises(Refusal, match=INDEX):
        remake_shard(tmp_path / "shards" / INDEX, name, tmp_path / "a.tar")


def test_a_data_set_keeps_its_own_base_and_scenarios(tmp_path: Path) -> None:
    """Its sweep file and its shards need neither the files that the sweep names nor the folder of these files."""
    own, folder = tmp_path / "own", tmp_path / "set"
    own.mkdir()
    (own / "mine.yaml").write_text("cage: {joint: revolute}\n")
    (own / "grows.yaml").write_text("timeline: [{at: 0.01, set: {faults.outer_1.width: 0.002}}]\n")
    (own / "sweep.yaml").write_text("base: mine.yaml\ncases: {grows: {scenario: grows.yaml}}\nduration: 0.02\n")
    plan = plan_of(read_sweep(own / "sweep.yaml"))
    made(plan, folder)
    shutil.rmtree(own)
    assert plan_of(read_sweep(folder / "sweep.yaml")).name == plan.name
    write_shards(folder, tmp_path / "shards", 1)
    remake_shard(tmp_path / "shards" / INDEX, "train-000000.tar", tmp_path / "again.tar")
    (folder / "sweep.yaml").write_text((folder / "sweep.yaml").read_text().replace("mine.yaml", "dry"))
    with pytest.raises(Refusal, match=r"there is no scenario 'grows\.yaml'"):
        read_sweep(folder / "sweep.yaml")  # another base: a sweep of its own


@pytest.mark.parametrize(("old", "new"), [(", operating.speed: 90.0", ""), ("90.0", "80.0"), ("set: {", "set: {operating.load: 5.0e+4, ")])
def test_a_changed_set_in_the_sweep_file_of_a_data_set_is_refused(old: str, new: str, tmp_path: Path) -> None:
    (tmp_path / "own.yaml").write_text("base: dry\nset: {cage.joint: revolute, operating.speed: 90.0}\nduration: 0.02\n")
    with open_data_set(plan_of(read_sweep(tmp_path / "own.yaml")), Store(str(tmp_path / "set"))):
        pass
    copy = tmp_path / "set" / "sweep.yaml"
    read_sweep(copy)
    copy.write_text(copy.read_text().replace(old, new))
    with pytest.raises(Refusal, match=r"sweep\.yaml: 'set' was changed, but base\.yaml beside it has the former values"):
        read_sweep(copy)


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        ("sweep.yaml", "160.0", "170.0"),
        ("sweep.yaml", "duration:", "split: {train: 0.2, validation: 0.2, test: 0.6}\nduration:"),  # the same runs in other splits
        ("base.yaml", "rollers_per_row: 16", "rollers_per_row: 15"),
        ("base.yaml", "rollers_per_row: 16", "rollers_per_row: 99"),  # damage, not a mistake of the user
        ("sweep.json", '"model"', "model"),
    ],
)
def test_an_edited_recipe_of_a_data_set_is_not_packed(file: str, old: str, new: str, data_set: Path, tmp_path: Path) -> None:
    copied = Path(shutil.copytree(data_set, tmp_path / "copied"))
    text = (copied / file).read_text()
    changed = text.replace(old, new)
    assert changed != text
    (copied / file).write_text(changed)
    with pytest.raises(Refusal, match=rf"{file} has been changed: its SHA-256 is not the one in SHA256SUMS"):
        write_shards(copied, tmp_path / "shards", 3)
    assert not (tmp_path / "shards").exists()


@pytest.mark.parametrize("key", ["dcrb_ros", "model"])
def test_a_data_set_of_another_version_is_not_packed(key: str, data_set: Path, tmp_path: Path) -> None:
    copied = Path(shutil.copytree(data_set, tmp_path / "copied"))
    about = json.loads((copied / ABOUT).read_text())
    (copied / ABOUT).write_text(json.dumps(about | {key: "another", "name": "another"}))
    write_sums(Store(str(copied)), RECIPE)
    with pytest.raises(Refusal, match=r"was made with dcrb_ros .*another.*: install that version, or give another folder"):
        write_shards(copied, tmp_path / "shards", 3)
    assert not (tmp_path / "shards").exists()


def test_a_missing_run_and_a_full_folder_are_refused(data_set: Path, tmp_path: Path) -> None:
    (tmp_path / "shards" / ".writing-0123456789abcdef").mkdir(parents=True)  # left by a process that was killed
    write_shards(data_set, tmp_path / "shards", 3)
    assert not (tmp_path / "shards" / ".writing-0123456789abcdef").exists()
    with pytest.raises(Refusal, match="an empty or a new folder"):
        write_shards(data_set, tmp_path / "shards", 3)
    with pytest.raises(Refusal, match=r"has no sweep\.yaml"):
        write_shards(tmp_path, tmp_path / "more", 3)
    (tmp_path / "file").touch()
    for place in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(Refusal, match=r"file.* cannot be written: Not a directory; .* or give another folder"):
            write_shards(data_set, place, 3)


def test_shards_have_at_least_their_runs(data_set: Path) -> None:
    plan = Plan(sweep_of({**TREE, "points": 40}, "sweep.yaml"))
    sizes = [(shard.name, sum(map(len, shard.tasks))) for shard in shards(plan, 7)]
    for split in ("train", "validation", "test"):
        own = [size for name, size in sizes if name.startswith(split)]
        assert all(size == 8 for size in own[:-1])  # pairs of a healthy and a faulty run
    assert sum(size for _, size in sizes) == 80


def test_a_changed_run_is_not_packed(data_set: Path, tmp_path: Path) -> None:
    copied = Path(shutil.copytree(data_set, tmp_path / "copied"))
    label = next((copied / "labels").iterdir())
    label.write_text(json.dumps(json.loads(label.read_text()) | {"fault": "cage"}))
    with pytest.raises(Refusal, match=r"has been changed: its contents do not have its digest: repair or finish"):
        write_shards(copied, tmp_path / "shards", 3)
    label.write_bytes((data_set / "labels" / label.name).read_bytes())
    waveform = next((copied / "runs").iterdir())
    waveform.write_bytes(waveform.read_bytes()[:-1] + b"x")
    with pytest.raises(Refusal, match=f"{waveform.name} has been changed"):
        write_shards(copied, tmp_path / "more", 3)


@pytest.mark.slow
def test_shards_of_vehicles_are_made_again_without_the_file_of_the_vehicle(tmp_path: Path) -> None:
    own = tmp_path / "bogie.yaml"
    own.write_text("vehicle: {bench: dry}\naxle_1: {left: {}, right: {}}\n")
    cases = {"healthy": {}, "outer": {"box": "axle_1.left", "box.faults.outer_1.width": 0.002}}
    split = {"train": 0.5, "validation": 0.0, "test": 0.5}
    vary = {"vehicle.seed": [1, 2]}
    tree = {"vehicle": str(own), "design": "grid", "vary": vary, "cases": cases, "duration": 0.5, "settle": 0.0, "split": split}
    made(tree, tmp_path / "set")
    name, *others = write_shards(tmp_path / "set", tmp_path / "shards", 100)
    assert [name, *others] == ["train-000000.tar", "test-000000.tar"]
    own.unlink()
    remake_shard(tmp_path / "shards" / INDEX, name, tmp_path / name)
    assert (tmp_path / name).read_bytes() == (tmp_path / "shards" / name).read_bytes()
    with tarfile.open(tmp_path / name) as tar:
        boxes = [json.loads(tar.extractfile(member).read())["box"] for member in tar.getnames() if member.endswith(".json")]  # type: ignore[union-attr]
    assert boxes == ["axle_1.left", "axle_1.right"] * 2
