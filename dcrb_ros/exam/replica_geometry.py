"""The bearing of a replica: the geometry that the orders of a measured recording imply, on the scale of a shipped bench."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings import step_limits
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import changed
from dcrb_ros.settings.measured_rate import rates
from dcrb_ros.settings.simulation import SHORTEST_STEP

LARGEST_FRACTION = 0.05
"""Largest deviation of BPFO + BPFI from a whole number of rolling elements [-]."""
LARGEST_DEVIATION = 0.02
"""Largest relative deviation of FTF from the order that BPFO and BPFI imply [-]."""
SMALLEST_ANGLE = 0.05
"""Angle below which the contact angle is that of rounded orders and taken as 0 [rad]."""
LARGEST_RATIO = 0.6
"""Largest ratio of the diameters of rolling elements and pitch circle [-]."""

SMALLEST_SIZE = 0.75
"""Smallest size of rolling elements of an unknown scale, relative to those of the bench [-]: bearings with more elements are larger."""
SMALLEST_AT_FULL_STEP = 0.9
"""Smallest size of rolling elements for which the step of the bench is short enough, relative to those of the bench [-]."""
SHORTEST = 1e-3
"""Shortest contact of a rolling element, as of `bearing.roller_length` [m]."""


@dataclass(frozen=True)
class RollerGeometry:
    """Numbers and ratios of a bearing that follow from its orders."""

    elements: int
    """Rolling elements in a row [-]."""
    ratio: float
    """Diameter of a rolling element over that of the pitch circle [-]."""
    contact_angle: float
    """[rad]"""


def geometry_of(orders: Orders) -> RollerGeometry:
    r"""Return the geometry that fits the orders.

    With Z rolling elements, d/D the ratio of diameters and the contact angle :math:`\alpha`,

    .. math::
        Z = BPFO + BPFI, \quad \gamma = \frac{BPFI - BPFO}{Z} = \frac{d}{D} \cos\alpha, \quad
        BSF = \frac{D}{2 d} (1 - \gamma^2), \quad FTF = \frac{1 - \gamma}{2} .

    Raises:
        Refusal: no bearing with a fixed outer ring has these orders.
    """
    both = orders.bpfo + orders.bpfi
    elements = round(both) if math.isfinite(both) else 0
    if elements < 1 or abs(both - elements) > LARGEST_FRACTION:
        raise Refusal(
            f"BPFO + BPFI = {both:.4g} is not a whole number of rolling elements to {LARGEST_FRACTION:g}: check the orders of this bearing"
        )
    gamma = (orders.bpfi - orders.bpfo) / both
    if not 0.0 < gamma < 1.0 or abs(orders.ftf / (0.5 * (1.0 - gamma)) - 1.0) > LARGEST_DEVIATION:
        raise Refusal(
            f"FTF = {orders.ftf:g} contradicts BPFO = {orders.bpfo:g} and BPFI = {orders.bpfi:g}, which give "
            f"{0.5 * (1.0 - gamma):.4g} with a fixed outer ring: check the orders of this bearing"
        )
    ratio = (1.0 - gamma**2) / (2.0 * orders.bsf)
    cosine = gamma / ratio
    if ratio > LARGEST_RATIO or not math.cos(1.0) <= cosine <= 1.0 + LARGEST_DEVIATION:
        raise Refusal(
            f"BSF = {orders.bsf:g} gives rolling elements of {ratio:.3g} of the pitch diameter, which BPFO and BPFI do not allow: "
            "check the orders of this bearing"
        )
    angle = math.acos(min(1.0, cosine))
    return RollerGeometry(elements, gamma if angle < SMALLEST_ANGLE else ratio, 0.0 if angle < SMALLEST_ANGLE else angle)


def bearing_settings(geometry: RollerGeometry, bench: Configuration, pitch_radius: float | None = None) -> Mapping[str, Any]:
    """Return the parameters of a bearing of a geometry, scaled from that of a bench.

    Lengths grow with the rolling elements, their masses with the cube and inertias with the fifth power of their size. The masses of rings
    and cage grow with the cube of the pitch radius, and the clearance of a larger bearing with the pitch radius. That radius is by
    default the one of the bench [m], or a larger one if the rolling elements were smaller than `SMALLEST_SIZE`.
    """
    known = bench.bearing
    own = known.own_roller_radius
    pitch = max(known.pitch_radius, SMALLEST_SIZE * own / geometry.ratio) if pitch_radius is None else pitch_radius
    size, scale = geometry.ratio * pitch / own, pitch / known.pitch_radius
    radius = geometry.ratio * pitch * math.cos(geometry.contact_angle)
    gap = 0.5 * (
        (known.outer_raceway_radius - known.pitch_radius - known.roller_radius)
        + (known.pitch_radius - known.roller_radius - known.inner_raceway_radius)
    )
    gap *= max(1.0, scale)
    settings = {
        "bearing.rollers_per_row": geometry.elements,
        "bearing.roller_radius": radius,
        "bearing.pitch_radius": pitch,
        "bearing.inner_raceway_radius": pitch - radius - gap,
        "bearing.outer_raceway_radius": pitch + radius + gap,
        "bearing.roller_length": max(known.roller_length * size, SHORTEST),
        "bearing.roller_mass": known.roller_mass * size**3,
        "bearing.roller_inertia": known.roller_inertia * size**5,
        "bearing.outer_ring_mass": known.outer_ring_mass * scale**3,
        "bearing.inner_ring_mass": known.inner_ring_mass * scale**3,
        "bearing.cage_mass": known.cage_mass * scale**3,
        "bearing.cage_inertia": known.cage_inertia * scale**5,
    }
    return settings if geometry.contact_angle == 0.0 else {**settings, "bearing.contact_angle": geometry.contact_angle}


def longest_step(bearing: Mapping[str, Any], bench: Configuration, load: float | None = None) -> float:
    """Return the longest time step [s] for a bearing of `bearing_settings`: that of the bench, or shorter for smaller rolling elements.

    A known ``load`` [N] may need a shorter one. Loads that are drawn do not.

    The stiffness of a contact grows with the root of the size of a rolling element and its mass with the cube, so natural frequencies fall
    with the power 1.25 of the size. The exponent 1.5 leaves a margin for cages.
    """
    size = (bearing["bearing.roller_mass"] / bench.bearing.roller_mass) ** (1.0 / 3.0)
    step = float(bench.simulation.step * min(1.0, (size / SMALLEST_AT_FULL_STEP) ** 1.5))
    if load is None:
        return step
    fine = rates(bench.sensor.sampling_rate, 2.0 * SHORTEST_STEP)
    return min(step, step_limits.longest_step(changed(bench, {**bearing, **fine, "operating.load": load}, "its bearing")))
