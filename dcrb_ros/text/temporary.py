"""Temporary files and folders beside the final ones; those of a killed process are removed by the next one that writes there.

A lock, which the system releases at the end of its process, shows which of them are abandoned.
"""

from __future__ import annotations

import os
import secrets
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

WRITING = ".writing-"
"""Beginning of the names of temporary files and folders."""
DIGITS = 16
"""Hexadecimal digits that follow it; files of users whose names begin alike are left alone."""
ABANDONED = 86400.0
"""Age of what is abandoned where nothing can be locked: on Windows, and on some file systems of a network [s]."""


@contextmanager
def temporary(folder: Path, suffix: str | None = None) -> Iterator[Path]:
    """Yield a new folder in ``folder``, or a new file if a ``suffix`` is given, which is removed at the end; remove abandoned ones before.

    Raises:
        OSError: ``folder`` does not exist or cannot be written.
    """
    remove_abandoned(folder)
    with new_locked(folder, WRITING, suffix) as path:
        try:
            yield path
        finally:
            remove(path)


@contextmanager
def new_locked(folder: Path, prefix: str, suffix: str | None = None) -> Iterator[Path]:
    """Yield a new folder in ``folder``, or a new file if a ``suffix`` is given, which is locked until the end of the context."""
    while True:
        path = folder / f"{prefix}{secrets.token_hex(DIGITS // 2)}{suffix or ''}"
        if suffix is None:
            path.mkdir()
        else:
            os.close(os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        with suppress(BlockingIOError, FileNotFoundError):  # another process has taken it for abandoned
            descriptor = lock(path)
            break
    try:
        yield path
    finally:
        if descriptor is not None:
            os.close(descriptor)


def remove_abandoned(folder: Path) -> None:
    """Remove the temporary files and folders that killed processes have left in ``folder``."""
    for path in abandoned(folder, WRITING):
        remove(path)


def in_use(folder: Path) -> bool:
    """Return whether another process writes to a temporary file or folder in ``folder``; remove abandoned ones before."""
    remove_abandoned(folder)
    return any(folder.glob(f"{WRITING}{'[0-9a-f]' * DIGITS}*"))


def abandoned(folder: Path, prefix: str) -> Iterator[Path]:
    """Yield what `new_locked` made with ``prefix`` in a folder and a killed process has left, locked until the next one."""
    with suppress(OSError):
        for path in sorted(folder.glob(f"{prefix}{'[0-9a-f]' * DIGITS}*")):
            with suppress(OSError):
                descriptor = lock(path)
                if descriptor is not None or time.time() - path.stat().st_mtime > ABANDONED:
                    yield path
                if descriptor is not None:
                    os.close(descriptor)


def remove(path: Path) -> None:
    """Remove a file or a folder, as far as possible."""
    with suppress(OSError):
        shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)


def lock(path: Path) -> int | None:
    """Return the descriptor of a file or folder that is locked; None where it cannot be locked.

    Raises:
        BlockingIOError: another process has locked it.
        FileNotFoundError: another process has removed it.
    """
    if fcntl is None:
        return None
    descriptor = os.open(path, os.O_RDONLY)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if os.path.samestat(os.fstat(descriptor), os.stat(path)):
            return descriptor
        raise FileNotFoundError
    except OSError as error:
        os.close(descriptor)
        if isinstance(error, (BlockingIOError, FileNotFoundError)):
            raise
        return None
