"""The displacement between wheel and rail by the track: irregularity, roughness, corrugation, joints and crossings along the rails.

Irregularity and roughness are made in pages of 256 m from random numbers keyed by seed, rail and page, so that any place has the same value
in whatever order the track is read. Neighbouring pages overlap with weights whose squares add up to 1.
"""

from __future__ import annotations

import hashlib
import math
from collections import OrderedDict
from collections.abc import Callable

import numpy as np

from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.vehicle.description import SIDES, Track, numbers, places
from dcrb_ros.vehicle.kernels import cubic

PAGE = 256.0
"""Length of a page [m]."""
COARSE, FINE = 0.05, 0.005
"""Grids of irregularity and of roughness [m]."""
CUTOFFS = 0.8246, 0.0206, 0.438
"""Omega_c, Omega_r, Omega_s of ERRI B176 [rad/m]."""
IRREGULARITY = {"erri_low": 4.032e-7, "erri_high": 1.08e-6}
"""A of ERRI B176 [m rad]."""
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
PAGES_KEPT = 12
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

    def _source(self, page: int) -> Floats:
        """Return two pages of a random function from the start of a page on, with weights."""
        key = hashlib.sha256(f"{self._name}/{page}".encode()).digest()
        random = np.random.Generator(np.random.Philox(key=int.from_bytes(key[:16], "little")))
        parts = random.standard_normal((2, len(self._amplitude)))
        return np.asarray(np.fft.irfft((parts[0] + 1j * parts[1]) * self._amplitude, 2 * self._points) * self._weight, np.float64)

    def page(self, number: int) -> Floats:
        """Return the values of a page at the points of the grid."""
        if number not in self._pages:
            self._pages[number] = self._source(number)[: self._points] + self._source(number - 1)[self._points :]
            if len(self._pages) > PAGES_KEPT:
                self._pages.popitem(last=False)
        return self._pages[number]

    def at(self, place: Floats) -> Floats:
        """Return the values at places [m]."""
        first, last = math.floor((place.min() - 2 * self._grid) / PAGE), math.floor((place.max() + 3 * self._grid) / PAGE)
        pages = [self.page(number) for number in range(first, last + 1)]
        values = pages[0] if len(pages) == 1 else np.concatenate(pages)
        number = np.floor(place / PAGE)
        return cubic(values, ((number - first) * self._points).astype(np.int64), (place - number * PAGE) / self._grid)


def irregularity(track: Track) -> tuple[Random, Random] | None:
    """Return vertical irregularity and cross level times half the distance of the rails, or None for a smooth track.

    S_v = A Wc^2 / ((W^2 + Wr^2) (W^2 + Wc^2)) and S_v W^2 / (W^2 + Ws^2) (ERRI B176), one-sided in the wavenumber W.
    """
    if track.spectrum == "none":
        return None
    scale, (c, r, s) = IRREGULARITY[track.spectrum], CUTOFFS

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
        self._rough = [Random(f"{track.seed}/rail/{side}", FINE, roughness(track.roughness)) for side in SIDES]
        self._crossings = places(track.crossings, "track.crossings")
        self._corrugation: tuple[float, float, str] | None = None
        if track.corrugation:
            *values, side = track.corrugation.split()
            if side not in SIDES:
                raise Refusal(f"track.corrugation = '{track.corrugation}' names no rail: give for example '0.05 10e-6 left' [m]")
            wavelength, amplitude = numbers(" ".join(values), 2, "track.corrugation")
            if not (0.02 <= wavelength <= SHORTEST and 0.0 < amplitude <= 2e-4):
                raise Refusal(
                    f"track.corrugation = '{track.corrugation}': give a wavelength of 0.02 .. {SHORTEST:g} m, an amplitude up to 0.0002 m"
                )
            self._corrugation = wavelength, amplitude, side

    def displacement(self, place: Floats, side: int) -> Floats:
        """Return the height of the left (1) or right (-1) rail at places [m]."""
        height = self._rough[0 if side > 0 else 1].at(place)
        if self._irregularity is not None:
            vertical, cross = self._irregularity
            height += vertical.at(place) + side * cross.at(place)
        if self._corrugation is not None and self._corrugation[2] == SIDES[0 if side > 0 else 1]:
            wavelength, amplitude, _ = self._corrugation
            height += amplitude * np.sin(2.0 * math.pi / wavelength * place)
        for kink in self.kinks(float(place.min()) - REACH, float(place.max()) + REACH, side):
            away = abs(place - kink)
            sunk = self._track.joint_angle * DIP * (np.exp(-away / DIP) - math.exp(-REACH / DIP))
            height -= np.where(away < REACH, sunk, 0.0)
        return height

    def kinks(self, first: float, last: float, side: int) -> list[float]:
        """Return the places of joints and crossings of a rail from ``first`` up to ``last`` [m], in order."""
        listed = [place for place, rail in self._crossings if first <= place < last and rail == SIDES[0 if side > 0 else 1]]
        spacing = self._track.joint_spacing
        if spacing > 0.0:
            listed += [k * spacing for k in range(math.ceil(first / spacing), math.ceil(last / spacing))]
        return sorted(listed)


def coherence(wavelength: float, spectrum: str = "erri_low") -> float:
    """Return the coherence of left and right irregularity at a wavelength [m], ((S_v - S_x) / (S_v + S_x))^2."""
    w, (c, r, s) = 2.0 * math.pi / wavelength, CUTOFFS
    vertical = IRREGULARITY[spectrum] * c**2 / ((w**2 + r**2) * (w**2 + c**2))
    cross = vertical * w**2 / (w**2 + s**2)
    return ((vertical - cross) / (vertical + cross)) ** 2
