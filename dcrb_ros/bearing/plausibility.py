"""Warnings of configurations that are valid but may differ from what a user expects."""

from __future__ import annotations

from collections.abc import Iterator

from dcrb_ros.faults.raceway_defect import NOTCH, RacewayDefect
from dcrb_ros.settings.configuration import Configuration


def implausible_notches(c: Configuration) -> Iterator[str]:
    """Yield a sentence for each notch in a bearing whose surfaces could have a spall."""
    if c.surfaces.law != "profile":
        return
    for key, fault in c.faults.present():
        if isinstance(fault, RacewayDefect) and fault.kind == NOTCH:
            yield (
                f"faults.{key}.kind = {NOTCH} is a groove {1e3 * fault.depth:g} mm deep across the whole raceway, several times as loud as "
                f"a spall of the same width: set faults.{key}.kind to spall, with a depth and a share of the length, for damage by fatigue"
            )
