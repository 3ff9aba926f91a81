"""The equations of motion with multipliers and Baumgarte's terms (Eqs. 32 to 35), stepped by Runge-Kutta (Eqs. 39, 40)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dcrb_ros.bearing.payload import build_payload, initial_state, pocket_azimuths
from dcrb_ros.faults.broken_bars import BrokenBars
from dcrb_ros.faults.geometry import BrokenBar
from dcrb_ros.faults.raceway_defect import RacewayDefect
from dcrb_ros.reference.bodies import ANGLE, CAGE, INNER_RING, OUTER_RING, Bodies, pocket_directions
from dcrb_ros.reference.cage_fracture import IntactBars
from dcrb_ros.reference.constraints import Constraints
from dcrb_ros.reference.forces import Forces, Loading
from dcrb_ros.runtime.arrays import Floats
from dcrb_ros.runtime.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration

BAUMGARTE = 5e3
"""Feedback coefficients alpha and beta [1/s]; the paper leaves them open."""

OF_THE_PAPER = (RacewayDefect, BrokenBars)
"""Kinds of faults in the paper."""


class Motion(NamedTuple):
    """What Runge-Kutta integrates, or its rate."""

    position: Floats
    """Shape (bodies, 3) [m, m, rad]."""
    velocity: Floats
    """Shape (bodies, 3) [m/s, m/s, rad/s]."""
    bristle: Floats
    """Bristle deflections, shape (contacts,) [m]."""

    def moved(self, rate: Motion, time: float) -> Motion:
        """Return the motion after ``time`` [s] at a constant rate."""
        return Motion(*(value + time * slope for value, slope in zip(self, rate, strict=True)))


class History(NamedTuple):
    """A stretch of motion at the beginning of every step and at its end, n = steps + 1 instants."""

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


def start(configuration: Configuration, bodies: Bodies, contacts: int) -> Motion:
    """Return the start of the production model, every pinned roller at its pocket's centre and moving with it."""
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
    return Motion(position, velocity, np.zeros(contacts))


def refuse_beyond_the_paper(c: Configuration) -> None:
    """Refuse what the paper's formulation does not have."""
    beyond = {
        "cage.joint": c.cage.joint != "revolute",
        "contact.law": c.contact.law != "johnson",
        "contact.damping": c.contact.damping != 0.0,
        "contact.notch": c.contact.notch != "sink",
        "friction.convection": c.friction.convection != 0.0,
    }
    beyond |= {f"faults.{key}": True for key, fault in c.faults.present() if not isinstance(fault, OF_THE_PAPER)}
    for key, there in beyond.items():
        if there:
            raise Refusal(f"{key} goes beyond the paper, whose formulation the reference keeps: leave it at the paper's value")


class Reference:
    """The bearing of a configuration with all its coordinates; speed and load stay as configured.

    It knows what the paper knows: pinned rollers but for those beside broken bars, Johnson's contact, the paper's notch in
    a raceway, plain LuGre friction. ``baumgarte`` are alpha and beta [1/s].

    Raises:
        Refusal: a configuration that goes beyond the paper.
    """

    def __init__(self, configuration: Configuration, *, baumgarte: tuple[float, float] = (BAUMGARTE, BAUMGARTE)) -> None:
        refuse_beyond_the_paper(configuration)
        bearing = configuration.bearing
        broken = tuple((damage.row, damage.bar) for damage in configuration.faults.damage(bearing) if isinstance(damage, BrokenBar))
        self.bodies = Bodies(bearing.rows, bearing.rollers_per_row, broken)
        self.constraints = Constraints(self.bodies, bearing.pitch_radius, pocket_azimuths(bearing), configuration.operating.speed)
        self.bars = IntactBars(configuration, self.bodies)
        self.forces = Forces(configuration, self.bodies, self.bars)
        self.motion = start(configuration, self.bodies, self.forces.contact_count)
        self.time = 0.0
        self._alpha, self._beta = baumgarte
        self._inverse_mass = 1.0 / self.bodies.masses(bearing)
        # The rollers' columns of Phi_q are constant, and so is their share of Phi_q M^-1 Phi_q^T.
        self._frame = 3 * (CAGE + bearing.rows)
        rollers = self.constraints.jacobian(self.motion.position)[:, self._frame :]
        self._roller_share: Floats = (rollers * self._inverse_mass.ravel()[self._frame :]) @ rollers.T

    @property
    def degrees_of_freedom(self) -> int:
        """Coordinates less constraints: 10 + nr healthy, 14 + nr with a bar broken, 18 + nr with one in both rows [-]."""
        return self.bodies.degrees_of_freedom

    def acceleration(self, time: float, motion: Motion, force: Floats) -> Floats:
        """Solve Eq. 34 with Eq. 35's right-hand side for q'', shape (bodies, 3) [m/s^2, m/s^2, rad/s^2].

        M is diagonal, so q'' = M^-1 (Q_e - Phi_q^T lambda) is put into the constraints' rows and lambda solved first.
        """
        position, velocity, _ = motion
        jacobian = self.constraints.jacobian(position)
        drift, drift_rate = self.constraints.values(position, time), self.constraints.rates(jacobian, velocity)
        target = self.constraints.gamma(position, velocity) - 2.0 * self._alpha * drift_rate - self._beta**2 * drift
        weighted = jacobian * self._inverse_mass.ravel()
        matrix = self._roller_share + weighted[:, : self._frame] @ jacobian[:, : self._frame].T
        multipliers = np.linalg.solve(matrix, weighted @ force.ravel() - target)
        free: Floats = self._inverse_mass * force
        return free - (multipliers @ weighted).reshape(free.shape)

    def rate(self, time: float, motion: Motion) -> tuple[Motion, Loading]:
        """Return the rate of the motion and the forces behind it."""
        loading = self.forces.at(*motion)
        return Motion(motion.velocity, self.acceleration(time, motion, loading.force), loading.bristle_rate), loading

    def _step(self, k1: Motion, step: float) -> None:
        """Take one step of classical Runge-Kutta, Eqs. 39 and 40; ``k1`` is the rate at its beginning."""
        half, whole = self.time + 0.5 * step, self.time + step
        k2, _ = self.rate(half, self.motion.moved(k1, 0.5 * step))
        k3, _ = self.rate(half, self.motion.moved(k2, 0.5 * step))
        k4, _ = self.rate(whole, self.motion.moved(k3, step))
        mean = Motion(*((a + 2.0 * b + 2.0 * c + d) / 6.0 for a, b, c, d in zip(k1, k2, k3, k4, strict=True)))
        self.motion, self.time = self.motion.moved(mean, step), whole
        if self.bars.count:
            self.bars.latch(self.motion.position, self.motion.velocity)

    def advance(self, duration: float, step: float) -> History:
        """Advance by ``duration`` [s] in steps of ``step`` [s]; call it again to go on."""
        steps, instants = round(duration / step), []
        for n in range(steps + 1):
            rate, loading = self.rate(self.time, self.motion)
            # An open contact forgets its bristle. It bears no friction, so the rate stays true.
            self.motion = self.motion._replace(bristle=self.motion.bristle * loading.closed)
            drift = np.abs(self.constraints.values(self.motion.position, self.time)).max()
            acceleration = rate.velocity[OUTER_RING, :ANGLE]
            instants.append((self.time, acceleration, loading.inner_normal, loading.inner_ring_force, drift))
            if n < steps:
                self._step(rate, step)
        return History(*(np.array(series) for series in zip(*instants, strict=True)))
