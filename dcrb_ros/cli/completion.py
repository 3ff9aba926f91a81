"""Shell completion of shipped names and of parameters; without a match the shell completes the names of files."""

from __future__ import annotations

from collections.abc import Iterable


def configurations(incomplete: str) -> list[str]:
    """Return the shipped configurations that begin with a text."""
    return _shipped(incomplete, "configuration")


def exams(incomplete: str) -> list[str]:
    """Return the shipped exams that begin with a text."""
    return _shipped(incomplete, "exam")


def scenarios(incomplete: str) -> list[str]:
    """Return the shipped scenarios that begin with a text."""
    return _shipped(incomplete, "scenario")


def sweeps(incomplete: str) -> list[str]:
    """Return the shipped sweeps that begin with a text."""
    return _shipped(incomplete, "sweep")


def settings(incomplete: str) -> list[str]:
    """Return the parameters that begin with a text, as ``KEY=``."""
    from dcrb_ros.settings.files import fields_by_key

    return _beginning(incomplete, (f"{key}=" for key in fields_by_key()))


def _shipped(incomplete: str, kind: str) -> list[str]:
    from dcrb_ros.settings.shipped import shipped

    return _beginning(incomplete, shipped(kind))


def _beginning(incomplete: str, names: Iterable[str]) -> list[str]:
    return sorted(name for name in names if name.startswith(incomplete))
