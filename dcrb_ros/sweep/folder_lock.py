"""The lock of a data set's folder, so that only one command at a time writes to it."""

from __future__ import annotations

import contextlib
import os
import platform
from collections.abc import Iterator
from pathlib import Path

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.writing import remedy_of

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

LOCK = ".lock"
"""File that exists while a command writes to the folder. It contains the process id and the name of the machine."""


@contextlib.contextmanager
def locked(folder: Path | None) -> Iterator[None]:
    """Lock a folder, which is made if it does not exist; the lock ends with the process, however it ends.

    An address without a folder on this machine (None) and a system without file locks (Windows) are not locked.

    Raises:
        Refusal: another process holds the lock, or the folder cannot be made or locked.
    """
    if folder is None or fcntl is None:
        yield
        return
    path = folder / LOCK
    try:
        folder.mkdir(parents=True, exist_ok=True)
        descriptor = _held(path)
    except FileExistsError:
        raise Refusal(f"{folder} cannot be read: Not a directory; give an empty or a new folder") from None
    except OSError as error:
        raise Refusal(f"{folder} cannot be written: {error.strerror}; {remedy_of(error)}, or give another folder") from None
    try:
        yield
    finally:
        path.unlink(missing_ok=True)
        os.close(descriptor)


def _held(path: Path) -> int:
    """Return the descriptor of a lock file that this process has locked."""
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            # The process that held it removes the file before it releases the lock, so this may be a file without a name.
            if _lies_at(path, descriptor):
                try:
                    os.ftruncate(descriptor, 0)
                    os.write(descriptor, f"{os.getpid()} on {platform.node()}".encode())
                except OSError:  # a full disk has room for the empty file only
                    path.unlink(missing_ok=True)
                    raise
                return descriptor
        except BlockingIOError:
            holder = os.read(descriptor, 200).decode(errors="replace") or "of another command"
            os.close(descriptor)
            raise Refusal(
                f"{path.parent} is being written by the process {holder}: wait until it has ended, stop it, or give another folder"
            ) from None
        except BaseException:
            os.close(descriptor)
            raise
        os.close(descriptor)


def _lies_at(path: Path, descriptor: int) -> bool:
    """Return whether an open file is the one that has a name now."""
    try:
        return os.path.samestat(os.fstat(descriptor), os.stat(path))
    except FileNotFoundError:
        return False
