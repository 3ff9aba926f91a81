"""Where a data set lies: a folder or any address that fsspec knows; files appear in it whole or not at all."""

from __future__ import annotations

import errno
import functools
import os
import shutil
import uuid
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from dcrb_ros.runtime.refusal import Refusal

PART = ".part-"
"""How the name of what is not yet whole begins."""


class StoreFailed(RuntimeError):
    """Writing failed, on a full disk say; the sweep ends and can go on later."""


class Store:
    """A place for files with names such as ``labels/0123.json``."""

    def __init__(self, address: str) -> None:
        """Open a folder or an address.

        Raises:
            Refusal: an address of a kind that is unknown, or whose package is not installed.
        """
        self.address = address if "://" in address else str(Path(address).absolute())
        try:
            _ = self._place
        except (ValueError, ImportError) as error:
            raise Refusal(
                f"{address} is no place for a data set: {error}; give a folder, or an address such as s3://bucket/folder"
            ) from None

    def __getstate__(self) -> dict[str, Any]:
        """A connection stays where it is."""
        return {"address": self.address}

    @functools.cached_property
    def _place(self) -> tuple[Any, str]:
        from fsspec.core import url_to_fs

        files, root = url_to_fs(self.address)
        return files, str(root).rstrip("/")

    @property
    def folder(self) -> Path | None:
        """The folder on this machine; none at an address elsewhere."""
        files, root = self._place
        return Path(root) if "file" in ([files.protocol] if isinstance(files.protocol, str) else files.protocol) else None

    def path(self, name: str) -> str:
        """Return where a file lies, as fsspec says it."""
        return f"{self._place[1]}/{name}"

    def write(self, name: str, data: bytes) -> None:
        """Write a file, or write it anew.

        Raises:
            StoreFailed: there is no room, or the place cannot be written.
        """
        try:
            if self.folder is None:
                self._place[0].pipe_file(self.path(name), data)
                return
            target = self.folder / name
            target.parent.mkdir(parents=True, exist_ok=True)
            part = target.parent / f"{PART}{uuid.uuid4().hex}"
            try:
                part.write_bytes(data)
                os.replace(part, target)
            except BaseException:
                part.unlink(missing_ok=True)
                raise
        except OSError as error:
            raise self._failed(error) from None

    def put(self, source: Path, name: str) -> None:
        """Move a folder of this machine into the place; see `write`."""
        try:
            if self.folder is None:
                for path in sorted(source.iterdir()):
                    self._place[0].put_file(str(path), self.path(f"{name}/{path.name}"))
                shutil.rmtree(source)
                return
            target = self.folder / name
            shutil.rmtree(target, ignore_errors=True)
            target.parent.mkdir(parents=True, exist_ok=True)
            os.replace(source, target)
        except OSError as error:
            raise self._failed(error) from None

    def read(self, name: str) -> bytes | None:
        """Return what a file holds; none where there is no such file."""
        try:
            data: bytes = self._place[0].cat_file(self.path(name))
            return data
        except FileNotFoundError:
            return None

    def remove(self, name: str) -> None:
        """Remove a file, if it is there."""
        if self._place[0].exists(self.path(name)):
            self._place[0].rm_file(self.path(name))

    def exists(self, name: str) -> bool:
        """Return whether there is a file."""
        return bool(self._place[0].exists(self.path(name)))

    def names(self, folder: str) -> Iterator[str]:
        """Yield the names of the files in a folder of the place; none where it is not there."""
        files = self._place[0]
        files.invalidate_cache()
        try:
            found = files.ls(self.path(folder) if folder else self._place[1], detail=False)
        except FileNotFoundError:
            return
        for path in found:
            name = str(path).rstrip("/").rsplit("/", 1)[-1]
            if not name.startswith(PART):
                yield name

    def sweep_up(self) -> None:
        """Remove what an interrupted run left unfinished."""
        if self.folder is not None and self.folder.is_dir():
            for part in self.folder.rglob(f"{PART}*"):
                shutil.rmtree(part, ignore_errors=True) if part.is_dir() else part.unlink(missing_ok=True)

    def _failed(self, error: OSError) -> StoreFailed:
        why = error.strerror or str(error)
        remedy = "make room" if error.errno in (errno.ENOSPC, errno.EDQUOT) else "give a place that can be written"
        return StoreFailed(f"{self.address} cannot be written: {why}; {remedy} and call the command again, it goes on from there")
