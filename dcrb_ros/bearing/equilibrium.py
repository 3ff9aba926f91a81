"""Static equilibrium of the bearing under its load, without friction: the initial positions of every run."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from dcrb_ros.bearing.surfaces import heights_at_contacts
from dcrb_ros.core.contacts import arrays
from dcrb_ros.core.contacts.notch import inner_notch_depth, outer_notch_depth, roller_notch_depth
from dcrb_ros.core.laws.calls import film_reach, normal_energy, normal_penetration
from dcrb_ros.core.laws.johnson import Johnson, johnson_stiffness
from dcrb_ros.core.laws.site import Site
from dcrb_ros.core.payload import SINK, Payload
from dcrb_ros.measurement.filter_cache import cached_at_start
from dcrb_ros.schema.arrays import Floats

START_PENETRATION = 2e-5
"""Penetration of the lowest roller at the start of the search [m]."""

BISECTIONS = 60
"""Halvings of the interval in which the position of a roller on its film is sought."""
MICROMETRE = 1e-6
TURN = 1e-7
"""Angle of the finite difference for the slope of a notch [rad]."""
MOST_STEPS = 100
"""Maximum number of steps of the last search; it needs three to ten, or oscillates in the last bits."""
EQUAL_WITHIN = 1e-9
"""Difference of positions below which rows of equal geometry get identical positions [m]; a notch in one row makes a larger one."""
LEAST_CONTACT_FORCE = 1e-3
"""Smallest force of a free roller on the outer raceway, so that its position is defined [N]."""
FIRST_BEARINGS = 4
"""Bearings of a process whose equilibrium is cached on disk [-]."""
RESOLUTION = 2.0**-43
"""Coordinates are rounded to a multiple of this [m], some mN at a raceway: the last bits of the search differ between processors, and idle
rollers would amplify them to a different run."""


class Rest(NamedTuple):
    """Positions of the bodies in equilibrium."""

    outer: Floats
    """Centre of the outer ring, shape (2,) [m]."""
    inner: Floats
    cages: Floats
    """Centres of the cages, shape (rows, 2) [m]."""
    rollers: Floats
    """Centres of the rollers, shape (rows, rollers, 2) [m]."""


def normal_forces(law: Any, penetration: Floats, site: Site) -> tuple[Floats, Floats]:
    """Return elastic forces [N] and stiffnesses [N/m] at penetrations [m]; any shape.

    Johnson's law with scipy's Lambert W instead of the kernels' fit, because recordings depend on its last bits.
    """
    if not isinstance(law, Johnson) or arrays.lubricated(site):
        return arrays.normal_forces(law, penetration, site)
    from scipy.special import lambertw

    closed = penetration > 0.0
    depth = np.where(closed, penetration, 1.0)
    force = np.where(closed, -law.modulus * depth / lambertw(-math.e * depth / site.scale, -1).real, 0.0)
    return force, np.where(closed, johnson_stiffness(law, np.where(closed, force, 1.0), site), 0.0)


def penetration_under(payload: Payload, force: Floats, site: Site) -> Floats:
    """Return the penetrations [m] under forces [N] above zero; any shape."""
    return np.asarray(normal_penetration(payload.normal_law, force, site))


def resting_penetration(payload: Payload, force: Floats, site: Site) -> Floats:
    """Return the penetrations [m], below zero on a film, at which rollers rest under forces [N] above zero; any shape."""
    if not arrays.lubricated(site):
        return penetration_under(payload, force, site)
    low, high = np.full(force.shape, -film_reach(site.film)), penetration_under(payload, force, site)
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        heavy = normal_forces(payload.normal_law, middle, site)[0] > force
        low, high = np.where(heavy, low, middle), np.where(heavy, middle, high)
    return 0.5 * (low + high)


def stored_energy(payload: Payload, penetration: Floats, site: Site) -> Floats:
    """Return the energy of contacts [J] at penetrations [m]; any shape."""
    return contact_energy(payload, normal_forces(payload.normal_law, penetration, site)[0], penetration, site)


def contact_energy(payload: Payload, force: Floats, penetration: Floats, site: Site) -> Floats:
    """Return the energy of contacts [J] at penetrations [m], where their force is known [N]; any shape."""
    if arrays.lubricated(site):
        return arrays.contact_energies(payload.normal_law, penetration, site)
    return energy_under(payload, force, penetration)


def energy_under(payload: Payload, force: Floats, penetration: Floats) -> Floats:
    """Return the energy of contacts [J] at penetrations [m] under their elastic forces [N]; any shape."""
    return np.asarray(normal_energy(payload.normal_law, arrays.no_memory(payload.normal_law), np.maximum(penetration, 0.0), force))


def radial_directions(payload: Payload) -> Floats:
    """Return the unit vectors from a cage's centre to its pockets at cage angle zero, shape (rows, rollers, 2) [-]."""
    tangent = payload.pocket_tangent
    return np.stack([tangent[..., 1], -tangent[..., 0]], axis=-1)


