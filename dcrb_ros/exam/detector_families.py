"""Families of detectors: the files of a folder, each a detector class with the settings of its members."""

from __future__ import annotations

import ast
import functools
import hashlib
import json
import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dcrb_ros.exam.family_process import class_and_variants
from dcrb_ros.exam.limits import Limits
from dcrb_ros.exam.plugin_process import DetectorProcess
from dcrb_ros.recordings.manifest import software
from dcrb_ros.runtime.version import __version__
from dcrb_ros.schema.parameter_field import more
from dcrb_ros.schema.refusal import Refusal

IMPORT_LIMITS = Limits(scenario=120.0, options=False)
"""Limits of the import of a file."""
SHIPPED_MODULE = "dcrb_ros.exam.shipped_family"
SHIPPED_FAMILY = "shipped detector"
SOURCES = ("bearing", "diagnosis", "exam", "messages", "schema", "stream", "settings")
"""Packages on which verdicts on a given signal may depend; a change of one of their sources makes verdicts outdated."""
UNRELATED = (
    "predictivity",
    "replica",
    "leaderboard",
    "agreement",
    "correlation",
    "report",
    "entry",
    "exam_file",
    "exam_score",
    "figure",
    "junit",
    "sealing",
)
"""Beginnings of the names of modules of the exam that take no part in a verdict."""


@dataclass(frozen=True)
class Member:
    """A detector with its settings."""

    name: str
    family: str
    given: str
    """The class and the member as `load_plugin` takes them."""
    digest: str
    """Digest of everything on which its verdicts on a signal depend."""
    published: bool
    """Whether it has the published settings: the first of its family."""


@dataclass(frozen=True)
class BrokenFamily:
    """A file that cannot be imported, or is no family."""

    name: str
    reason: str


class NoFamily(Refusal):
    """A file cannot be imported, or is no family."""


def families_of(folder: Path, kept: Path | None = None) -> tuple[list[Member], list[BrokenFamily]]:
    """Return the members of all families of a folder, and the files that cannot be used.

    A file with exactly one complete class that has a method ``update`` is a family; files without one are helpers. Every file is imported
    in a process of its own, unless what it contains is read from the folder ``kept``.

    Raises:
        Refusal: there is no such folder, it has no family or a file that cannot be read, or the folder ``kept`` cannot be written.
    """
    if not folder.is_dir():
        raise Refusal(f"there is no folder {folder}: give a folder of detectors, one family in each file")
    members: list[Member] = []
    broken: list[BrokenFamily] = []
    data = _data_digest(folder)
    for file in sorted(folder.glob("*.py")):
        if not file.is_file():
            broken.append(BrokenFamily(file.stem, f"{file} is not a file that can be read: remove it, or give it another name"))
            continue
        digest = _file_digest(file, data)
        try:
            about = _kept_about(file, digest, kept)
        except NoFamily as refusal:
            broken.append(BrokenFamily(file.stem, str(refusal)))
            continue
        members += _members(file.stem, f"{file}:{about['class']}", about, digest) if about["class"] else []
    if not members and broken:
        raise Refusal(f"{folder} has no detector that can be used: {broken[0].reason}{more(len(broken))}")
    if not members:
        raise Refusal(f"{folder} has no detector: give files with one class that has update(index, acceleration, shaft_angle)")
    return members, broken


def shipped_members() -> list[Member]:
    """Return the members of the family of the shipped detector."""
    about = class_and_variants(SHIPPED_MODULE)
    return list(_members(SHIPPED_FAMILY, f"{SHIPPED_MODULE}:{about['class']}", about, ""))


def _members(family: str, given: str, about: dict[str, Any], digest: str) -> Iterator[Member]:
    package = package_digest()
    for number, (name, settings) in enumerate((about["variants"] or {family: ""}).items()):
        whole = hashlib.sha256("\n".join((package, digest, given.rpartition(":")[2], name, settings)).encode()).hexdigest()
        yield Member(name, family, f"{given}[{name}]" if about["variants"] else given, whole, number == 0)


