"""The normal of a contact on a raceway with a slope."""

from __future__ import annotations

from dcrb_ros.core.jit import kernel, piece
from dcrb_ros.core.layout.contacts import RacewayContact


@kernel
def tilted(nx: float, ny: float, slope: float) -> tuple[float, float]:
    """Return a unit vector turned towards its left by a small slope [-]."""
    square = slope * slope
    by_length = 1.0 - square * (0.5 - 0.375 * square)
    return (nx - slope * ny) * by_length, (ny + slope * nx) * by_length


@piece
def write_tilt(contact: RacewayContact, k: int, slope: float, speed: float) -> None:
    """Tilt the normal of a contact by a slope [-] along the raceway, which turns at a speed [rad/s]."""
    contact.tilt[k] = slope
    nx, ny = tilted(contact.radial_x[k], contact.radial_y[k], slope)
    contact.normal_x[k], contact.normal_y[k] = nx, ny
    contact.surface_speed_normal[k] = speed * contact.distance[k] * (contact.radial_x[k] * ny - contact.radial_y[k] * nx)
