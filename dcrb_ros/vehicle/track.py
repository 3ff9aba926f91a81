"""The displacement between wheel and rail by the track: irregularity, roughness, corrugation, joints and crossings along the rails.

Irregularity and roughness are made in pages of 256 m from random numbers keyed by seed, rail and page, so that any place has the same value
in whatever order the track is read. Neighbouring pages overlap with weights whose squares add up to 1.
"""

from __future__ import annotations

import hashlib
import math
from collections import OrderedDict
from collections.abc import Callable, Sequence

import numpy as np

from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.vehicle.description import SIDES, Track, numbers, places
from dcrb_ros.vehicle.kernels import cubic_on_pages

PAGE = 256.0
"""Length of a page [m]."""
COARSE, FINE, FINEST = 0.05, 0.005, 0.00128
"""Grids of irregularity, of roughness, and of its curvature [m]."""
ERRI_CUTOFFS = 0.8246, 0.0206, 0.438
"""Omega_c, Omega_r, Omega_s of ERRI B176 [rad/m]."""
FRA_CUTOFF, FRA_SHARE = 0.8245, 0.25e-4
"""Omega_c of the classes of the FRA [rad/m], and k over their A_v [m^2/cm^2]."""
FRA = {
    "fra_1": (1.2107, 0.6046),
    "fra_2": (1.0181, 0.9308),
    "fra_3": (0.6816, 0.8520),
    "fra_4": (0.5376, 1.1312),
    "fra_5": (0.2095, 0.8209),
    "fra_6": (0.0339, 0.4380),
}
"""A_v [cm^2 rad/m] and Omega_s [rad/m] of the classes of the FRA (Hamid and Yang 1981, from memory)."""
IRREGULARITY = {
    "erri_low": (4.032e-7, ERRI_CUTOFFS),
    "erri_high": (1.08e-6, ERRI_CUTOFFS),
    **{name: (FRA_SHARE * scale, (FRA_CUTOFF, 0.0, cross)) for name, (scale, cross) in FRA.items()},
}
"""A [m rad], and Omega_c, Omega_r, Omega_s [rad/m], of every spectrum."""
SHORTEST = 0.3
"""Shortest wavelength of the irregularity, longest one of the roughness [m]."""
ROUGHNESS_SLOPE = 3.0
"""Rise of the roughness for each octave of wavelength [dB] (an assumption)."""
PATCH = 6e-3
"""Half length of the contact patch, which averages the roughness [m]."""
DIP, REACH = 0.5, 5.0
"""Length over which a rail sinks to a joint (an assumption), and at which it lies even [m]."""
SMOOTHEST = -40.0
"""Level of roughness at which rails and wheels are smooth [dB]."""
PAGES_KEPT = 4
"""Pages of each kind in memory [-]."""


class Random:
    """A random function of place with a given spectrum."""

    def __init__(self, name: str, grid: float, spectrum: Callable[[Floats], Floats]) -> None:
        """Prepare for a one-sided ``spectrum`` of the wavenumber [rad/m], in the square of the value for each rad/m."""
        self._name, self._grid, self._points = name, grid, round(PAGE / grid)
        count = 2 * self._points
        wavenumber = np.asarray(2.0 * math.pi * np.fft.rfftfreq(count, grid), np.float64)
        density = np.zeros(len(wavenumber))
        density[1:] = spectrum(wavenumber[1:])
        self._amplitude = np.sqrt(density * wavenumber[1] * 0.5) * count * 0.5**0.5
        self._weight = np.sin(0.5 * math.pi * (np.arange(count) + 0.5) / self._points)
        self._pages: OrderedDict[int, Floats] = OrderedDict()
        self._end: tuple[int, Floats] | None = None
        """Last source: the page from which on it was made, and its second half."""

    def _source(self, page: int) -> tuple[Floats, Floats]:
        """Return two pages of a random function from the start of a page on, with weights."""
        key = hashlib.sha256(f"{self._name}/{page}".encode()).digest()
        random = np.random.Generator(np.random.Philox(key=int.from_bytes(key[:16], "little")))
        real, imaginary = random.standard_normal((len(self._amplitude), 2)).T  # a finer grid adds waves and keeps the others
        values = np.fft.irfft((real + 1j * imaginary) * self._amplitude, 2 * self._points) * self._weight
        return values[: self._points], values[self._points :]

    def page(self, number: int) -> Floats:
        """Return the values of a page at the points of the grid."""
        if number not in self._pages:
            before = self._end[1] if self._end is not None and self._end[0] == number - 1 else self._source(number - 1)[1]
            start, end = self._source(number)
            self._pages[number], self._end = start + before, (number, end)
            if len(self._pages) > PAGES_KEPT:
                self._pages.popitem(last=False)
        return self._pages[number]

    def at(self, place: Floats) -> Floats:
        """Return the values at places [m]."""
        first, last = math.floor((place.min() - 2 * self._grid) / PAGE), math.floor((place.max() + 3 * self._grid) / PAGE)
        pages = [self.page(number) for number in range(first, last + 1)]
        values = pages[0] if len(pages) == 1 else np.concatenate(pages)
        return cubic_on_pages(values, first, self._points, PAGE, self._grid, place)


