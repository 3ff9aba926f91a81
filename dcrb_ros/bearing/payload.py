"""From a configuration to what the kernels need: the payload and a settled start. The only bridge into the core."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from dcrb_ros.bearing.equilibrium import roller_forces, static_equilibrium
from dcrb_ros.bearing.states import Layout
from dcrb_ros.core.laws import NORMAL_LAWS, TRACTION_LAWS, lugre
from dcrb_ros.core.laws.interface import inner_site, outer_site, pair_site
from dcrb_ros.core.laws.pereira import pereira_coefficients
from dcrb_ros.core.layout.state import State, empty_state
from dcrb_ros.core.payload import EDGE, NOTCH, ROLLER_NOTCH, SINK, Notches, Payload, RollerNotches
from dcrb_ros.faults.defects import RacewayDefect, RollerDefect
from dcrb_ros.runtime.arrays import Floats
from dcrb_ros.settings.configuration import Configuration, material_of
from dcrb_ros.settings.parameters import Bearing


def layout(configuration: Configuration) -> Layout:
    """Return rows and rollers of the configured bearing."""
    return Layout(configuration.bearing.rows, configuration.bearing.rollers_per_row)


def pocket_azimuths(bearing: Bearing) -> Floats:
    """Return the azimuth of each pocket at cage angle zero, shape (rows, rollers) [rad].

    Roller 1 of row 1 stands in the middle of the loading zone; the second row is staggered by ``row_phase`` pitches.
    """
    pitch = 2.0 * math.pi / bearing.rollers_per_row
    stagger = bearing.row_phase * np.arange(bearing.rows)
    return pitch * (np.arange(bearing.rollers_per_row)[None, :] + stagger[:, None])


def _bottom(half_angle: float, edge: float, other: float, distance: float, hollow: bool) -> tuple[float, float]:
    """Return the angle on either side of a notch's middle over which the other body stands on its floor [rad], and by how much the slope
    of the depth drops at either end of that [m/rad].

    ``edge`` is the radius on which the notch's edges lie, ``other`` the other body's [m]; ``distance`` [m] is that of the centres with the
    floor in contact. ``hollow`` says that the other body is a raceway about the notched one.
    """
    squares = other**2 - edge**2 - distance**2 if hollow else distance**2 + edge**2 - other**2
    cosine = squares / (2.0 * distance * edge)
    inside = math.acos(min(cosine, 1.0)) if cosine > math.cos(half_angle) else half_angle
    sine, cosine = edge * math.sin(inside), edge * math.cos(inside)
    bend = sine * cosine / math.sqrt(other**2 - sine**2)
    return half_angle - inside, abs(bend - sine if hollow or distance < edge else bend + sine)


def _notches(defects: Iterable[RacewayDefect], raceway: float, roller: float, side: float, fillet: float) -> Notches:
    """Return the notches of a ring whose edges are rounded over a length ``fillet`` [m] beyond the width.

    ``side`` is 1 at the inner ring, -1 at the outer.
    """
    found = []
    for defect in defects:
        half, floor = 0.5 * defect.width / raceway, raceway + side * (roller - defect.depth)
        bottom, kink = _bottom(half, raceway, roller, floor, False)
        nearness = math.cos((0.5 * defect.width + fillet) / raceway)
        found.append((defect.row - 1, half, nearness, bottom, kink, defect.depth, defect.azimuth))
    return np.array(found, NOTCH).view(np.recarray)


def _roller_notches(defects: Iterable[RollerDefect], roller: float, inner: float, outer: float) -> RollerNotches:
    """Return the notches of rollers; ``inner`` and ``outer`` are the raceways' radii [m]."""
    found = []
    for defect in defects:
        half = 0.5 * defect.width / roller
        inner_bottom, inner_kink = _bottom(half, roller, inner, inner + roller - defect.depth, False)
        outer_bottom, outer_kink = _bottom(half, roller, outer, outer - roller + defect.depth, True)
        notch = (half, inner_bottom, outer_bottom, inner_kink, outer_kink, defect.depth, defect.azimuth)
        found.append((defect.row - 1, defect.roller - 1, *notch))
    return np.array(found, ROLLER_NOTCH).view(np.recarray)


def broken_bars(configuration: Configuration) -> npt.NDArray[np.bool_]:
    """Return whether the bar between a pocket and the next one is broken, shape (rows, rollers)."""
    broken = np.zeros((configuration.bearing.rows, configuration.bearing.rollers_per_row), np.bool_)
    for row, bar in configuration.faults.bars():
        broken[row - 1, bar - 1] = True
    return broken


def free_rollers(configuration: Configuration) -> npt.NDArray[np.bool_]:
    """Return which rollers are not pinned: all with pockets, otherwise those beside a broken bar, shape (rows, rollers)."""
    broken = broken_bars(configuration)
    if configuration.cage.joint == "pocket":
        return np.ones_like(broken)
    return broken | np.roll(broken, 1, axis=1)


def degrees_of_freedom(configuration: Configuration) -> int:
    """Return the free coordinates [-]: two rings and the cages in the plane, cages and rollers turning, free rollers moving."""
    b = configuration.bearing
    return 4 + 3 * b.rows + b.rows * b.rollers_per_row + 2 * int(free_rollers(configuration).sum())


def land_radius(configuration: Configuration) -> float:
    """Return the radius of the outer land [m]: as configured, or midway between pitch circle and outer raceway."""
    b = configuration.bearing
    return configuration.cage.land_radius or 0.5 * (b.pitch_radius + b.outer_raceway_radius)


