"""Files and folders that are written whole or not at all."""

from __future__ import annotations

import contextlib
import errno
import os
import stat
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.files import checked_path, special_kind
from dcrb_ros.text.temporary import remove_abandoned, temporary

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""Errors of a disk without space, and of a file beyond the largest size."""


@contextmanager
def whole_file(path: Path, *, otherwise: str = "give another file") -> Iterator[Path]:
    """Yield the name of a temporary file beside ``path``; at the end of the context it is on the disk and replaces ``path`` in one step.

    If the context raises, or the disk is full, ``path`` stays as it was and the temporary file is removed; that of a killed process is
    removed by the next one that writes to the folder. The temporary name ends like ``path``, for libraries that choose a format by the
    suffix. A link stays, and what it points to is replaced. A device or a pipe is written directly. ``otherwise`` ends the sentence of an
    error.

    Raises:
        Refusal: the file cannot be written.
    """
    with whole_files(path, otherwise=otherwise) as (temporary,):
        yield temporary


@contextmanager
def whole_files(*paths: Path, otherwise: str = "give another file") -> Iterator[tuple[Path, ...]]:
    """Yield temporary names of files that belong together; all are on the disk before the first one is replaced. See `whole_file`."""
    given = [checked_path(path).absolute() for path in paths]
    with _refused(paths[0], otherwise), ExitStack() as stack:
        targets = [target if special_kind(target) else target.resolve() for target in given]
        files = {target: stack.enter_context(temporary(target.parent, target.suffix)) for target in targets if not special_kind(target)}
        yield tuple(files.get(target, target) for target in targets)
        for target, written in files.items():
            if target.exists():  # a file keeps its permissions
                written.chmod(stat.S_IMODE(target.stat().st_mode))
            sync(written)
        _replace(files)
        for parent in {target.parent for target in files}:
            sync(parent)


def _replace(files: Mapping[Path, Path]) -> None:
    """Replace files by written ones, which belong together; an interrupt takes effect after the last one."""
    interrupt: KeyboardInterrupt | None = None
    left = dict(files)
    while left:
        try:
            for target, written in list(left.items()):
                if written.exists():  # an interrupt may come between the next two lines
                    written.replace(target)
                del left[target]
        except KeyboardInterrupt as error:
            interrupt = error
    if interrupt is not None:
        raise interrupt


@contextmanager
def whole_folder(folder: Path, last: str) -> Iterator[Path]:
    """Yield a temporary folder in ``folder``, which is made if it does not exist; at the end of the context its entries move up.

    The entry ``last``, without which the others are not used, moves last. If the context raises, ``folder`` stays as it was.

    Raises:
        Refusal: the folder cannot be written.
    """
    with _refused(folder, "give another folder"):
        new = not folder.exists()
        folder.mkdir(parents=True, exist_ok=True)
        try:
            with temporary(folder) as written:
                yield written
                for path in written.rglob("*"):
                    sync(path)
                _replace({folder / path.name: path for path in sorted(written.iterdir(), key=lambda path: path.name == last)})
                sync(folder)
        except BaseException:
            if new:
                with contextlib.suppress(OSError):
                    folder.rmdir()
            raise


def check_empty(folder: Path) -> None:
    """Refuse a folder with content; what a killed process has left there is removed.

    Raises:
        Refusal: the folder contains files, is no folder or cannot be read.
    """
    with _refused(folder, "give another folder"):
        remove_abandoned(folder)
        if folder.exists() and any(folder.iterdir()):
            raise Refusal(f"{folder} contains files: give an empty or a new folder")


def check_new_folder(path: Path) -> None:
    """Check that a new folder can be created at a path, or beside it, before a long work begins.

    Raises:
        Refusal: it cannot.
    """
    folder = checked_path(path).absolute().parent
    while not folder.exists():
        folder = folder.parent
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise Refusal(f"no folder can be created in {folder}: {error.strerror}; give a path in a folder that can be written") from None


@contextmanager
def _refused(path: Path, otherwise: str) -> Iterator[None]:
    """Turn an error of the operating system into a sentence on the file or folder."""
    try:
        yield
    except OSError as error:
        raise Refusal(f"{path} cannot be written: {error.strerror or error}; {remedy_of(error)} or {otherwise}") from None


def remedy_of(error: OSError) -> str:
    """Return what makes a failed write possible: space on a full disk, a file that is no pipe, folders, a sound disk, or a permission."""
    if error.errno in FULL:
        return "free some space"
    remedies = {
        errno.ESPIPE: "write a regular file",
        errno.ENOENT: "create its folder",
        errno.ENOTDIR: "remove the file in its path",
        errno.EIO: "check the disk",
    }
    return remedies.get(error.errno or 0, "make it writable")


def write_whole(path: Path, content: str | bytes, *, otherwise: str = "give another file") -> None:
    """Write a file whole, a text as UTF-8, or leave it as it was; see `whole_file`.

    Raises:
        Refusal: the file cannot be written.
    """
    with whole_file(path, otherwise=otherwise) as temporary:
        temporary.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8"))


def sync(path: Path) -> None:
    """Wait until a file, or the entries of a folder, are on the disk."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
