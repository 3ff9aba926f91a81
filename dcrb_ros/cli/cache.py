"""`dcrb cache`: the files that dcrb keeps outside of the user's folders."""

from __future__ import annotations

import errno
import os
import shutil
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Annotated

import typer

from dcrb_ros.cli.options import JsonOutput, size_text
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.json import json_text
from dcrb_ros.text.temporary import in_use

ATTEMPTS = 10
"""How often a folder is removed to which another command is writing."""
WRITTEN = "{} cannot be deleted, because another command writes to it: wait until it has ended, and repeat"


def cache(
    clear: Annotated[bool, typer.Option("--clear", help="Delete the files. They are made again when they are needed.")] = False,
    as_json: JsonOutput = False,
) -> None:
    """Print or delete the caches: compiled kernels and recordings of exams.

    Uninstalling the package leaves them behind, so clear them before.

    Example: dcrb cache --clear
    """
    folders = {path: _size(path) for path in _folders()}
    sizes = {path: size for path, size in folders.items() if size}  # importing the kernels makes empty folders
    if clear:
        if used := next((path for path in folders if in_use(path)), None):
            raise Refusal(WRITTEN.format(used))
        for path in folders:
            _remove(path)
    if as_json:
        kept = [{"path": str(path), "bytes": size} for path, size in sizes.items()]
        print(json_text({"folders": kept, "cleared": clear}))
        return
    for path, size in sizes.items():
        print(f"{path}: {size_text(size)}{' deleted' if clear else ''}")
    if not sizes:
        print("the caches are empty")


def _size(folder: Path) -> int:
    """Return the size of the files in a folder, without the mark of new kernels and files that another command removes meanwhile [B]."""
    from dcrb_ros.core import SOURCES

    size = 0
    for place, _, names in os.walk(folder):
        for name in set(names) - {SOURCES}:
            with suppress(FileNotFoundError):
                size += os.stat(os.path.join(place, name)).st_size
    return size


def _remove(folder: Path) -> None:
    """Remove a cache folder; of a link, which moves it to another disk, only the contents, so that the link remains valid.

    Raises:
        Refusal: it cannot be removed, or another command keeps writing to it.
    """
    for _ in range(ATTEMPTS):
        try:
            for entry in folder.iterdir() if folder.is_symlink() else (folder,):
                if entry.is_dir() and not entry.is_symlink():
                    shutil.rmtree(entry)
                else:
                    entry.unlink()
        except FileNotFoundError:  # another command has removed a part of it, or the whole
            if not folder.is_dir():
                return
        except OSError as error:
            if error.errno != errno.ENOTEMPTY:
                raise Refusal(f"{folder} cannot be deleted: {error.strerror}; make it and its contents writable, and repeat") from None
        else:
            return
    raise Refusal(WRITTEN.format(folder))


def _folders() -> Iterator[Path]:
    """Yield the cache folders that exist."""
    from dcrb_ros.core import CACHE
    from dcrb_ros.exam.recording_cache import default_folder

    for path in (*sorted(CACHE.parent.glob("kernels-*")), default_folder()):
        if path.is_dir():
            yield path
