"""Storage of a data set: a folder or any fsspec address; a file appears under its name only when it is complete."""

from __future__ import annotations

import errno
import functools
import hashlib
import os
import shutil
import uuid
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TypedDict

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.sweep.folder_lock import LOCK
from dcrb_ros.text.files import Unreadable, checked_path, read_bytes
from dcrb_ros.text.writing import remedy_of, sync

LARGEST_FILE = 16 * 1024 * 1024
"""Largest label or description that is read [bytes]."""
PART = ".part-"
"""Prefix of the names of unfinished files."""
CHUNK = 1 << 20
"""Bytes that are hashed at once [-]."""
READ_AGAIN = "make it readable and run the same command again to continue"
"""Remedy for a file that cannot be read."""


class StoreFailed(RuntimeError):
    """Reading or writing failed, for example on a full disk; the sweep stops and can be continued later."""


class FileRecord(TypedDict):
    """A file as it was written."""

    size: int
    """Size [byte]."""
    sha256: str


def file_record(data: bytes) -> FileRecord:
    """Return the record of a file with these contents."""
    return {"size": len(data), "sha256": hashlib.sha256(data).hexdigest()}


def record_of(path: Path) -> FileRecord:
    """Return the record of a file of any size in a folder of this machine."""
    digest = hashlib.sha256()
    with path.open("rb") as file:
        while data := file.read(CHUNK):
            digest.update(data)
        return {"size": file.tell(), "sha256": digest.hexdigest()}


class Store:
    """Storage for files with names such as ``labels/0123.json``.

    Raises:
        StoreFailed: a file cannot be read or written now, or there is no space left; of all methods.
    """

    def __init__(self, address: str) -> None:
        """Open a folder or an address.

        Raises:
            Refusal: the protocol of the address is unknown, or its package is not installed.
        """
        self.address = address if "://" in address else str(checked_path(address).absolute())
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

        if "::" in self.address and "://" not in self.address:  # fsspec takes these colons for a chain of addresses
            from fsspec.implementations.local import LocalFileSystem

            return LocalFileSystem(), str(Path(self.address).absolute())
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

    def write(self, name: str, data: bytes) -> FileRecord:
        """Write a file, which replaces one of that name, and return its record."""
        try:
            if self.folder is None:
                self._filesystem[0].pipe_file(self.path(name), data)
                return file_record(data)
            target = self.folder / name
            target.parent.mkdir(parents=True, exist_ok=True)
            part = target.parent / f"{PART}{uuid.uuid4().hex}"
            try:
                part.write_bytes(data)
                sync(part)
                os.replace(part, target)
                sync(target.parent)
            except BaseException:
                part.unlink(missing_ok=True)
                raise
            return file_record(data)
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
            target.parent.mkdir(parents=True, exist_ok=True)
            for path in (*sorted(source.iterdir()), source):
                sync(path)
            try:
                _replace_folder(source, target)
            except OSError as error:
                if error.errno != errno.ENOTEMPTY:
                    raise
                _replace_folder(source, target)  # another worker has put its folder meanwhile
            sync(target.parent)
        except OSError as error:
            raise self._failed(error) from None

    def read(self, name: str) -> bytes | None:
        """Return the contents of a file; None if it does not exist.

        Raises:
            Refusal: it is not a regular file, or it is too large.
        """
        try:
            if self.folder is not None:
                return None if not (self.folder / name).exists() else read_bytes(self.folder / name, LARGEST_FILE)
            data: bytes = self._filesystem[0].cat_file(self.path(name), end=LARGEST_FILE + 1)
        except FileNotFoundError:
            return None
        except OSError as error:
            raise self._unreadable(name, error) from None
        except Unreadable as unreadable:
            raise StoreFailed(f"{unreadable}; {READ_AGAIN}") from None
        if len(data) > LARGEST_FILE:
            raise Refusal(f"{self.path(name)} has more than {LARGEST_FILE} bytes")
        return data

    def size(self, name: str) -> int | None:
        """Return the size of a file [byte]; None if it does not exist."""
        try:
            entry = self._filesystem[0].info(self.path(name))
        except (FileNotFoundError, NotADirectoryError):
            return None
        except OSError as error:
            raise self._unreadable(name, error) from None
        return int(entry["size"]) if entry["type"] == "file" else None

    def sha256(self, name: str, *, remote: bool = False) -> str | None:
        """Return the SHA-256 of a file; None for a remote address, from which the file is transferred with ``remote`` only."""
        try:
            if self.folder is not None:
                return record_of(self.folder / name)["sha256"]
            return hashlib.sha256(self._filesystem[0].cat_file(self.path(name))).hexdigest() if remote else None
        except OSError as error:
            raise self._unreadable(name, error) from None

    def remove(self, name: str) -> None:
        """Remove a file if it exists, or a folder of that name."""
        try:
            if self._filesystem[0].exists(self.path(name)):
                self._filesystem[0].rm(self.path(name), recursive=True)
        except OSError as error:
            raise self._failed(error) from None

    def names(self, folder: str) -> Iterator[str]:
        """Yield the names of the files in a folder of the store; nothing if the folder does not exist."""
        files = self._filesystem[0]
        files.invalidate_cache()
        try:
            paths = files.ls(self.path(folder) if folder else self._filesystem[1], detail=False)
        except FileNotFoundError:
            return
        for path in paths:
            name = str(path).rstrip("/").rsplit("/", 1)[-1]
            if not name.startswith(PART) and name != LOCK:
                yield name

    def remove_unfinished(self) -> None:
        """Remove the unfinished files of an interrupted run."""
        if self.folder is not None and self.folder.is_dir():
            for part in self.folder.rglob(f"{PART}*"):
                shutil.rmtree(part, ignore_errors=True) if part.is_dir() else part.unlink(missing_ok=True)

    def _unreadable(self, name: str, error: OSError) -> StoreFailed:
        return StoreFailed(f"{self.path(name)} cannot be read: {error.strerror or error}; {READ_AGAIN}")

    def _failed(self, error: OSError) -> StoreFailed:
        reason = error.strerror or str(error)
        return StoreFailed(f"{self.address} cannot be written: {reason}; {remedy_of(error)} and run the same command again to continue")


def _replace_folder(source: Path, target: Path) -> None:
    shutil.rmtree(target, ignore_errors=True)
    os.replace(source, target)


def local_folder(address: str | Path) -> Path:
    """Return the path that a path or an address such as ``file:///data/bearings`` has on this machine.

    Raises:
        Refusal: the address is remote or unknown.
    """
    if "://" not in str(address):
        return checked_path(address)
    if (folder := Store(str(address)).folder) is None:
        raise Refusal(f"{address} is not on this machine: give a folder on it, to which the files are copied")
    return folder
