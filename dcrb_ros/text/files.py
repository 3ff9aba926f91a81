"""Files from outside: only regular ones are opened, and texts are read up to a limit."""

from __future__ import annotations

import os
import stat
from pathlib import Path
from typing import BinaryIO

from dcrb_ros.schema.refusal import Refusal

LARGEST_TEXT = 1_000_000
"""Largest text file that is read unless another limit is given [bytes]; typical ones have a few hundred."""
KINDS = {
    stat.S_IFDIR: "a folder",
    stat.S_IFIFO: "a named pipe",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFSOCK: "a socket",
}
"""Kinds of entries of a folder that are not regular files."""


class Unreadable(Refusal):
    """The operating system does not read a file, now or for this user; its content may be sound."""


def checked_path(path: str | Path) -> Path:
    """Return a path that the file system can represent, whether something exists there or not.

    Raises:
        Refusal: it contains a NUL or a surrogate, a name in it is too long, or a folder in it may not be entered.
    """
    checked = Path(path)
    try:
        os.lstat(checked)
    except ValueError as error:
        raise Refusal(f"{checked} is not a path ({error}): give the name of a file or folder") from None
    except OSError as error:
        if isinstance(error, PermissionError):
            raise Refusal(f"{checked} cannot be used: {error.strerror}; make its folder accessible, or give another path") from None
        if not isinstance(error, FileNotFoundError | NotADirectoryError):
            raise Refusal(f"{checked} cannot be used: {error.strerror}; give another path") from None
    return checked


def expanded_path(path: str) -> Path:
    """Return a path in which ``~`` or ``~user`` at the beginning is a home folder, for a text that no shell has expanded.

    Raises:
        Refusal: there is no such user, or see `checked_path`.
    """
    expanded = os.path.expanduser(path)
    if expanded.startswith("~"):
        raise Refusal(f"{path} begins with the home folder of an unknown user: give the whole path, or ./ before a name with ~")
    return checked_path(expanded)


def special_kind(path: Path) -> str:
    """Return the kind of an entry that is not a regular file, such as a named pipe; the empty string for a regular file or none."""
    try:
        return KINDS.get(stat.S_IFMT(os.stat(path).st_mode), "")
    except OSError:
        return ""


def is_file(path: Path) -> bool:
    """Return whether a path is a file; a folder may have the name of something shipped, and nothing may exist there.

    Raises:
        Refusal: it is a named pipe, a device or a socket.
    """
    if (kind := special_kind(path)) and kind != KINDS[stat.S_IFDIR]:
        raise Refusal(f"{path} is {kind}: give a regular file")
    return path.is_file()


def open_regular(path: Path) -> BinaryIO:
    """Return a regular file opened for reading; a pipe or a device, which may never end, is not read.

    Raises:
        Refusal: the path is not a regular file.
        Unreadable: it cannot be read.
    """
    try:
        # Without this flag, opening a pipe would wait for a writer.
        descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0))
    except ValueError as error:
        raise Refusal(f"{path} is not a path ({error}): give the name of a file") from None
    except OSError as error:
        raise Unreadable(f"{path} cannot be read: {error.strerror}") from None
    kind = stat.S_IFMT(os.fstat(descriptor).st_mode)
    if kind != stat.S_IFREG:
        os.close(descriptor)
        raise Refusal(f"{path} is {KINDS.get(kind, 'not a file')}: give a regular file")
    return os.fdopen(descriptor, "rb")


def check_regular(path: Path) -> None:
    """Refuse a path that `open_regular` refuses."""
    open_regular(path).close()


def read_bytes(path: Path, largest: int) -> bytes:
    """Return the content of a file of at most ``largest`` bytes.

    Raises:
        Refusal: the path is not a regular file, or it is too large.
        Unreadable: it cannot be read.
    """
    with open_regular(path) as stream:
        size = os.fstat(stream.fileno()).st_size
        try:
            # A file that is being written, or one of the kernel, has more bytes than its size says.
            data = b"" if size > largest else stream.read(largest + 1)
        except OSError as error:
            raise Unreadable(f"{path} cannot be read: {error.strerror}") from None
    if max(size, len(data)) > largest:
        raise Refusal(f"{path} has {max(size, len(data))} bytes; at most {largest} are read")
    return data


def read_text(path: Path, largest: int = LARGEST_TEXT) -> str:
    """Return the text of a file of at most ``largest`` bytes.

    Raises:
        Refusal: the path is not a regular file, or it cannot be read, is too large or is not UTF-8.
    """
    data = read_bytes(path, largest)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise Refusal(f"{path} is not a text file: byte {error.start} is not UTF-8; save it as UTF-8") from None
