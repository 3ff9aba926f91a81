"""What presses on the contacts of a bearing, how stiff they are, and how fast its cage is in pure rolling."""

from __future__ import annotations

import math

from dcrb_ros.core.laws import NORMAL_LAWS
from dcrb_ros.core.laws.site import Material, inner_site
from dcrb_ros.settings.groups import ParameterGroups
from dcrb_ros.settings.parameters import Bearing


def heaviest(c: ParameterGroups) -> float:
    """Return the largest normal force of a roller [N]: five times the mean of a row, as without a radial gap (Stribeck)."""
    return max(1.0, 5.0 * load_and_weight(c) / (c.bearing.rows * c.bearing.rollers_per_row))


def load_and_weight(c: ParameterGroups) -> float:
    """Return the sum of load and weight on the inner ring [N]."""
    return math.hypot(c.operating.load, c.operating.lateral_load) + c.bearing.inner_ring_mass * c.operating.gravity


def material_of(bearing: Bearing) -> Material:
    """Return what the constants of contact laws may depend on."""
    return Material(**{name: getattr(bearing, name) for name in Material._fields})


def contact_stiffness(c: ParameterGroups, force: float) -> float:
    """Return the stiffness [N/m] of a roller's contact with the inner raceway under a normal force [N]."""
    law = NORMAL_LAWS[c.contact.law]
    return float(law.stiffness(law.build(dict(c.contact), material_of(c.bearing)), force, inner_site(material_of(c.bearing))))


def cage_speed(c: ParameterGroups, shaft_speed: float) -> float:
    """Return the cage speed for pure rolling [rad/s]: with rollers pinned at the pitch radius, or free on the inner raceway."""
    b = c.bearing
    orbit = b.pitch_radius if c.cage.joint == "revolute" else b.inner_raceway_radius + b.roller_radius
    return shaft_speed * b.inner_raceway_radius / (2.0 * orbit)
