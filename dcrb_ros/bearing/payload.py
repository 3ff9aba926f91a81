"""The kernels' constants and initial state from a configuration; the only module that builds them."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from dcrb_ros.bearing.cage_rest import settled_cages
from dcrb_ros.bearing.equilibrium import FIRST_BEARINGS, roller_forces, static_equilibrium
from dcrb_ros.bearing.individual import individual_of
from dcrb_ros.bearing.surfaces import build_surfaces
from dcrb_ros.core.contacts.heights import Smooth
from dcrb_ros.core.laws import LUBRICATION_LAWS, NORMAL_LAWS, TRACTION_LAWS, lugre
from dcrb_ros.core.laws.calls import film_at
from dcrb_ros.core.laws.pereira import pereira_coefficients
from dcrb_ros.core.laws.site import inner_site, outer_site, pair_site
from dcrb_ros.core.layout.state import SHAFT_SPEED, State, empty_state
from dcrb_ros.core.payload import EDGE, NOTCH, ROLLER_NOTCH, SINK, Notches, Payload
from dcrb_ros.faults.geometry import BrokenBar, RacewayNotch, RollerNotch
from dcrb_ros.measurement.filter_cache import cached_at_start
from dcrb_ros.measurement.random_streams import random_stream
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.loaded_contacts import cage_speed, material_of
from dcrb_ros.settings.parameters import Bearing
from dcrb_ros.stream.states import BodyNames


def body_names(configuration: Configuration) -> BodyNames:
    """Return the numbers of rows and rollers of the configured bearing, and with them the names of its bodies."""
    return BodyNames(configuration.bearing.rows, configuration.bearing.rollers_per_row)


def pocket_azimuths(bearing: Bearing) -> Floats:
    """Return the azimuth of each pocket at cage angle zero, shape (rows, rollers) [rad].

    Roller 1 of row 1 is in the middle of the load zone; the second row is offset by ``row_phase`` pitches.
    """
    pitch = 2.0 * math.pi / bearing.rollers_per_row
    stagger = bearing.row_phase * np.arange(bearing.rows)
    return pitch * (np.arange(bearing.rollers_per_row)[None, :] + stagger[:, None])


def start_azimuths(configuration: Configuration, places: Floats) -> Floats:
    """Return the azimuth of each pocket at cage angle zero, shape (rows, rollers) [rad], with deviations along the pitch circle [m].

    With ``operating.cage_angles`` drawn every cage starts somewhere within a pitch.
    """
    b = configuration.bearing
    azimuth = pocket_azimuths(b) + places / b.pitch_radius
    if configuration.operating.cage_angles == "drawn":
        pitches = random_stream(configuration.simulation.seed, "angles of the cages").random(b.rows)
        azimuth += pitches[:, None] * (2.0 * math.pi / b.rollers_per_row)
    return azimuth


def _records(damage: Iterable[RacewayNotch | RollerNotch], fields: np.dtype[np.void]) -> Notches:
    """Return notches as the records of the kernels."""
    return np.array([tuple(getattr(notch, name) for name in fields.names or ()) for notch in damage], fields).view(np.recarray)


def broken_bars(configuration: Configuration) -> npt.NDArray[np.bool_]:
    """Return whether the bar between a pocket and the next one is broken, shape (rows, rollers)."""
    broken = np.zeros((configuration.bearing.rows, configuration.bearing.rollers_per_row), np.bool_)
    for damage in configuration.faults.damage(configuration.bearing):
        if isinstance(damage, BrokenBar):
            broken[damage.row, damage.bar] = True
    return broken


def free_rollers(configuration: Configuration) -> npt.NDArray[np.bool_]:
    """Return which rollers are not pinned, shape (rows, rollers): all with the joint `pocket`, otherwise those beside a broken bar."""
    broken = broken_bars(configuration)
    if configuration.cage.joint == "pocket":
        return np.ones_like(broken)
    return broken | np.roll(broken, 1, axis=1)


def degrees_of_freedom(configuration: Configuration) -> int:
    """Return the number of degrees of freedom: two rings and the cages in the plane, rotation of cages and rollers, free rollers."""
    b = configuration.bearing
    return 4 + 3 * b.rows + b.rows * b.rollers_per_row + 2 * int(free_rollers(configuration).sum())


def land_radius(configuration: Configuration) -> float:
    """Return the radius of the outer land [m]: as configured, or midway between pitch circle and outer raceway."""
    b = configuration.bearing
    return configuration.cage.land_radius or 0.5 * (b.pitch_radius + b.outer_raceway_radius)


def mounting(configuration: Configuration) -> tuple[float, float, float]:
    """Return stiffness [N/m] and damping [N s/m] of what holds the outer ring, and the weight of the bearing on it [N]."""
    b, housing = configuration.bearing, configuration.housing
    weight = b.outer_ring_mass + b.inner_ring_mass + b.rows * (b.cage_mass + b.rollers_per_row * b.roller_mass)
    if housing.suspension_stiffness == 0.0:
        return housing.stiffness, housing.damping, weight * configuration.operating.gravity
    series = 1.0 / (1.0 / housing.stiffness + 1.0 / housing.suspension_stiffness)
    return series, housing.suspension_damping, weight * configuration.operating.gravity


def build_payload(configuration: Configuration, fastest: float | None = None) -> Payload:
    """Return the constants of the time loop; ``fastest`` is the present speed [rad/s], by default the configured one."""
    c, b = configuration, configuration.bearing
    free, broken, individual = free_rollers(c), broken_bars(c), individual_of(c)
    azimuth, clearance = start_azimuths(c, individual.pocket_places), c.cage.pocket_clearance + individual.pocket_clearance
    damage = c.faults.damage(b, c.contact.edge_radius if c.contact.notch == "edge" else 0.0)
    surfaces, highest = build_surfaces(c, damage, fastest)
    damage = damage if isinstance(surfaces, Smooth) else []
    raceway_notches = [notch for notch in damage if isinstance(notch, RacewayNotch)]
    roller_notches = [notch for notch in damage if isinstance(notch, RollerNotch)]
    tangent = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1)
    pinned = (~free).sum(axis=1)
    # With all rollers pinned the sum of the tangents is zero up to rounding, which must not influence the motion.
    moment = b.roller_mass * b.pitch_radius * np.where(free[..., None], 0.0, tangent).sum(axis=1)
    moment[~free.any(axis=1)] = 0.0
    # A centre of mass towards (sin psi, -cos psi) has the tangent (cos psi, sin psi).
    moment += b.cage_mass * np.stack([-individual.cage_unbalance[:, 1], individual.cage_unbalance[:, 0]], axis=-1)
    mass, inertia = b.cage_mass + pinned * b.roller_mass, b.cage_inertia + pinned * b.roller_mass * b.pitch_radius**2
    bars = np.array([pereira_coefficients(float(gap), b.roller_length, b.effective_modulus) for gap in clearance.ravel()])
    coefficient, exponent = bars.T.reshape(2, *clearance.shape)
    land = pereira_coefficients(c.cage.land_clearance, b.roller_length, b.effective_modulus)
    material = material_of(b)
    oil, orbit = LUBRICATION_LAWS[c.lubrication.law].build(dict(c.lubrication), material), cage_speed(c, c.operating.speed)
    stiffness, damping, weight = mounting(c)
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
        any_defect=bool(raceway_notches or roller_notches),
        inner_raceway_radius=b.inner_raceway_radius,
        outer_raceway_radius=b.outer_raceway_radius,
        pitch_radius=b.pitch_radius,
        roller_radius=b.roller_radius,
        spin_share=math.cos(b.contact_angle),
        outer_mass=b.outer_ring_mass + c.housing.box_mass,
        inner_mass=b.inner_ring_mass + c.housing.axle_mass,
        outer_ring_mass=b.outer_ring_mass,
        inner_ring_mass=b.inner_ring_mass,
        roller_mass=b.roller_mass,
        roller_inertia=b.roller_inertia * math.cos(b.contact_angle) ** 2,
        train_mass=mass,
        train_inertia=inertia,
        train_moment=moment,
        train_inverse=np.stack([1.0 / mass, 1.0 / (inertia - (moment**2).sum(axis=1) / mass)], axis=1),
        gravity=c.operating.gravity,
        housing_stiffness=stiffness,
        housing_damping=damping,
        suspended=c.housing.suspension_stiffness > 0.0,
        carried_weight=weight,
        inner=inner_site(material, film_at(oil, 0, (orbit - c.operating.speed) * b.inner_raceway_radius)),
        outer=outer_site(material, film_at(oil, 1, orbit * b.outer_raceway_radius)),
        pair=pair_site(material, film_at(oil, 2, 0.0)),
        normal_law=NORMAL_LAWS[c.contact.law].build(dict(c.contact), material),
        traction_law=TRACTION_LAWS[c.friction.law].build(dict(c.friction), material),
        lubrication=oil,
        cage_traction_law=lugre.build(dict(c.friction) | cage_friction, material),
        loss_time=c.contact.loss_time,
        contact_damping=c.contact.damping,
        notch_law={"sink": SINK, "edge": EDGE}[c.contact.notch],
        edge_radius=c.contact.edge_radius,
        inner_notches=_records((notch for notch in raceway_notches if notch.ring == "inner_ring"), NOTCH),
        outer_notches=_records((notch for notch in raceway_notches if notch.ring == "outer_ring"), NOTCH),
        roller_notches=_records(roller_notches, ROLLER_NOTCH),
        profile_height=highest,
        surfaces=surfaces,
        pocket_clearance=clearance,
        bar_coefficient=coefficient.copy(),
        bar_exponent=exponent.copy(),
        land_clearance=c.cage.land_clearance,
        land_radius=land_radius(c),
        land_coefficient=land[0],
        land_exponent=land[1],
        impact_loss=0.75 * (1.0 - c.cage.restitution**2),
        speed_ramp=c.operating.speed_ramp,
        load_ramp=c.operating.load_ramp,
    )


def roller_spin(bearing: Bearing, shaft_speed: float) -> float:
    """Return the absolute spin of a roller of the plane in pure rolling [rad/s]."""
    return -0.5 * shaft_speed * bearing.inner_raceway_radius / bearing.roller_radius


@cached_at_start(FIRST_BEARINGS)
def contact_forces(payload: Payload, outer: Floats, inner: Floats, rollers: Floats) -> Floats:
    """Return the magnitudes of `roller_forces`, shape (2, rows, rollers) [N]."""
    return np.asarray(np.linalg.norm(roller_forces(payload, outer, inner, rollers), axis=-1))


def initial_state(configuration: Configuration, payload: Payload) -> State:
    """Return the initial state: static equilibrium, with pure rolling (warm, settled) or with cage and rollers at rest (cold)."""
    bearing, operating = configuration.bearing, configuration.operating
    state = empty_state(payload)
    state.load[:] = operating.lateral_load, -operating.load
    state.target[:] = operating.speed, *state.load
    state.shaft[SHAFT_SPEED] = operating.speed
    orbit = cage_speed(configuration, operating.speed) if operating.start != "cold" else 0.0
    rest = static_equilibrium(payload, state.load, orbit)
    state.outer_position[:], state.inner_position[:], state.cage_position[:, :2] = rest.outer, rest.inner, rest.cages
    state.roller_position[:] = rest.rollers
    state.inner_force[:], state.outer_force[:] = contact_forces(payload, rest.outer, rest.inner, rest.rollers)
    if operating.start == "settled":
        state.cage_position[:, :2] = settled_cages(payload, rest)
    if operating.start != "cold":
        state.cage_velocity[:, 2] = orbit
        arm = state.roller_position - state.cage_position[:, None, :2]
        state.roller_velocity[..., 0], state.roller_velocity[..., 1] = -orbit * arm[..., 1], orbit * arm[..., 0]
        state.roller_velocity[..., 2] = roller_spin(bearing, operating.speed)
    return state
