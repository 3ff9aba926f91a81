"""Tables of the heights of raceways and rollers over a turn, and how damage is added to them."""

from __future__ import annotations

import math

import numpy as np

from dcrb_ros.bearing.contact_path import ContactPath, contact_path, half_width, notch_heights, reduced_radii
from dcrb_ros.core.contacts.heights import HEIGHT, PART_HEIGHT, PART_SLOPE, SHARE, SLOPE
from dcrb_ros.faults.geometry import Damage, RacewayNotch, RollerNotch, SurfaceHeights
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.configuration import Configuration

RACEWAY_NODES, ROLLER_NODES = 16384, 1024
COLUMNS = 5
RINGS = ("inner_ring", "outer_ring")
FINE = 4
"""Samples per node for damage, which has edges."""
LEAST_HEIGHT = 1e-12
"""Height below which a defect is left out [m]."""
RESOLUTION = 2.0**-50
"""Heights [m] and slopes [m/rad] are rounded to multiples of it: the last bits of a Fourier transform differ between processors."""


def rounded(values: Floats) -> Floats:
    """Return heights [m] and slopes [m/rad] rounded to what all processors share."""
    return np.asarray(np.round(values / RESOLUTION) * RESOLUTION)


def add_window(table: Floats, columns: tuple[int, int], path: ContactPath, azimuth: float, radius: float) -> None:
    """Add the path over a defect at an azimuth [rad] of a surface of a radius [m] to two columns of its table over a turn."""
    spacing, half = 2.0 * math.pi / len(table), len(path.height) // 2
    places = azimuth + np.arange(-half, half + 1) * (path.spacing / radius)
    at = np.arange(math.ceil(places[0] / spacing), math.floor(places[-1] / spacing) + 1)
    table[at % len(table), columns[0]] += np.interp(at * spacing, places, path.height)
    table[at % len(table), columns[1]] += np.interp(at * spacing, places, path.slope) * radius


def add_damage(configuration: Configuration, damage: Damage, table: Floats, rollers: Floats) -> None:
    """Add a fault to the tables of raceways and rollers."""
    c, b = configuration, configuration.bearing
    radii, raceways = reduced_radii(c), (b.inner_raceway_radius, b.outer_raceway_radius)
    if isinstance(damage, RollerNotch):
        spacing, roller = 2.0 * math.pi * b.own_roller_radius / (ROLLER_NODES * FINE), damage.row * b.rollers_per_row + damage.roller
        for ring in (0, 1):
            width = half_width(c, radii[ring])
            heights, distance = notch_heights(2.0 * damage.half_angle * b.roller_radius, damage.depth, spacing)
            path = contact_path(heights, distance, radii[ring], width)
            add_window(rollers[roller], (2 * ring, 2 * ring + 1), path, damage.azimuth, b.own_roller_radius)
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
            before = table[at, :, PART_HEIGHT].copy()
            add_window(table[at], (PART_HEIGHT, PART_SLOPE), path, azimuth, raceway)
            here = np.abs(table[at, :, PART_HEIGHT] - before) > LEAST_HEIGHT
            table[at, here, SHARE] = np.maximum(table[at, here, SHARE], share)
        else:
            add_window(table[at], (HEIGHT, SLOPE), path, azimuth, raceway)
