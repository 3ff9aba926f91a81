"""The physics as numba kernels: floats, arrays and named tuples in, nothing validated, nothing allocated in the loop.

Importing this package chooses the folder of the compile cache, so it must come before any kernel. Numba's own cache does
not notice that a kernel in another file has changed; a folder named by a hash of all kernel sources cannot be stale.
"""

from __future__ import annotations

import hashlib
import os
import platform
import tempfile
from pathlib import Path

import numba
import platformdirs


def _cache_folder() -> Path:
    digest = hashlib.sha256(f"{numba.__version__} {platform.python_version()}".encode())
    for source in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(source.read_bytes())
    return Path(platformdirs.user_cache_dir("dcrb_ros")) / f"kernels-{digest.hexdigest()[:16]}"


def _choose_cache() -> Path:
    if "NUMBA_CACHE_DIR" in os.environ:
        return Path(os.environ["NUMBA_CACHE_DIR"])
    folder = _cache_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if not os.access(folder, os.W_OK):
            raise PermissionError
    except OSError:
        # Without a home that can be written numba would refuse to import the kernels at all.
        folder = Path(tempfile.mkdtemp(prefix="dcrb_ros-kernels-"))
    setattr(numba.config, "CACHE_DIR", str(folder))  # noqa: B010 - numba's configuration is untyped
    return folder


CACHE = _choose_cache()


def compiled() -> bool:
    """Return whether the time loop lies compiled in the cache, so that it starts at once."""
    return any(CACHE.rglob("step.advance-*.nbc"))
