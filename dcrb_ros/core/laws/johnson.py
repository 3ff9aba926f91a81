"""Johnson's line contact: Johnson 1985, Contact Mechanics, as Eq. 4 of Fan et al. 2025.

    delta = F/(pi E* L) (ln(4 pi E* L dR/F) - 1)

with pi E* L [N/m] as ``modulus`` and 4 dR [m] as ``scale`` of the `Site`.

With a contact angle alpha a roller gives way along the line of contact by cos(alpha) of its way in the plane, and cos(alpha) of its
force acts there. The law of the plane has the same form, with pi E* L cos(alpha)^2 as ``modulus`` and 4 dR/cos(alpha)^2 as ``scale``, for
the radii along the line of contact are those in the plane over cos(alpha).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from dcrb_ros.core.arithmetic import logarithm
from dcrb_ros.core.jit import kernel
from dcrb_ros.core.laws.interface import NormalLaw
from dcrb_ros.core.laws.site import Material, NoMemory, Site


class Johnson(NamedTuple):
    """Constants."""

    modulus: float
    """pi E* L cos(alpha)^2 [N/m]."""


@kernel
def line_contact(log_ratio: float) -> tuple[float, float]:
    """Return numerator and denominator of -W_-1(-e^l) at l = ``log_ratio``, the lower branch of the Lambert function.

    A rational fit over -40 .. -4 with an error of 1e-13 (`benchmarks/fit_line_contact.py`). Above -4, where a roller would be pressed in
    by one part in forty of its radius, the value at -4.
    """
    t = (min(log_ratio, -4.0) + 22.0) * (1.0 / 18.0)
    t2 = t * t
    t4 = t2 * t2
    above = (25.227952610343658 - 111.70804449222039 * t) + t2 * (209.02017336824925 - 214.28786416771893 * t)
    above += t4 * ((130.31719216890709 - 47.426067396990194 * t) + t2 * (9.8533827349380200 - 1.0261529188664917 * t))
    above += t4 * t4 * 0.037774529454882129
    below = (1.0 - 3.6850037902163191 * t) + t2 * (5.5589025113215732 - 4.4000992016805178 * t)
    below += t4 * ((1.9413959503750688 - 0.46528432479890793 * t) + t2 * (0.053636784985261526 - 0.0020961313201773434 * t))
    return above, below


@kernel
def johnson_force(law: Johnson, memory: NoMemory, penetration: float, site: Site) -> tuple[float, float]:
    """Return the normal force [N] and its slope [N/m] at a penetration [m] above zero.

    F = -pi E* L delta / W_-1(-e delta / (4 dR)), its slope -pi E* L / (W_-1 + 1).
    """
    above, below = line_contact(1.0 + logarithm(penetration) - logarithm(site.scale))
    share = law.modulus * below / (above * (above - below))
    return penetration * share * (above - below), share * above


@kernel
def johnson_energy(law: Johnson, memory: NoMemory, penetration: Any, force: Any) -> Any:
    """Return the energy stored [J]: F delta/2 - F^2/(4 pi E* L)."""
    return 0.5 * force * penetration - force * force / (4.0 * law.modulus)


def johnson_penetration(law: Johnson, force: Any, site: Site) -> Any:
    """Return the penetration [m] under a normal force [N] above zero, Eq. 4 as printed."""
    return force / law.modulus * (np.log(law.modulus * site.scale / force) - 1.0)


def johnson_stiffness(law: Johnson, force: Any, site: Site) -> Any:
    """Return the slope [N/m] under a normal force [N] above zero; under more than the law describes, that at its limit."""
    return law.modulus / np.maximum(np.log(law.modulus * site.scale / force) - 2.0, 1.0)


def build(values: Mapping[str, float], material: Material) -> Johnson:
    """Return the constants."""
    cosine = math.cos(material.contact_angle)
    return Johnson(math.pi * material.effective_modulus * material.roller_length * (cosine * cosine))


LAW = NormalLaw(
    name="johnson",
    summary="the line contact of Eq. 4 (the paper)",
    constants=Johnson,
    build=build,
    force=johnson_force,
    energy=johnson_energy,
    penetration=johnson_penetration,
    stiffness=johnson_stiffness,
)
