"""Heights of raceways and rollers along the path of a contact: waviness, individual dimensions, and damage.

A surface has heights z over its circumference, above zero where there is more metal. A rigid roller of reduced radius R follows the upper
envelope of z by a parabola (a morphological dilation)

    H_1(x) = max_t (z(x + t) - t^2/(2 R))

and the elastic contact of half-width b the average of waviness over Hertz's pressure, a semi-ellipse, which in the order domain is the
factor 2 J_1(k b)/(k b), k = n/r. Waviness is shallow enough for the envelope to be itself; `dcrb_ros.bearing.contact_path` treats damage.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from dcrb_ros.bearing.contact_path import contact_weight, half_width, reduced_radii
from dcrb_ros.bearing.damage_tables import COLUMNS, RACEWAY_NODES, ROLLER_NODES, add_damage, rounded
from dcrb_ros.bearing.individual import individual_of, surface_seed
from dcrb_ros.bearing.unequal_impacts import axial_interference, impacts_of, start_strength, unequal_damage
from dcrb_ros.core.contacts.heights import (
    HEIGHT,
    PART_HEIGHT,
    PART_SLOPE,
    SHARE,
    SLOPE,
    TURN,
    Profile,
    Smooth,
    interpolated,
    packed,
    unpacked,
)
from dcrb_ros.core.contacts.impacts import DEFECT, Impacts
from dcrb_ros.core.layout.records import Integers
from dcrb_ros.core.payload import Payload
from dcrb_ros.faults.geometry import Damage
from dcrb_ros.measurement.random_streams import random_stream
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.configuration import Configuration

ROUNDNESS_ORDERS = (2, 14)
WAVINESS_ORDERS = (15, 150)
"""Orders whose root mean square ``surfaces.waviness`` states."""
HIGHEST_ORDER = 2000
ROLLER_ORDERS = (2, 60)
HIGHEST_ROLLER_ORDER = 280
"""As many lobes per length as `HIGHEST_ORDER` on a raceway."""
SHORT_ORDERS, SHORT_ROLLER_ORDERS = (WAVINESS_ORDERS[1], HIGHEST_ORDER), (20, HIGHEST_ROLLER_ORDER)
"""The order below them and the last order of ``surfaces.short_waves``: waves of the same lengths on raceways and rollers."""


@lru_cache(maxsize=256)
def order_weights(first: int, last: int, radius: float, width: float) -> Floats:
    """Return `contact_weight` of each order from the first to the last, on a radius and for a half-width [m]."""
    orders = np.arange(first, last + 1, dtype=np.float64)
    weights = contact_weight(orders / radius * width)
    weights.setflags(write=False)  # shared by all callers
    return weights


def level_of_orders(orders: Floats, slope: float, reference: tuple[int, int], rms: float) -> Floats:
    """Return the amplitudes [m] of orders that fall as n^-slope, for a root mean square over the reference orders [m]."""
    shape = orders**-slope
    inside = np.arange(reference[0], reference[1] + 1, dtype=np.float64) ** -slope
    return rms * math.sqrt(2.0) * shape / math.sqrt(float((inside**2).sum()))


def waves(random: np.random.Generator, orders: Floats, amplitudes: Floats, factor: Floats, nodes: int) -> tuple[Floats, Floats]:
    """Return heights [m] and slopes [m/rad] at the nodes of a turn, of orders with random phases and Rayleigh-distributed amplitudes.

    ``factor`` weights each order after its random amplitude is drawn.
    """
    size = np.sqrt(-np.log1p(-random.random(len(orders))))  # Rayleigh, of unit mean square
    phase = 2.0 * math.pi * random.random(len(orders))
    spectrum = np.zeros(nodes // 2 + 1, np.complex128)
    index = orders.astype(np.int64)
    spectrum[index] = 0.5 * nodes * amplitudes * size * factor * np.exp(1j * phase)
    return np.fft.irfft(spectrum, nodes), np.fft.irfft(1j * np.arange(nodes // 2 + 1) * spectrum, nodes)


@lru_cache(maxsize=32)
def raceway_waves(
    seed: int, name: str, radius: float, width: float, roundness: float, waviness: float, exponent: float
) -> tuple[Floats, Floats]:
    """Return heights [m] and slopes [m/rad] of a raceway without damage over a turn, about a mean of zero."""
    random = random_stream(seed, name)
    low = np.arange(ROUNDNESS_ORDERS[0], ROUNDNESS_ORDERS[1] + 1, dtype=np.float64)
    high = np.arange(WAVINESS_ORDERS[0], HIGHEST_ORDER + 1, dtype=np.float64)
    amplitudes = [level_of_orders(low, 1.0, ROUNDNESS_ORDERS, roundness), level_of_orders(high, exponent, WAVINESS_ORDERS, waviness)]
    orders = np.concatenate([low, high])
    return waves(
        random, orders, np.concatenate(amplitudes), order_weights(ROUNDNESS_ORDERS[0], HIGHEST_ORDER, radius, width), RACEWAY_NODES
    )


@lru_cache(maxsize=256)
def roller_waves(seed: int, name: str, radius: float, widths: tuple[float, float], waviness: float, exponent: float) -> tuple[Floats, ...]:
    """Return heights [m] and slopes [m/rad] of a roller averaged by the contact with the inner raceway, then by that with the outer one."""
    orders = np.arange(ROLLER_ORDERS[0], HIGHEST_ROLLER_ORDER + 1, dtype=np.float64)
    amplitudes = level_of_orders(orders, exponent, ROLLER_ORDERS, waviness)
    return tuple(
        part
        for width in widths
        for part in waves(
            random_stream(seed, name),
            orders,
            amplitudes,
            order_weights(ROLLER_ORDERS[0], HIGHEST_ROLLER_ORDER, radius, width),
            ROLLER_NODES,
        )
    )


@lru_cache(maxsize=256)
def short_waves(
    seed: int, name: str, radius: float, widths: tuple[float, ...], rms: float, orders: tuple[int, int], nodes: int
) -> tuple[Floats, ...]:
    """Return heights [m] and slopes [m/rad] that remain of roughness averaged along a roller and over contacts of half-widths [m].

    Before a contact averages them over its width they are alike over all orders between the first and the last; afterwards they have the
    root mean square ``rms`` [m] at the last of the contacts.
    """
    between = np.arange(orders[0] + 1, orders[1] + 1, dtype=np.float64)
    weights = order_weights(orders[0] + 1, orders[1], radius, widths[-1])
    amplitudes = np.full(len(between), rms * math.sqrt(2.0 / float((weights**2).sum())))
    return tuple(
        part
        for width in widths
        for part in waves(random_stream(seed, name), between, amplitudes, order_weights(orders[0] + 1, orders[1], radius, width), nodes)
    )


def build_surfaces(
    configuration: Configuration, damage: Sequence[Damage], fastest: float | None = None
) -> tuple[Smooth | Profile | Impacts, float]:
    """Return the surfaces of a bearing as the kernels take them, and how far the highest rises [m].

    Every row, raceway and roller has random numbers of its own, so that one parameter changes nothing else.
    """
    c = configuration
    if c.surfaces.law == "smooth":
        return Smooth(), 0.0
    b, seed, s = c.bearing, surface_seed(c), c.surfaces
    radii, raceways = reduced_radii(c), (b.inner_raceway_radius, b.outer_raceway_radius)
    widths = half_width(c, radii[0]), half_width(c, radii[1])
    table = np.zeros((2, b.rows, RACEWAY_NODES, COLUMNS))
    individual = individual_of(c)
    waviness = s.waviness * individual.waviness
    for ring in (0, 1):
        for row in range(b.rows):
            name = f"{('inner', 'outer')[ring]} raceway of row {row + 1}"
            height, slope = raceway_waves(seed, name, raceways[ring], widths[ring], s.roundness, waviness, s.waviness_slope)
            short = short_waves(
                seed, f"short waves of {name}", raceways[ring], widths[ring : ring + 1], s.short_waves, SHORT_ORDERS, RACEWAY_NODES
            )
            table[ring, row, :, HEIGHT], table[ring, row, :, SLOPE] = height + short[0], slope + short[1]
    table[1, :, :, HEIGHT] += (individual.row_radii - 0.5 * individual.clearance)[:, None]
    add_run_out(table[0], individual.run_out)
    rollers = np.zeros((b.rows * b.rollers_per_row, ROLLER_NODES, 4))
    for k in range(len(rollers)):
        long = roller_waves(seed, f"roller {k + 1}", b.own_roller_radius, widths, 0.5 * waviness, s.waviness_slope)
        short = short_waves(
            seed, f"short waves of roller {k + 1}", b.own_roller_radius, widths, 0.5 * s.short_waves, SHORT_ROLLER_ORDERS, ROLLER_NODES
        )
        rollers[k] = np.stack(long, axis=-1) + np.stack(short, axis=-1)
    rollers[:, :, 0::2] += 0.5 * individual.roller_diameters[:, None, None]
    table[1, :, :, HEIGHT] += axial_interference(c, individual)
    damaged = unequal_damage(c, damage, fastest) if c.impacts.unequal else None
    for item in damage if damaged is None else damaged.alike:
        add_damage(c, item, table, rollers)
    table[..., :SHARE], rollers = rounded(table[..., :SHARE]), rounded(rollers)
    highest = float(table[..., HEIGHT].max() + max(table[..., PART_HEIGHT].max(), 0.0) + rollers[:, :, 0::2].max())
    roller_nodes = np.stack([packed(rollers[..., 2 * ring], rollers[..., 2 * ring + 1]) for ring in (0, 1)])
    if damaged is not None:
        raceway_nodes = packed(table[..., HEIGHT], table[..., SLOPE], damaged.parts[..., DEFECT])
        return impacts_of(c, damaged, raceway_nodes, roller_nodes), max(highest + damaged.highest, 0.0)
    parts = table[..., [PART_HEIGHT, PART_SLOPE, SHARE]].astype(np.float32)
    raceway_nodes = packed(table[..., HEIGHT], table[..., SLOPE], table[..., SHARE])
    return Profile(raceway_nodes, roller_nodes, parts, bool((parts[..., 2] > 0.0).any())), max(highest, 0.0)


def add_run_out(table: Floats, centres: Floats) -> None:
    """Add circles about centres off the shaft's axis, shape (rows, 2) [m], to the tables of the inner raceways.

    The raceway at azimuth theta lies towards (sin theta, -cos theta).
    """
    angle = 2.0 * math.pi / table.shape[1] * np.arange(table.shape[1])
    sine, cosine = np.sin(angle), np.cos(angle)
    for row, (x, y) in enumerate(centres):
        table[row, :, HEIGHT] += x * sine - y * cosine
        table[row, :, SLOPE] += x * cosine + y * sine


def heights_at_contacts(payload: Payload, from_ring: Floats, inner: bool) -> Floats:
    """Return the heights at the contacts, at shaft and spin angle zero, shape (rows, rollers) [m]; those over a part of the length count by
    their share.

    ``from_ring`` are the vectors from the ring's centre to the rollers', shape (rows, rollers, 2).
    """
    surfaces = payload.surfaces
    if isinstance(surfaces, Smooth):
        return np.zeros(payload.free.shape)
    azimuth, ring = np.arctan2(from_ring[..., 0], -from_ring[..., 1]), 0 if inner else 1
    heights = _between_packed(surfaces.raceways[ring], azimuth)
    for row, angles in enumerate(azimuth):
        part, nodes = surfaces.parts[ring, row], np.floor(np.mod(angles / TURN, 1.0) * RACEWAY_NODES).astype(np.int64) % RACEWAY_NODES
        strength = start_strength(surfaces, ring, row, angles, nodes) if isinstance(surfaces, Impacts) else 1.0
        at, way = _places(angles, RACEWAY_NODES)
        before, after = (part[i].astype(np.float64) for i in (at, (at + 1) % RACEWAY_NODES))
        over_part = _curve(before[:, 0], after[:, 0], before[:, 1], after[:, 1], RACEWAY_NODES, way)
        heights[row] += strength * part[nodes, 2].astype(np.float64) * over_part
    on_roller = (azimuth + math.pi if inner else azimuth).reshape(-1, 1)
    heights += _between_packed(surfaces.rollers[ring, : azimuth.size], on_roller).reshape(azimuth.shape)
    return heights


def _places(angles: Floats, nodes: int) -> tuple[Integers, Floats]:
    """Return the nodes of a turn before some angles [rad], and the ways from there [nodes]."""
    position = np.mod(angles / TURN, 1.0) * nodes
    at = np.minimum(np.floor(position), nodes - 1.0).astype(np.int64)
    return at, position - at


def _curve(before: Floats, after: Floats, rise: Floats, rise_after: Floats, nodes: int, way: Floats) -> Floats:
    """Return the heights [m] between nodes of a turn, from heights [m] and slopes [m/rad] at both."""
    curve: Any = getattr(interpolated, "py_func", interpolated)
    return np.asarray(curve(before, after, rise, rise_after, TURN / nodes, way)[0])


def _between_packed(tables: Integers, angles: Floats) -> Floats:
    """Return heights [m] of tables, shape (tables, nodes + 1), at angles of each, shape (tables, angles) [rad], from their nodes alone."""
    nodes = tables.shape[-1] - 1
    at, way = _places(angles, nodes)
    before, after = (unpacked(np.take_along_axis(tables, i, axis=-1)) for i in (at, at + 1))
    return _curve(before[0], after[0], before[1], after[1], nodes, way)
