"""How the impacts of rolling elements on damage differ from each other: the group ``impacts``."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from dcrb_ros.schema.fields import Group, quantity

if TYPE_CHECKING:
    from dcrb_ros.settings.groups import ParameterGroups

OFF = 1.0
"""Value of ``impacts.axial_share`` that leaves the clearance as it is [-]."""
LARGEST_AXIAL_SHARE = 0.8
"""Largest share with axial preload [-]: beyond it the preload would exceed a hundred times the radial load's approach."""
BALLS = "hertz"
"""Law of the normal force between balls and their grooves."""


class Impacts(Group):
    """Strength and time of the impacts on damage, drawn for each passage; with the defaults all passages of a defect are alike."""

    spread: float = quantity(
        0.0,
        "-",
        "Standard deviation over mean of the strength of the impacts on a raceway's damage, without what the bearing's dimensions and "
        "the load zone cause; 0 for impacts that are alike",
        0.0,
        2.0,
        symbol="kappa",
    )
    element_share: float = quantity(
        0.0, "-", "Share of the variance of the strength that belongs to the rolling element", 0.0, 1.0, symbol="beta"
    )
    shaft_share: float = quantity(
        0.0, "-", "Share of the variance of the strength that belongs to the angle of the shaft", 0.0, 1.0, symbol="sigma"
    )
    axial_share: float = quantity(
        OFF,
        "-",
        "Load of a rolling element a quarter turn from the load line over the largest load, by axial preload; 1 for no axial preload",
        0.0,
        1.0,
        symbol="phi",
    )
    time_spread: float = quantity(
        0.0,
        "s",
        "Standard deviation of independent errors of the times of the impacts on a raceway's damage, at most three times that",
        0.0,
        1e-3,
        symbol="sigma_t",
    )
    spin_memory: float = quantity(
        0.0,
        "s",
        "Time in which the axis about which a damaged ball spins turns to an independent direction; 0 for damage that stays on the track",
        0.0,
        1e4,
    )

    @property
    def unequal(self) -> bool:
        """Whether the passages over damage differ."""
        return self.spread > 0.0 or self.time_spread > 0.0 or self.spin_memory > 0.0


def impact_limits(c: ParameterGroups) -> Iterator[str]:
    """Yield a sentence for each parameter of the impacts that contradicts others."""
    i = c.impacts
    if i.element_share + i.shaft_share > 1.0:
        yield (
            f"impacts.element_share + impacts.shaft_share = {i.element_share + i.shaft_share:g} is above 1: they are shares of one "
            "variance; reduce one of them"
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
