"""Kept files with a checksum: what is in one is executed or scored, so a file that was changed, cut, renamed or replaced is not used."""

from __future__ import annotations

import hashlib
import os
import shutil
from contextlib import suppress
from pathlib import Path

DIGEST_SIZE = 32
"""Bytes of the SHA-256 at the beginning of a file [-]."""


class DamagedFile(OSError):
    """A kept file is not as it was written, or cannot be read."""


def signed(path: str | Path, content: bytes) -> bytes:
    """Return a content after the hash of it and of the name of its file, so that a file under the name of another one is found."""
    return _digest(path, content) + content


def read_signed(path: str | Path) -> bytes:
    """Return the content of a file without its digest.

    A folder, a pipe or a link in place of a sound file is removed, so that the file can be written again, and nothing elsewhere instead.

    Raises:
        FileNotFoundError: there is no file.
        DamagedFile: the file cannot be read, or is not as it was written, or something else was in its place.
    """
    if not os.path.lexists(path):
        raise FileNotFoundError(f"{path} does not exist")
    reason = f"{path} is no file"
    if os.path.isfile(path):  # a pipe would be waited for
        try:
            written = Path(path).read_bytes()
            content = written[DIGEST_SIZE:]
            if written[:DIGEST_SIZE] == _digest(path, content):
                return content
            reason = f"{path} is damaged, or was written under another name"
        except OSError as error:
            reason = f"{path} cannot be read: {error.strerror}"
    with suppress(OSError):
        if os.path.islink(path) or not (os.path.isfile(path) or os.path.isdir(path)):
            os.unlink(path)
        elif os.path.isdir(path):
            shutil.rmtree(path, ignore_errors=True)
    raise DamagedFile(reason)


def _digest(path: str | Path, content: bytes) -> bytes:
    return hashlib.sha256(os.path.basename(path).encode() + content).digest()
