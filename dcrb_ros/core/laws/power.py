"""The power law of a normal contact, Q = K delta^n; F = K cos(alpha)^(n + 1) delta^n in the plane of a contact angle alpha."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from dcrb_ros.core.jit import kernel
from dcrb_ros.core.laws.interface import NormalLaw, Parameter
from dcrb_ros.core.laws.site import Material, NoMemory, Site

Floats = npt.NDArray[np.float64]


class Power(NamedTuple):
    """Constants."""

    coefficient: float
    """K cos(alpha)^(n + 1) [N/m^n]."""
    exponent: float
    """n [-]."""


@kernel
def power_force(law: Power, memory: NoMemory, penetration: float, site: Site) -> tuple[float, float]:
    """Return the normal force [N] and its slope [N/m] at a penetration [m] above zero."""
    force = law.coefficient * penetration**law.exponent
    return force, law.exponent * force / penetration


@kernel
def power_energy(law: Power, memory: NoMemory, penetration: Any, force: Any) -> Any:
    """Return the energy stored [J]: F delta/(n + 1)."""
    return force * penetration / (law.exponent + 1.0)


def power_forces(law: Power, penetration: Floats, site: Site) -> tuple[Floats, Floats]:
    """Return `power_force` over arrays, zero where a contact is open."""
    depth = np.maximum(penetration, 0.0)
    force = law.coefficient * depth**law.exponent
    return force, np.where(force > 0.0, law.exponent * force / np.where(force > 0.0, penetration, 1.0), 0.0)


def power_penetration(law: Power, force: Any, site: Site) -> Any:
    """Return the penetration [m] under a normal force [N] above zero."""
    return (force / law.coefficient) ** (1.0 / law.exponent)


def power_stiffness(law: Power, force: float, site: Site) -> float:
    """Return the slope [N/m] under a normal force [N] above zero."""
    return float(law.exponent * force ** (1.0 - 1.0 / law.exponent) * law.coefficient ** (1.0 / law.exponent))


def build(values: Mapping[str, float], material: Material) -> Power:
    """Return the constants."""
    exponent = values["power_exponent"]
    return Power(values["power_coefficient"] * math.cos(material.contact_angle) ** (exponent + 1.0), exponent)


LAW = NormalLaw(
    name="power",
    summary="power_coefficient * penetration^power_exponent",
    constants=Power,
    build=build,
    force=power_force,
    energy=power_energy,
    penetration=power_penetration,
    stiffness=power_stiffness,
    forces=power_forces,
    parameters=(
        Parameter("power_coefficient", 3.449e9, "N/m^n", "Coefficient of the power law", 1e3, 1e15, symbol="K"),
        Parameter("power_exponent", 1.0766, "-", "Exponent of the power law", 1.0, 2.0, symbol="n"),
    ),
)
