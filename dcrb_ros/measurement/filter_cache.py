"""Results cached on disk beside the compiled kernels: importing scipy takes longer than everything else at a start.

These are the designs of filters, the static equilibrium, the weights of the contacts, and the impulse response of the housing. A kernel
needs 0.03 s for the response of 5000 modes.
"""

from __future__ import annotations

import functools
import hashlib
import inspect
import io
import itertools
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

MOST_RESULTS = 256
"""Files in the cache of one function; the oldest are removed [-]."""
MOST_BYTES = 8_000_000
"""Size of these files together [bytes]."""

P = ParamSpec("P")


def cached_on_disk(design: Callable[P, Floats]) -> Callable[P, Floats]:
    """Cache the result of a function that depends on its arguments alone; a cached result has the same bits.

    The file name is a hash of the arguments, the versions of numpy and scipy and the sources that compute it, so that no result is stale.
    """

    sources = Path(inspect.getfile(design)).parent

    @functools.wraps(design)
    def cached(*args: P.args, **kwargs: P.kwargs) -> Floats:
        name = hashlib.sha256(_versions(sources) + pickle.dumps((design.__qualname__, args, kwargs), protocol=5)).hexdigest()
        path = folder() / f"{design.__name__}-{name[:32]}.npy"
        with suppress(OSError, ValueError, EOFError):
            return _read(path)
        made = design(*args, **kwargs)
        with suppress(OSError):
            _write(made, path)
            _keep_newest(path.parent, f"{design.__name__}-*.npy")
        return made

    return cached


def cached_at_start(calls: int) -> Callable[[Callable[P, Floats]], Callable[P, Floats]]:
    """Return a decorator that caches the results of the first calls of a process on disk.

    A start that finds them needs no scipy. A worker that simulates many bearings computes the others, which takes no longer than writing
    them, and leaves no file for each.
    """

    def decorate(compute: Callable[P, Floats]) -> Callable[P, Floats]:
        from_disk, number = cached_on_disk(compute), itertools.count()

        @functools.wraps(compute)
        def cached(*args: P.args, **kwargs: P.kwargs) -> Floats:
            return (from_disk if next(number) < calls else compute)(*args, **kwargs)

        return cached

    return decorate


def _read(path: Path) -> Floats:
    """Return the result in a file.

    Raises:
        OSError: the file does not exist, or is not as it was written.
    """
    from dcrb_ros.core.signed_file import read_signed

    return np.asarray(np.load(io.BytesIO(read_signed(path))), dtype=float)


def folder() -> Path:
    """Return the folder of the cache."""
    # The configuration imports this module for its limits, and the core imports numba.
    from dcrb_ros.core import CACHE

    return CACHE / "filters"


@functools.cache
def _versions(sources: Path) -> bytes:
    """Return a hash of the versions of numpy and scipy and of the sources in a folder; the core's are in the name of the cache's folder."""
    digest = hashlib.sha256(f"{scipy.__version__} {np.__version__}".encode())
    for source in sorted({*sources.rglob("*.py"), *Path(__file__).parent.rglob("*.py")}):
        digest.update(source.read_bytes())
    return digest.digest()


def _keep_newest(cache: Path, pattern: str) -> None:
    """Remove all but the newest files of a pattern, as many and as large as the limits allow."""
    files = sorted(cache.glob(pattern), key=lambda file: file.stat().st_mtime, reverse=True)
    sizes = itertools.accumulate(file.stat().st_size for file in files)
    for number, (file, size) in enumerate(zip(files, sizes, strict=True)):
        if number >= MOST_RESULTS or size > MOST_BYTES:
            file.unlink(missing_ok=True)


def _write(made: Floats, path: Path) -> None:
    """Write a result and rename the file into place, because another process may read it at the same time."""
    from dcrb_ros.core.signed_file import signed

    path.parent.mkdir(exist_ok=True)
    stream = io.BytesIO()
    np.save(stream, made)
    handle, name = tempfile.mkstemp(dir=path.parent)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(signed(path, stream.getvalue()))
            file.flush()
            os.fsync(handle)
        Path(name).replace(path)
    except BaseException:
        Path(name).unlink()
        raise
