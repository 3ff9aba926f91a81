"""The physics as numba kernels: floats, arrays and named tuples in, nothing validated, nothing allocated in the loop.

Importing this package chooses the folder of the compile cache, so it must come before any kernel. Numba's own cache does
not notice that a kernel in another file has changed; a folder named by a hash of all kernel sources cannot be stale. The hash includes
their path and the processor, because numba compiles anew for others. A user's NUMBA_CACHE_DIR gets such a folder, too. Each folder names
the sources from which it was made. When they have changed, or are gone, the folder is removed an hour after its last use.
"""

from __future__ import annotations

import hashlib
import os
import platform
import shutil
import stat
import tempfile
import time
from pathlib import Path

import llvmlite.binding
import numba
import platformdirs

from dcrb_ros.core.blas_check import assume_blas


def _folder_name() -> str:
    sources = Path(__file__).resolve().parent
    versions = f"{numba.__version__} {platform.python_version()} {llvmlite.binding.get_host_cpu_name()}"
    digest = hashlib.sha256(f"{versions} {sources}".encode())
    for source in sorted(sources.rglob("*.py")):
        digest.update(source.read_bytes())
    return f"kernels-{digest.hexdigest()[:16]}"


def _own_temporary_folder() -> Path:
    """Return a folder for temporary files that is this user's alone, the same in every process."""
    user: int = os.getuid() if hasattr(os, "getuid") else 0
    folder = Path(tempfile.gettempdir(), f"dcrb_ros-{user}")
    folder.mkdir(mode=0o700, exist_ok=True)
    status = folder.lstat()
    # What lies there is executed: nobody else may have made it, or write into it.
    if not stat.S_ISDIR(status.st_mode) or status.st_uid != user or (os.name == "posix" and status.st_mode & 0o022):
        raise PermissionError
    return folder


def _made(folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    if not os.access(folder, os.W_OK):
        raise PermissionError
    return folder


SOURCES = "sources"
"""File of a folder with the path of the sources; touched at every start."""
UNUSED_FOR = 3600.0
"""Time after its last use at which the folder of an earlier version is removed [s]: processes that run with it may still read it."""


def _remove_earlier(folder: Path) -> None:
    """Note the use of a folder; when it is new, remove those of earlier versions of the same sources, and of sources that are gone."""
    sources = str(Path(__file__).resolve().parent)
    try:
        if (folder / SOURCES).exists():
            os.utime(folder / SOURCES)
            return
        (folder / SOURCES).write_text(sources)
        for mark in folder.parent.glob(f"kernels-*/{SOURCES}"):
            made_from = mark.read_text()
            earlier = made_from == sources or not Path(made_from).exists()
            if mark.parent != folder and earlier and time.time() - mark.stat().st_mtime > UNUSED_FOR:
                shutil.rmtree(mark.parent, ignore_errors=True)
    except OSError:  # another process removes them, or the disk is full: nothing that keeps kernels from running
        return


def _choose_cache() -> Path:
    name = _folder_name()
    if chosen := os.environ.get("NUMBA_CACHE_DIR"):
        folder = _made(Path(chosen) / name)
    else:
        # Without a folder that can be written numba would refuse to import the kernels at all.
        try:
            folder = _made(Path(platformdirs.user_cache_dir("dcrb_ros")).expanduser() / name)
        except (OSError, RuntimeError):  # the latter where a user has no home at all
            try:
                folder = _made(_own_temporary_folder() / name)
            except OSError:
                folder = _made(Path(tempfile.mkdtemp(prefix="dcrb_ros-kernels-")) / name)
    _remove_earlier(folder)
    setattr(numba.config, "CACHE_DIR", str(folder))  # noqa: B010 - numba's configuration is untyped
    return folder


CACHE = _choose_cache()
assume_blas()


def compiled() -> bool:
    """Return whether the time loop lies compiled in the cache, so that it starts at once."""
    return any(CACHE.rglob("step.advance-*.nbc"))
