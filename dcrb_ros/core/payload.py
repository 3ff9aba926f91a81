"""Everything constant that the kernels need, in one named tuple."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from dcrb_ros.core.jit import kernel
from dcrb_ros.core.laws.registry import law_of
from dcrb_ros.core.laws.site import Site
from dcrb_ros.core.layout.contacts import by_law
from dcrb_ros.core.layout.records import ByLaw, Flags, Floats, Integers

SINK, EDGE = 0, 1
"""Notch laws: the paper's depth, or edges with a contact normal of their own."""


Notches = np.recarray[Any, np.dtype[np.record]]
"""Raceway defects of one ring, an entry of the fields `NOTCH` each; one array of records, for each array costs compile time."""
RollerNotches = np.recarray[Any, np.dtype[np.record]]
"""Defects of rollers, an entry of the fields `ROLLER_NOTCH` each."""

NOTCH = np.dtype(
    [
        ("row", np.int64),  # of the defect, -1 for all rows
        ("half_angle", np.float64),  # half the angular width b/(2 r) [rad]
        ("nearness", np.float64),  # cosine of the angle from the middle at which the notch begins, its edges' fillets included [-]
        ("bottom", np.float64),  # angle on either side of the middle over which the roller touches the floor [rad]
        ("kink", np.float64),  # by how much the slope of the depth drops at either end of that [m/rad]
        ("depth", np.float64),  # h [m]
        ("azimuth", np.float64),  # of the middle from the load line; on the inner ring at shaft angle zero [rad]
    ]
)
ROLLER_NOTCH = np.dtype(
    [
        ("row", np.int64),
        ("roller", np.int64),
        ("half_angle", np.float64),  # half the angular width b/(2 r_R) [rad]
        ("inner_bottom", np.float64),  # angle on either side of the middle over which the inner raceway reaches the floor [rad]
        ("outer_bottom", np.float64),  # the same of the outer raceway
        ("inner_kink", np.float64),  # by how much the slope of the depth drops at either end of that [m/rad]
        ("outer_kink", np.float64),
        ("depth", np.float64),  # h [m]
        ("azimuth", np.float64),  # of the middle on the roller at spin angle zero, from -Y [rad]
    ]
)


class Payload(NamedTuple):
    """The constants of the bearing for the time loop, SI units."""

    step: float
    """Time step [s]."""
    pocket_tangent: Floats
    """Unit vector along the pitch circle at each pocket at cage angle zero, shape (rows, rollers, 2) [-].

    A pocket at azimuth psi lies towards (sin psi, -cos psi) and has the tangent (cos psi, sin psi)."""
    free: Flags
    """Whether a roller is a body of its own or pinned to its pocket, shape (rows, rollers)."""
    broken: Flags
    """Whether the bar between a pocket and the next one is broken, shape (rows, rollers)."""
    gaps: Integers
    """Row and rollers before and after each broken bar, shape (broken bars, 3)."""
    beside: Flags
    """Whether a roller lies free beside a broken bar, shape (rows, rollers)."""
    all_free: bool
    any_broken: bool
    any_free: bool
    any_defect: bool
    """Whether there is a notch."""
    inner_raceway_radius: float
    outer_raceway_radius: float
    pitch_radius: float
    roller_radius: float
    """In the plane: the roller's own times cos(alpha) [m]."""
    spin_share: float
    """cos(alpha): a roller's spin about its own axis over that of the plane's roller, both relative to the cage [-]."""
    outer_mass: float
    """Mass of the outer ring with the axle box [kg]."""
    inner_mass: float
    """Mass of the inner ring with the axle [kg]."""
    outer_ring_mass: float
    """Mass of the ring alone: what box and axle weigh is part of the load [kg]."""
    inner_ring_mass: float
    roller_mass: float
    roller_inertia: float
    """Of the plane's roller: the roller's own times cos(alpha)^2, with the same kinetic energy [kg m^2]."""
    train_mass: Floats
    """Mass of each cage with its pinned rollers, shape (rows,) [kg]."""
    train_inertia: Floats
    """Its moment of inertia about the cage's centre, without the rollers' spin, shape (rows,) [kg m^2]."""
    train_moment: Floats
    """Mass times lever of the pinned rollers along the tangents at cage angle zero, shape (rows, 2) [kg m]; zero when
    all rollers are pinned or all are free, for then the centre of mass is the cage's."""
    train_inverse: Floats
    """One over each train's mass, and over its moment of inertia about its centre of mass, shape (rows, 2) [1/kg, 1/(kg m^2)]."""
    gravity: float
    housing_stiffness: float
    """Of what holds the outer ring, in X and in Y [N/m]: the housing, in series with a primary suspension where there is one."""
    housing_damping: float
    """[N s/m]"""
    suspended: bool
    """Whether a primary suspension carries load and weight: its preload keeps the outer ring at its seat."""
    carried_weight: float
    """Weight that the suspension carries, without box and axle [N]."""
    inner: Site
    """Contact of a roller with the inner raceway."""
    outer: Site
    """Contact of a roller with the outer raceway."""
    pair: Site
    """Contact of two rollers."""
    normal_law: Any
    """Constants of the law of the normal force; their type chooses it, see `dcrb_ros.core.laws.interface`."""
    traction_law: Any
    """The same of traction between rollers and raceways."""
    lubrication: Any
    """The same of what is between them."""
    surfaces: Any
    """The same of their surfaces, see `dcrb_ros.core.contacts.surface`."""
    cage_traction_law: Any
    """The same of traction at bars and lands."""
    loss_time: float
    contact_damping: float
    """Constant damping of a closed contact [N s/m]."""
    notch_law: int
    edge_radius: float
    inner_notches: Notches
    outer_notches: Notches
    roller_notches: RollerNotches
    profile_height: float
    """How far the highest of all surfaces rises above the nominal one [m]."""
    pocket_clearance: Floats
    """Clearance between each roller and a bar, on either side, shape (rows, rollers) [m]."""
    bar_coefficient: Floats
    """Coefficient of the conformal contact with the bars of each pocket, Eq. 22, shape (rows, rollers) [N/m^exponent]."""
    bar_exponent: Floats
    """Its exponent, shape (rows, rollers) [-]."""
    land_clearance: float
    land_radius: float
    land_coefficient: float
    land_exponent: float
    impact_loss: float
    """3 (1 - c_e^2)/4 of Eq. 22 [-]."""
    speed_ramp: float
    load_ramp: float


def arrays_by_law(payload: Payload) -> ByLaw:
    """Return the arrays that the bearing's laws name in the tables of contacts."""
    laws = (payload.normal_law, payload.traction_law, payload.cage_traction_law, payload.lubrication)
    return by_law(*(law_of(constants) for constants in laws))


@kernel
def mobilities(payload: Payload) -> tuple[float, float]:
    """Return how a force changes a roller's mean velocity over a step, h/(2 m), and at its surface its rim speed, h r_R^2/(2 J) [s/kg]."""
    radius = payload.roller_radius
    return 0.5 * payload.step / payload.roller_mass, 0.5 * payload.step * radius * radius / payload.roller_inertia