def _edges(direction: Floats, middle: float, half_angle: float) -> Floats:
    """Return the angles from the nearer edge of a notch into it [rad], negative outside; shape of ``direction`` without the last axis."""
    offset = np.arctan2(direction[..., 0], -direction[..., 1]) - middle
    return half_angle - np.abs(np.mod(offset + np.pi, 2.0 * np.pi) - np.pi)


def notch_depths(payload: Payload, from_ring: Floats, inner: bool) -> Floats:
    """Return the depth of the notches of raceway and rollers at the contacts, at shaft and spin angle zero, shape (rows, rollers) [m].

    Heights of the surfaces are included. Notches with the law `edge` are not: their edges have contact normals of their own.
    """
    depths = -heights_at_contacts(payload, from_ring, inner)
    if payload.notch_law != SINK:
        return depths
    raceway = payload.inner_raceway_radius if inner else payload.outer_raceway_radius
    law, notches = (inner_notch_depth, payload.inner_notches) if inner else (outer_notch_depth, payload.outer_notches)
    for notch in notches:
        edges = _edges(from_ring, notch.azimuth, notch.half_angle)
        rows = slice(None) if notch.row < 0 else slice(notch.row, notch.row + 1)
        for row, i in np.argwhere(edges[rows] > 0.0):
            at = row + max(notch.row, 0), i
            depths[at] += law(edges[at], notch.depth, raceway, payload.roller_radius)
    for notch in payload.roller_notches:
        at = notch.row, notch.roller
        share = payload.spin_share
        edge = float(_edges(-from_ring[at] if inner else from_ring[at], notch.azimuth, share * notch.half_angle)) / share
        depths[at] += roller_notch_depth(edge, notch.depth, raceway, payload.roller_radius, inner) if edge > 0.0 else 0.0
    return depths


def penetrations(
    payload: Payload, outer: Floats, inner: Floats, rollers: Floats, notch_depth: tuple[Floats, Floats] | None = None
) -> tuple[Floats, Floats, Floats, Floats]:
    """Return the vectors from inner and outer ring to each roller and the penetrations there [m].

    ``rollers`` contains the rollers' centres, shape (rows, rollers, 2). ``notch_depth`` contains the depths of the notches under them at
    the inner and the outer raceway, shape (rows, rollers) [m]; without it they follow from the positions.
    """
    from_inner, from_outer = rollers - inner, rollers - outer
    inner_depth = payload.inner_raceway_radius + payload.roller_radius - np.linalg.norm(from_inner, axis=-1)
    outer_depth = np.linalg.norm(from_outer, axis=-1) + payload.roller_radius - payload.outer_raceway_radius
    inner_notch, outer_notch = notch_depth or (notch_depths(payload, from_inner, True), notch_depths(payload, from_outer, False))
    return from_inner, from_outer, inner_depth - inner_notch, outer_depth - outer_notch


def roller_forces(payload: Payload, outer: Floats, inner: Floats, rollers: Floats) -> tuple[Floats, Floats]:
    """Return the forces on each roller from the inner and from the outer raceway, shape (rows, rollers, 2) [N]."""
    return _forces_and_energy(payload, outer, inner, rollers)[:2]


