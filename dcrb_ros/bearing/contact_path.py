"""The path of a contact over damage: a rigid roller on its envelope, and what an elastic contact makes of it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from dcrb_ros.core.laws import hertz
from dcrb_ros.measurement.filter_cache import cached_at_start
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.loaded_contacts import heaviest, material_of

FIRST_WEIGHTS = 32
"""Results of `contact_weight` in a process that are cached on disk [-]: more than a bearing with a dozen defects needs."""
AVERAGING_FORCE = 20e3 / (0.015 * 0.048)
"""Force whose half-width averages the heights, over radius and length of a roller [N/m^2]: the same pressure in bearings of any size."""
BRIDGED = 1e-9
"""Gap under a rigid roller from which on it bridges missing metal [m]."""
EDGE_AVERAGE = 0.5
"""Half-width over which the edges of missing metal are averaged, over that of the contact [-], a choice: steps of 10 us can follow it."""


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


def half_width(configuration: Configuration, radius: float) -> float:
    """Return the half-width [m] of a contact of a reduced radius in the plane [m], over which it averages heights."""
    bearing = configuration.bearing
    if configuration.contact.law == hertz.LAW.name:
        inner, outer = hertz.curvatures(dict(configuration.contact), material_of(bearing))
        # Of the two, the one whose curvature in the plane is that of the reduced radius.
        curvature = inner if radius < bearing.roller_radius else outer
        return hertz.semiaxes(curvature, heaviest(configuration), bearing.effective_modulus)[1]
    along = radius / math.cos(bearing.contact_angle)
    return math.sqrt(4.0 * along * AVERAGING_FORCE * bearing.roller_radius / (math.pi * bearing.effective_modulus))


def reduced_radii(configuration: Configuration) -> tuple[float, float]:
    """Return the reduced radii of the contacts with inner and outer raceway in the plane [m]."""
    b = configuration.bearing
    return 1.0 / (1.0 / b.roller_radius + 1.0 / b.inner_raceway_radius), 1.0 / (1.0 / b.roller_radius - 1.0 / b.outer_raceway_radius)


class ContactPath(NamedTuple):
    """Path of a contact over a defect, at equal distances about its middle."""

    height: Floats
    """[m]"""
    slope: Floats
    """[-]"""
    spacing: float
    """[m]"""


def contact_path(heights: Floats, spacing: float, radius: float, width: float) -> ContactPath:
    """Return the path of a contact of a reduced radius and a half-width [m] over heights that end in zeros [m].

    Shallow heights that the roller follows are averaged over the contact, as waviness is. Where it bridges missing metal, a load on both
    edges sinks as far as a rigid roller, at every load: c^2/(2 R) for a gap of half-width c. In a contact wider than the gap, the gap acts
    as a crack of the energy pi c^2 p^2/(2 E*) at a place of the pressure p. There p^2 is E* P/(pi R) for a load P per length, less a term
    of the place alone, so the approach grows by c^2/(2 R) wherever the gap lies within the contact. So the contact takes the lowest height
    of the rigid path within its half-width, averaged over half of it for the edges; heights above zero are averaged over the contact.
    """
    margin = math.ceil((math.sqrt(2.0 * radius * float(np.ptp(heights))) + 3.0 * width) / spacing)
    raw = np.pad(heights, margin)
    rigid = envelope(raw, spacing, radius)
    if float((rigid - raw).max()) < BRIDGED:
        return ContactPath(*averaged(rigid, spacing, width), spacing)
    steps = round(width / spacing)
    sunk = sliding_window_view(np.pad(np.minimum(rigid, 0.0), steps, mode="edge"), 2 * steps + 1).min(axis=-1)
    low, low_slope = averaged(sunk, spacing, EDGE_AVERAGE * width)
    high, high_slope = averaged(np.maximum(rigid, 0.0), spacing, width)
    return ContactPath(low + high, low_slope + high_slope, spacing)


def notch_heights(width: float, depth: float, spacing: float) -> tuple[Floats, float]:
    """Return the heights of a notch with sharp edges and a flat floor, and their distance [m], at most ``spacing``.

    A sample lies on each edge, or the notch would be wider for the roller by up to a sample.
    """
    half = math.ceil(0.5 * width / spacing)
    heights = np.full(2 * half + 3, -depth)
    heights[[0, 1, -2, -1]] = 0.0
    return heights, 0.5 * width / half
