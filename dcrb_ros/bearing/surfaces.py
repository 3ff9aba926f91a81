"""Heights of raceways and rollers along the path of a contact: waviness, individual dimensions, and damage.

A surface has heights z over its circumference, above zero where there is more metal. A rigid roller of reduced radius R follows the upper
envelope of z by a parabola (a morphological dilation)

    H_1(x) = max_t (z(x + t) - t^2/(2 R))

and the elastic contact of half-width b the average of that over Hertz's pressure, a semi-ellipse, which in the order domain is the factor
2 J_1(k b)/(k b), k = n/r. Waviness is shallow enough for the envelope to be itself.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from dcrb_ros.bearing.individual import individual_of, surface_seed
from dcrb_ros.core.contacts.heights import HEIGHT, PART_HEIGHT, PART_SLOPE, SHARE, SLOPE, Profile, Smooth, interpolated, packed, unpacked
from dcrb_ros.core.laws import hertz
from dcrb_ros.core.payload import Payload
from dcrb_ros.faults.geometry import Damage, RacewayNotch, RollerNotch, SurfaceHeights
from dcrb_ros.measurement.filter_cache import cached_at_start
from dcrb_ros.measurement.random_streams import random_stream
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.loaded_contacts import heaviest, material_of

RACEWAY_NODES, ROLLER_NODES = 16384, 1024
COLUMNS = 5
RINGS = ("inner_ring", "outer_ring")
AVERAGING_FORCE = 20e3
"""Force whose half-width averages the heights [N]."""
ROUNDNESS_ORDERS = (2, 14)
WAVINESS_ORDERS = (15, 150)
"""Orders whose root mean square ``surfaces.waviness`` states."""
HIGHEST_ORDER = 2000
ROLLER_ORDERS = (2, 60)
HIGHEST_ROLLER_ORDER = 280
"""As many lobes per length as `HIGHEST_ORDER` on a raceway."""
SHORT_ORDERS, SHORT_ROLLER_ORDERS = (WAVINESS_ORDERS[1], HIGHEST_ORDER), (20, HIGHEST_ROLLER_ORDER)
"""The order below them and the last order of ``surfaces.short_waves``: waves of the same lengths on raceways and rollers."""
FIRST_WEIGHTS = 32
"""Results of `contact_weight` in a process that are cached on disk [-]: more than a bearing with a dozen defects needs."""
FINE = 4
"""Samples per node for damage, which has edges."""
LEAST_HEIGHT = 1e-12
"""Height below which a defect is left out [m]."""
HEIGHT_RESOLUTION, SLOPE_RESOLUTION = 2.0**-50, 2.0**-44
"""Heights [m] and slopes [m/rad] are rounded to multiples of these: the last bits of a Fourier transform differ between processors."""


def envelope(heights: Floats, spacing: float, radius: float) -> Floats:
    """Return the path of a rigid cylinder over a surface: its dilation by a parabola of the reduced radius [m].

    ``heights`` [m] lie ``spacing`` [m] apart; beyond their ends the surface continues at the last height.
    """
    reach = math.ceil(math.sqrt(2.0 * radius * max(float(np.ptp(heights)), 0.0)) / spacing)
    padded, path = np.pad(heights, reach, mode="edge"), np.array(heights, np.float64)
    for k in range(1, reach + 1):
        drop = (k * spacing) ** 2 / (2.0 * radius)
        for first in (reach - k, reach + k):
            np.maximum(path, padded[first : first + len(heights)] - drop, out=path)
    return path


def averaged(heights: Floats, spacing: float, half_width: float) -> tuple[Floats, Floats]:
    """Return the average of heights [m] over a semi-ellipse of a half-width [m], and its slope [-]; they end in zeros on both sides."""
    count = 2 ** math.ceil(math.log2(2 * len(heights)))
    wave: Floats = np.asarray(2.0 * math.pi * np.fft.rfftfreq(count, spacing), np.float64)
    spectrum = np.fft.rfft(heights, count) * contact_weight(wave * half_width)
    mean = np.fft.irfft(spectrum, count)[: len(heights)]
    return mean, np.fft.irfft(1j * wave * spectrum, count)[: len(heights)]


@cached_at_start(FIRST_WEIGHTS)
def contact_weight(phase: Floats) -> Floats:
    """Return 2 J_1(x)/x [-], the mean of a wave over a semi-ellipse, at x = wave number times half-width."""
    from scipy.special import j1

    held = np.maximum(phase, 1e-9)
    return np.asarray(2.0 * j1(held) / held)


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


def half_width(configuration: Configuration, radius: float) -> float:
    """Return the half-width [m] of a contact of a reduced radius [m], over which it averages heights."""
    bearing = configuration.bearing
    if configuration.contact.law == hertz.LAW.name:
        inner, outer = hertz.curvatures(dict(configuration.contact), material_of(bearing))
        # Of the two, the one whose curvature in the plane is that of the reduced radius.
        curvature = inner if radius < bearing.roller_radius else outer
        return hertz.semiaxes(curvature, heaviest(configuration), bearing.effective_modulus)[1]
    return math.sqrt(4.0 * radius * AVERAGING_FORCE / (math.pi * bearing.roller_length * bearing.effective_modulus))


def reduced_radii(configuration: Configuration) -> tuple[float, float]:
    """Return the reduced radii of the contacts with inner and outer raceway [m]."""
    b = configuration.bearing
    return 1.0 / (1.0 / b.roller_radius + 1.0 / b.inner_raceway_radius), 1.0 / (1.0 / b.roller_radius - 1.0 / b.outer_raceway_radius)


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


class ContactPath(NamedTuple):
    """Path of a contact over a defect, at equal distances about its middle."""

    height: Floats
    """[m]"""
    slope: Floats
    """[-]"""
    spacing: float
    """[m]"""


def contact_path(heights: Floats, spacing: float, radius: float, width: float) -> ContactPath:
    """Return the path of a contact of a reduced radius and a half-width [m] over heights that end in zeros [m]."""
    margin = math.ceil((math.sqrt(2.0 * radius * float(np.ptp(heights))) + 2.0 * width) / spacing)
    rigid = envelope(np.pad(heights, margin), spacing, radius)
    return ContactPath(*averaged(rigid, spacing, width), spacing)


def notch_heights(width: float, depth: float, spacing: float) -> tuple[Floats, float]:
    """Return the heights of a notch with sharp edges and a flat floor, and their distance [m], at most ``spacing``.

    A sample lies on each edge, or the notch would be wider for the roller by up to a sample.
    """
    half = math.ceil(0.5 * width / spacing)
    heights = np.full(2 * half + 3, -depth)
    heights[[0, 1, -2, -1]] = 0.0
    return heights, 0.5 * width / half


def add_window(table: Floats, columns: tuple[int, int], path: ContactPath, azimuth: float, radius: float) -> None:
    """Add the path over a defect at an azimuth [rad] of a surface of a radius [m] to two columns of its table over a turn."""
    spacing, half = 2.0 * math.pi / len(table), len(path.height) // 2
    places = azimuth + np.arange(-half, half + 1) * (path.spacing / radius)
    at = np.arange(math.ceil(places[0] / spacing), math.floor(places[-1] / spacing) + 1)
    table[at % len(table), columns[0]] += np.interp(at * spacing, places, path.height)
    table[at % len(table), columns[1]] += np.interp(at * spacing, places, path.slope) * radius


def build_surfaces(configuration: Configuration, damage: Sequence[Damage]) -> tuple[Smooth | Profile, float]:
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
        long = roller_waves(seed, f"roller {k + 1}", b.roller_radius, widths, 0.5 * waviness, s.waviness_slope)
        short = short_waves(
            seed, f"short waves of roller {k + 1}", b.roller_radius, widths, 0.5 * s.short_waves, SHORT_ROLLER_ORDERS, ROLLER_NODES
        )
        rollers[k] = np.stack(long, axis=-1) + np.stack(short, axis=-1)
    rollers[:, :, 0::2] += 0.5 * individual.roller_diameters[:, None, None]
    for item in damage:
        add_damage(c, item, table, rollers)
    table[..., :SHARE] = np.round(table[..., :SHARE] / HEIGHT_RESOLUTION) * HEIGHT_RESOLUTION
    rollers = np.round(rollers / HEIGHT_RESOLUTION) * HEIGHT_RESOLUTION
    highest = float(table[..., HEIGHT].max() + max(table[..., PART_HEIGHT].max(), 0.0) + rollers[:, :, 0::2].max())
    roller_nodes = np.stack([packed(rollers[..., 2 * ring], rollers[..., 2 * ring + 1]) for ring in (0, 1)])
    parts = table[..., [PART_HEIGHT, PART_SLOPE, SHARE]].astype(np.float32)
    surfaces = Profile(
        packed(table[..., HEIGHT], table[..., SLOPE], table[..., SHARE]), roller_nodes, parts, bool((parts[..., 2] > 0.0).any())
    )
    return surfaces, max(highest, 0.0)


def add_run_out(table: Floats, centres: Floats) -> None:
    """Add circles about centres off the shaft's axis, shape (rows, 2) [m], to the tables of the inner raceways.

    The raceway at azimuth theta lies towards (sin theta, -cos theta).
    """
    angle = 2.0 * math.pi / table.shape[1] * np.arange(table.shape[1])
    for row, (x, y) in enumerate(centres):
        table[row, :, HEIGHT] += x * np.sin(angle) - y * np.cos(angle)
        table[row, :, SLOPE] += x * np.cos(angle) + y * np.sin(angle)


def heights_at_contacts(payload: Payload, from_ring: Floats, inner: bool) -> Floats:
    """Return the heights at the contacts, at shaft and spin angle zero, shape (rows, rollers) [m]; those over a part of the length count by
    their share.

    ``from_ring`` are the vectors from the ring's centre to the rollers', shape (rows, rollers, 2).
    """
    surfaces = payload.surfaces
    if isinstance(surfaces, Smooth):
        return np.zeros(payload.free.shape)
    azimuth = np.arctan2(from_ring[..., 0], -from_ring[..., 1])
    ring = 0 if inner else 1
    heights = np.zeros(azimuth.shape)
    for row, angles in enumerate(azimuth):
        heights[row] = between_nodes(*unpacked(surfaces.raceways[ring, row]), angles)
        nodes = np.floor(np.mod(angles / (2.0 * math.pi), 1.0) * RACEWAY_NODES).astype(np.int64) % RACEWAY_NODES
        part = np.concatenate([surfaces.parts[ring, row], surfaces.parts[ring, row, :1]]).astype(np.float64)
        heights[row] += part[nodes, 2] * between_nodes(part[:, 0], part[:, 1], angles)
        for i, angle in enumerate(angles + math.pi if inner else angles):
            roller = surfaces.rollers[ring, row * azimuth.shape[1] + i]
            heights[row, i] += between_nodes(*unpacked(roller), np.array([angle]))[0]
    return heights


def between_nodes(heights: Floats, slopes: Floats, angles: Floats) -> Floats:
    """Return heights [m] at angles [rad] of heights [m] and slopes [m/rad] over a turn, its first node again at the end."""
    nodes = len(heights) - 1
    position = np.mod(angles / (2.0 * math.pi), 1.0) * nodes
    i = np.minimum(np.floor(position), nodes - 1.0).astype(np.int64)
    curve = getattr(interpolated, "py_func", interpolated)
    return np.asarray(curve(heights[i], heights[i + 1], slopes[i], slopes[i + 1], 2.0 * math.pi / nodes, position - i)[0])


def add_damage(configuration: Configuration, damage: Damage, table: Floats, rollers: Floats) -> None:
    """Add a fault to the tables of raceways and rollers."""
    c, b = configuration, configuration.bearing
    radii, raceways = reduced_radii(c), (b.inner_raceway_radius, b.outer_raceway_radius)
    if isinstance(damage, RollerNotch):
        spacing = 2.0 * math.pi * b.roller_radius / (ROLLER_NODES * FINE)
        for ring in (0, 1):
            width = half_width(c, radii[ring])
            heights, distance = notch_heights(2.0 * damage.half_angle * b.roller_radius, damage.depth, spacing)
            path = contact_path(heights, distance, radii[ring], width)
            add_window(
                rollers[damage.row * b.rollers_per_row + damage.roller], (2 * ring, 2 * ring + 1), path, damage.azimuth, b.roller_radius
            )
    elif isinstance(damage, RacewayNotch):
        ring = RINGS.index(damage.ring)
        spacing = 2.0 * math.pi * raceways[ring] / (RACEWAY_NODES * FINE)
        heights, distance = notch_heights(2.0 * damage.half_angle * raceways[ring], damage.depth, spacing)
        path = contact_path(heights, distance, radii[ring], half_width(c, radii[ring]))
        add_to_raceway(table[ring], damage.row, path, damage.azimuth, raceways[ring], 1.0)
    elif isinstance(damage, SurfaceHeights):
        ring = RINGS.index(damage.ring)
        path = contact_path(np.asarray(damage.heights), damage.spacing, radii[ring], half_width(c, radii[ring]))
        add_to_raceway(table[ring], damage.row, path, damage.azimuth, raceways[ring], damage.share)


def add_to_raceway(table: Floats, row: int, path: ContactPath, azimuth: float, raceway: float, share: float) -> None:
    """Add the path of a contact over a defect to the table of a raceway; ``row`` -1 means all rows."""
    for at in range(len(table)) if row < 0 else (row,):
        if share < 1.0:
            add_window(table[at], (PART_HEIGHT, PART_SLOPE), path, azimuth, raceway)
            table[at, np.abs(table[at, :, PART_HEIGHT]) > LEAST_HEIGHT, SHARE] = share
        else:
            add_window(table[at], (HEIGHT, SLOPE), path, azimuth, raceway)
