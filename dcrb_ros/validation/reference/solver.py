"""The equations of motion with Lagrange multipliers and Baumgarte stabilisation (Eqs. 32 to 35 of Fan et al. 2025).

They are integrated by the classical Runge-Kutta method of order 4 (Eqs. 39 and 40).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from dcrb_ros.bearing.payload import build_payload, initial_state, pocket_azimuths
from dcrb_ros.faults.broken_bars import BrokenBars
from dcrb_ros.faults.geometry import BrokenBar
from dcrb_ros.faults.raceway_defect import RacewayDefect
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.validation.reference.bodies import ANGLE, CAGE, INNER_RING, OUTER_RING, Bodies, pocket_directions
from dcrb_ros.validation.reference.cage_fracture import IntactBars
from dcrb_ros.validation.reference.constraints import Constraints
from dcrb_ros.validation.reference.forces import ExternalForces, Forces

BAUMGARTE = 5e3
"""Feedback coefficients alpha and beta [1/s], which the paper does not give."""

LARGEST_DECAY = 2.0
"""Largest product of a bristle's rate and the step [-]: a bristle that relaxes faster makes the Runge-Kutta method unstable, from 2.785 on.

Where a contact slides at several metres per second, as a freed roller's on a bar, the rate is 1e7 1/s, and a step of 1 us is divided."""

PAPER_FAULTS = (RacewayDefect, BrokenBars)
"""Kinds of faults that the paper includes."""


class State(NamedTuple):
    """The integrated quantities, or their rates."""

    position: Floats
    """Positions, shape (bodies, 3) [m, m, rad]."""
    velocity: Floats
    """Velocities, shape (bodies, 3) [m/s, m/s, rad/s]."""
    bristle: Floats
    """Bristle deflections, shape (contacts,) [m]."""

    def moved(self, rate: State, time: float) -> State:
        """Return the state after ``time`` [s] at a constant rate."""
        return State(*(value + time * slope for value, slope in zip(self, rate, strict=True)))


class History(NamedTuple):
    """The motion at the start of every step and at the end, n = steps + 1 instants."""

    time: Floats
    """Shape (n,) [s]."""
    outer_acceleration: Floats
    """Acceleration of the outer ring in X and Y, shape (n, 2) [m/s^2]."""
    inner_normal: Floats
    """Normal forces at the inner raceway, shape (n, rows, rollers) [N]."""
    inner_ring_force: Floats
    """Force of the rollers on the inner ring in X and Y, shape (n, 2) [N]."""
    drift: Floats
    """Largest violation of a constraint, max |Phi|, shape (n,) [m or rad]."""


def start(configuration: Configuration, bodies: Bodies, contacts: int) -> State:
    """Return the initial state of the production solver, with every pinned roller at the centre of its pocket and moving with it."""
    bearing, state = configuration.bearing, initial_state(configuration, build_payload(configuration))
    position, velocity = np.zeros((bodies.count, 3)), np.zeros((bodies.count, 3))
    position[OUTER_RING, :ANGLE], velocity[OUTER_RING, :ANGLE] = state.outer_position, state.outer_velocity
    position[INNER_RING], velocity[INNER_RING] = (*state.inner_position, state.shaft[0]), (*state.inner_velocity, state.shaft[1])
    bodies.cages(position)[:], bodies.cages(velocity)[:] = state.cage_position, state.cage_velocity
    n, tau = pocket_directions(pocket_azimuths(bearing) + state.cage_position[:, ANGLE, None])
    rollers, speeds = bodies.rollers(position), bodies.rollers(velocity)
    pins = state.cage_position[:, None, :ANGLE] + bearing.pitch_radius * n
    rollers[..., :ANGLE] = np.where(bodies.pinned[..., None], pins, state.roller_position)
    rim_speed = bearing.pitch_radius * state.cage_velocity[:, ANGLE]
    carried = state.cage_velocity[:, None, :ANGLE] + rim_speed[:, None, None] * tau
    speeds[..., :ANGLE] = np.where(bodies.pinned[..., None], carried, state.roller_velocity[..., :ANGLE])
    rollers[..., ANGLE], speeds[..., ANGLE] = state.spin_angle, state.roller_velocity[..., ANGLE]
    return State(position, velocity, np.zeros(contacts))


def check_supported(c: Configuration) -> None:
    """Refuse settings that the paper's formulation does not include."""
    unsupported = {
        "cage.joint": c.cage.joint != "revolute",
        "contact.law": c.contact.law != "johnson",
        "contact.damping": c.contact.damping != 0.0,
        "contact.notch": c.contact.notch != "sink",
        "friction.convection": c.friction.convection != 0.0,
        "lubrication.law": c.lubrication.law != "dry",
        "surfaces.law": c.surfaces.law != "smooth",
        "housing.box_mass": c.housing.box_mass != 0.0,
        "housing.axle_mass": c.housing.axle_mass != 0.0,
    }
    unsupported |= {f"faults.{key}": True for key, fault in c.faults.present() if not isinstance(fault, PAPER_FAULTS)}
    for key, used in unsupported.items():
        if used:
            raise Refusal(f"{key} is not part of the paper's formulation, which the reference solver uses: set it to the paper's value")


