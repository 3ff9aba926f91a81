"""Distributions of what a table of measured recordings does not say, from which replicas are drawn.

All are wide, and none was fitted to the order of detectors. `PRIORS` is the table in the documentation.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, Protocol

import numpy as np

from dcrb_ros.measurement.housing_priors import AXLE_BOX, FLOORS, LABORATORY, Beta, Lognormal, Normal, Uniform
from dcrb_ros.text.markdown import table

Owner = Literal["machine", "bearing"]
"""Whether a value is drawn once for a machine, or for a bearing on it."""
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


@dataclass(frozen=True)
class Prior:
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
    bench: Literal["any", "balls", "rollers"] = "any"
    """Kind of bench for which it is drawn: a ball bearing on a laboratory rig, or a roller bearing in an axle box."""


RINGS = ("outer_ring", "inner_ring")
LOAD, GAIN, WIDTH, DEPTH, SHARE, AZIMUTH = "load", "gain", "width", "depth", "share", "azimuth"
BOX, AXLE = "box mass", "axle mass"
BACKGROUND, LINES, FLOOR = "structure.background", "structure.background_lines", "structure.floor"
PRIORS: tuple[Prior, ...] = (
    Prior(LOAD, "machine", LogUniform(0.5, 5.0), "of the bench's load", "unknown on CWRU and HIT; 110 to 1340 N on MFPT"),
    Prior("operating.speed_fluctuation", "machine", LogUniform(3e-4, 3e-3), "-", "motors without a flywheel"),
    Prior("structure.seed", "machine", Seed(), "-", "the housing: distributions of `housing_priors.LABORATORY`", "path"),
    Prior("sensor.noise_density", "machine", LogUniform(5e-4, 4e-3), "m/s²/√Hz", "data sheets of IEPE sensors, times the gain"),
    Prior("surfaces.seed", "bearing", Seed(), "-", "the individual"),
    Prior("surfaces.waviness", "bearing", LogUniform(3e-9, 3e-8), "m", "no line of the bearing on healthy CWRU", "", (), "balls"),
    Prior("surfaces.waviness", "bearing", LogUniform(1e-8, 1e-7), "m", "new and run bearings", "", (), "rollers"),
    Prior("surfaces.run_out", "bearing", LogUniform(5e-7, 5e-6), "m", "tolerance classes P5 to normal"),
    Prior(WIDTH, "bearing", LogUniform(0.02, 0.2), "of the roller's diameter", "0.16 to 1.6 mm on a 6205", "", (*RINGS, "roller")),
    Prior(DEPTH, "bearing", LogUniform(1e-5, 1e-4), "m", "spalls and seeded pits", "", (*RINGS, "roller")),
    Prior(SHARE, "bearing", Uniform(0.3, 1.0), "-", "axial share of the track", "", RINGS),
    Prior(AZIMUTH, "bearing", Uniform(-1.0, 1.0), "rad", "in or beside the load zone", "", ("outer_ring",)),
    Prior(
        "impacts.spread", "bearing", Lognormal(0.5, 1.8), "-", "scatter of impacts of three rigs; at most 1.3", "impacts", RINGS, "balls"
    ),
    Prior("impacts.spread", "bearing", Lognormal(0.25, 1.8), "-", "a choice: longer lines of contact", "impacts", RINGS, "rollers"),
    Prior("impacts.element_share", "bearing", Beta(1.0, 2.5), "-", "cage lines of three rigs", "impacts", RINGS, "balls"),
    Prior("impacts.element_share", "bearing", Beta(1.0, 3.0), "-", "a choice", "impacts", RINGS, "rollers"),
    Prior("impacts.shaft_share", "bearing", Beta(1.0, 5.0), "-", "sidebands of outer rings", "impacts", RINGS, "balls"),
    Prior("impacts.shaft_share", "bearing", Beta(1.0, 4.0), "-", "a choice", "impacts", RINGS, "rollers"),
    Prior("impacts.axial_share", "machine", Uniform(0.3, 0.8), "-", "sidebands of inner rings", "impacts", (), "balls"),
    Prior("impacts.axial_share", "machine", Uniform(0.0, 0.1), "-", "a choice", "impacts", (), "rollers"),
    Prior("impacts.time_spread", "bearing", Lognormal(4e-5, 3.0), "s", "jitter of three rigs", "impacts", RINGS, "balls"),
    Prior("impacts.time_spread", "bearing", Lognormal(5e-5, 2.0), "s", "a choice", "impacts", RINGS, "rollers"),
    Prior("impacts.spin_memory", "bearing", LogUniform(0.002, 0.05), "s", "consecutive impacts on CWRU", "impacts", ("roller",), "balls"),
    Prior(
        BACKGROUND, "machine", Normal(5.0, 5.0), "dB", "over the healthy bearing; 6 to 10 on HIT by calibration", "background", (), "balls"
    ),
    Prior(BACKGROUND, "machine", AXLE_BOX.background, "dB", "over the healthy bearing", "background", (), "rollers"),
    Prior(LINES, "machine", LABORATORY.lines, "-", "share of lines on CWRU and HIT", "background", (), "balls"),
    Prior(LINES, "machine", AXLE_BOX.lines, "-", "a choice", "background", (), "rollers"),
    Prior(FLOOR, "bearing", FLOORS["outer"], "-", "quiet quarter between impacts on three rigs", "background", ("outer_ring",)),
    Prior(FLOOR, "bearing", FLOORS["inner"], "-", "the same", "background", ("inner_ring",)),
    Prior(FLOOR, "bearing", FLOORS["roller"], "-", "quiet quarter on CWRU, 70 % of all added power", "background", ("roller",)),
    Prior(GAIN, "bearing", Lognormal(1.0, 3.0), "-", "an amplifier is set when a bearing is mounted; 1 if it is `known`"),
    Prior("structure.mounting", "bearing", Seed(), "-", "spectra of the bearings of a rig, three rigs", "path"),
    Prior(
        BOX, "machine", LogUniform(0.125, 1.0), "of the bench's mass", "a pillow block of 0.5 kg to an end shield of 4 kg", "", (), "balls"
    ),
    Prior(
        AXLE,
        "machine",
        LogUniform(0.0625, 1.0),
        "of the bench's mass",
        "0.1 m of the shaft, 0.5 kg, to a rigid rotor of 8 kg",
        "",
        (),
        "balls",
    ),
)
"""What is drawn for every replica."""
START, STARTS = 0.2, 0.3
"""Shortest start of a run that is cut off, and the range of its random lengths [s]."""
HOUSINGS = {"balls": "laboratory", "rollers": "axle_box"}
"""Housing of a replica with a path, by the kind of its bench; see `dcrb_ros.measurement.housing_priors`."""
MOST_SPREAD = 1.3
"""Largest spread of the strength of impacts [-]."""


def drawn(owner: Owner, truth: str, bench: str, random: np.random.Generator, without: Iterable[str] = ()) -> dict[str, Any]:
    """Return a value of every prior of an owner that applies to a truth and a kind of bench.

    Parts that are left out change no other value.
    """
    left_out, values = set(without), dict[str, Any]()
    for prior in PRIORS:
        if prior.owner != owner:
            continue
        value = prior.distribution.drawn(random)
        if prior.part not in left_out and prior.bench in ("any", bench) and (not prior.truths or truth in prior.truths):
            values[prior.key] = value
    if "impacts.spread" in values:
        values["impacts.spread"] = min(values["impacts.spread"], MOST_SPREAD)
        shares = values["impacts.element_share"] + values["impacts.shaft_share"]
        for key in ("impacts.element_share", "impacts.shaft_share"):
            values[key] /= max(1.0, shares * (1.0 + 1e-9))
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
        case Normal(mean, deviation):
            return f"{mean:g} ± {deviation:g}, normal"
        case Beta(a, b):
            return f"Beta({a:g}, {b:g})"
    return "a random seed"


def prior_table() -> str:
    """Return the priors as a Markdown table, for the documentation."""
    heads = ("value", "drawn for each", "distribution", "unit", "applies to", "part", "reason")
    rows = (
        (
            f"`{prior.key}`" if "." in prior.key else prior.key,
            prior.owner,
            described(prior.distribution),
            prior.unit,
            ", ".join(filter(None, (*prior.truths, prior.bench if prior.bench != "any" else ""))) or "all",
            prior.part or "-",
            prior.reason,
        )
        for prior in PRIORS
    )
    return table(heads, rows)


def generator_of(*words: object) -> np.random.Generator:
    """Return the random generator of some words, alike on every machine."""
    digest = hashlib.sha256("\n".join(map(str, words)).encode()).digest()
    return np.random.Generator(np.random.PCG64(int.from_bytes(digest[:16], "big")))
