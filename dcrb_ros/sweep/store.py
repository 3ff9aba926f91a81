"""Storage of a data set: a folder or any fsspec address; a file appears under its name only when it is complete."""

from __future__ import annotations

import errno
import functools
import os
import shutil
import uuid
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from dcrb_ros.schema.refusal import Refusal

PART = ".part-"
"""Prefix of the names of unfinished files."""


class StoreFailed(RuntimeError):
    """Writing failed, for example on a full disk; the sweep stops and can be continued later."""


class Store:
    """Storage for files with names such as ``labels/0123.json``."""

    def __init__(self, address: str) -> None:
        """Open a folder or an address.

        Raises:
            Refusal: the protocol of the address is unknown, or its package is not installed.
        """
        self.address = address if "://" in address else str(Path(address).absolute())
        try:
            _ = self._filesystem
        except (ValueError, ImportError) as error:
            raise Refusal(
                f"{address} cannot be used for a data set: {error}; give a folder, or an address such as s3://bucket/folder"
            ) from None

    def __getstate__(self) -> dict[str, Any]:
        """Pickle the address only; the connection cannot be transferred."""
        return {"address": self.address}

    @functools.cached_property
    def _filesystem(self) -> tuple[Any, str]:
        from fsspec.core import url_to_fs

        files, root = url_to_fs(self.address)
        return files, str(root).rstrip("/")

    @property
    def folder(self) -> Path | None:
        """The folder on this machine; None for a remote address."""
        files, root = self._filesystem
        return Path(root) if "file" in ([files.protocol] if isinstance(files.protocol, str) else files.protocol) else None

    def path(self, name: str) -> str:
        """Return the path of a file in the notation of fsspec."""
        return f"{self._filesystem[1]}/{name}"

    def write(self, name: str, data: bytes) -> None:
        """Write a file; replace it if it exists.

        Raises:
            StoreFailed: there is no space left, or the store cannot be written.
        """
        try:
            if self.folder is None:
                self._filesystem[0].pipe_file(self.path(name), data)
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
        """Move a local folder into the store; see `write`."""
        try:
            if self.folder is None:
                for path in sorted(source.iterdir()):
                    self._filesystem[0].put_file(str(path), self.path(f"{name}/{path.name}"))
                shutil.rmtree(source)
                return
            target = self.folder / name
            shutil.rmtree(target, ignore_errors=True)
            target.parent.mkdir(parents=True, exist_ok=True)
            os.replace(source, target)
        except OSError as error:
            raise self._failed(error) from None

    def read(self, name: str) -> bytes | None:
        """Return the contents of a file; None if it does not exist."""
        try:
            data: bytes = self._filesystem[0].cat_file(self.path(name))
            return data
        except FileNotFoundError:
            return None

    def remove(self, name: str) -> None:
        """Remove a file if it exists."""
        if self._filesystem[0].exists(self.path(name)):
            self._filesystem[0].rm_file(self.path(name))

    def exists(self, name: str) -> bool:
        """Return whether a file exists."""
        return bool(self._filesystem[0].exists(self.path(name)))

    def names(self, folder: str) -> Iterator[str]:
        """Yield the names of the files in a folder of the store; nothing if the folder does not exist."""
        files = self._filesystem[0]
        files.invalidate_cache()
        try:
            found = files.ls(self.path(folder) if folder else self._filesystem[1], detail=False)
        except FileNotFoundError:
            return
        for path in found:
            name = str(path).rstrip("/").rsplit("/", 1)[-1]
            if not name.startswith(PART):
                yield name

    def remove_unfinished(self) -> None:
        """Remove the unfinished files of an interrupted run."""
        if self.folder is not None and self.folder.is_dir():
            for part in self.folder.rglob(f"{PART}*"):
                shutil.rmtree(part, ignore_errors=True) if part.is_dir() else part.unlink(missing_ok=True)

    def _failed(self, error: OSError) -> StoreFailed:
        reason = error.strerror or str(error)
        remedy = "free some space" if error.errno in (errno.ENOSPC, errno.EDQUOT) else "make it writable"
        return StoreFailed(f"{self.address} cannot be written: {reason}; {remedy} and run the same command again to continue")