def _forces_and_energy(
    payload: Payload, outer: Floats, inner: Floats, rollers: Floats, notch_depth: tuple[Floats, Floats] | None = None
) -> tuple[Floats, Floats, float]:
    """Return `roller_forces`, and the energy of all contacts [J]."""
    from_inner, from_outer, inner_depth, outer_depth = penetrations(payload, outer, inner, rollers, notch_depth)
    inner_force = normal_forces(payload.normal_law, inner_depth, payload.inner)[0]
    outer_force = normal_forces(payload.normal_law, outer_depth, payload.outer)[0]
    energy = contact_energy(payload, inner_force, inner_depth, payload.inner).sum()
    energy += contact_energy(payload, outer_force, outer_depth, payload.outer).sum()
    return (
        from_inner * (inner_force / np.linalg.norm(from_inner, axis=-1))[..., None],
        -from_outer * (outer_force / np.linalg.norm(from_outer, axis=-1))[..., None],
        float(energy),
    )


def _within(offset: Floats, most: float) -> Floats:
    """Return an offset shortened to ``most`` [m]."""
    return offset * min(1.0, most / max(math.hypot(*offset), 1e-12))


class _Problem:
    """Energy and forces over the free coordinates: positions of the rings and of cages with pinned rollers, radii of free rollers.

    Free rollers keep their azimuth about the midpoint of the rings, as friction would hold them. A cage without pinned rollers is at that
    midpoint, or as close to it as its land allows.
    """

    def __init__(self, payload: Payload, load: Floats, orbit: float) -> None:
        self.payload, self.load = payload, load
        carried = np.array([0.0, payload.carried_weight]) - load
        self.preload = carried if payload.suspended else np.zeros(2)
        self.free, self.radial = payload.free, radial_directions(payload)
        self.carrying = ~payload.free.all(axis=1)
        self.first_free = 4 + 2 * int(self.carrying.sum())
        # Weight and centrifugal force decide on which raceway an unloaded free roller rests.
        weight = -payload.roller_mass * payload.gravity * self.radial[..., 1]
        self.outward = (weight + payload.roller_mass * payload.pitch_radius * orbit**2 + LEAST_CONTACT_FORCE)[self.free]

    def positions(self, x: Floats) -> Rest:
        """Return the positions of the bodies at coordinates ``x`` [m]."""
        outer, inner = x[:2], x[2:4]
        middle = 0.5 * (outer + inner)
        cages = np.tile(outer + _within(middle - outer, self.payload.land_clearance), (len(self.free), 1))
        cages[self.carrying] = x[4 : self.first_free].reshape(-1, 2)
        rollers = cages[:, None] + self.payload.pitch_radius * self.radial
        rollers[self.free] = middle + x[self.first_free :, None] * self.radial[self.free]
        return Rest(outer, inner, cages, rollers)

    def notch_depth(self, x: Floats) -> tuple[Floats, Floats]:
        """Return the depths of the notches under the rollers at the inner and the outer raceway, shape (rows, rollers) [m]."""
        rest = self.positions(x)
        return notch_depths(self.payload, rest.rollers - rest.inner, True), notch_depths(self.payload, rest.rollers - rest.outer, False)

    def balance(self, x: Floats, notch_depth: tuple[Floats, Floats] | None = None) -> tuple[float, Floats]:
        """Return the potential energy [J] and the generalised forces [N], which are zero in equilibrium.

        The forces are the derivative of the energy only if ``notch_depth`` fixes the depths of the notches, which exert no force along the
        raceway.
        """
        p, rest = self.payload, self.positions(x)
        inner, outer, contacts = _forces_and_energy(p, rest.outer, rest.inner, rest.rollers, notch_depth)
        weights = p.outer_ring_mass * rest.outer[1] + p.inner_ring_mass * rest.inner[1]
        weights += (p.train_mass * rest.cages[:, 1])[self.carrying].sum()
        housing = 0.5 * p.housing_stiffness * rest.outer @ rest.outer
        energy = contacts + housing + p.gravity * weights - self.load @ rest.inner - self.outward @ x[self.first_free :]
        energy -= self.preload @ rest.outer
        both = inner + outer
        rings = np.array([self.preload - p.housing_stiffness * rest.outer - outer.sum(axis=(0, 1)), self.load - inner.sum(axis=(0, 1))])
        rings += 0.5 * both[self.free].sum(axis=0)
        rings[:, 1] -= p.gravity * np.array([p.outer_ring_mass, p.inner_ring_mass])
        cages = np.where(self.free[..., None], 0.0, both).sum(axis=1)
        cages[:, 1] -= p.train_mass * p.gravity
        radii = (both[self.free] * self.radial[self.free]).sum(axis=-1) + self.outward
        return float(energy), np.concatenate([rings.ravel(), cages[self.carrying].ravel(), radii])

    def slope(self, x: Floats) -> Floats:
        """Return the derivatives of the generalised forces of `balance`, shape (coordinates, coordinates) [N/m].

        Those of the depths of notches are finite differences; they affect the steps of the search, not its result.
        """
        p, rest = self.payload, self.positions(x)
        along = self._motions(len(x))
        total = np.zeros((len(x), len(x)))
        total[:2, :2] -= p.housing_stiffness * np.eye(2)
        from_inner, from_outer, inner, outer = penetrations(p, rest.outer, rest.inner, rest.rollers)
        for ring, away, depth, site, sign in ((1, from_inner, inner, p.inner, 1.0), (0, from_outer, outer, p.outer, -1.0)):
            distance = np.linalg.norm(away, axis=-1)[..., None]
            normal = away / distance
            across = np.stack([-normal[..., 1], normal[..., 0]], axis=-1)
            ahead, behind = (notch_depths(p, away + turn * distance * across, ring == 1) for turn in (TURN, -TURN))
            closing = -sign * normal - (ahead - behind)[..., None] / (2.0 * TURN * distance) * across
            force, stiffness = (values[..., None] for values in normal_forces(p.normal_law, depth, site))
            block = (stiffness * sign * normal)[..., None] * closing[..., None, :]
            block += (sign * force / distance * across)[..., None] * across[..., None, :]
            moved = along.copy()
            moved[..., 2 * ring : 2 * ring + 2] -= np.eye(2)
            total += np.einsum("rnai,rnab,rnbj->ij", moved, block, moved)
        return total

    def _motions(self, count: int) -> Floats:
        """Return the derivatives of the rollers' positions with respect to the coordinates, shape (rows, rollers, 2, coordinates) [-]."""
        along = np.zeros((*self.free.shape, 2, count))
        along[self.free, :, :4] = 0.5 * np.tile(np.eye(2), 2)
        for k, row in enumerate(np.flatnonzero(self.carrying)):
            along[row, ~self.free[row], :, 4 + 2 * k : 6 + 2 * k] = np.eye(2)
        free = np.argwhere(self.free)
        along[free[:, 0], free[:, 1], :, self.first_free + np.arange(len(free))] = self.radial[self.free]
        return along

    def resting_on_raceways(self, x: Floats) -> Floats:
        """Return coordinates [m] in which free rollers without contact have moved to the raceway on which they rest."""
        p, rest = self.payload, self.positions(x)
        inner, outer = (depth[self.free] for depth in penetrations(p, rest.outer, rest.inner, rest.rollers)[2:])
        outside, weight = self.outward > 0.0, np.maximum(np.abs(self.outward), LEAST_CONTACT_FORCE)
        down = np.where(outside, resting_penetration(p, weight, p.outer) - outer, inner - resting_penetration(p, weight, p.inner))
        laid: Floats = x.copy()
        laid[self.first_free :] += np.where(np.maximum(inner, outer) > -film_reach(p.outer.film), 0.0, down)
        return laid

    def start(self) -> Floats:
        """Return coordinates [m] with the rings pressed together along the load, so that the search does not end in the radial gap."""
        p = self.payload
        pinned = p.train_mass.sum() if self.carrying.any() else 0.0
        total = self.load + np.array([0.0, -p.gravity * (p.inner_ring_mass + pinned)])
        size = float(np.linalg.norm(total))
        direction = total / size if size > 0.0 else np.array([0.0, -1.0])
        half_gap = 0.5 * (p.outer_raceway_radius - p.inner_raceway_radius) - p.roller_radius
        outer = (total + self.preload) / p.housing_stiffness
        inner = outer + (2.0 * half_gap + 2.0 * START_PENETRATION) * direction
        middle = 0.5 * (p.inner_raceway_radius + p.outer_raceway_radius) - p.pitch_radius
        cages = np.tile(outer + (half_gap + START_PENETRATION + middle) * direction, (int(self.carrying.sum()), 1))
        facing = self.radial[self.free] @ direction
        below = p.outer_raceway_radius - p.roller_radius - half_gap * facing + START_PENETRATION * np.maximum(facing, 0.0)
        above = p.inner_raceway_radius + p.roller_radius + half_gap * facing
        radii = np.where((facing > 0.0) | (self.outward > 0.0), below, above)
        return np.concatenate([outer, inner, cages.ravel(), radii])