class ReferenceSolver:
    """The reference solver for a configuration; speed and load are constant.

    It has the parts of the paper's model: rollers pinned to their pockets except beside broken bars, Johnson's contact law, the
    paper's raceway defects, and LuGre friction.

    Raises:
        Refusal: the configuration uses something that the paper does not include.
    """

    def __init__(self, configuration: Configuration) -> None:
        check_supported(configuration)
        bearing = configuration.bearing
        broken = tuple((damage.row, damage.bar) for damage in configuration.faults.damage(bearing) if isinstance(damage, BrokenBar))
        self.bodies = Bodies(bearing.rows, bearing.rollers_per_row, broken)
        self.constraints = Constraints(self.bodies, bearing.pitch_radius, pocket_azimuths(bearing), configuration.operating.speed)
        self.bars = IntactBars(configuration, self.bodies)
        self.forces = Forces(configuration, self.bodies, self.bars)
        self.state = start(configuration, self.bodies, self.forces.contact_count)
        self.time = 0.0
        self._inverse_mass = 1.0 / self.bodies.masses(bearing)
        # The rollers' columns of Phi_q are constant, and so is their contribution to Phi_q M^-1 Phi_q^T.
        self._frame = 3 * (CAGE + bearing.rows)
        rollers = self.constraints.jacobian(self.state.position)[:, self._frame :]
        self._roller_share: Floats = (rollers * self._inverse_mass.ravel()[self._frame :]) @ rollers.T

    def acceleration(self, time: float, state: State, force: Floats) -> Floats:
        """Return q'' of Eq. 34 with the right-hand side of Eq. 35, shape (bodies, 3) [m/s^2, m/s^2, rad/s^2].

        M is diagonal, so q'' = M^-1 (Q_e - Phi_q^T lambda) is inserted into the constraint equations, which are solved for lambda.
        """
        position, velocity, _ = state
        jacobian = self.constraints.jacobian(position)
        drift, drift_rate = self.constraints.values(position, time), self.constraints.rates(jacobian, velocity)
        target = self.constraints.gamma(position, velocity) - 2.0 * BAUMGARTE * drift_rate - BAUMGARTE**2 * drift
        weighted = jacobian * self._inverse_mass.ravel()
        matrix = self._roller_share + weighted[:, : self._frame] @ jacobian[:, : self._frame].T
        multipliers = np.linalg.solve(matrix, weighted @ force.ravel() - target)
        free: Floats = self._inverse_mass * force
        return free - (multipliers @ weighted).reshape(free.shape)

    def rate(self, time: float, state: State) -> tuple[State, ExternalForces]:
        """Return the rate of the state and the external forces."""
        forces = self.forces.at(*state)
        return State(state.velocity, self.acceleration(time, state, forces.force), forces.bristle_rate), forces

    def _step(self, k1: State, step: float) -> None:
        """Take one step [s] of the classical Runge-Kutta method, Eqs. 39 and 40; ``k1`` is the rate at its start."""
        half, whole = self.time + 0.5 * step, self.time + step
        k2, _ = self.rate(half, self.state.moved(k1, 0.5 * step))
        k3, _ = self.rate(half, self.state.moved(k2, 0.5 * step))
        k4, _ = self.rate(whole, self.state.moved(k3, step))
        mean = State(*((a + 2.0 * b + 2.0 * c + d) / 6.0 for a, b, c, d in zip(k1, k2, k3, k4, strict=True)))
        self.state, self.time = self.state.moved(mean, step), whole
        if self.bars.count:
            self.bars.latch(self.state.position, self.state.velocity)

    def _present(self) -> tuple[State, ExternalForces]:
        """Reset the bristles of open contacts and return the rate of the state and the external forces."""
        rate, forces = self.rate(self.time, self.state)
        # An open contact has no friction, so the rate is unaffected.
        self.state = self.state._replace(bristle=self.state.bristle * forces.closed)
        return rate, forces

    def _step_in_parts(self, rate: State, relaxation: float, step: float) -> None:
        """Take one step [s], divided so that no bristle relaxes by more than `LARGEST_DECAY` in a part; its rates are in [1/s]."""
        parts = max(1, math.ceil(relaxation * step / LARGEST_DECAY))
        self._step(rate, step / parts)
        for _ in range(parts - 1):
            self._step(self._present()[0], step / parts)

    def advance(self, duration: float, step: float) -> History:
        """Advance by ``duration`` [s] in steps of ``step`` [s] and return the motion; further calls continue from there.

        A step is divided while a contact slides so fast that its bristle would make it unstable.
        """
        steps, instants = round(duration / step), []
        for n in range(steps + 1):
            rate, forces = self._present()
            drift = np.abs(self.constraints.values(self.state.position, self.time)).max()
            acceleration = rate.velocity[OUTER_RING, :ANGLE]
            instants.append((self.time, acceleration, forces.inner_normal, forces.inner_ring_force, drift))
            if n < steps:
                self._step_in_parts(rate, forces.relaxation, step)
        return History(*(np.array(series) for series in zip(*instants, strict=True)))
