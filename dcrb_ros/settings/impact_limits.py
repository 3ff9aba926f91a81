"""Parameters of the impacts that contradict others."""

from __future__ import annotations

from collections.abc import Iterator

from dcrb_ros.settings.groups import ParameterGroups
from dcrb_ros.settings.impacts import LARGEST_AXIAL_SHARE, OFF, Impacts

BALLS = "hertz"
"""Law of the normal force between balls and their grooves."""


def impact_limits(c: ParameterGroups) -> Iterator[str]:
    """Yield a sentence for each parameter of the impacts that contradicts others."""
    i = c.impacts
    if i.element_share + i.shaft_share > 1.0:
        yield (
            f"impacts.element_share + impacts.shaft_share = {i.element_share + i.shaft_share:g} is above 1: they are shares of one "
            "variance; reduce one of them"
        )
    for name in ("element_share", "shaft_share"):
        if getattr(i, name) > 0.0 and i.spread == 0.0:
            yield (
                f"impacts.{name} = {getattr(i, name):g} is a share of the variance of impacts.spread, which is 0: set it, or leave "
                f"impacts.{name} at 0"
            )
    if LARGEST_AXIAL_SHARE < i.axial_share < OFF:
        yield (
            f"impacts.axial_share = {i.axial_share:g} is between {LARGEST_AXIAL_SHARE:g} and 1: give 0 .. {LARGEST_AXIAL_SHARE:g}, "
            "or 1 for no axial preload"
        )
    if c.surfaces.law != "profile":
        for name, on in (
            ("spread", i.spread > 0.0),
            ("axial_share", i.axial_share < OFF),
            ("time_spread", i.time_spread > 0.0),
            ("spin_memory", i.spin_memory > 0.0),
        ):
            if on:
                yield (
                    f"impacts.{name} = {getattr(i, name):g} needs surfaces.law = profile, and it is {c.surfaces.law}: set it, or leave "
                    f"impacts.{name} at {Impacts.model_fields[name].default:g}"
                )
    if i.spin_memory > 0.0 and c.contact.law != BALLS:
        yield (
            f"impacts.spin_memory = {i.spin_memory:g} s belongs to balls, and contact.law = {c.contact.law}: give 0, or contact.law = "
            f"{BALLS}"
        )
