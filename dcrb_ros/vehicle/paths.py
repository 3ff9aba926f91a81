"""Paths by which bearings and contacts reach the boxes beyond the modes of the structure: resonances drawn for each vehicle.

A path is a sum of resonances with random signs, each after the time that a bending wave of its frequency takes. Its mean square in every
band is the level that the vehicle's file gives.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from dcrb_ros.measurement.random_streams import random_stream
from dcrb_ros.schema.arrays import Complexes, Floats
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.parameters import STEEL_DENSITY
from dcrb_ros.vehicle.description import Vehicle, levels
from dcrb_ros.vehicle.kernels import add_paths
from dcrb_ros.vehicle.structure import BODY_DIAMETER, ELASTICITY

BANDS = (200.0, 500.0, 1000.0, 2000.0, 5000.0, 20000.0)
"""Limits of the bands of a path [Hz]."""
RESONANCES = 8
DAMPING = (0.01, 0.05)
"""Range of the damping ratio of a resonance [-]."""
FASTEST = 3000.0
"""Highest group velocity [m/s]."""
CONTACT_LEVELS = {
    "same_wheelset": (-11.0, -15.0, -15.0),
    "same_side": (-7.0, -8.0, -9.0, -15.0, -15.0),
    "diagonal": (-21.0, -16.0, -16.0, -25.0, -25.0),
}
"""Levels of the motion of a contact at other boxes, over the box above it [dB]."""
MOST_ENERGY = 0.5
"""Largest sum of the levels of the paths from a bearing in a band, as shares of its energy [-]."""
THIRDS = np.array([1000.0 * 10.0 ** (k / 10.0) for k in range(-7, 14)])
"""Middles of the third octaves of a path [Hz]."""
WITHIN = 10.0 ** (np.linspace(-0.05, 0.05, 48, endpoint=False) + 0.05 / 48)
"""Frequencies within a third octave, over its middle [-]; their distance is 0.24 of the width of the narrowest resonance."""


@dataclass(frozen=True)
class Path:
    """A path from one source to one box."""

    sections: Floats
    """Gain and recursion of every resonance, shape (resonances, 3)."""
    delays: Floats
    """Delay of each [steps]."""

    def response(self, frequency: Floats, rate: float) -> Floats:
        """Return the squared magnitude at frequencies [Hz]."""
        return _magnitude(self.sections[:, 0], _resonances(self.sections, self.delays, frequency, rate))


def _resonances(sections: Floats, delays: Floats, frequency: Floats, rate: float) -> list[tuple[Complexes, Complexes, Complexes]]:
    """Return numerator, denominator and delay of each resonance of a path at frequencies [Hz]; they do not depend on the gains."""
    z = np.exp(-2j * np.pi * frequency / rate)
    return [(1.0 - z**2, 1.0 - a1 * z - a2 * z**2, z**delay) for (_, a1, a2), delay in zip(sections, delays, strict=True)]


def _magnitude(gains: Floats, resonances: Sequence[tuple[Complexes, Complexes, Complexes]]) -> Floats:
    """Return the squared magnitude of a sum of resonances with some gains."""
    whole = sum(gain * above / below * late for gain, (above, below, late) in zip(gains, resonances, strict=True))
    return np.asarray(np.square(np.abs(whole)), np.float64)


class Paths:
    """Paths from sources to boxes, which are stepped together."""

    def __init__(self, chosen: Mapping[tuple[int, int], Path], sources: int, columns: int) -> None:
        """Start at rest with paths by source and box; each of the ``sources`` has so many ``columns``."""
        self._ends = np.array(list(chosen), np.int64).reshape(-1, 2)
        self._sections = np.array([path.sections for path in chosen.values()], np.float64).reshape(-1, RESONANCES, 3)
        self._delays = np.array([path.delays for path in chosen.values()], np.float64).reshape(-1, RESONANCES)
        self._memory = np.zeros((len(chosen), columns, RESONANCES, 2))
        self._lead = int(self._delays.max(initial=0.0)) + 2
        self._before = np.zeros((sources, columns, self._lead))

    def add(self, source: Floats, target: Floats) -> None:
        """Add what arrives of the next steps of the sources to ``target``; shapes (sources, columns, steps) and (boxes, columns, steps)."""
        known = np.concatenate([self._before, source], axis=2)
        add_paths(self._ends, self._sections, self._delays, self._memory, known, self._lead, target)
        self._before = known[:, :, -self._lead :].copy()


def group_velocity(frequency: Floats) -> Floats:
    """Return the group velocity of bending waves of an axle, at most that of its surface waves [m/s]: 2 sqrt(w) (EI / rho A)^(1/4)."""
    ratio = ELASTICITY / STEEL_DENSITY * BODY_DIAMETER**2 / 16.0
    return np.asarray(np.minimum(2.0 * np.sqrt(2.0 * np.pi * frequency) * ratio**0.25, FASTEST), np.float64)


@functools.lru_cache(maxsize=256)
def drawn_path(seed: int, name: str, bands: tuple[float, ...], decibels: tuple[float, ...], distance: float, rate: float) -> Path:
    """Return a path whose mean square in each band has a level [dB], over a distance [m], at a rate [Hz].

    ``bands`` are the limits of the bands [Hz], one more than ``decibels``. Vehicles of one seed share the path.
    """
    random = random_stream(seed, f"path/{name}")
    edges = np.minimum(bands, 0.4 * rate)
    share = np.sort(random.uniform(size=RESONANCES - len(decibels)))
    spread = np.exp(np.log(edges[0]) + share * np.log(edges[-1] / edges[0]))
    centres = np.exp([random.uniform(math.log(a) + 0.2, math.log(b) - 0.2) for a, b in itertools.pairwise(edges)])
    frequency = np.sort(np.concatenate([centres, spread]))
    damping, sign = random.uniform(*DAMPING, RESONANCES), random.choice([-1.0, 1.0], RESONANCES)
    delays = np.round(distance / group_velocity(frequency) * rate)
    band = np.clip(np.searchsorted(edges, frequency) - 1, 0, len(decibels) - 1)
    angle, radius = 2.0 * np.pi * frequency / rate, np.exp(-damping * 2.0 * np.pi * frequency / rate)
    unit = np.column_stack([0.5 * (1.0 - radius**2) * sign, 2.0 * radius * np.cos(angle), -(radius**2)])
    aims, gains = 10.0 ** (np.asarray(decibels) / 10.0), 10.0 ** (np.asarray(decibels)[band] / 20.0)
    grids = [np.asarray(np.geomspace(a, b, 400), np.float64) for a, b in itertools.pairwise(edges)]
    resonances = [_resonances(unit, delays, grid, rate) for grid in grids]
    for _ in range(60):  # each band is mostly of its own resonances
        present = np.array([_magnitude(unit[:, 0] * gains, each).mean() for each in resonances])
        gains = gains * ((aims / present) ** 0.25)[band]
    return Path(unit * np.column_stack([np.round(gains, 9), np.ones(RESONANCES), np.ones(RESONANCES)]), delays)


def kind_of(vehicle: Vehicle, first: int, second: int) -> str:
    """Return how two boxes lie: same_wheelset, same_side or diagonal."""
    a, b = vehicle.boxes[first], vehicle.boxes[second]
    if a.axle == b.axle:
        return "same_wheelset"
    return "same_side" if a.side == b.side else "diagonal"


def distance_of(vehicle: Vehicle, first: int, second: int) -> float:
    """Return the distance of two boxes along the axles and the rail [m]."""
    a, b = vehicle.boxes[first], vehicle.boxes[second]
    return abs(vehicle.axles[a.axle].x - vehicle.axles[b.axle].x) + 1.0 * abs(a.side - b.side)


def bearing_paths(vehicle: Vehicle, rate: float) -> dict[tuple[int, int], Path]:
    """Return the paths between the bearings by source and receiver; both directions of a pair are one draw (reciprocity).

    Raises:
        Refusal: the levels are more than half of a bearing's energy, or the drawn paths carry more than all of it in a third octave.
    """
    chosen: dict[tuple[int, int], Path] = {}
    energy = np.zeros((len(vehicle.boxes), len(BANDS) - 1))
    for first in range(len(vehicle.boxes)):
        for second in range(first + 1, len(vehicle.boxes)):
            kind = kind_of(vehicle, first, second)
            decibels = tuple(levels(getattr(vehicle.paths, kind), len(BANDS) - 1, f"paths.{kind}"))
            name = f"bearing/{vehicle.boxes[first].name}/{vehicle.boxes[second].name}"
            path = drawn_path(vehicle.paths.seed, name, BANDS, decibels, distance_of(vehicle, first, second), rate)
            chosen[first, second] = chosen[second, first] = path
            energy[[first, second]] += 10.0 ** (np.asarray(decibels) / 10.0)
    if energy.max() > MOST_ENERGY:
        raise Refusal(f"paths: {energy.max():.2f} of a bearing's energy reaches other boxes, above {MOST_ENERGY:g}: lower the levels")
    _check_drawn(vehicle, chosen, rate)
    return chosen


def _check_drawn(vehicle: Vehicle, chosen: Mapping[tuple[int, int], Path], rate: float) -> None:
    """Refuse paths that carry more energy than a bearing has in a third octave: that of a path lies in its resonances."""
    middles = THIRDS[THIRDS * WITHIN[-1] < 0.4 * rate]
    each = {id(path): path.response((middles[:, None] * WITHIN).ravel(), rate) for path in chosen.values()}
    shares = np.zeros((len(vehicle.boxes), len(middles)))
    for (source, _), path in chosen.items():
        shares[source] += each[id(path)].reshape(-1, len(WITHIN)).mean(axis=1)
    box, band = np.unravel_index(int(np.argmax(shares)), shares.shape)
    if shares[box, band] > 1.0:
        raise Refusal(
            f"paths: in the third octave at {float(f'{middles[band]:.3g}'):g} Hz, {shares[box, band]:.2f} of the energy of the bearing of "
            f"{vehicle.boxes[int(box)].name} reaches other boxes, above 1: lower the levels, or give another paths.seed"
        )


def contact_paths(vehicle: Vehicle, rate: float, gains: Sequence[float]) -> dict[tuple[int, int], Path]:
    """Return the paths from the motion of each contact [m/s^2] to each box, beyond the modes of the structure.

    ``gains`` are the rms gains of the box over the contact in the first two of `BANDS`, which the structure moves [-]; from the second one
    they fall by 12 dB in an octave (an assumption).
    """
    middles = [math.sqrt(a * b) for a, b in itertools.pairwise(BANDS[1:])]
    above = [20.0 * math.log10(gains[0]), *(20.0 * math.log10(gains[1]) - 40.0 * math.log10(middle / middles[0]) for middle in middles)]
    chosen = {}
    for source in range(len(vehicle.boxes)):
        for box in range(len(vehicle.boxes)):
            relative = (0.0, 0.0, 0.0) if source == box else CONTACT_LEVELS[kind_of(vehicle, source, box)]
            count = len(relative)
            decibels = tuple(level + part for level, part in zip(above[-count:], relative, strict=True))
            names = sorted((vehicle.boxes[source].name, vehicle.boxes[box].name))
            distance = distance_of(vehicle, source, box)
            chosen[source, box] = drawn_path(
                vehicle.paths.seed, f"contact/{'/'.join(names)}", BANDS[-count - 1 :], decibels, distance, rate
            )
    return chosen
