"""Passages over damage that differ: the heights of a defect are multiplied by a strength g_k/E(g) at its passage k,

    g_k = max(0, 1 + kappa (sqrt(beta) b_j + sqrt(2 sigma) cos(theta_k + phi) + sqrt(1 - beta - sigma) w_k)),
    w_k = (e_k - 0.2 e_(k-1))/1.02,

b_j of the rolling element, theta_k the shaft's angle, e_k standard normal. The lag is that of rings that rebound (measured, see
`docs/explanation/surfaces.md`). Each passage is late by a time of its own, over which the element rolls on.

The number of a passage follows from the turns of the cage against the ring, so that nothing has to be remembered: every run over the same
way has the same passages.

A mark on a ball lies on its track only now and then: the axis of its spin is a direction in space that changes continuously. It is the
direction of a vector of three normal numbers that goes over into an independent one within ``memory``, and so uniform on the sphere.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from dcrb_ros.core.contacts.chance import key_of, normal_of
from dcrb_ros.core.contacts.heights import TURN, interpolated
from dcrb_ros.core.contacts.tilt import write_tilt
from dcrb_ros.core.jit import kernel, piece
from dcrb_ros.core.layout.contacts import RacewayContact
from dcrb_ros.core.layout.records import Floats, Integers, SingleFloats
from dcrb_ros.core.layout.state import CAGE, SHAFT_ANGLE, SHAFT_SPEED, State
from dcrb_ros.core.payload import Payload

REBOUND = 0.2
"""Share of the strength of an impact by which the next one is weaker [-]; measured on three rigs, see the documentation."""
BY_REBOUND = 1.0 / math.sqrt(1.0 + REBOUND * REBOUND)
MOST_DEVIATION = 3.0
"""Standard deviations of the errors of times at most [-]."""
OF_TIMES, OF_SPINS = 0x54494D45, 0x5350494E
"""Names of the streams of times and of spins."""
DEFECT = 3
"""Column of a defect's number, counted from one, in `Impacts.parts`."""


class Impacts(NamedTuple):
    """Heights as in `dcrb_ros.core.contacts.heights.Profile`, with damage in tables of its own whose passages differ."""

    raceways: Integers
    """As in `Profile`, without damage; the mark of a node says that damage may be met near it."""
    rollers: Integers
    """As in `Profile`, without damage if the axes of spin change."""
    parts: SingleFloats
    """Height [m] and slope [m/rad] of damage, the share of the length that it takes [-] and its number, shape (2, rows, nodes, 4)."""
    partial: bool
    marks: SingleFloats
    """Height [m] and slope [m/rad] of damage of rollers whose axes of spin change, shape (2, marks, nodes + 1, 2)."""
    marked: Integers
    """The roller of each, shape (marks,)."""
    latitudes: Floats
    """Latitude up to which each is met [rad], shape (2, marks)."""
    mark_strengths: Floats
    """Its strength on the track [-], shape (2, marks)."""
    middles: Floats
    """Azimuth of the middle of each defect of a raceway [rad]."""
    names: Integers
    """The name of the random stream of each."""
    elements: Floats
    """kappa sqrt(beta) b of the rolling elements, shape (rows, rollers) [-]."""
    shaft: float
    """kappa sqrt(2 sigma) [-]"""
    phase: float
    """phi [rad]"""
    white: float
    """kappa sqrt(1 - beta - sigma)/1.02 [-]"""
    by_mean: float
    """1/E(g) [-]"""
    time_spread: float
    """[s]"""
    memory: float
    """Time in which an axis of spin turns to an independent direction [s]; 0 for axes that stay."""
    orbit: float
    """Speed of the cage over that of the shaft in pure rolling [-]."""
    reach: Floats
    """How far the errors of times may shift damage on inner and outer raceway [rad], shape (2,)."""
    seed: int


@kernel
def passage_of(cage: float, turn: float, pocket: float, offset: float, middle: float, rollers: int, i: int) -> int:
    """Return the number of a roller's passage over a defect, which counts all rollers of the row.

    ``cage`` is the cage's angle and ``turn`` the ring's, ``pocket`` the nominal azimuth of the roller's pocket, ``offset`` the way from
    the defect's ``middle`` to the contact [rad].
    """
    return math.floor((cage - turn + pocket - offset - middle) * (1.0 / TURN) + 0.5) * rollers - i


@kernel
def strength_of(impacts: Impacts, name: int, row: int, i: int, passage: int, shaft: float) -> float:
    """Return the strength [-] of a roller's passage over a defect at an angle of the shaft [rad]."""
    now, before = normal_of(key_of(impacts.seed, name, row, passage)), normal_of(key_of(impacts.seed, name, row, passage - 1))
    deviation = impacts.elements[row, i] + impacts.shaft * math.cos(shaft + impacts.phase) + impacts.white * (now - REBOUND * before)
    return max(1.0 + deviation, 0.0) * impacts.by_mean


