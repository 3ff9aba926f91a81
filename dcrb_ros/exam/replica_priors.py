"""Distributions of what a table of measured recordings does not say, from which replicas are drawn.

All are wide, and none was fitted to the order of detectors. `PRIORS` is the table in the documentation.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Literal, NamedTuple, Protocol

import numpy as np

from dcrb_ros.measurement.housing_priors import Beta, Lognormal, Uniform

Owner = Literal["machine", "bearing", "file"]
"""Whether a value is drawn once for a machine, for a bearing on it, or for a recording."""
PARTS = ("path", "impacts", "background")
"""Parts of a replica that can be left out, to see what each of them changes."""
SEEDS = 2**31 - 1


class Distribution(Protocol):
    """A distribution of a number."""

    def drawn(self, random: np.random.Generator) -> float:
        """Return a random value."""


class LogUniform(NamedTuple):
    """A range with equal probability of the logarithm."""

    low: float
    high: float

    def drawn(self, random: np.random.Generator) -> float:
        """Return a random value."""
        return float(self.low * (self.high / self.low) ** random.uniform())


class Seed(NamedTuple):
    """A seed of the bench."""

    def drawn(self, random: np.random.Generator) -> int:
        """Return a random seed."""
        return int(random.integers(1, SEEDS))


class Prior(NamedTuple):
    """What is drawn."""

    key: str
    """Parameter of the bench, or a name of `replica` for a value that it converts."""
    owner: Owner
    distribution: Distribution
    unit: str
    reason: str
    part: str = ""
    """Part of `PARTS` to which it belongs; empty if it always applies."""
    truths: tuple[str, ...] = ()
    """Verdicts for which it is drawn; all of them if empty."""


RINGS = ("outer_ring", "inner_ring")
LOAD, GAIN, GAIN_KNOWN, WIDTH, DEPTH, SHARE, AZIMUTH = "load", "gain", "gain known", "width", "depth", "share", "azimuth"
PRIORS: tuple[Prior, ...] = (
    Prior(LOAD, "machine", LogUniform(0.5, 5.0), "of the bench's load", "unknown on CWRU and HIT; 110 to 1340 N on MFPT"),
    Prior("operating.speed_fluctuation", "machine", LogUniform(3e-4, 3e-3), "-", "motors without a flywheel"),
    Prior("structure.seed", "machine", Seed(), "-", "the housing: distributions of `housing_priors.LABORATORY`", "path"),
    Prior("sensor.noise_density", "machine", LogUniform(5e-4, 4e-3), "m/s²/√Hz", "data sheets of IEPE sensors, times the gain"),
    Prior(GAIN_KNOWN, "machine", Uniform(0.0, 1.0), "-", "below 0.5 the gains of all files are equal; a column `gain` says so instead"),
    Prior(GAIN, "file", Lognormal(1.0, 3.0), "-", "files of one public set differ tenfold"),
    Prior("surfaces.seed", "bearing", Seed(), "-", "the individual"),
    Prior("surfaces.waviness", "bearing", LogUniform(1e-8, 1e-7), "m", "new and run bearings"),
    Prior("surfaces.run_out", "bearing", LogUniform(5e-7, 5e-6), "m", "tolerance classes P5 to normal"),
    Prior(WIDTH, "bearing", LogUniform(0.02, 0.2), "of the roller's diameter", "0.16 to 1.6 mm on a 6205", "", (*RINGS, "roller")),
    Prior(DEPTH, "bearing", LogUniform(1e-5, 1e-4), "m", "spalls and seeded pits", "", (*RINGS, "roller")),
    Prior(SHARE, "bearing", Uniform(0.3, 1.0), "-", "axial share of the track", "", RINGS),
    Prior(AZIMUTH, "bearing", Uniform(-1.0, 1.0), "rad", "in or beside the load zone", "", ("outer_ring",)),
)
"""What is drawn for every replica."""
HOUSING = {"structure.housing": "laboratory"}
"""Housing of every replica with a path; see `dcrb_ros.measurement.housing_priors`."""
EQUAL_GAINS = 0.5
"""Probability that all files of a machine have one gain [-]."""


def drawn(owner: Owner, truth: str, random: np.random.Generator, without: Iterable[str] = ()) -> Mapping[str, Any]:
    """Return a value of every prior of an owner that applies to a truth; parts that are left out change no other value."""
    left_out, values = set(without), {}
    for prior in PRIORS:
        if prior.owner != owner:
            continue
        value = prior.distribution.drawn(random)
        if prior.part not in left_out and (not prior.truths or truth in prior.truths):
            values[prior.key] = value
    return values


def described(distribution: Distribution) -> str:
    """Return a distribution in words, as in the table of the documentation."""
    match distribution:
        case LogUniform(low, high):
            return f"{low:g} to {high:g}, log-uniform"
        case Uniform(low, high):
            return f"{low:g} to {high:g}, uniform"
        case Lognormal(median, factor):
            return f"{median:g}, lognormal, factor {factor:g}, clipped at two"
        case Beta(a, b):
            return f"Beta({a:g}, {b:g})"
    return "a random seed"


def seed_of(*words: object) -> np.random.Generator:
    """Return the random generator of some words, alike on every machine."""
    import hashlib

    digest = hashlib.sha256("\n".join(map(str, words)).encode()).digest()
    return np.random.Generator(np.random.PCG64(int.from_bytes(digest[:16], "big")))
