"""Everything constant that the kernels need, in one named tuple."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]


class Notches(NamedTuple):
    """Raceway defects of one ring; arrays of one entry per defect."""

    row: npt.NDArray[np.int64]
    """Row index of the defect, -1 for all rows."""
    half_angle: Floats
    """Half the angular width b/(2 r) [rad]."""
    depth: Floats
    """Depth h [m]."""
    azimuth: Floats
    """Azimuth of the middle from the load line; on the inner ring at shaft angle zero [rad]."""


class Payload(NamedTuple):
    """The bearing as the time loop sees it, SI units."""

    step: float
    """Time step [s]."""
    pocket_tangent: Floats
    """Unit vector along the pitch circle at each pocket at cage angle zero, shape (rows, rollers, 2) [-].

    A pocket at azimuth psi lies towards (sin psi, -cos psi) and has the tangent (cos psi, sin psi)."""
    inner_raceway_radius: float
    outer_raceway_radius: float
    pitch_radius: float
    roller_radius: float
    outer_ring_mass: float
    inner_ring_mass: float
    train_mass: float
    """Mass of a cage with its pinned rollers [kg]."""
    train_inertia: float
    """Moment of inertia of a cage with its pinned rollers, without their spin [kg m^2]."""
    roller_inertia: float
    gravity: float
    housing_stiffness: float
    housing_damping: float
    contact_modulus: float
    """pi E* L of the line contact [N/m]."""
    inner_scale: float
    """4 dR of roller and inner raceway, dR = r_I + r_R [m]."""
    outer_scale: float
    """4 dR of roller and outer raceway, dR = r_O - r_R [m]."""
    loss_time: float
    kinetic_coefficient: float
    static_coefficient: float
    stribeck_speed: float
    bristle_stiffness: float
    bristle_damping: float
    viscous: float
    inner_notches: Notches
    outer_notches: Notches
    speed_ramp: float
    load_ramp: float
