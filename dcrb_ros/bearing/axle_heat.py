"""Heat that reaches the journal of a bearing along its axle: from the bearing at the other end, and from the brakes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from dcrb_ros.bearing.heat_network import HeatNetwork, Vector

AXLE_CONDUCTION = 0.5
"""Conductance of the axle between its journals [W/K]: k A / L of 2 m of steel with a diameter of 0.17 m, 45 W/(m K) 0.0227 m^2 / 2 m."""


@dataclass(frozen=True)
class BoxTemperatures:
    """The temperatures of a bearing in its box that a detector measures or that heat the opposite box [deg C]."""

    journal: float
    """Mean of the inner rings."""
    outer_ring: float
    """Mean of the outer rings."""
    box: float


def box_temperatures(network: HeatNetwork, temperatures: Sequence[float]) -> BoxTemperatures:
    """Return journal, outer ring and box from the temperatures of a network's nodes [deg C]."""
    rows = range(network.rows)
    return BoxTemperatures(
        sum(temperatures[network.inner(row)] for row in rows) / network.rows,
        sum(temperatures[network.outer(row)] for row in rows) / network.rows,
        temperatures[network.box],
    )


@dataclass(frozen=True)
class Surroundings:
    """What a vehicle does to the heat of one of its boxes."""

    opposite: BoxTemperatures | None = None
    """The box at the other end of the axle; None where nothing is known of it."""
    journal_heat: float = 0.0
    """Heat of the brakes in the journal [W]."""
    air: float = 1.0
    """Speed of the air at the box over that of ``thermal.exposure`` [-]."""

    def heated(self, network: HeatNetwork, heat: Sequence[float], temperatures: Sequence[float]) -> Vector:
        """Return the heat of each node [W] with that along the axle, G (T_opposite - T), and of the brakes, in equal parts for each row."""
        sources = list(heat)
        for row in range(network.rows):
            node = network.inner(row)
            across = AXLE_CONDUCTION * (self.opposite.journal - temperatures[node]) if self.opposite is not None else 0.0
            sources[node] += (across + self.journal_heat) / network.rows
        return sources


ALONE = Surroundings()
"""Those of a bearing on a bench."""