def _kept_about(file: Path, digest: str, kept: Path | None) -> dict[str, Any]:
    """Return class and variants of a file with a digest, from the folder ``kept`` where it has them."""
    if kept is None:
        return _about(str(file))
    from dcrb_ros.core.signed_file import read_signed
    from dcrb_ros.exam.recording_cache import keep

    path = kept / f"family-{hashlib.sha256(f'{package_digest()} {digest} {file.name}'.encode()).hexdigest()[:32]}.signed"
    try:
        return dict(json.loads(read_signed(path)))
    except OSError:  # a damaged file is like a missing one: the family is imported again
        about = _about(str(file))
        keep(path, json.dumps(about).encode())
        return about


def _about(file: str) -> dict[str, Any]:
    """Return class and variants of a file, imported in a process of its own.

    Raises:
        NoFamily: it cannot be imported, or has several detectors.
    """
    try:
        process = DetectorProcess(file, IMPORT_LIMITS, "dcrb_ros.exam.family_process")
    except Refusal as refusal:
        raise NoFamily(left_out(refusal)) from None
    process.close()
    return dict(json.loads(process.imported))


def left_out(refusal: Refusal) -> str:
    """Return a refusal of a detector without the option of ``dcrb score`` that gives one."""
    return str(refusal).removeprefix("--python ")


def _file_digest(file: Path, data: str) -> str:
    """Return the digest of a file, of the files in its folder that it imports, and of the ``data`` in the folder, by their digest."""
    return hashlib.sha256(f"{_digest_of(sorted(_imported(file, {file}, file.parent)), file.parent)} {data}".encode()).hexdigest()


def _data_digest(folder: Path) -> str:
    """Return the digest of all files in a folder and its subfolders but sources, and hidden files and folders.

    Raises:
        Refusal: a file cannot be read.
    """
    files = []
    for at, folders, names in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith(".") and name != "__pycache__")
        files += [Path(at, name) for name in sorted(names) if not name.startswith(".") and Path(name).suffix not in (".py", ".pyc")]
    return _digest_of([file for file in files if file.is_file()], folder)


def _imported(file: Path, known: set[Path], folder: Path) -> set[Path]:
    """Add the files of a folder that a file imports, directly or not, to the known ones; of a package in the folder, all of them."""
    try:
        tree = ast.parse(file.read_text(encoding="utf-8"))
    except (SyntaxError, ValueError, OSError):
        return known
    for node in ast.walk(tree):
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        names += [node.module] if isinstance(node, ast.ImportFrom) and node.module else []
        for name in names:
            package = folder / name.partition(".")[0]
            for path in (package.with_suffix(".py"), *package.rglob("*.py")):
                if path.is_file() and path not in known:
                    known.add(path)
                    _imported(path, known, folder)
    return known


@functools.cache
def package_digest() -> str:
    """Return the digest of the sources of this package on which verdicts may depend, of its version and of the software below it."""
    package = Path(__file__).parents[1]
    files = [path for name in SOURCES for path in sorted((package / name).rglob("*.py"))]
    related = [path for path in files if path.parent.name != "exam" or not path.name.startswith(UNRELATED)]
    return hashlib.sha256(f"{__version__} {_digest_of(related, package)} {json.dumps(software())}".encode()).hexdigest()


def _digest_of(files: Iterable[Path], folder: Path) -> str:
    digest = hashlib.sha256()
    for file in files:
        content = hashlib.sha256()
        try:
            with file.open("rb") as stream:
                while part := stream.read(1 << 20):
                    content.update(part)
        except OSError as error:
            raise Refusal(f"{file} cannot be read ({error.strerror}): make it readable, or move it out of {folder}") from None
        digest.update(os.fsencode(file.relative_to(folder)) + b"\0" + content.digest())
    return digest.hexdigest()
