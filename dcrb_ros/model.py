"""From a configuration to what the kernels need: the payload and a settled start. The only bridge into the core."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from dcrb_ros.block import Floats, Layout
from dcrb_ros.configuration import Configuration
from dcrb_ros.core.payload import Notches, Payload
from dcrb_ros.core.state import State, empty_state
from dcrb_ros.equilibrium import static_equilibrium
from dcrb_ros.faults import Faults, RacewayDefect
from dcrb_ros.parameters import Bearing


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


def _notches(defects: Iterable[RacewayDefect], raceway_radius: float) -> Notches:
    found = [defect for defect in defects if defect.width > 0.0]
    return Notches(
        row=np.array([defect.row - 1 for defect in found], np.int64),
        half_angle=np.array([0.5 * defect.width / raceway_radius for defect in found], np.float64),
        depth=np.array([defect.depth for defect in found], np.float64),
        azimuth=np.array([defect.azimuth for defect in found], np.float64),
    )


def build_payload(configuration: Configuration) -> Payload:
    """Return the constants of the time loop."""
    c, b = configuration, configuration.bearing
    azimuth = pocket_azimuths(b)
    faults: Faults = c.faults
    return Payload(
        step=1.0 / c.step_rate,
        pocket_tangent=np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1),
        inner_raceway_radius=b.inner_raceway_radius,
        outer_raceway_radius=b.outer_raceway_radius,
        pitch_radius=b.pitch_radius,
        roller_radius=b.roller_radius,
        outer_ring_mass=b.outer_ring_mass,
        inner_ring_mass=b.inner_ring_mass,
        train_mass=b.cage_mass + b.rollers_per_row * b.roller_mass,
        train_inertia=b.cage_inertia + b.rollers_per_row * b.roller_mass * b.pitch_radius**2,
        roller_inertia=b.roller_inertia,
        gravity=c.operating.gravity,
        housing_stiffness=c.housing.stiffness,
        housing_damping=c.housing.damping,
        contact_modulus=math.pi * b.effective_modulus * b.roller_length,
        inner_scale=4.0 * (b.inner_raceway_radius + b.roller_radius),
        outer_scale=4.0 * (b.outer_raceway_radius - b.roller_radius),
        loss_time=c.contact.loss_time,
        kinetic_coefficient=c.friction.kinetic_coefficient,
        static_coefficient=c.friction.static_coefficient,
        stribeck_speed=c.friction.stribeck_speed,
        bristle_stiffness=c.friction.bristle_stiffness,
        bristle_damping=c.friction.bristle_damping,
        viscous=c.friction.viscous,
        inner_notches=_notches((faults.inner_1, faults.inner_2), b.inner_raceway_radius),
        outer_notches=_notches((faults.outer_1, faults.outer_2), b.outer_raceway_radius),
        speed_ramp=c.operating.speed_ramp,
        load_ramp=c.operating.load_ramp,
    )


def cage_speed(bearing: Bearing, shaft_speed: float) -> float:
    """Return the cage speed of pure rolling with the rollers pinned at the pitch radius [rad/s]."""
    return shaft_speed * bearing.inner_raceway_radius / (2.0 * bearing.pitch_radius)


def roller_spin(bearing: Bearing, shaft_speed: float) -> float:
    """Return the absolute spin of a roller in pure rolling with the rollers pinned at the pitch radius [rad/s]."""
    return -cage_speed(bearing, shaft_speed) * bearing.pitch_radius / bearing.roller_radius


def initial_state(configuration: Configuration, payload: Payload) -> State:
    """Return the start: static equilibrium, warm (kinematic rolling) or cold (cage and rollers at rest)."""
    bearing, operating = configuration.bearing, configuration.operating
    state = empty_state(bearing.rows, bearing.rollers_per_row)
    state.load[:] = operating.lateral_load, -operating.load
    state.target[:] = operating.speed, *state.load
    state.shaft[1] = operating.speed
    centres = static_equilibrium(payload, state.load)
    state.outer_position[:] = centres[0]
    state.inner_position[:] = centres[1]
    state.cage_position[:, :2] = centres[2:]
    if operating.start == "warm":
        state.cage_velocity[:, 2] = cage_speed(bearing, operating.speed)
        state.spin[:] = roller_spin(bearing, operating.speed)
    return state
