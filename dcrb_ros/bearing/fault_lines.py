"""The lines at which the faults of a bearing show in a spectrum."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

from dcrb_ros.bearing.frequencies import Orders, characteristic_orders
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.parameters import Bearing

CAGE_HARMONICS = 4
"""Harmonics of FTF that are shown."""

UNKNOWN = Orders(math.nan, math.nan, math.nan, math.nan)
"""Orders of an unknown bearing."""


class HasBearing(Protocol):
    """A configuration."""

    @property
    def bearing(self) -> Bearing:
        """Geometry of the bearing."""


BearingLike = Bearing | Orders | HasBearing
"""Any object with characteristic orders: a geometry, a configuration or the orders themselves."""


@dataclass(frozen=True)
class Comb:
    """A fault and the lines at which it shows."""

    name: str
    orders: tuple[float, ...]
    """Its harmonics as multiples of the shaft frequency [-]."""


def fault_combs(orders: Orders, highest: float) -> list[Comb]:
    """Return the harmonics of BPFO, BPFI, 2BSF and FTF below the ``highest`` order; of FTF the first four. None of unknown orders."""
    if math.isnan(orders.bpfo):
        return []
    bases = {"BPFO": orders.bpfo, "BPFI": orders.bpfi, "2BSF": 2.0 * orders.bsf, "FTF": orders.ftf}
    combs = []
    for name, base in bases.items():
        most = CAGE_HARMONICS if name == "FTF" else int(highest / base)
        combs.append(Comb(name, tuple(base * k for k in range(1, most + 1) if base * k < highest)))
    return combs


def orders_of(bearing: BearingLike) -> Orders:
    """Return the characteristic orders of a bearing, given by its geometry, a configuration or the orders themselves.

    Raises:
        Refusal: it is something else, such as the name of a configuration.
    """
    if isinstance(bearing, Orders):
        return bearing
    geometry = bearing if isinstance(bearing, Bearing) else getattr(bearing, "bearing", None)
    if not isinstance(geometry, Bearing):
        remedy = f"dcrb_ros.load_configuration({bearing!r})" if isinstance(bearing, str) else "a Bearing, Orders or a Configuration"
        raise Refusal(f"bearing = {bearing!r} is not a bearing: give {remedy}")
    return characteristic_orders(geometry)
