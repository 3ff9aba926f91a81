"""Modules of packages that are not required, imported on first use."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

from dcrb_ros.schema.refusal import Refusal


def installed(module: str, refusal: str) -> ModuleType:
    """Return a module.

    Raises:
        Refusal: it is not installed, in the words of ``refusal``.
    """
    try:
        return import_module(module)
    except ImportError:
        raise Refusal(refusal) from None
