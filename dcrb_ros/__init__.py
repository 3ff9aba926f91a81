"""A simulated double-row cylindrical roller bearing for condition monitoring, as a ROS 2 package.

Every name of `__all__` is imported on first use, so that ``import dcrb_ros`` takes no time and needs neither numba nor ROS. The stub beside
this file lists them for type checkers and for this file.
"""

from __future__ import annotations

from importlib import import_module

from dcrb_ros.runtime.kernel_loading import load_kernels_quickly

with open(f"{__file__}i", encoding="utf-8") as stub:
    _MODULES = {line.split()[3]: line.split()[1] for line in stub if line.startswith("from ")}
"""The module of each public name."""

__all__ = sorted(_MODULES)


def __getattr__(name: str) -> object:
    """Import a public name on its first use (PEP 562)."""
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = globals()[name] = getattr(import_module(_MODULES[name]), name)
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


load_kernels_quickly()
