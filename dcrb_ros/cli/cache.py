"""`dcrb cache`: the files that dcrb keeps outside of the user's folders."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import typer

from dcrb_ros.cli.options import JsonOutput, size_text


def cache(
    clear: Annotated[bool, typer.Option("--clear", help="Delete the files. They are made again when they are needed.")] = False,
    as_json: JsonOutput = False,
) -> None:
    """Print or delete the caches: compiled kernels and recordings of exams.

    Uninstalling the package leaves them behind, so clear them before.

    Example: dcrb cache --clear
    """
    folders = {path: sum(file.stat().st_size for file in path.rglob("*") if file.is_file()) for path in _folders()}
    sizes = {path: size for path, size in folders.items() if size}  # numba makes empty folders when it is imported
    if clear:
        for path in folders:
            _remove(path)
    if as_json:
        kept = [{"path": str(path), "bytes": size} for path, size in sizes.items()]
        print(json.dumps({"folders": kept, "cleared": clear}, indent=2))
        return
    for path, size in sizes.items():
        print(f"{path}: {size_text(size)}{' deleted' if clear else ''}")
    if not sizes:
        print("the caches are empty")


def _remove(folder: Path) -> None:
    """Remove a cache folder; of a link, which moves it to another disk, only the contents, so that the link remains valid."""
    if not folder.is_symlink():
        shutil.rmtree(folder)
        return
    for entry in folder.iterdir():
        if entry.is_dir() and not entry.is_symlink():
            shutil.rmtree(entry)
        else:
            entry.unlink()


def _folders() -> Iterator[Path]:
    """Yield the cache folders that exist."""
    from dcrb_ros.core import CACHE
    from dcrb_ros.exam.recording_cache import default_folder

    for path in (*sorted(CACHE.parent.glob("kernels-*")), default_folder()):
        if path.is_dir():
            yield path
