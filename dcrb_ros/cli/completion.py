"""Shell completion of shipped names and of parameters; without a match the shell completes the names of files."""

from __future__ import annotations

from collections.abc import Callable, Iterable


def _shipped(kind: str) -> Callable[[str], list[str]]:
    """Return the completion of the names of shipped files of a kind."""

    def names(incomplete: str) -> list[str]:
        from dcrb_ros.settings.shipped import shipped

        return _beginning(incomplete, shipped(kind))

    return names


configurations, exams, scenarios, sweeps, vehicles = map(_shipped, ("configuration", "exam", "scenario", "sweep", "vehicle"))
"""Each returns the shipped names that begin with a text."""


def settings(incomplete: str) -> list[str]:
    """Return the parameters that begin with a text, as ``KEY=``."""
    from dcrb_ros.settings.files import fields_by_key

    return _beginning(incomplete, (f"{key}=" for key in fields_by_key()))


def _beginning(incomplete: str, names: Iterable[str]) -> list[str]:
    return sorted(name for name in names if name.startswith(incomplete))
