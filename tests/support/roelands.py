"""Roelands' viscosity under pressure, in closed form."""

from __future__ import annotations

import math

from dcrb_ros.core.laws.viscosity import ROELANDS_OFFSET, ROELANDS_PRESSURE, roelands_exponent


def viscosity_under(viscosity: float, alpha: float, pressure: float) -> float:
    """Return the viscosity [Pa s] under a pressure [Pa], with a pressure coefficient [1/Pa]."""
    exponent = roelands_exponent(viscosity, alpha)
    return viscosity * math.exp((math.log(viscosity) + ROELANDS_OFFSET) * ((1.0 + pressure / ROELANDS_PRESSURE) ** exponent - 1.0))
