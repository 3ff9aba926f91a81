"""Verification of labels: a labelled run counts only if its label is complete and its files have the stated sizes and hashes."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field, TypeAdapter, ValidationError, ValidationInfo, field_validator

from dcrb_ros.runtime.processes import cores
from dcrb_ros.runtime.threads import show_name
from dcrb_ros.schema.parameter_field import first_problem
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.sweep.store import Store
from dcrb_ros.text.json import digest_of, parsed_json

LABELS, ERRORS = "labels", "errors"
"""Folders of the labels of runs that are not repeated, and of runs that ended in an error."""


class DamagedLabel(RuntimeError):
    """A label is not as `dcrb sweep` wrote it."""


LONGEST = 1e6
"""Longest run [s], as in a sweep file."""
DIGEST = "digest"
"""Key of a label: SHA-256 of its other entries."""


class _File(BaseModel):
    """A `FileRecord` in a label."""

    size: int
    sha256: str


class _Label(BaseModel):
    """The keys of every label."""

    run: str
    place: int
    split: str
    condition: str
    reason: str
    configuration: dict[str, Any]


class _RunLabel(_Label):
    status: Literal["refused", "failed", "error"]


class _DoneLabel(_Label):
    status: Literal["done"]
    fault: str
    file: str
    sampling_rate: int = Field(gt=0)
    first_index: int
    samples: int
    sha256: str
    files: dict[str, _File] = Field(min_length=1)

    @field_validator("file", "files")
    @classmethod
    def _inside(cls, value: Any, info: ValidationInfo) -> Any:
        run = info.data.get("run", "")
        for name in [value] if isinstance(value, str) else value:
            parts = name.split("/")
            inside = parts[0] in ("runs", "windows") and not {"", ".", ".."} & set(parts) and "\\" not in name
            if not inside or run not in (*parts[1:], *(part.partition(".")[0] for part in parts[1:])):
                raise ValueError(f"{name!r} is not a file of this run in the data set")
        return value

    @field_validator("samples")
    @classmethod
    def _possible(cls, samples: int, info: ValidationInfo) -> int:
        seconds = samples / info.data.get("sampling_rate", 1)
        if not 0.0 < seconds <= LONGEST:
            raise ValueError(f"{seconds:g} s is not above 0 and at most {LONGEST:g} s")
        return samples


_SCHEMA: TypeAdapter[_RunLabel | _DoneLabel] = TypeAdapter(Annotated[_RunLabel | _DoneLabel, Field(discriminator="status")])


def label_name(run: str, folder: str = LABELS) -> str:
    """Return the name of a run's label in the store."""
    return f"{folder}/{run}.json"


def read_label(store: Store, run: str, folder: str = LABELS) -> dict[str, Any] | None:
    """Return the label of a run; None if it has none.

    Raises:
        DamagedLabel: the label is empty, cut off, changed, or lacks an entry.
        StoreFailed: it cannot be read.
    """
    name = label_name(run, folder)
    try:
        data = store.read(name)
    except Refusal as refusal:
        raise DamagedLabel(str(refusal)) from None
    if data is None:
        return None
    try:
        label = parsed_json(data, store.path(name))
        named = _SCHEMA.validate_python(label).run
    except ValidationError as error:
        problem = first_problem(error)
        key = problem.key.partition(".")[2]
        raise DamagedLabel(f"{store.path(name)} is damaged ({key or 'status'}: {problem.reason.lower()})") from None
    except (ValueError, RecursionError):
        raise DamagedLabel(f"{store.path(name)} is {'damaged: it is not JSON' if data else 'empty'}") from None
    if named != run:
        raise DamagedLabel(f"{store.path(name)} is damaged: it is the label of the run {named}")
    if label.get(DIGEST) != digest_of(label, DIGEST):
        reason = "its contents do not have its digest" if DIGEST in label else "it has no digest"
        raise DamagedLabel(f"{store.path(name)} has been changed: {reason}")
    return dict(label)


def flaw(store: Store, run: str) -> str | None:
    """Return why a labelled run does not count, with the name of the file; None if its label and its files are intact.

    Raises:
        StoreFailed: the store cannot be read, which says nothing about the run.
    """
    try:
        label = read_label(store, run)
        if label is None:  # it is listed, but was removed since, or is a link to nothing
            return f"{store.path(label_name(run))} is missing"
        return next((reason for name, stated in label.get("files", {}).items() if (reason := _file_flaw(store, name, stated))), None)
    except DamagedLabel as error:
        return str(error)


def flaws(store: Store, runs: list[str]) -> dict[str, str]:
    """Return the labelled runs that do not count, each with the reason; see `flaw`."""
    with ThreadPoolExecutor(cores(), "verify", show_name) as threads:
        reasons = threads.map(lambda run: flaw(store, run), runs)
        return {run: reason for run, reason in zip(runs, reasons, strict=True) if reason is not None}


def _file_flaw(store: Store, name: str, stated: Mapping[str, Any]) -> str | None:
    path, size = store.path(name), store.size(name)
    if size is None:
        return f"{path} is missing"
    if size != stated["size"]:
        return f"{path} has {size} bytes instead of {stated['size']}"
    if store.sha256(name) not in (None, stated["sha256"]):
        return f"{path} has been changed: its SHA-256 is not the one in its label"
    return None