@kernel
def delay_of(impacts: Impacts, name: int, row: int, passage: int) -> float:
    """Return the error of the time of a passage [s]."""
    deviation = normal_of(key_of(impacts.seed ^ OF_TIMES, name, row, passage))
    return impacts.time_spread * max(min(deviation, MOST_DEVIATION), -MOST_DEVIATION)


@kernel
def wrapped(angle: float) -> float:
    """Return an angle within half a turn [rad]."""
    return angle - TURN * math.floor(angle * (1.0 / TURN) + 0.5)


@kernel
def met(
    impacts: Impacts, ring: int, row: int, i: int, angle: float, defect: int, cage: float, turn: float, speed: float
) -> tuple[float, float]:
    """Return the strength [-] of a passage over a defect, and by how much it is shifted along the raceway [rad].

    ``angle`` is that of the contact on the raceway, ``cage`` the cage's angle and ``turn`` the shaft's [rad], ``speed`` the shaft's
    [rad/s]; ``ring`` is 0 for the inner one.
    """
    middle, name, rollers = impacts.middles[defect], impacts.names[defect], impacts.elements.shape[1]
    offset = wrapped(angle - middle)
    of_ring = turn if ring == 0 else 0.0
    passage = passage_of(cage, of_ring, TURN / rollers * i, offset, middle, rollers, i)
    # The shaft's angle when the roller is at the middle, by pure rolling: one angle for the whole passage.
    relative = impacts.orbit - 1.0 if ring == 0 else impacts.orbit
    strength = strength_of(impacts, name, row, i, passage, turn - offset / relative)
    shift = delay_of(impacts, name, row, passage) * relative * speed
    return strength, max(min(shift, impacts.reach[ring]), -impacts.reach[ring])


@piece
def write_unequal_part(
    impacts: Impacts, payload: Payload, state: State, contact: RacewayContact, k: int, ring: int, row: int, c: int, node: int, way: float
) -> None:
    """Write height and tilt of the damage under a contact at the strength of its passage, and the share of the length that it takes."""
    parts = impacts.parts[ring, row]
    nodes = parts.shape[0]
    after = node + 1 if node + 1 < nodes else 0
    spacing, number = TURN / nodes, max(parts[node, DEFECT], parts[after, DEFECT])
    contact.share[k] = 0.0
    if number > 0.0:
        cage, turn, speed = state.position[CAGE + row, 2], state.shaft[SHAFT_ANGLE], state.shaft[SHAFT_SPEED]
        i = c - row * payload.free.shape[1]
        strength, shift = met(impacts, ring, row, i, (node + way) * spacing, int(number) - 1, cage, turn, speed)
        place = node + way - shift / spacing
        whole = math.floor(place)
        way = place - whole
        node = int(whole) & (nodes - 1)
        after = node + 1 if node + 1 < nodes else 0
        height, slope = interpolated(parts[node, 0], parts[after, 0], parts[node, 1], parts[after, 1], spacing, way)
        share, tilt = max(parts[node, 2], parts[after, 2]), strength * slope / contact.distance[k]
        if share < 1.0:
            contact.share[k], contact.part_height[k], contact.part_tilt[k] = share, strength * height, tilt
        else:
            contact.penetration[k] += strength * height
            write_tilt(contact, k, contact.tilt[k] + (-tilt if ring == 0 else tilt), speed if ring == 0 else 0.0)


@kernel
def latitude_of(impacts: Impacts, mark: int, time: float) -> float:
    """Return the latitude of a mark on a ball over its track at a time [s], [rad]."""
    place = time / impacts.memory
    knot = math.floor(place)
    before, after = math.cos(0.25 * TURN * (place - knot)), math.sin(0.25 * TURN * (place - knot))
    square, along, n = 0.0, 0.0, int(knot)
    for axis in range(3):
        stream = impacts.seed ^ OF_SPINS
        here = before * normal_of(key_of(stream, mark, axis, n)) + after * normal_of(key_of(stream, mark, axis, n + 1))
        square += here * here
        along = here
    return math.asin(along / math.sqrt(square))


@kernel
def mark_strength(impacts: Impacts, ring: int, mark: int, time: float) -> float:
    """Return the strength [-] with which a raceway meets a mark on a ball at a time [s]; 0 where the mark lies beside the track."""
    share = latitude_of(impacts, impacts.marked[mark], time) / impacts.latitudes[ring, mark]
    return math.sqrt(max(1.0 - share * share, 0.0)) * impacts.mark_strengths[ring, mark]


@kernel
def mark_under(impacts: Impacts, ring: int, mark: int, node: int, way: float) -> tuple[float, float]:
    """Return height [m] and slope [m/rad] of a mark on the track, between a node and the next one."""
    table = impacts.marks[ring, mark]
    spacing = TURN / (table.shape[0] - 1)
    return interpolated(table[node, 0], table[node + 1, 0], table[node, 1], table[node + 1, 1], spacing, way)
