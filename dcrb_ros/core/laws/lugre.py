"""LuGre friction in coefficient form (Eqs. 6 and 7 of Fan et al. 2025), integrated over one step."""

from __future__ import annotations

import math

from dcrb_ros.core.arithmetic import exponential
from dcrb_ros.core.jit import kernel
from dcrb_ros.core.payload import Payload


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
def friction_line(
    slip: float, bristle: float, kinetic: float, static: float, convection: float, payload: Payload
) -> tuple[float, float, float, float]:
    """Return friction per normal force as a straight line over the mean slip of the step, and the bristle's law.

    ``slip`` [m/s] is the slip known beforehand, which sets the relaxation, ``convection`` [1/s] what rolling adds to
    it; the line a + b s [-, s/m] is what the implicit velocity update needs. The last two numbers are lambda [1/s] and
    phi [-] for `bristle_after`.
    """
    g = stribeck_coefficient(slip, kinetic, static, payload.stribeck_speed)
    rate = payload.bristle_stiffness * abs(slip) / g + convection
    phi, psi = bristle_weights(rate * payload.step)
    constant = phi * bristle * (payload.bristle_stiffness - payload.bristle_damping * rate)
    slope = payload.bristle_stiffness * psi * payload.step + payload.bristle_damping * phi + payload.viscous
    return constant, slope, rate, phi


@kernel
def bristle_after(bristle: float, slip: float, rate: float, phi: float, step: float) -> float:
    """Return the bristle deflection [m] at the end of a step with mean slip ``slip`` [m/s]."""
    return bristle + step * phi * (slip - rate * bristle)