def build_payload(configuration: Configuration) -> Payload:
    """Return the constants of the time loop."""
    c, b = configuration, configuration.bearing
    azimuth, free, broken = pocket_azimuths(b), free_rollers(c), broken_bars(c)
    fillet = c.contact.edge_radius if c.contact.notch == "edge" else 0.0
    tangent = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1)
    pinned = (~free).sum(axis=1)
    # All pinned: the sum of the tangents is zero but for rounding, which would make the motion depend on it.
    moment = b.roller_mass * b.pitch_radius * np.where(free[..., None], 0.0, tangent).sum(axis=1)
    moment[~free.any(axis=1)] = 0.0
    mass, inertia = b.cage_mass + pinned * b.roller_mass, b.cage_inertia + pinned * b.roller_mass * b.pitch_radius**2
    bar = pereira_coefficients(c.cage.pocket_clearance, b.roller_length, b.effective_modulus)
    land = pereira_coefficients(c.cage.land_clearance, b.roller_length, b.effective_modulus)
    material = material_of(b)
    cage_friction = {"kinetic_coefficient": c.cage.friction_coefficient, "static_coefficient": c.cage.friction_coefficient}
    return Payload(
        step=1.0 / c.step_rate,
        pocket_tangent=tangent,
        free=free,
        broken=broken,
        gaps=np.array([(row, i, (i + 1) % b.rollers_per_row) for row, i in np.argwhere(broken)], np.int64).reshape(-1, 3),
        beside=broken | np.roll(broken, 1, axis=1),
        all_free=bool(free.all()),
        any_broken=bool(broken.any()),
        any_free=bool(free.any()),
        any_notch=any(True for _ in c.faults.present()),
        inner_raceway_radius=b.inner_raceway_radius,
        outer_raceway_radius=b.outer_raceway_radius,
        pitch_radius=b.pitch_radius,
        roller_radius=b.roller_radius,
        outer_ring_mass=b.outer_ring_mass,
        inner_ring_mass=b.inner_ring_mass,
        roller_mass=b.roller_mass,
        roller_inertia=b.roller_inertia,
        train_mass=mass,
        train_inertia=inertia,
        train_moment=moment,
        train_inverse=np.stack([1.0 / mass, 1.0 / (inertia - (moment**2).sum(axis=1) / mass)], axis=1),
        gravity=c.operating.gravity,
        housing_stiffness=c.housing.stiffness,
        housing_damping=c.housing.damping,
        inner=inner_site(material),
        outer=outer_site(material),
        pair=pair_site(material),
        normal_law=NORMAL_LAWS[c.contact.law].build(dict(c.contact), material),
        traction_law=TRACTION_LAWS[c.friction.law].build(dict(c.friction), material),
        cage_traction_law=lugre.build(dict(c.friction) | cage_friction, material),
        loss_time=c.contact.loss_time,
        contact_damping=c.contact.damping,
        notch_law={"sink": SINK, "edge": EDGE}[c.contact.notch],
        edge_radius=c.contact.edge_radius,
        inner_notches=_notches(
            (defect for _, defect in c.faults.raceway_defects("inner")), b.inner_raceway_radius, b.roller_radius, 1.0, fillet
        ),
        outer_notches=_notches(
            (defect for _, defect in c.faults.raceway_defects("outer")), b.outer_raceway_radius, b.roller_radius, -1.0, fillet
        ),
        roller_notches=_roller_notches(
            (defect for _, defect in c.faults.roller_defects()), b.roller_radius, b.inner_raceway_radius, b.outer_raceway_radius
        ),
        pocket_clearance=c.cage.pocket_clearance,
        bar_coefficient=bar[0],
        bar_exponent=bar[1],
        land_clearance=c.cage.land_clearance,
        land_radius=land_radius(c),
        land_coefficient=land[0],
        land_exponent=land[1],
        impact_loss=0.75 * (1.0 - c.cage.restitution**2),
        speed_ramp=c.operating.speed_ramp,
        load_ramp=c.operating.load_ramp,
    )


def cage_speed(configuration: Configuration, shaft_speed: float) -> float:
    """Return the cage speed of pure rolling [rad/s]: rollers pinned at the pitch radius, or free between the raceways."""
    b = configuration.bearing
    orbit = b.pitch_radius if configuration.cage.joint == "revolute" else b.inner_raceway_radius + b.roller_radius
    return shaft_speed * b.inner_raceway_radius / (2.0 * orbit)


def roller_spin(bearing: Bearing, shaft_speed: float) -> float:
    """Return the absolute spin of a roller in pure rolling [rad/s]."""
    return -0.5 * shaft_speed * bearing.inner_raceway_radius / bearing.roller_radius


def initial_state(configuration: Configuration, payload: Payload) -> State:
    """Return the start: static equilibrium, warm (kinematic rolling) or cold (cage and rollers at rest)."""
    bearing, operating = configuration.bearing, configuration.operating
    state = empty_state(payload)
    state.load[:] = operating.lateral_load, -operating.load
    state.target[:] = operating.speed, *state.load
    state.shaft[1] = operating.speed
    orbit = cage_speed(configuration, operating.speed) if operating.start == "warm" else 0.0
    rest = static_equilibrium(payload, state.load, orbit)
    state.outer_position[:], state.inner_position[:], state.cage_position[:, :2] = rest.outer, rest.inner, rest.cages
    state.roller_position[:] = rest.rollers
    for force, contacts in zip(
        (state.inner_force, state.outer_force), roller_forces(payload, rest.outer, rest.inner, rest.rollers), strict=True
    ):
        force[:] = np.linalg.norm(contacts, axis=-1)
    if operating.start == "warm":
        state.cage_velocity[:, 2] = orbit
        arm = state.roller_position - state.cage_position[:, None, :2]
        state.roller_velocity[..., 0], state.roller_velocity[..., 1] = -orbit * arm[..., 1], orbit * arm[..., 0]
        state.roller_velocity[..., 2] = roller_spin(bearing, operating.speed)
    return state
