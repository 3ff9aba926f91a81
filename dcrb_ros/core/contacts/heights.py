"""Tables of the heights of raceways and rollers over a turn, and how the kernels read them between two nodes."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from dcrb_ros.core.arithmetic import INTEGERS, bits_of, single_of
from dcrb_ros.core.jit import kernel, piece
from dcrb_ros.core.layout.records import Floats, Integers, SingleFloats
from dcrb_ros.core.layout.rollers import Nodes
from dcrb_ros.core.memory import prefetch

HEIGHT, SLOPE, PART_HEIGHT, PART_SLOPE, SHARE = range(5)
"""Columns of a raceway's table: height [m] and its slope [m/rad] over the whole length of a roller, those of a part of it added there, and
the share of that part [-]."""
TURN = 2.0 * math.pi
NODES_AHEAD = 8
"""Nodes on the next cache line: they are used some steps later."""


class Smooth(NamedTuple):
    """Raceways and rollers without heights."""


class Profile(NamedTuple):
    """Heights of raceways and rollers, at equal angles over a turn, the first node again at the end.

    A node is height [m] and slope [m/rad], each in single precision, a hundredth of a nanometre, for the cache: both are one integer,
    which the kernels copy at once. The last bit of a slope says whether a defect over a share of the length lies between the node and the
    next one. `packed` makes them, `unpacked` takes them apart.
    """

    raceways: Integers
    """Inner and outer raceway, row by row, shape (2, rows, nodes + 1)."""
    rollers: Integers
    """Each roller, averaged by the contact with the inner raceway and then with the outer one, shape (2, rows * rollers, nodes + 1)."""
    parts: SingleFloats
    """Height [m] and slope [m/rad] of defects over a share of the length, and that share [-], shape (2, rows, nodes, 3)."""
    partial: bool
    """Whether a defect takes a share of the length."""


def packed(heights: Floats, slopes: Floats, shares: Floats | None = None) -> Integers:
    """Return heights [m] and slopes [m/rad] at the nodes of a turn, the last axis, as the kernels take them.

    ``shares`` are the shares of the length that a defect takes at the nodes [-].
    """
    low, high = (values.astype(np.float32).view(np.uint32).astype(np.uint64) for values in (heights, slopes))
    marks = np.zeros(heights.shape, np.uint64)
    if shares is not None:
        marks[(shares > 0.0) | (np.roll(shares, -1, axis=-1) > 0.0)] = 1
    nodes = (low | (high & ~np.uint64(1) | marks) << np.uint64(32)).view(np.int64)
    return np.concatenate([nodes, nodes[..., :1]], axis=-1)


def unpacked(nodes: Integers) -> tuple[Floats, Floats]:
    """Return heights [m] and slopes [m/rad] at the nodes of a turn from what `packed` returns, the last node included."""
    bits = nodes.view(np.uint64)
    low, high = bits & np.uint64(0xFFFFFFFF), bits >> np.uint64(32)
    return tuple(half.astype(np.uint32).view(np.float32).astype(np.float64) for half in (low, high))


@kernel
def place_of(angle: float, nodes: int) -> tuple[int, float]:
    """Return the node before an angle [rad] on a table of a turn, and the way from there [nodes]; in arithmetic of vectors.

    The number of nodes is a power of two: the last bits of an integer that counts on over the turns are the node.
    """
    position = angle * (nodes * (1.0 / TURN))
    before = np.floor(position)
    return bits_of(before + INTEGERS) & (nodes - 1), position - before


@kernel
def interpolated(before: float, after: float, rise: float, rise_after: float, spacing: float, u: float) -> tuple[float, float]:
    """Return value and slope of the cubic between two nodes, from values and slopes at both; continuous with its slope."""
    chord = after - before
    start, end = rise * spacing, rise_after * spacing
    square, cube = 3.0 * chord - 2.0 * start - end, start + end - 2.0 * chord
    value = before + u * (start + u * (square + u * cube))
    slope = (start + u * (2.0 * square + 3.0 * u * cube)) * (1.0 / spacing)
    return value, slope


@kernel
def nodes_ahead(speed: float) -> int:
    """Return how many nodes ahead of a contact the next cache line is, where the angle of the contact grows with a ``speed`` [rad/s]."""
    return NODES_AHEAD if speed > 0.0 else -NODES_AHEAD


@piece
def read_node(nodes: Nodes, k: int, raceway: Integers, roller: Integers, ahead: int, roller_ahead: int) -> None:
    """Copy the heights on both sides of a contact from the tables of a raceway and of a roller, and prefetch those ahead of it."""
    i, n = np.uint64(nodes.node[k]), np.uint64(nodes.roller_node[k])
    before, after, roller_before, roller_after = raceway[i], raceway[i + np.uint64(1)], roller[n], roller[n + np.uint64(1)]
    nodes.before[k], nodes.after[k], nodes.roller_before[k], nodes.roller_after[k] = before, after, roller_before, roller_after
    prefetch(raceway, nodes.node[k] + ahead)
    prefetch(roller, nodes.roller_node[k] + roller_ahead)


@piece
def clear_node(nodes: Nodes, k: int) -> None:
    """Write no heights on both sides of a contact."""
    nodes.before[k] = nodes.after[k] = nodes.roller_before[k] = nodes.roller_after[k] = 0


@kernel
def between(nodes: Nodes, k: int, raceway_nodes: int, roller_nodes: int) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return height [m] and slope [m/rad] of a raceway, and those of a roller, at a contact between two nodes."""
    return (
        curve(nodes.before[k], nodes.after[k], TURN / raceway_nodes, nodes.way[k]),
        curve(nodes.roller_before[k], nodes.roller_after[k], TURN / roller_nodes, nodes.roller_way[k]),
    )


@kernel
def marked(node: int) -> float:
    """Return 1 where a defect over a share of the length lies between a node and the next one, otherwise 0."""
    return 1.0 if (node >> 32) & 1 != 0 else 0.0


@kernel
def curve(before: int, after: int, spacing: float, u: float) -> tuple[float, float]:
    """Return height [m] and slope [m/rad] between two nodes, ``u`` of the ``spacing`` [rad] past the first."""
    return interpolated(single_of(before), single_of(after), single_of(before >> 32), single_of(after >> 32), spacing, u)
