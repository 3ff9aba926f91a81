"""Loss of a raceway's normal contact."""

from __future__ import annotations

from dcrb_ros.core.jit import kernel


@kernel
def loss_coefficient(force: float, damping: float, rate: float) -> float:
    """Return the damping [N s/m] of a contact that never pulls.

    ``force`` is the elastic force [N], ``damping`` the law's [N s/m], ``rate`` the speed of penetration [m/s]. Where the contact opens so
    fast that the loss would outweigh the elastic force, the damping is reduced until their sum is zero.
    """
    return -force / rate if force + damping * rate < 0.0 else damping
