"""LuGre friction: Canudas de Wit et al. 1995, in coefficient form as Eqs. 6 and 7 of Fan et al. 2025, integrated over one step.

    friction/normal force = sigma_0 z + sigma_1 dz/dt + sigma_2 s
    dz/dt = s - lambda z,   lambda = sigma_0 |s|/g(s) + kappa V/(2 a)
    g(s) = mu_k + (mu_s - mu_k) exp(-(s/v_s)^2)

with the slip s and the bristle deflection z. The term kappa V/(2 a), rolling that carries bristles out of the contact of half-width a, is
not the paper's.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from dcrb_ros.core.arithmetic import exponential
from dcrb_ros.core.jit import kernel
from dcrb_ros.core.laws.calls import steady_friction
from dcrb_ros.core.laws.interface import Parameter, TractionLaw
from dcrb_ros.core.laws.site import Material, Site

LEAST_FORCE = 1e-9
"""Normal force of an open contact where the half-width is a divisor [N]."""

LEAST_COEFFICIENT = 1e-9
"""Friction coefficient used instead of 0 [-]: as g vanishes, the steady bristle g/sigma_0 vanishes, but its rate grows beyond bounds."""


class LuGre(NamedTuple):
    """Constants."""

    kinetic_coefficient: float
    """mu_k [-]."""
    static_coefficient: float
    """mu_s [-]."""
    stribeck_speed: float
    """v_s [m/s]."""
    bristle_stiffness: float
    """sigma_0 [1/m]."""
    bristle_damping: float
    """sigma_1 [s/m]."""
    viscous: float
    """sigma_2 [s/m]."""
    convection: float
    """kappa [-]."""


class Bristle(NamedTuple):
    """Memory of a contact."""

    bristle: float
    """Deflection z [m]."""


class Relaxation(NamedTuple):
    """How a bristle relaxes over a step."""

    rate: float
    """lambda [1/s]."""
    bristle_weight: float
    """phi of `bristle_weights` [-]."""


@kernel
def stribeck_coefficient(slip: float, kinetic: float, static: float, stribeck_speed: float) -> float:
    """Return g = mu_k + (mu_s - mu_k) exp(-(s/v_s)^2), the friction coefficient of steady slip [-], Eq. 7."""
    ratio = slip * (1.0 / stribeck_speed)
    return kinetic + (static - kinetic) * exponential(-ratio * ratio)


@kernel
def bristle_weights(decay: float) -> tuple[float, float]:
    """Return how the mean bristle over a step depends on its start and on the slip: phi and psi.

    Over a step h at constant slip s and rate lambda (``decay`` = lambda h), the bristle starts at z, its mean is
    phi z + psi h s and its end z + h phi (s - lambda z). Both come from exp(-x) ~ 1/(1 + x + x^2/2): second order where
    the step resolves the bristle, and the steady s/lambda where it does not (gross sliding, lambda h up to 200).
    """
    denominator = 1.0 / (1.0 + decay + 0.5 * decay * decay)
    return (1.0 + 0.5 * decay) * denominator, 0.5 * (1.0 + decay) * denominator


@kernel
def convection_rate(rolling: float, force: float, width: float, convection: float) -> float:
    """Return the rate [1/s] at which rolling carries bristles out of the contact: kappa V/(2 a), a the half-width.

    ``rolling`` is the speed V [m/s] of the surfaces through the contact, ``width`` a^2 over the force [m^2/N].
    """
    return 0.5 * convection * abs(rolling) / math.sqrt(width * force)


@kernel
def lugre_line(
    law: LuGre, memory: Bristle, slip: float, rolling: float | None, force: float, site: Site | None, step: float
) -> tuple[float, float, Relaxation]:
    """Return friction per normal force over the mean slip of the step, a + b s, and the bristle's relaxation.

    ``slip`` [m/s], known beforehand, sets the relaxation.
    """
    sliding, g, convection = abs(slip), 0.0, 0.0
    if rolling is None or site is None:
        g = stribeck_coefficient(slip, law.kinetic_coefficient, law.static_coefficient, law.stribeck_speed)
    else:
        sliding, g = steady_friction(site.film, site.memory, law, slip)
        convection = convection_rate(rolling, max(force, LEAST_FORCE), site.width, law.convection)
    rate = law.bristle_stiffness * sliding / g + convection
    phi, psi = bristle_weights(rate * step)
    offset = phi * memory.bristle * (law.bristle_stiffness - law.bristle_damping * rate)
    slope = law.bristle_stiffness * psi * step + law.bristle_damping * phi + law.viscous
    return offset, slope, Relaxation(rate, phi)


@kernel
def lugre_update(law: LuGre, memory: Bristle, kept: Relaxation, slip: float, closed: bool, step: float) -> Bristle:
    """Return the bristle at the end of a step of mean slip ``slip`` [m/s]; an open contact has none."""
    after = memory.bristle + step * kept.bristle_weight * (slip - kept.rate * memory.bristle)
    return Bristle(after if closed else 0.0)


def build(values: Mapping[str, float], material: Material) -> LuGre:
    """Return the constants; coefficients of 0 become `LEAST_COEFFICIENT`."""
    law = LuGre(*(values[name] for name in LuGre._fields))
    return law._replace(
        kinetic_coefficient=max(law.kinetic_coefficient, LEAST_COEFFICIENT),
        static_coefficient=max(law.static_coefficient, LEAST_COEFFICIENT),
    )


LAW = TractionLaw(
    name="lugre",
    summary="bristles as in the paper, Eqs. 6 and 7",
    constants=LuGre,
    build=build,
    line=lugre_line,
    update=lugre_update,
    memory=Bristle,
    kept=Relaxation,
    parameters=(
        Parameter("kinetic_coefficient", 0.05, "-", "Kinetic friction coefficient", 0.0, 1.0, symbol="mu_k"),
        Parameter("static_coefficient", 0.06, "-", "Static friction coefficient, not below the kinetic one", 0.0, 1.0, symbol="mu_s"),
        Parameter("stribeck_speed", 0.01, "m/s", "Stribeck velocity", 1e-6, 10.0, symbol="v_s"),
        Parameter(
            "bristle_stiffness",
            1e5,
            "1/m",
            "Bristle stiffness per normal force",
            1.0,
            1e8,
            symbol="sigma_0",
            remedy="the coefficient form is in 1/m; the paper prints N/m",
        ),
        Parameter(
            "bristle_damping",
            0.0133,
            "s/m",
            "Bristle damping per normal force (400 N s/m at 30 kN)",
            0.0,
            10.0,
            symbol="sigma_1",
            remedy="the coefficient form is in s/m; the paper's 400 N s/m is 0.0133 s/m at 30 kN",
        ),
        Parameter("viscous", 0.0, "s/m", "Viscous friction per normal force", 0.0, 10.0, symbol="sigma_2"),
        Parameter(
            "convection",
            0.0,
            "-",
            "Transport of the bristles out of the contact by rolling: 0 for plain LuGre (the paper), 0.7 for Carter's creep under 30 kN",
            0.0,
            10.0,
            symbol="kappa",
        ),
    ),
)