def irregularity(track: Track) -> tuple[Random, Random] | None:
    """Return vertical irregularity and cross level times half the distance of the rails, or None for a smooth track.

    S_v = A Wc^2 / ((W^2 + Wr^2) (W^2 + Wc^2)) and S_v W^2 / (W^2 + Ws^2), one-sided in the wavenumber W (ERRI B176). The classes of the
    FRA have the same form with Wr = 0 and A = k A_v; wavelengths above two pages are left out.
    """
    if track.spectrum == "none":
        return None
    scale, (c, r, s) = IRREGULARITY[track.spectrum]

    def vertical(w: Floats) -> Floats:
        density = scale * c**2 / ((w**2 + r**2) * (w**2 + c**2))
        return np.asarray(np.where(w < 2.0 * math.pi / SHORTEST, density, 0.0), np.float64)

    def cross(w: Floats) -> Floats:
        return np.asarray(vertical(w) * w**2 / (w**2 + s**2), np.float64)

    return Random(f"{track.seed}/vertical", COARSE, vertical), Random(f"{track.seed}/cross", COARSE, cross)


def roughness(level: float) -> Callable[[Floats], Floats]:
    """Return the one-sided spectrum of a roughness with a level in third octaves at 0.1 m [dB re 1 um], averaged over the patch.

    The level rises by 3 dB for each octave of wavelength. The patch of half length a passes (1 + pi (k a)^3 / 4)^(-1/2).
    """

    def spectrum(w: Floats) -> Floats:
        wavelength = 2.0 * math.pi / w
        power = float(level > SMOOTHEST) * 1e-12 * 10.0 ** ((level + ROUGHNESS_SLOPE * np.log2(wavelength / 0.1)) / 10.0)
        density = power / (w * (2.0 ** (1.0 / 6.0) - 2.0 ** (-1.0 / 6.0))) / (1.0 + 0.25 * math.pi * (w * PATCH) ** 3)
        return np.asarray(np.where(wavelength < SHORTEST, density, 0.0), np.float64)

    return spectrum


def is_smooth(track: Track) -> bool:
    """Return whether neither rails nor wheels have any roughness, irregularity or kink."""
    kinked = track.joint_spacing > 0.0 or track.crossings or track.corrugation
    return track.spectrum == "none" and track.roughness <= SMOOTHEST and not kinked


class Rails:
    """Both rails: displacement and kinks at any place."""

    def __init__(self, track: Track) -> None:
        self._track = track
        self._irregularity = irregularity(track)
        rough = roughness(track.roughness)
        self._rough = [Random(f"{track.seed}/rail/{side}", FINE, rough) for side in SIDES]
        self._curvature = [Random(f"{track.seed}/rail/{side}", FINEST, lambda w: rough(w) * w**4) for side in SIDES]
        self._crossings = places(track.crossings, "track.crossings")
        self._corrugation: tuple[float, float, str] | None = None
        if track.corrugation:
            *values, side = track.corrugation.split() or [""]
            if side not in SIDES:
                raise Refusal(f"track.corrugation = '{track.corrugation}' names no rail: give for example '0.05 10e-6 left' [m]")
            wavelength, amplitude = numbers(" ".join(values), 2, "track.corrugation")
            if not (0.02 <= wavelength <= SHORTEST and 0.0 < amplitude <= 2e-4):
                raise Refusal(
                    f"track.corrugation = '{track.corrugation}': give a wavelength of 0.02 .. {SHORTEST:g} m, an amplitude up to 0.0002 m"
                )
            self._corrugation = wavelength, amplitude, side

    def displacements(self, place: Floats, sides: Sequence[int]) -> dict[int, Floats]:
        """Return the heights of the left (1) and right (-1) rail at places [m] by side; both share the irregularity."""
        both = tuple(part.at(place) for part in self._irregularity) if self._irregularity is not None else None
        return {side: self._displacement(place, side, both) for side in sides}

    def _displacement(self, place: Floats, side: int, both: tuple[Floats, ...] | None) -> Floats:
        height = self._rough[0 if side > 0 else 1].at(place)
        if both is not None:
            vertical, cross = both
            height += vertical + side * cross
        if self._corrugation is not None and self._corrugation[2] == SIDES[0 if side > 0 else 1]:
            wavelength, amplitude, _ = self._corrugation
            height += amplitude * np.sin(2.0 * math.pi / wavelength * place)
        for kink, _ in self.kinks(float(place.min()) - REACH, float(place.max()) + REACH, side):
            away = abs(place - kink)
            sunk = self._track.joint_angle * DIP * (np.exp(-away / DIP) - math.exp(-REACH / DIP))
            height -= np.where(away < REACH, sunk, 0.0)
        return height

    def curvature(self, place: Floats, side: int) -> Floats:
        """Return the second derivative of the roughness of a rail at places [1/m]."""
        return -self._curvature[0 if side > 0 else 1].at(place)

    def kinks(self, first: float, last: float, side: int) -> list[tuple[float, str]]:
        """Return the places of kinks of a rail from ``first`` up to ``last`` [m], in order, and whether each is a joint or a crossing."""
        listed = [(place, "crossing") for place, rail in self._crossings if first <= place < last and rail == SIDES[0 if side > 0 else 1]]
        spacing = self._track.joint_spacing
        if spacing > 0.0 and self._track.joint_rail in ("both", SIDES[0 if side > 0 else 1]):
            listed += [(k * spacing, "joint") for k in range(math.ceil(first / spacing), math.ceil(last / spacing))]
        return sorted(listed)
