"""The measured path: a gain and a spectral envelope between outer ring and accelerometer, as a calibration finds them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from dcrb_ros.measurement.filters import HIGHEST_SHARE, Filter, above_step_rate, pole_zero_pair
from dcrb_ros.measurement.random_streams import random_stream
from dcrb_ros.measurement.stage import Parameters, Setup, Span, Stage
from dcrb_ros.measurement.stages.structure import StructureParameters
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import Group, choice, quantity

MOST_SECTIONS = 48
"""Largest number of sections of a path [-]."""
FREQUENCY_RANGE = (10.0, 40000.0)
"""Range of the frequencies of sections [Hz]."""
DAMPING_RANGE = (0.001, 5.0)
"""Range of their damping ratios [-]."""
DEVIATIONS = 125.0 * 2.0 ** np.arange(0.0, 8.0, 0.5)
"""Frequencies of the sections by which a drawn path deviates [Hz]: two per octave from 125 Hz to 22 kHz."""
DEVIATION_DAMPING = 0.35
"""Their damping ratio [-]: a section is an octave wide."""
OVERLAP = 1.3
"""Standard deviation of the whole deviation over that of one of these sections [-], from 250 Hz to 10 kHz."""


class PathParameters(Group):
    """Gain and spectral envelope of a measured path, and its deviation between machines."""

    gain_x: float = quantity(1.0, "-", "Gain of the path in X; of a recording in unknown units also the unit", 1e-6, 1e6)
    gain_y: float = quantity(1.0, "-", "Gain of the path in Y; of a recording in unknown units also the unit", 1e-6, 1e6)
    path_x: str = choice(
        "",
        "Path in X: pairs of poles and zeros, the frequency [Hz] and the damping ratio of either, such as '1400 0.03 1600 0.05; 5200 0.02 "
        "6000 0.1'; dcrb calibrate finds them",
    )
    path_y: str = choice("", "The same in Y")
    path_spread: float = quantity(
        0.0, "dB", "Standard deviation of a smooth deviation of the path, drawn by structure.seed for each machine; 0 for none", 0.0, 20.0
    )


class Pair(NamedTuple):
    """A resonance and an antiresonance of the path: a pair of poles and one of zeros."""

    pole: float
    """Natural frequency of the poles [Hz]."""
    pole_damping: float
    """Damping ratio of the poles [-]."""
    zero: float
    """Natural frequency of the zeros [Hz]."""
    zero_damping: float
    """Damping ratio of the zeros [-]."""


class MeasuredPath(Stage):
    """Acceleration through the gain and the sections of a measured path."""

    group, parameters = "structure", PathParameters

    def __init__(self, setup: Setup, rate: float) -> None:
        super().__init__(setup, rate)
        path = setup.parameters[PathParameters]
        self._gains = np.array([path.gain_x, path.gain_y])
        drawn = deviations(setup.parameters[StructureParameters].seed, path.path_spread, rate)
        axes = [[*pairs(text, key), *more] for key, text, more in zip(("x", "y"), (path.path_x, path.path_y), drawn, strict=True)]
        self._filters = [Filter(cascade(axis, rate), columns=1) if axis else None for axis in axes]
        self._active = bool(np.any(self._gains != 1.0)) or any(self._filters)

    @classmethod
    def problems(cls, parameters: Parameters, step_rate: int) -> Iterator[str]:
        path = parameters[PathParameters]
        for key, text in (("structure.path_x", path.path_x), ("structure.path_y", path.path_y)):
            yield from problems_of(key, text, step_rate)

    @property
    def active(self) -> bool:
        return self._active

    def process(self, acceleration: Floats, span: Span) -> Floats:
        columns = []
        for axis, (gain, bank) in enumerate(zip(self._gains, self._filters, strict=True)):
            column = acceleration[:, axis : axis + 1]
            columns.append(gain * (column if bank is None else bank.process(column)))
        return np.concatenate(columns, axis=1)


def cascade(sections: Sequence[Pair], rate: float) -> Floats:
    """Return pairs of poles and zeros as second-order sections in series at a rate [Hz], shape (sections, 6)."""
    return np.concatenate([pole_zero_pair((pair.pole, pair.pole_damping), (pair.zero, pair.zero_damping), rate) for pair in sections])


def deviations(seed: int, spread: float, rate: float) -> tuple[list[Pair], list[Pair]]:
    """Return the sections in X and Y by which the path of a machine deviates, whose standard deviation is about ``spread`` [dB]."""
    if spread == 0.0:
        return [], []
    levels = random_stream(seed, "path").standard_normal((2, len(DEVIATIONS))).clip(-2.5, 2.5) * (spread / OVERLAP)
    x, y = (
        [_peak(float(f), float(level)) for f, level in zip(DEVIATIONS, axis, strict=True) if f < HIGHEST_SHARE * rate] for axis in levels
    )
    return x, y


def _peak(frequency: float, level: float) -> Pair:
    """Return poles and zeros at one frequency [Hz], where their gain is ``level`` [dB]; it is 0 dB far from it."""
    wide = DEVIATION_DAMPING * 10.0 ** (abs(level) / 20.0)
    dampings = (DEVIATION_DAMPING, wide) if level >= 0.0 else (wide, DEVIATION_DAMPING)
    return Pair(frequency, dampings[0], frequency, dampings[1])


def pairs(text: str, key: str) -> list[Pair]:
    """Return the pairs in a text such as ``1400 0.03 1600 0.05; 5200 0.02 6000 0.1``.

    Raises:
        ValueError: an entry is not four numbers.
    """
    sections = []
    for entry in (entry.strip() for entry in text.split(";")):
        try:
            numbers = [float(word) for word in re.split(r"[,\s]+", entry)] if entry else []
            if numbers:
                pole, pole_damping, zero, zero_damping = numbers
                sections.append(Pair(pole, pole_damping, zero, zero_damping))
        except ValueError:
            raise ValueError(
                f"{key}: '{entry}' is not a pair of poles and zeros: give the frequency [Hz] and the damping ratio of either, such as "
                "1400 0.03 1600 0.05"
            ) from None
    return sections


def text_of(sections: Sequence[Pair]) -> str:
    """Return pairs as `pairs` reads them."""
    return "; ".join(" ".join(f"{number:.6g}" for number in pair) for pair in sections)


def problems_of(key: str, text: str, step_rate: int) -> Iterator[str]:
    """Yield a sentence for each reason for which the pairs in a text cannot run at a step rate [Hz]."""
    try:
        sections = pairs(text, key)
    except ValueError as error:
        yield str(error)
        return
    yield from _outside(key, sections)
    for frequency in (frequency for pair in sections for frequency in (pair.pole, pair.zero)):
        yield from above_step_rate(f"{key}: a frequency", frequency, step_rate)


def _outside(key: str, sections: Sequence[Pair]) -> Iterator[str]:
    """Yield a sentence for each number out of range."""
    frequency, damping = ("frequency", FREQUENCY_RANGE, " Hz"), ("damping ratio", DAMPING_RANGE, "")
    for pair in sections:
        for value, (name, (low, high), unit) in zip(pair, (frequency, damping, frequency, damping), strict=True):
            if not low <= value <= high:
                yield f"{key}: {name} {value:g}{unit} is outside {low:g} .. {high:g}{unit}"
    if len(sections) > MOST_SECTIONS:
        yield f"{key} has {len(sections)} pairs of poles and zeros; at most {MOST_SECTIONS} are allowed"
