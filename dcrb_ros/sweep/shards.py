"""WebDataset shards of a data set, and the index from which any of them is made again, bit for bit.

A shard is a tar file with two members per run: ``RUN.npz`` or ``RUN.parquet``, the waveform, and ``RUN.json``, its label. Loaders of
WebDataset group members by the name before the first dot. Members have no dates and no owners, so that equal runs give equal bytes.
"""

from __future__ import annotations

import io
import itertools
import json
import os
import tarfile
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from pydantic import Field, ValidationError

from dcrb_ros.recordings.manifest import model_fingerprint, software
from dcrb_ros.runtime.version import __version__
from dcrb_ros.schema.fields import Group
from dcrb_ros.schema.parameter_field import first_problem
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.sweep.data_set import check_same, known_inputs
from dcrb_ros.sweep.execution import common_settings, run_task
from dcrb_ros.sweep.kinds import plan_of
from dcrb_ros.sweep.label import DONE
from dcrb_ros.sweep.loader import kept_inputs, kept_sweep
from dcrb_ros.sweep.plan import Plan, Task
from dcrb_ros.sweep.schema import SPLITS
from dcrb_ros.sweep.store import Store, record_of
from dcrb_ros.sweep.sums import SUMS, read_sums
from dcrb_ros.sweep.sweep_file import ABOUT, COPY, KEPT_BASE
from dcrb_ros.sweep.verification import flaw, read_label
from dcrb_ros.text.files import read_text
from dcrb_ros.text.json import parsed_json
from dcrb_ros.text.writing import check_empty, whole_file, whole_folder
from dcrb_ros.text.yaml import read_yaml

INDEX = "index.json"
LARGEST_INDEX, MOST_VALUES = 256 * 1024 * 1024, 6_000_000
"""Longest index that is read [bytes], and its most values [-]; a million shards of one run have 152 MB and 5 million values."""
RECIPE = (COPY, KEPT_BASE, ABOUT)
"""Files of a data set from which its plan is made again."""


class Shard(NamedTuple):
    """Runs that are stored together."""

    name: str
    """Such as ``train-000003.tar``."""
    tasks: tuple[Task, ...]
    """Groups of runs that share a start; a group is in one shard."""


class ShardRecord(Group):
    """What the index says of a shard."""

    size: int = Field(ge=0)
    """[bytes]"""
    sha256: str
    runs: list[str]


class Index(Group):
    """The index of the shards of a data set."""

    dcrb_ros: str
    model: str
    software: dict[str, str]
    plan: str
    """Hash of the plan."""
    runs_per_shard: int = Field(ge=1)
    recipe: dict[str, str]
    """Texts of `RECIPE`."""
    shards: dict[str, ShardRecord]


def shards(plan: Plan, runs: int) -> Iterator[Shard]:
    """Yield the shards of a plan: the groups of each split in the order of the plan, at least ``runs`` runs each but the last."""
    for split in SPLITS:
        number, kept = 0, list[Task]()
        for task in itertools.chain(plan.groups(), [()]):
            if task and task[0].split == split:
                kept.append(task)
            if kept and (not task or sum(map(len, kept)) >= runs):
                yield Shard(f"{split}-{number:06d}.tar", tuple(kept))
                number, kept = number + 1, []


def write_shards(data_set: Path, folder: Path, runs: int) -> list[str]:
    """Write the shards of a finished data set and their index to a new folder; return the names of the shards.

    If that fails, no shard is left.

    Raises:
        Refusal: the data set is not whole, was changed, is of another version or model, or has bags; or the folder is not empty or cannot
            be written.
    """
    store = Store(str(data_set))
    sums, kept = read_sums(store), [name for name in RECIPE if (data_set / name).is_file()]
    changed = next((name for name in kept if sums is not None and store.sha256(name) != sums.get(name)), None)
    if changed is not None:
        raise Refusal(
            f"{data_set / changed} has been changed: its SHA-256 is not the one in {SUMS}; restore it, or make the data set again"
        )
    plan, entries = _plan(data_set), dict[str, dict[str, object]]()
    check_same(known_inputs(store), plan, store)
    check_empty(folder)
    with whole_folder(folder, INDEX) as written:
        for shard in shards(plan, runs):
            pack(store, shard, written / shard.name)
            entries[shard.name] = {**record_of(written / shard.name), "runs": [run.name for task in shard.tasks for run in task]}
        recipe = {name: (data_set / name).read_text(encoding="utf-8") for name in RECIPE}
        about = {"dcrb_ros": __version__, "model": model_fingerprint(), "software": software(), "plan": plan.name, "runs_per_shard": runs}
        (written / INDEX).write_text(json.dumps({**about, "recipe": recipe, "shards": entries}))
    return list(entries)


