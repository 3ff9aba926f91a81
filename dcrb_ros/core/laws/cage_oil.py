"""Oil between rollers and bars, between cages and lands, and about the orbiting rollers.

Squeeze film of a roller that approaches a bar, as at the raceways with R = r_R (see `squeeze`), with a layer that ends at a gap H:

    c(g) = A (q^(-3/2) - H^(-3/2)),   q = max(g, h_s)

Shear of the same film by the turning roller, Couette flow in a parabolic gap, with the same end of the layer (a choice); s is the speed of
the roller's surface past the bar:

    F = eta L pi sqrt(2 r_R) (q^(-1/2) - H^(-1/2)) s

Two lands of the width B, short bearings whose clearance c_l is filled to a share (Ocvirk and DuBois 1953): damping of radial motion, and
torque of the turning cage (Petroff); e is the eccentricity over c_l, at most 0.95, with the sign of the motion, so below 0 for a cage
that comes back to the centre:

    c = 2 eta R B^3 I(e)/c_l^3 share,   I(e) = ((1 + 2 e^2) (pi/2 + arcsin e) + 3 e (1 - e^2)^(1/2))/(1 - e^2)^(5/2)
    T = 2 pi eta omega R^3 2 B/c_l share

I is the integral of cos^2(phi)/(1 - e cos(phi))^3 over the half of the land that the cage approaches. In the other half the film cavitates.

Drag on an orbiting roller in a mist of oil (Harris 2001):

    F = 0.5 rho f C_d 2 r_R L v^2
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from dcrb_ros.core.arithmetic import HALF_PI
from dcrb_ros.core.jit import kernel
from dcrb_ros.core.laws.lubricants import OIL_SHARES, lubricant_of
from dcrb_ros.core.laws.site import Material
from dcrb_ros.core.laws.squeeze import squeeze_coefficient, squeeze_floor
from dcrb_ros.core.laws.viscosity import density

BAR_FLOOR = 2e-6
"""Gap between roller and bar below which the film's resistance grows no more [m] (a choice: both are rough)."""
LAND_SHARE = 10.0 / 15.0
"""Width B of each of the two lands of a cage over the radius of a roller [-] (a choice)."""
MOST_ECCENTRICITY = 0.95
"""Of a cage in its lands [-]; nearer the elastic contact takes over."""
DRAG_COEFFICIENT = 1.1
"""C_d of a cylinder across the flow [-]."""


class CageOil(NamedTuple):
    """Constants."""

    squeeze: float
    """A of a bar [N s m^(1/2)]; 0 without a squeeze film."""
    floor: float
    """h_s, at most H [m]."""
    layer: float
    """H [m]."""
    shear: float
    """eta L pi sqrt(2 r_R) [N s m^(-1/2)]; 0 without a layer."""
    land_squeeze: float
    """2 eta B^3 times the share that is filled [N s m^2]; 0 without a squeeze film."""
    land_shear: float
    """2 pi eta 2 B times that share [N s/m]."""
    churning: float
    """Drag of an orbiting roller over its squared speed [N s^2/m^2]."""


@kernel
def bar_damping(law: Any, gap: float) -> float:
    """Return the damping [N s/m] of a roller that approaches a bar at a gap [m]."""
    oil = law.cage
    by_q, by_root = 1.0 / min(max(gap, oil.floor), oil.layer), 1.0 / math.sqrt(oil.layer)
    damping: float = oil.squeeze * max(by_q * math.sqrt(by_q) - by_root * by_root * by_root, 0.0)
    return damping


@kernel
def bar_shear(law: Any, gap: float) -> float:
    """Return the drag of a bar at a gap [m] over the speed of the roller's surface past it [N s/m]."""
    oil = law.cage
    q = min(max(gap, oil.floor), oil.layer)
    drag: float = oil.shear * (1.0 / math.sqrt(q) - 1.0 / math.sqrt(oil.layer))
    return drag


@kernel
def land_damping(law: Any, offset: float, clearance: float, radius: float) -> tuple[float, float]:
    """Return the damping [N s/m] of a cage that moves away from the centre of its lands, and of one that comes back, at an offset [m]."""
    eccentricity = min(offset / clearance, MOST_ECCENTRICITY)
    square = eccentricity * eccentricity
    left, factor = 1.0 - square, 1.0 + 2.0 * square
    root = math.sqrt(left)
    scale = law.cage.land_squeeze * radius / (clearance * clearance * clearance * left * left * root)
    even, odd = factor * HALF_PI, factor * math.asin(eccentricity) + 3.0 * eccentricity * root
    return scale * (even + odd), scale * (even - odd)


@kernel
def land_torque(law: Any, clearance: float, radius: float) -> float:
    """Return the torque of the lands over the speed of the cage [N m s]."""
    oil = law.cage
    torque: float = oil.land_shear * radius * radius * radius / clearance
    return torque


@kernel
def churning(law: Any) -> float:
    """Return the drag of an orbiting roller over its squared speed [N s^2/m^2]."""
    drag: float = law.cage.churning
    return drag


def cage_oil(values: Mapping[str, Any], material: Material, viscosity: float, impedance: float) -> CageOil:
    """Return the constants, at a viscosity [Pa s]; ``impedance`` is the largest damping of a squeeze film [N s/m]."""
    radius, length = material.roller_radius, material.roller_length
    # A layer thinner than the floor has no effect.
    layer, squeezes = max(values["pocket_layer"], BAR_FLOOR), float(values["squeeze"])
    squeeze = squeeze_coefficient(viscosity, length, radius)
    share, width = values["oil_share"] or OIL_SHARES[values["lubricant"]], LAND_SHARE * radius
    return CageOil(
        squeeze=squeeze * squeezes,
        floor=min(max(BAR_FLOOR, float(squeeze_floor(squeeze, impedance, layer))), layer),
        layer=layer,
        shear=math.pi * viscosity * length * math.sqrt(2.0 * radius),
        land_squeeze=2.0 * viscosity * width**3 * values["land_fill"] * squeezes,
        land_shear=2.0 * math.pi * viscosity * 2.0 * width * values["land_fill"],
        churning=DRAG_COEFFICIENT * density(lubricant_of(values), values["temperature"]) * share * radius * length,
    )
