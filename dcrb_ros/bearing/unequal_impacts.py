"""The tables and random numbers of passages over damage that differ, from a configuration; see `dcrb_ros.core.contacts.impacts`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dcrb_ros.bearing.damage_tables import COLUMNS, LEAST_HEIGHT, RACEWAY_NODES, RINGS, ROLLER_NODES, add_damage, rounded
from dcrb_ros.bearing.individual import Individual, surface_seed
from dcrb_ros.core.contacts.heights import HEIGHT, PART_HEIGHT, PART_SLOPE, SHARE, SLOPE, TURN
from dcrb_ros.core.contacts.impacts import BY_REBOUND, DEFECT, MOST_DEVIATION, Impacts, met
from dcrb_ros.core.laws import LUBRICATION_LAWS, hertz
from dcrb_ros.core.laws.calls import film_at, film_offset
from dcrb_ros.core.layout.records import Integers
from dcrb_ros.faults.geometry import BrokenBar, Damage, RacewayNotch, RollerNotch, SurfaceHeights
from dcrb_ros.measurement.random_streams import random_stream
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.impacts import OFF
from dcrb_ros.settings.loaded_contacts import cage_speed, contact_stiffness, heaviest, load_and_weight, material_of

LEAST_FASTEST = 200.0
"""Speed of the shaft up to which errors of times are never cut off [rad/s]: they need room beside the damage before it is met."""
ANGLES = 64
"""Angles of the shaft over which the mean strength is taken."""
HIGHEST_STRENGTH = 6.0
"""Standard deviations above the mean strength that the height of damage is allowed for [-]."""
NAMES = 2**30
"""Names of the random streams of defects."""


class UnequalDamage(NamedTuple):
    """Damage whose passages differ."""

    alike: list[Damage]
    """Damage that stays in the tables of the surfaces."""
    parts: Floats
    """Height [m], slope [m/rad], share and number of the damage of raceways, shape (2, rows, nodes, 4)."""
    defects: list[RacewayNotch | SurfaceHeights]
    """Damage of raceways, in the order of the numbers."""
    marks: Floats
    """Height [m] and slope [m/rad] of damage of balls whose axes of spin change, shape (2, marks, nodes + 1, 2)."""
    marked: list[RollerNotch]
    reach: Floats
    """How far errors of times may shift the damage of inner and outer raceway [rad], shape (2,)."""
    highest: float
    """How high damage rises [m]."""


def unequal_damage(c: Configuration, damage: Sequence[Damage], fastest: float | None = None) -> UnequalDamage:
    """Return damage in tables of its own; errors of times are whole at ``fastest``, the present speed, by default the configured one."""
    b, ratio = c.bearing, cage_speed(c, 1.0)
    parts = np.zeros((2, b.rows, RACEWAY_NODES, 4))
    most = MOST_DEVIATION * c.impacts.time_spread * max(abs(c.operating.speed if fastest is None else fastest), LEAST_FASTEST)
    reach = most * np.array([1.0 - ratio, ratio])
    alike: list[Damage] = []
    defects: list[RacewayNotch | SurfaceHeights] = []
    marked: list[RollerNotch] = []
    marks: list[Floats] = []
    for item in damage:
        if isinstance(item, BrokenBar) or (isinstance(item, RollerNotch) and c.impacts.spin_memory == 0.0):
            alike.append(item)
            continue
        table = np.zeros((2, b.rows, RACEWAY_NODES, COLUMNS))
        rollers = np.zeros((b.rows * b.rollers_per_row, ROLLER_NODES, 4))
        add_damage(c, item, table, rollers)
        if isinstance(item, RollerNotch):
            own = rounded(rollers[item.row * b.rollers_per_row + item.roller])
            marks.append(np.stack([np.concatenate([own[:, side : side + 2], own[:1, side : side + 2]]) for side in (0, 2)]))
            marked.append(item)
            continue
        defects.append(item)
        heights, slopes = rounded(table[..., HEIGHT] + table[..., PART_HEIGHT]), rounded(table[..., SLOPE] + table[..., PART_SLOPE])
        here = np.abs(heights) > LEAST_HEIGHT
        parts[..., 0] += heights
        parts[..., 1] += slopes
        parts[here, 2] = np.maximum(parts[here, 2], np.where(table[here, SHARE] > 0.0, table[here, SHARE], 1.0))
        parts[here, DEFECT] = len(defects)
        near = within_reach(here, reach)
        parts[near & (parts[..., DEFECT] == 0.0), DEFECT] = len(defects)
    of_marks = np.stack(marks, axis=1) if marks else np.zeros((2, 0, ROLLER_NODES + 1, 2))
    of_raceways, of_balls = float(parts[..., 0].max()), float(of_marks[..., 0].max(initial=0.0))
    highest = of_raceways * (1.0 + HIGHEST_STRENGTH * c.impacts.spread) + of_balls
    return UnequalDamage(alike, parts, defects, of_marks, marked, reach, highest)


def within_reach(here: npt.NDArray[np.bool_], reach: Floats) -> npt.NDArray[np.bool_]:
    """Return which nodes damage may be shifted to, shape (2, rows, nodes); ``here`` says where it is, ``reach`` [rad] how far."""
    near = np.array(here, np.bool_)
    for ring, far in enumerate(reach):
        steps = math.ceil(far / TURN * RACEWAY_NODES) + 1
        for row, there in enumerate(here[ring]):
            at = np.flatnonzero(there)
            for edge in at[(there[(at + 1) % len(there)] & there[at - 1]) == 0]:
                near[ring, row, np.arange(edge - steps, edge + steps + 1) % len(there)] = True
    return np.asarray(near, np.bool_)


def mean_strength(elements: Floats, shaft: float, white: float) -> float:
    """Return the mean of max(0, 1 + element + shaft cos(theta) + white n) over elements, angles and a normal number n [-]."""
    means = 1.0 + elements.ravel()[:, None] + shaft * np.cos(TURN / ANGLES * np.arange(ANGLES))[None, :]
    if white == 0.0:
        return float(np.maximum(means, 0.0).mean())
    ratio = means / white
    from scipy.special import ndtr

    return float((means * ndtr(ratio) + white * np.exp(-0.5 * ratio**2) / math.sqrt(2.0 * math.pi)).mean())


def impacts_of(c: Configuration, damaged: UnequalDamage, raceways: Integers, rollers: Integers) -> Impacts:
    """Return the surfaces as the kernels take them, from the nodes of raceways and rollers without the damage."""
    i, b, seed = c.impacts, c.bearing, surface_seed(c)
    drawn = random_stream(seed, "impacts of the rolling elements").standard_normal((b.rows, b.rollers_per_row))
    drawn = (drawn - drawn.mean(axis=1, keepdims=True)) / drawn.std(axis=1, keepdims=True)
    elements, shaft = i.spread * math.sqrt(i.element_share) * drawn, i.spread * math.sqrt(2.0 * i.shaft_share)
    white = i.spread * math.sqrt(max(1.0 - i.element_share - i.shaft_share, 0.0))
    latitudes, strengths = track_of_marks(c, damaged.marked)
    names = [round(item.azimuth * 1e6) % NAMES * 2 + RINGS.index(item.ring) for item in damaged.defects]
    return Impacts(
        raceways=raceways,
        rollers=rollers,
        parts=damaged.parts.astype(np.float32),
        partial=bool((damaged.parts[..., 2] > 0.0).any()),
        marks=damaged.marks.astype(np.float32),
        marked=np.array([item.row * b.rollers_per_row + item.roller for item in damaged.marked], np.int64),
        latitudes=latitudes,
        mark_strengths=strengths,
        middles=np.array([item.azimuth for item in damaged.defects], np.float64),
        names=np.array(names, np.int64),
        elements=elements,
        shaft=shaft,
        phase=TURN * float(random_stream(seed, "impacts over the angle of the shaft").random()),
        white=white * BY_REBOUND,
        by_mean=1.0 / mean_strength(elements, shaft, white),
        time_spread=i.time_spread,
        memory=i.spin_memory,
        orbit=cage_speed(c, 1.0),
        reach=damaged.reach,
        seed=int(random_stream(seed, "impacts").integers(2**31)),
    )


def track_of_marks(c: Configuration, marked: Sequence[RollerNotch]) -> tuple[Floats, Floats]:
    """Return up to which latitude marks on balls meet inner and outer raceway [rad], and their strength on the track [-], shape (2, marks).

    A mark of the diameter d meets a contact of the semimajor axis a on a ball of the radius r up to (d/2 + a)/r; it takes the share d/(2 a)
    of the contact's length.
    """
    latitudes, strengths = np.ones((2, len(marked))), np.ones((2, len(marked)))
    if not marked:
        return latitudes, strengths
    b = c.bearing
    for ring, curvature in enumerate(hertz.curvatures(dict(c.contact), material_of(b))):
        long = hertz.semiaxes(curvature, heaviest(c), b.effective_modulus)[0]
        for mark, item in enumerate(marked):
            diameter = 2.0 * item.half_angle * b.roller_radius
            latitudes[ring, mark] = min((0.5 * diameter + long) / b.own_roller_radius, 0.5 * math.pi)
            strengths[ring, mark] = min(0.5 * diameter / long, 1.0)
    return latitudes, strengths


def film_thicknesses(c: Configuration) -> float:
    """Return the sum of the films by which both raceways hold a rolling element away at the configured speed [m]."""
    b, ratio = c.bearing, cage_speed(c, 1.0)
    oil, speed = LUBRICATION_LAWS[c.lubrication.law].build(dict(c.lubrication), material_of(b)), c.operating.speed
    speeds = (ratio - 1.0) * speed * b.inner_raceway_radius, ratio * speed * b.outer_raceway_radius
    return sum(float(film_offset(film_at(oil, raceway, entrained))) for raceway, entrained in enumerate(speeds))


def axial_interference(c: Configuration, individual: Individual) -> float:
    """Return by how much the outer raceway is raised for the axial preload [m].

    In the plane an axial preload acts as an interference d_0 that loads all rolling elements, Q(psi) proportional to
    (d_0 + d_r cos psi)^n. For a share phi of the largest load at a quarter turn, d_0/d_r = x/(1 - x), x = phi^(1/n). The load that the
    bearing carries gives d_r; so the load zone that is simulated already is replaced, not multiplied. Clearance, its deviation and the
    films are taken off.
    """
    if c.impacts.axial_share == OFF:
        return 0.0
    b, balls = c.bearing, c.contact.law == hertz.LAW.name
    exponent = 1.5 if balls else 10.0 / 9.0
    root = c.impacts.axial_share ** (1.0 / exponent)
    ratio = root / (1.0 - root)
    cosine = np.cos(TURN / ANGLES * np.arange(ANGLES))
    carried = b.rollers_per_row * float((np.maximum(ratio + cosine, 0.0) ** exponent * cosine).mean())
    largest = load_and_weight(c) / b.rows * (ratio + 1.0) ** exponent / carried
    # Force over approach of a power law from its stiffness; the two raceways lie in series.
    approach = 2.0 * exponent * float(largest) / contact_stiffness(c, float(largest))
    taken_up = float(b.radial_gap) + 0.5 * individual.clearance - float(individual.row_radii.mean()) - film_thicknesses(c)
    return float(taken_up + approach * ratio / (1.0 + ratio))


def start_strength(impacts: Impacts, ring: int, row: int, angles: Floats, nodes: npt.NDArray[np.int64]) -> Floats:
    """Return the strengths with which rollers at some angles [rad] rest in the damage at some nodes, at cage and shaft angle zero."""
    strengths = np.ones(len(angles))
    for i, (angle, node) in enumerate(zip(angles, nodes, strict=True)):
        number = int(impacts.parts[ring, row, [node, (node + 1) % RACEWAY_NODES], DEFECT].max())
        if number > 0:
            strengths[i] = met(impacts, ring, row, i, float(angle), number - 1, 0.0, 0.0, 0.0)[0]
    return strengths
