"""Verification: which labelled runs count as done when a data set is continued."""

from __future__ import annotations

import errno
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
from attacked_files import ATTACKS, flip
from data_sets import made

from dcrb_ros.cli.app import app
from dcrb_ros.cli.sweep import _report_flaws
from dcrb_ros.runtime.exit_status import exit_status
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.sweep.data_set import open_data_set
from dcrb_ros.sweep.execution import common_settings, run_task
from dcrb_ros.sweep.label import base_label
from dcrb_ros.sweep.loader import sweep_of
from dcrb_ros.sweep.plan import Plan
from dcrb_ros.sweep.store import Store, StoreFailed
from dcrb_ros.sweep.table import write_table
from dcrb_ros.sweep.verification import DIGEST, flaw
from dcrb_ros.text.json import digest_of

pytestmark = pytest.mark.slow

TREE = {"set": {"cage.joint": "revolute"}, "duration": 0.02, "vary": {"operating.speed": [100.0, 120.0]}, "windows": {"length": 256}}
SWEEP = "set: {cage.joint: revolute}\nduration: 0.02\nvary: {operating.speed: [100.0, 120.0]}\nwindows: {length: 256}\n"


def simulated(folder: Path, **changed: object) -> tuple[Plan, Store, list[str]]:
    """Make a data set in this process; return its plan, its store and the names of its runs."""
    plan, store = Plan(sweep_of({**TREE, **changed}, "sweep.yaml", text=SWEEP)), Store(str(folder))
    made(plan, folder)
    return plan, store, [run.name for run in plan.runs()]


def edit(key: str, value: object, *, sign: bool = False) -> Callable[[Path], None]:
    """Return a change of a label; ``sign`` gives it the digest of its new contents."""

    def change(path: Path) -> None:
        label = json.loads(path.read_text()) | {key: value}
        if sign:
            label["digest"] = digest_of(label, DIGEST)
        path.write_text(json.dumps(label))

    return change


def without(key: str) -> Callable[[Path], None]:
    def change(path: Path) -> None:
        label = json.loads(path.read_text())
        del label[key]
        path.write_text(json.dumps(label))

    return change


DAMAGE: dict[str, tuple[str, Callable[[Path], object], str]] = {
    "an empty label": ("labels/{}.json", ATTACKS["empty"], "labels/{}.json is empty"),
    "a label cut off": ("labels/{}.json", ATTACKS["truncated"], "labels/{}.json is damaged: it is not JSON"),
    "a label that is text": ("labels/{}.json", lambda path: path.write_text('"done"'), "labels/{}.json is damaged (status:"),
    "a label nested without end": ("labels/{}.json", lambda path: path.write_text("[" * 100_000), "labels/{}.json is damaged"),
    "a label without files": ("labels/{}.json", without("files"), "labels/{}.json is damaged (files: field required)"),
    "a label without status": ("labels/{}.json", without("status"), "labels/{}.json is damaged (status: unable to extract"),
    "an edited fault": ("labels/{}.json", edit("fault", "cage"), "labels/{}.json has been changed: its contents do not have its digest"),
    "a label without its digest": ("labels/{}.json", without("digest"), "labels/{}.json has been changed: it has no digest"),
    "a path outside": ("labels/{}.json", edit("file", "../../etc/passwd", sign=True), "'../../etc/passwd' is not a file of this run"),
    "an absolute path": ("labels/{}.json", edit("file", "/etc/passwd", sign=True), "'/etc/passwd' is not a file of this run"),
    "the file of another run": ("labels/{}.json", edit("file", "runs/another.npz", sign=True), "'runs/another.npz' is not a file of this"),
    "files outside": (
        "labels/{}.json",
        edit("files", {"runs/../../{}.npz": {"size": 1, "sha256": "0"}}, sign=True),
        "is not a file of this run",
    ),
    "a run of 1e9 s": ("labels/{}.json", edit("samples", 51_200_000_000_000, sign=True), "1e+09 s is not above 0 and at most 1e+06 s"),
    "a folder for a label": ("labels/{}.json", ATTACKS["folder"], "labels/{}.json is a folder: give a regular file"),
    "a link to nothing for a label": ("labels/{}.json", ATTACKS["broken link"], "labels/{}.json is missing"),
    "a deleted waveform": ("runs/{}.npz", Path.unlink, "runs/{}.npz is missing"),
    "a truncated waveform": ("runs/{}.npz", ATTACKS["truncated"], "bytes instead of"),
    "a waveform with a flipped bit": ("runs/{}.npz", flip, "runs/{}.npz has been changed: its SHA-256 is not the one in its label"),
    "deleted windows": ("windows/train/{}.npz", Path.unlink, "windows/train/{}.npz is missing"),
}