def static_equilibrium(payload: Payload, load: Floats, orbit: float = 0.0) -> Rest:
    """Return the positions of the bodies under ``load`` [N] with the rollers orbiting at ``orbit`` [rad/s].

    The cages are at angle zero. A roller over a notch lies in it.
    """
    rest = _Problem(payload, load, orbit).positions(_equilibrium(payload, load, orbit))
    _make_equal_rows_identical(payload, rest)
    return rest


@cached_at_start(FIRST_BEARINGS)
def _equilibrium(payload: Payload, load: Floats, orbit: float) -> Floats:
    """Return the coordinates of the static equilibrium [m], multiples of `RESOLUTION`."""
    from scipy.optimize import least_squares, minimize

    problem = _Problem(payload, load, orbit)
    scale = max(float(np.linalg.norm(load)) + payload.inner_ring_mass * payload.gravity, 1.0)

    def energy(x: Floats) -> tuple[float, Floats]:
        height, left = problem.balance(x * MICROMETRE, notch_depth)
        return height / (scale * MICROMETRE), -left / scale

    def residual(x: Floats) -> Floats:
        left = problem.balance(x * MICROMETRE)[1]
        if payload.suspended:  # the preload is whatever keeps the outer ring at its seat
            left[:2] = -payload.housing_stiffness * MICROMETRE * x[:2]
        return left / scale

    def slope(x: Floats) -> Floats:
        jacobian = problem.slope(x * MICROMETRE)
        if payload.suspended:
            jacobian[:2] = 0.0
            jacobian[:2, :2] -= payload.housing_stiffness * np.eye(2)
        return jacobian * (MICROMETRE / scale)

    # Minimising the energy closes contacts for which the forces give no direction, but does not resolve forces of a newton. Two searches by
    # least squares follow: the first still moves the rings by more than the penetration of the lightest rollers.
    begin = problem.start()
    notch_depth = problem.notch_depth(begin)
    solution = minimize(energy, begin / MICROMETRE, jac=True, method="BFGS", options={"gtol": 1e-6, "maxiter": 5000}).x
    for _ in range(2):
        laid = problem.resting_on_raceways(solution * MICROMETRE) / MICROMETRE
        solution = least_squares(residual, laid, jac=slope, method="lm", xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=MOST_STEPS).x
    rounded: Floats = np.round(solution * MICROMETRE / RESOLUTION) * RESOLUTION + 0.0  # no negative zero
    return rounded


def _make_equal_rows_identical(payload: Payload, rest: Rest) -> None:
    """Make the positions of rows of equal geometry identical; rounding errors, which differ between machines, would separate them."""
    for row in range(1, len(rest.cages)):
        same = np.array_equal(payload.pocket_tangent[row], payload.pocket_tangent[0]) and np.array_equal(payload.free[row], payload.free[0])
        if same and np.allclose(rest.rollers[row], rest.rollers[0], rtol=0.0, atol=EQUAL_WITHIN):
            rest.cages[row], rest.rollers[row] = rest.cages[0], rest.rollers[0]
