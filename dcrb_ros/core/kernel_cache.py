"""The files of compiled kernels with checksums: numba would execute what a damaged file contains."""

from __future__ import annotations

import hashlib
import io
import os
import pickle
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from numba.core.caching import IndexDataCacheFile

from dcrb_ros.core.announcement import announce_damage

DIGEST_SIZE = 32
"""Bytes of the SHA-256 at the beginning of a file [-]."""


class CheckedCacheFile(IndexDataCacheFile):
    """Index and kernels of a function. A file that is not as it was written is announced, and the kernel is compiled again."""

    @contextmanager
    def _open_for_write(self, filepath: str) -> Iterator[io.BytesIO]:
        content = io.BytesIO()
        yield content
        with super()._open_for_write(filepath) as file:
            file.write(_digest(filepath, content.getvalue()) + content.getvalue())

    def _load_index(self) -> dict[Any, str]:
        try:
            content = io.BytesIO(_checked(self._index_path))
        except OSError:
            return {}
        if pickle.load(content) != self._version:
            return {}
        stamp, overloads = pickle.load(content)
        return overloads if stamp == self._source_stamp else {}

    def _load_data(self, name: str) -> Any:
        return pickle.loads(_checked(os.path.join(self._cache_path, name)))


def _checked(path: str) -> bytes:
    """Return the content of a file without its digest.

    Raises:
        OSError: it cannot be read, or is damaged.
    """
    written = Path(path).read_bytes()
    stated, content = written[:DIGEST_SIZE], written[DIGEST_SIZE:]
    if stated != _digest(path, content):
        announce_damage(path)
        raise OSError(f"{path} is damaged")
    return content


def _digest(path: str, content: bytes) -> bytes:
    """Return the hash of a content and of the name of its file, so that a file under the name of another one is found."""
    return hashlib.sha256(os.path.basename(path).encode() + content).digest()
