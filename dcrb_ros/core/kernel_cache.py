"""The files of compiled kernels with checksums: numba would execute what a damaged file contains."""

from __future__ import annotations

import io
import os
import pickle
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from numba.core.caching import IndexDataCacheFile

from dcrb_ros.core.announcement import announce_damage
from dcrb_ros.core.signed_file import DamagedFile, read_signed, signed


class CheckedCacheFile(IndexDataCacheFile):
    """Index and kernels of a function. A file that is not as it was written is announced, and the kernel is compiled again."""

    @contextmanager
    def _open_for_write(self, filepath: str) -> Iterator[io.BytesIO]:
        content = io.BytesIO()
        yield content
        with super()._open_for_write(filepath) as file:
            file.write(signed(filepath, content.getvalue()))

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
    """Return the content of a file without its digest; announce a damaged one.

    Raises:
        OSError: it does not exist, cannot be read, or is damaged.
    """
    try:
        return read_signed(path)
    except DamagedFile:
        announce_damage(path)
        raise
