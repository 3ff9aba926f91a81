"""Files that are written whole or not at all."""

from __future__ import annotations

import contextlib
import errno
import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.files import checked_path, special_kind

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""Errors of a disk without space, and of a file beyond the largest size."""


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Yield the name of a temporary file beside ``path``; at the end of the context it is on the disk and replaces ``path`` in one step.

    If the context raises, or the disk is full, ``path`` stays as it was and the temporary file is removed. The temporary name ends like
    ``path``, for libraries that choose a format by the suffix. A link stays, and what it points to is replaced. A device or a pipe is
    written directly.

    Raises:
        Refusal: the file cannot be written.
    """
    target = checked_path(path).absolute()
    if special_kind(target):
        with _refused(path):
            yield target
        return
    with _refused(path):
        target = target.resolve()
        temporary = target.with_name(f".writing-{secrets.token_hex(8)}{target.suffix}")
        os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        try:
            yield temporary
            sync(temporary)
            temporary.replace(target)
            sync(target.parent)
        finally:
            with contextlib.suppress(OSError):
                temporary.unlink(missing_ok=True)


@contextmanager
def _refused(path: Path) -> Iterator[None]:
    """Turn an error of the operating system into a sentence on the file."""
    try:
        yield
    except OSError as error:
        raise Refusal(f"{path} cannot be written: {error.strerror or error}; {remedy_of(error)} or give another file") from None


def remedy_of(error: OSError) -> str:
    """Return what makes a failed write possible: space on a full disk, a folder that exists, a sound disk, otherwise a permission."""
    if error.errno in FULL:
        return "free some space"
    return {errno.ENOENT: "create its folder", errno.EIO: "check the disk"}.get(error.errno or 0, "make it writable")


def write_whole(path: Path, content: str | bytes) -> None:
    """Write a file whole, a text as UTF-8, or leave it as it was; see `whole_file`.

    Raises:
        Refusal: the file cannot be written.
    """
    with whole_file(path) as temporary:
        temporary.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8"))


def sync(path: Path) -> None:
    """Wait until a file, or the entries of a folder, are on the disk."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
