"""Filter designs cached on disk beside the compiled kernels: importing scipy.signal takes a quarter of the start-up time."""

from __future__ import annotations

import functools
import hashlib
import os
import pickle
import tempfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import ParamSpec

import numpy as np
import scipy

from dcrb_ros.schema.arrays import Floats

P = ParamSpec("P")


def cached_on_disk(design: Callable[P, Floats]) -> Callable[P, Floats]:
    """Cache the result of a function that depends on its arguments alone; a cached result has the same bits.

    The file name is a hash of the arguments, the versions of numpy and scipy and the sources of this package, so that no result is stale.
    """

    @functools.wraps(design)
    def cached(*args: P.args, **kwargs: P.kwargs) -> Floats:
        name = hashlib.sha256(_versions() + pickle.dumps((design.__qualname__, args, kwargs), protocol=5)).hexdigest()
        path = folder() / f"{design.__name__}-{name[:32]}.npy"
        with suppress(OSError, ValueError, EOFError):
            return np.asarray(np.load(path), dtype=float)
        made = design(*args, **kwargs)
        with suppress(OSError):
            _write(made, path)
        return made

    return cached


def folder() -> Path:
    """Return the folder of the cache."""
    # The configuration imports this module for its limits, and the core imports numba.
    from dcrb_ros.core import CACHE

    return CACHE / "filters"


@functools.cache
def _versions() -> bytes:
    digest = hashlib.sha256(f"{scipy.__version__} {np.__version__}".encode())
    for source in sorted(Path(__file__).parent.rglob("*.py")):
        digest.update(source.read_bytes())
    return digest.digest()


def _write(made: Floats, path: Path) -> None:
    """Write a result and rename the file into place, because another process may read it at the same time."""
    path.parent.mkdir(exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent)
    try:
        with os.fdopen(handle, "wb") as file:
            np.save(file, made)
        Path(name).replace(path)
    except BaseException:
        Path(name).unlink()
        raise