@pytest.mark.parametrize("kind", DAMAGE)
def test_a_damaged_run_is_named_and_simulated_again(kind: str, tmp_path: Path) -> None:
    plan, store, runs = simulated(tmp_path, vary={}, split={"train": 1.0, "validation": 0.0, "test": 0.0})
    place, damage, sentence = DAMAGE[kind]
    file = tmp_path / place.format(runs[0])
    whole = (tmp_path / f"runs/{runs[0]}.npz").read_bytes(), (tmp_path / f"labels/{runs[0]}.json").read_bytes()
    damage(file)
    with open_data_set(plan, store) as data_set:
        assert data_set.done == set()
        assert sentence.format(runs[0]) in data_set.flaws[runs[0]]
        assert str(file) in data_set.flaws[runs[0]]
        (task,) = plan.tasks(data_set.done, 1.0)
        assert run_task(common_settings(plan.sweep, store), task) == [(runs[0], "done")]
    assert ((tmp_path / f"runs/{runs[0]}.npz").read_bytes(), (tmp_path / f"labels/{runs[0]}.json").read_bytes()) == whole
    with open_data_set(plan, store) as data_set:
        assert (data_set.done, data_set.flaws) == ({runs[0]}, {})


@pytest.mark.parametrize("place", ["labels/{}.json", "runs/{}.npz"])
def test_a_store_that_cannot_be_read_now_costs_no_run(place: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # A network drive that is away for a moment is no damage.
    plan, store, runs = simulated(tmp_path, vary={}, split={"train": 1.0, "validation": 0.0, "test": 0.0})
    file = str(tmp_path / place.format(runs[0]))
    real_open, real_path_open = os.open, Path.open

    def away(path: Any, *of: Any, **given: Any) -> int:
        if str(path) == file:
            raise OSError(errno.EIO, "Input/output error")
        return real_open(path, *of, **given)

    def path_away(path: Path, *of: Any, **given: Any) -> Any:
        if str(path) == file:
            raise OSError(errno.EIO, "Input/output error")
        return real_path_open(path, *of, **given)

    with monkeypatch.context() as patch:
        patch.setattr("os.open", away)
        patch.setattr(Path, "open", path_away)
        with (
            pytest.raises(Refusal, match=f"{file} cannot be read: Input/output error; make it readable and run the same command again"),
            open_data_set(plan, store),
        ):
            pytest.fail("the data set was opened")
    with open_data_set(plan, store) as data_set:
        assert (data_set.done, data_set.flaws) == ({runs[0]}, {})


def test_the_label_of_another_run_does_not_count(tmp_path: Path) -> None:
    _, store, runs = simulated(tmp_path)
    (tmp_path / f"labels/{runs[0]}.json").write_bytes((tmp_path / f"labels/{runs[1]}.json").read_bytes())
    assert f"labels/{runs[0]}.json is damaged: it is the label of the run {runs[1]}" in str(flaw(store, runs[0]))


def test_every_file_of_a_bag_is_verified(tmp_path: Path) -> None:
    _, store, runs = simulated(tmp_path, output="bag", windows=None, vary={})
    assert flaw(store, runs[0]) is None
    files = sorted((tmp_path / "runs" / runs[0]).iterdir())
    assert len(files) == 2
    for file in files:
        kept = file.read_bytes()
        file.write_bytes(kept[:-1])
        assert f"{file} has {len(kept) - 1} bytes instead of {len(kept)}" in str(flaw(store, runs[0]))
        file.write_bytes(kept)


def test_a_bag_of_a_worker_that_was_taken_for_lost_is_replaced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plan, store = Plan(sweep_of({**TREE, "windows": None, "output": "bag"}, "sweep.yaml")), Store(str(tmp_path))
    run, done = next(plan.runs()), {"status": "done", "reason": "", "fault": "healthy", "samples": 1, "sampling_rate": 1, "first_index": 0}
    made, folder = [], f"runs/{run.name}"

    def label(common: Any, run: Any, simulated: Any) -> dict[str, Any]:
        made.append(store.write(f"{folder}/bag", b"mine"))
        if len(made) == 1:
            store.write(f"{folder}/bag", b"of the other worker")
        return base_label(run, common.base) | done | {"file": folder, "sha256": "", "files": {f"{folder}/bag": made[-1]}}

    monkeypatch.setattr("dcrb_ros.sweep.execution._label", label)
    run_task(common_settings(plan.sweep, store), (run,))
    assert len(made) == 2
    assert flaw(store, run.name) is None


def test_a_folder_replaces_one_that_another_worker_puts_meanwhile(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store, target, replace = Store(str(tmp_path / "set")), tmp_path / "set" / "runs" / "run", os.replace
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "bag").write_bytes(b"mine")

    def clash(source: Path, folder: Path) -> None:
        monkeypatch.setattr(os, "replace", replace)
        target.mkdir(parents=True)
        (target / "other").touch()
        os.replace(source, folder)

    monkeypatch.setattr(os, "replace", clash)
    store.put(tmp_path / "mine", "runs/run")
    assert [path.name for path in target.iterdir()] == ["bag"]


def test_files_at_a_remote_address_are_verified_by_their_size() -> None:
    plan, store = Plan(sweep_of({**TREE, "vary": {}}, "sweep.yaml")), Store("memory://verification")
    (task,) = plan.groups()
    run_task(common_settings(plan.sweep, store), task)
    name = task[0].name
    assert flaw(store, name) is None
    store.write(f"runs/{name}.npz", b"short")
    assert f"runs/{name}.npz has 5 bytes instead of" in str(flaw(store, name))


@pytest.mark.parametrize(("data", "sentence"), [(b"", "is empty"), (b"{", "is not JSON"), (None, "is missing")])
def test_a_table_without_one_of_its_labels_is_not_written(tmp_path: Path, data: bytes | None, sentence: str) -> None:
    plan, store, runs = simulated(tmp_path)
    (tmp_path / "labels.parquet").unlink()
    label = tmp_path / f"labels/{runs[1]}.json"
    label.unlink()
    if data is not None:
        label.write_bytes(data)
    with pytest.raises(StoreFailed, match=f"{runs[1]}.json {sentence}|{runs[1]}.json .*{sentence}.*run the same command again"):
        write_table(plan, store)
    assert not (tmp_path / "labels.parquet").exists()


def test_the_command_repairs_a_damaged_data_set_without_dask(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def sweep(*options: str) -> int:
        arguments = ["sweep", str(file), "-o", str(folder), "--workers", "1", *options]
        return exit_status("dcrb", lambda: app(arguments, standalone_mode=False))

    for module in ("dask", "distributed"):
        monkeypatch.setitem(sys.modules, module, None)
    file, folder = tmp_path / "sweep.yaml", tmp_path / "set"
    file.write_text(SWEEP, encoding="utf-8")
    _, _, runs = simulated(folder)
    table = pd.read_parquet(folder / "labels.parquet")
    assert list(table["status"]) == ["done", "done"]
    assert set(json.loads(table["files"][0])) == {table["file"][0], f"windows/{table['split'][0]}/{runs[0]}.npz"}
    (folder / f"labels/{runs[0]}.json").write_bytes(b"")
    assert sweep() == 0
    printed = capsys.readouterr()
    assert f"{folder}/labels/{runs[0]}.json is empty: the run is simulated again" in printed.err
    assert "2 done" in printed.out
    assert pd.read_parquet(folder / "labels.parquet").equals(table)
    assert sweep("--quiet", "--json") == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    about = json.loads(printed.out)
    assert about == {
        "address": str(folder),
        "runs": {"done": 2},
        "splits": {"train": 1, "validation": 0, "test": 1},
        "seconds": pytest.approx(0.04),
        "reasons": {},
    }
    assert sweep("--quiet") == 0
    assert capsys.readouterr() == (f"{folder}: 2 done; 1 train, 1 test; 0.04 s recorded\n", "")


def test_only_the_first_of_many_damaged_runs_are_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plan, store, runs = simulated(tmp_path, vary={"operating.speed": [90.0 + k for k in range(7)]}, windows=None)
    for run in runs:
        (tmp_path / f"labels/{run}.json").write_bytes(b"")
    with open_data_set(plan, store) as data_set:
        _report_flaws(data_set)
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 6
    assert lines[-1] == "damage in 2 further runs: simulated again"


@pytest.mark.parametrize("name", ["labels.parquet", "dataset.yaml", "sweep.json", "sweep.yaml", "base.yaml", "README.md"])
def test_every_table_and_description_has_a_hash(name: str, tmp_path: Path) -> None:
    simulated(tmp_path)
    subprocess.run(["sha256sum", "-c", "--quiet", "SHA256SUMS"], cwd=tmp_path, check=True)
    flip(tmp_path / name)
    done = subprocess.run(["sha256sum", "-c", "--quiet", "SHA256SUMS"], cwd=tmp_path, check=False, capture_output=True, text=True)
    assert f"{name}: FAILED" in done.stdout


def test_files_are_on_the_disk_before_they_have_their_names(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[tuple[str, str]] = []
    replace, fsync = os.replace, os.fsync

    def synced(descriptor: int) -> None:
        calls.append(("sync", os.readlink(f"/proc/self/fd/{descriptor}")))
        fsync(descriptor)

    def renamed(source: Any, target: Any) -> None:
        calls.append(("rename", str(source)))
        replace(source, target)

    monkeypatch.setattr("os.fsync", synced)
    monkeypatch.setattr("os.replace", renamed)
    Store(str(tmp_path)).write("labels/a.json", b"{}")
    (kind, part), (then, source), (last, folder) = calls
    assert (kind, then, last) == ("sync", "rename", "sync")
    assert part == source
    assert folder == str(tmp_path / "labels")


@pytest.mark.parametrize("name", ["README.md", "labels.parquet", "SHA256SUMS"])
def test_a_folder_in_place_of_a_file_is_refused_before_the_first_run(name: str, tmp_path: Path) -> None:
    plan, store = Plan(sweep_of(TREE, "sweep.yaml", text=SWEEP)), Store(str(tmp_path))
    with open_data_set(plan, store):
        pass
    (tmp_path / name).mkdir()
    with pytest.raises(Refusal, match=f"{name} is a folder, .*: rename or remove the folder"), open_data_set(plan, store):
        pass
