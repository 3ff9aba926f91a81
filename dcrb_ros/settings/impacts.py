"""How the impacts of rolling elements on damage differ from each other: the group ``impacts``."""

from __future__ import annotations

from dcrb_ros.schema.fields import Group, quantity

OFF = 1.0
"""Value of ``impacts.axial_share`` that leaves the clearance as it is [-]."""
LARGEST_AXIAL_SHARE = 0.8
"""Largest share with axial preload [-]: beyond it the preload would exceed a hundred times the radial load's approach."""


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