def remake_shard(index: Path, name: str, target: Path) -> str:
    """Simulate the runs of one shard of an index again and write it; return its SHA-256.

    Raises:
        Refusal: the index is damaged or of another version or model, it has no such shard, or the bytes differ from those in the index.
    """
    about = _read_index(index)
    known = about.shards
    if name not in known:
        raise Refusal(f"{index} has no shard '{name}': it has {len(known)}, such as {next(iter(known), 'none')}")
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        for file, text in about.recipe.items():
            (folder / file).write_text(text, encoding="utf-8")
        plan, store = _indexed_plan(index, about, folder), Store(str(folder / "runs_of_shard"))
        shard = next((shard for shard in shards(plan, about.runs_per_shard) if shard.name == name), None)
        if shard is None or [run.name for task in shard.tasks for run in task] != known[name].runs:
            raise Refusal(f"{index} was changed: the runs of {name} are not those of its recipe; get the index again")
        for task in shard.tasks:
            run_task(common_settings(plan.sweep, store), task)
        with whole_file(target) as part:
            pack(store, shard, part)
            made = record_of(part)
            sha256 = made["sha256"]
            if sha256 != known[name].sha256:
                raise Refusal(
                    f"{name} has the SHA-256 {sha256[:12]}..., not {known[name].sha256[:12]}... as in the index: the last bits depend on "
                    f"processor and libraries, which were {about.software}"
                )
            if made["size"] != known[name].size:
                raise Refusal(f"{index} was changed: {name} has {made['size']} bytes, not {known[name].size}; get the index again")
    return sha256


def _indexed_plan(index: Path, about: Index, folder: Path) -> Plan:
    """Return the plan of an index from its recipe in a folder; refuse one of another version or model, or a damaged one."""
    try:
        plan = _plan(folder)
        if plan.name == about.plan:
            return plan
        reason = "its plan does not follow from its recipe"
    except Refusal as refusal:
        reason = str(refusal).replace(f"{folder}{os.sep}", "its recipe ")
    if (about.dcrb_ros, about.model) != (__version__, model_fingerprint()):
        raise Refusal(
            f"{index} was made with dcrb_ros {about.dcrb_ros} and model {about.model}, but this is {__version__} with model "
            f"{model_fingerprint()}: install that version"
        )
    raise Refusal(f"{index} was changed: {reason}; get the index again")


def pack(store: Store, shard: Shard, target: Path) -> None:
    """Write a shard as a tar file, one run after the other; runs that were refused or failed are left out.

    Raises:
        Refusal: a run has no label or no waveform file.
    """
    with tarfile.open(target, mode="w", format=tarfile.USTAR_FORMAT) as tar:
        for run in itertools.chain.from_iterable(shard.tasks):
            reason = flaw(store, run.name)
            if reason is not None:
                raise Refusal(f"{reason}: repair or finish the data set with dcrb sweep first")
            label = read_label(store, run.name) or {}
            if label["status"] != DONE:
                continue
            file = str(label["file"])
            if not (Path(store.address) / file).is_file():
                raise Refusal(f"{store.address}: {file} is no waveform file: shards need 'output: npz' or parquet")
            _add(tar, f"{run.name}{Path(file).suffix}", (Path(store.address) / file).read_bytes())
            _add(tar, f"{run.name}.json", json.dumps(label, sort_keys=True).encode())


def _add(tar: tarfile.TarFile, name: str, data: bytes) -> None:
    member = tarfile.TarInfo(name)
    member.size = len(data)
    tar.addfile(member, io.BytesIO(data))


def _plan(folder: Path) -> Plan:
    """Return the plan of a data set from the sweep file and the base that it keeps."""
    missing = next((name for name in RECIPE if not (folder / name).is_file()), None)
    if missing:
        raise Refusal(f"{folder} has no {missing}, so it is not a data set: give the folder of dcrb sweep")
    path = folder / COPY
    tree = read_yaml(path)
    if not isinstance(tree, dict):
        raise Refusal(f"{path} is not a sweep: give the folder of dcrb sweep")
    return plan_of(kept_sweep(tree, path, kept_inputs(path).get("scenarios", {})))


def _read_index(index: Path) -> Index:
    tree = parsed_json(read_text(index, LARGEST_INDEX), str(index), LARGEST_INDEX, MOST_VALUES) if index.is_file() else None
    if not isinstance(tree, dict) or "shards" not in tree:
        raise Refusal(f"{index} is not an index of shards: dcrb shards writes one as {INDEX}")
    try:
        about = Index.model_validate(tree)
    except ValidationError as error:
        problem = first_problem(error)
        raise Refusal(f"{index} is damaged ({problem.key or 'the file'}: {problem.reason}): get the index again") from None
    if set(about.recipe) != set(RECIPE):
        raise Refusal(f"{index} is damaged: its recipe must have {', '.join(RECIPE)}; get the index again")
    return about
