"""The structural path: a bank of modes of the axle box between outer ring and accelerometer."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from dcrb_ros.measurement.filters import Filter, side_by_side, transmissibility
from dcrb_ros.measurement.housing_priors import HousingName
from dcrb_ros.measurement.random_streams import random_stream
from dcrb_ros.measurement.stage import Parameters, Setup, Span, Stage
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import Group, choice, quantity

LOWEST, HIGHEST = 500.0, 8000.0
"""Band in which natural frequencies are drawn [Hz]."""
LEAST_DAMPING, MOST_DAMPING = 0.01, 0.05
"""Range in which damping ratios are drawn [-]."""
USUAL_DAMPING = 0.02
"""Damping ratio of given modes if none is given [-]."""
FREQUENCY_RANGE = (50.0, 20000.0)
"""Range of given natural frequencies [Hz]."""
DAMPING_RANGE = (0.001, 0.5)
"""Range of given damping ratios [-]."""
MOST_MODES = 24


class StructureParameters(Group):
    """Modes of the axle box, and its housing."""

    housing: HousingName = choice(
        "none",
        "Housing with many overlapping modes, drawn by structure.seed: none, laboratory (a bearing support on a plate) or axle_box (a "
        "casting of 60 kg). With further modes it begins above the highest of them",
    )
    modes: int = quantity(
        0, "-", "Number of modes of the axle box drawn at random, 500 to 8000 Hz, damping 1 to 5 %; 0 for a rigid path", 0, MOST_MODES
    )
    seed: int = quantity(1, "-", "Seed of the random modes, the housing and path_spread, independent of simulation.seed", 0, 2**31 - 1)
    mounting: int = quantity(
        0,
        "-",
        "Seed of the mounting of the bearing, which changes the shares of the modes of a housing; 0 for those drawn by structure.seed",
        0,
        2**31 - 1,
    )
    frequencies: str = choice("", "Natural frequencies of the modes [Hz], such as '900, 2300, 5200', instead of random ones")
    dampings: str = choice("", "Damping ratios of these modes [-], such as '0.02, 0.03, 0.01'; empty for 0.02 each")
    coupling: float = quantity(
        0.7,
        "-",
        "Share of the acceleration transmitted by the modes; the rest is transmitted directly. 1 in a housing",
        0.0,
        1.0,
        remedy="give a share, not per cent",
    )


class AxleBox(Stage):
    """Acceleration through the modes of the axle box, which differ in X and Y; in a housing, the stage of the housing includes them."""

    group, parameters = "structure", StructureParameters

    def __init__(self, setup: Setup, rate: float) -> None:
        super().__init__(setup, rate)
        structure = setup.parameters[StructureParameters]
        present = structure.housing == "none" and has_modes(structure) and structure.coupling > 0.0
        self._axes = [Filter(axis, columns=1) for axis in sections(structure, rate)] if present else []

    @classmethod
    def problems(cls, parameters: Parameters, step_rate: int) -> Iterator[str]:
        structure = parameters[StructureParameters]
        if structure.mounting and structure.housing == "none":
            yield (
                f"structure.mounting = {structure.mounting} changes a housing, and there is none: give structure.mounting = 0, or "
                "structure.housing = laboratory or axle_box"
            )
        try:
            frequencies = numbers(structure.frequencies, "structure.frequencies")
            dampings = numbers(structure.dampings, "structure.dampings")
        except ValueError as error:
            yield str(error)
            return
        yield from _outside("structure.frequencies", frequencies, FREQUENCY_RANGE, " Hz")
        yield from _outside("structure.dampings", dampings, DAMPING_RANGE, "")
        if dampings and len(dampings) != len(frequencies):
            yield f"structure.dampings has {len(dampings)} numbers for {len(frequencies)} structure.frequencies: give one for each, or none"

    @property
    def active(self) -> bool:
        return bool(self._axes)

    def process(self, acceleration: Floats, span: Span) -> Floats:
        columns = [bank.process(acceleration[:, axis : axis + 1]) for axis, bank in enumerate(self._axes)]
        return np.concatenate(columns, axis=1)


class Mode(NamedTuple):
    """A mode of the axle box."""

    frequency: float
    """Natural frequency [Hz]."""
    damping: float
    """Damping ratio [-]."""
    share: tuple[float, float]
    """Share of the acceleration in X and Y that goes through it [-]; the shares of all modes add up to 1."""


def has_modes(structure: StructureParameters) -> bool:
    """Return whether an axle box has given or drawn modes."""
    return structure.modes > 0 or bool(structure.frequencies.strip())


def modes(structure: StructureParameters) -> list[Mode]:
    """Return the modes of an axle box: the given ones, or one drawn in each of equal intervals of the logarithm of the band."""
    random = random_stream(structure.seed, "structure")
    frequencies = numbers(structure.frequencies, "structure.frequencies")
    dampings = numbers(structure.dampings, "structure.dampings") or [USUAL_DAMPING] * len(frequencies)
    if not frequencies:
        places = (np.arange(structure.modes) + random.random(structure.modes)) / max(1, structure.modes)
        frequencies = [float(frequency) for frequency in LOWEST * (HIGHEST / LOWEST) ** places]
        dampings = [float(damping) for damping in random.uniform(LEAST_DAMPING, MOST_DAMPING, structure.modes)]
    shares = random.uniform(0.2, 1.0, (len(frequencies), 2))
    shares /= shares.sum(axis=0)
    return [Mode(f, z, (float(x), float(y))) for f, z, (x, y) in zip(frequencies, dampings, shares, strict=True)]


def sections(structure: StructureParameters, rate: float) -> tuple[Floats, Floats]:
    """Return the path through the axle box in X and in Y as second-order sections at a rate [Hz]; its static gain is 1."""
    bench_modes = modes(structure)
    bank = [transmissibility(mode.frequency, mode.damping, rate) for mode in bench_modes]
    x, y = ([structure.coupling * mode.share[axis] for mode in bench_modes] for axis in (0, 1))
    straight = 1.0 - structure.coupling
    return side_by_side(bank, x, straight), side_by_side(bank, y, straight)


def numbers(text: str, key: str) -> list[float]:
    """Return the numbers of a list in a text.

    Raises:
        ValueError: a word that is not a number.
    """
    words = [word for word in re.split(r"[,\s]+", text) if word]
    try:
        return [float(word) for word in words]
    except ValueError:
        raise ValueError(f"{key}: '{text}' is not a list of numbers: separate them by commas, such as '900, 2300'") from None


def _outside(key: str, values: list[float], span: tuple[float, float], unit: str) -> Iterator[str]:
    low, high = span
    for value in values:
        if not low <= value <= high:
            yield f"{key}: {value:g}{unit} is outside {low:g} .. {high:g}{unit}"
    if len(values) > MOST_MODES:
        yield f"{key} has {len(values)} numbers; at most {MOST_MODES} are allowed"
