"""The power law F = K delta^n of a normal contact."""

from __future__ import annotations

from dcrb_ros.core.jit import kernel


@kernel
def power_force(penetration: float, coefficient: float, exponent: float) -> tuple[float, float]:
    """Return the normal force [N] and its slope [N/m] at a penetration [m] above zero."""
    force = coefficient * penetration**exponent
    return force, exponent * force / penetration


@kernel
def power_energy(penetration: float, force: float, exponent: float) -> float:
    """Return the energy [J] stored at a penetration [m] under its force [N]: F delta/(n + 1)."""
    return force * penetration / (exponent + 1.0)
