"""The path from ring to sensor, its gain, and the white noise: what the spectra of all recordings together identify."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from dcrb_ros.calibration.estimate import QUANTILE, Estimate, PathLevel, by_factor
from dcrb_ros.calibration.measured import Measured
from dcrb_ros.calibration.path_fit import NEPER, Data, PathFit, fit_path
from dcrb_ros.calibration.source import Source
from dcrb_ros.calibration.spectra import HIGHEST_SHARE, Spectrum, binned, fluctuation, power_density
from dcrb_ros.diagnosis.features.band_levels import EDGE, middles
from dcrb_ros.measurement.stages.path import text_of
from dcrb_ros.schema.arrays import Floats

LOWEST = 200.0
"""Frequency from which a path is identified [Hz]: below it, machines have other sources."""
HEARD = 0.5
"""Share of the noise in a bin from which the noise counts as identified, and of the bearing from which the path does [-]."""
FEWEST_BINS = 16
"""Bins in which the noise must exceed the bearing [-]: a third of an octave."""
FEW = 2.3534 / QUANTILE
"""Quantile of Student's t with three degrees of freedom over that of a normal variable [-]: four individuals are compared."""
COLUMNS = {"x": 0, "y": 1}


@dataclass
class Part:
    """What a part of the calibration found."""

    estimates: list[Estimate] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    """What could not be identified, and why."""
    parameters: dict[str, Any] = field(default_factory=dict)
    """Parameters of the configuration."""


@dataclass
class IdentifiedPath(Part):
    """The path of each axis."""

    fits: dict[str, PathFit] = field(default_factory=dict)
    levels: list[PathLevel] = field(default_factory=list)
    residuals: list[tuple[str, Floats, Floats]] = field(default_factory=list)
    gains: dict[str, Estimate] = field(default_factory=dict)
    """Gain of each axis over the band of the source, which is what can be identified of a gain."""
    white: float = 0.0
    """Density of the white noise [m/s^2/sqrt(Hz)]."""

    def gain(self, axis: str) -> float:
        """Return the gain at rest of the first recording [-]."""
        return float(self.parameters[f"structure.gain_{axis}"])

    def divide_gains(self, factor: float) -> None:
        """Divide all gains and levels by a factor [-]: modulation by the shaft adds power, which is not the path's."""
        shift = 20.0 * math.log10(factor)
        self.levels = [replace(one, level=one.level - shift, low=one.low - shift, high=one.high - shift) for one in self.levels]
        self.gains = {axis: one.divided(factor) for axis, one in self.gains.items()}
        for k, one in enumerate(self.estimates):
            if one.key.startswith("structure.gain_"):
                self.estimates[k] = one.divided(factor)
                self.parameters[one.key] = one.value / factor


def identified_path(machines: Sequence[Measured], individuals: Sequence[Sequence[Source]], step_rate: float) -> IdentifiedPath:
    """Return the path of each axis and the noise of both; of the individuals of the bearing for each recording, the first is the source."""
    found, sources = IdentifiedPath(), [one[0] for one in individuals]
    for row, axis in enumerate(machines[0].axes):
        found.fits[axis] = fit_path(_data(machines, sources, row, axis, step_rate))
    _add_noise(found)
    for row, axis in enumerate(machines[0].axes):
        own = power_density(sources[0].acceleration[COLUMNS[axis]], machines[0].rate)
        _add_axis(found, axis, own, [_unsure(m, i, row, axis) for m, i in zip(machines, individuals, strict=True)])
    if machines[0].axes == ("y",):
        for name in ("gain", "path"):
            found.parameters[f"structure.{name}_x"] = found.parameters[f"structure.{name}_y"]
        gain = found.estimates[-1]
        found.estimates.append(Estimate("structure.gain_x", gain.value, gain.low, gain.high, gain.unit, log=True))
        found.remarks.append("the recording has one axis: it is taken as Y, the direction of the load, and X has the same path")
    if machines[0].unit == "relative":
        found.remarks.append("the unit of the recording is relative: the gain contains it, and levels mean nothing by themselves")
    return found


def _data(machines: Sequence[Measured], sources: Sequence[Source], row: int, axis: str, step_rate: float) -> Data:
    rate = machines[0].rate
    return Data.of(
        [binned(power_density(machine.acceleration[row], rate), rate) for machine in machines],
        [binned(power_density(source.acceleration[COLUMNS[axis]], rate), rate) for source in sources],
        LOWEST,
        step_rate,
    )


class Unsure(NamedTuple):
    """Variances of the log level in a band beyond that of the fit."""

    changes: float
    """By what changes from second to second in recording and source."""
    individuals: float
    """By another individual of the bearing than the source's."""


def _unsure(machine: Measured, individuals: Sequence[Source], row: int, axis: str) -> dict[float, Unsure]:
    """Return the variances in each third octave by its middle [Hz]; at 0 Hz, those of all of them.

    The source is one individual and the machine's bearing is another, so that the variance between individuals counts twice. It is that of
    mean logarithms of the density, which the fit compares, and it is known from a few only, which Student's t accounts for.
    """
    rate, found = machine.rate, {}
    signals = machine.acceleration[row], individuals[0].acceleration[COLUMNS[axis]]
    spectra = [binned(power_density(one.acceleration[COLUMNS[axis]], rate), rate) for one in individuals]
    bands = {float(middle): (middle / EDGE, middle * EDGE) for middle in middles(rate) if middle > LOWEST / EDGE}
    for middle, (low, high) in (bands | {0.0: (LOWEST, HIGHEST_SHARE * rate)}).items():
        levels = [one.level[(one.frequency >= low) & (one.frequency < high)] for one in spectra]
        between = float(np.var([level.mean() for level in levels], ddof=1)) if len(spectra) > 1 and len(levels[0]) else 0.0
        found[middle] = Unsure(sum(fluctuation(signal, rate, low, high) for signal in signals), 2.0 * FEW**2 * between)
    return found


def _add_noise(found: IdentifiedPath) -> None:
    """Combine the white noise of the axes, which the bench has in common; fit the other axis anew with it."""
    heard = {axis: int(np.count_nonzero(1.0 - fit.share().max(axis=0) > HEARD)) >= FEWEST_BINS for axis, fit in found.fits.items()}
    known = [fit for axis, fit in found.fits.items() if heard[axis]]
    if not known:
        lowest = min(fit.white for fit in found.fits.values())
        highest = math.exp(0.5 * min(fit.data.lowest for fit in found.fits.values()))
        found.white = lowest
        found.parameters["sensor.noise_density"] = lowest
        found.estimates.append(Estimate("sensor.noise_density", lowest, 0.0, max(lowest, highest), "m/s^2/sqrt(Hz)"))
        found.remarks.append(
            "the noise of the sensor is covered by the bearing in the whole band: only its upper bound is known, "
            f"{highest:.3g} m/s^2/sqrt(Hz)"
        )
        return
    variances = np.array([0.25 * float(fit.covariance[0, 0]) for fit in known])
    logarithms = np.log([fit.white for fit in known])
    white = float(np.exp(np.sum(logarithms / variances) / np.sum(1.0 / variances)))
    deviation = math.hypot(math.sqrt(1.0 / np.sum(1.0 / variances)), 0.5 * float(np.ptp(logarithms)))
    if float(np.ptp(logarithms)) > 0.2:
        found.remarks.append(
            f"the noise differs between the axes, {known[0].white:.3g} and {known[-1].white:.3g} m/s^2/sqrt(Hz): the bench has one, "
            "their mean"
        )
    found.white = white
    found.parameters |= {"sensor.noise_density": white, "sensor.white_noise_ug": 0.0}
    found.estimates.append(by_factor("sensor.noise_density", white, deviation, "m/s^2/sqrt(Hz)"))
    for axis, fit in found.fits.items():
        if not heard[axis]:
            found.fits[axis] = fit_path(fit.data, white=white)


def _add_axis(found: IdentifiedPath, axis: str, source: Spectrum, unsure: Sequence[dict[float, Unsure]]) -> None:
    """Add gain, sections and levels in third octaves of an axis; ``source`` is the spectrum of the first source."""
    fit = found.fits[axis]
    whole, variance = _level(fit, source, LOWEST, float(fit.data.frequency[-1]))
    variance += unsure[0][0.0].changes
    if len(fit.gains) > 1:  # gains that differ between recordings are less certain by as much
        variance += 4.0 * float(np.var(np.log(fit.gains), ddof=1))
    deviation, wider = 0.5 * math.sqrt(variance), 0.5 * math.sqrt(variance + unsure[0][0.0].individuals)
    gain = float(fit.gains[0])
    found.parameters |= {f"structure.gain_{axis}": gain, f"structure.path_{axis}": text_of(fit.pairs)}
    found.estimates.append(by_factor(f"structure.gain_{axis}", gain, deviation, "-"))
    found.gains[axis] = by_factor(f"gain_{axis}", math.exp(0.5 * whole), wider, "-")
    levels = list(_levels(fit, axis, source, unsure[0]))
    found.levels += levels
    found.residuals.append((axis, fit.data.frequency, fit.residual()[0]))
    silent = [one.frequency for one in levels if not one.identified]
    if silent:
        found.remarks.append(
            f"the path in {axis.upper()} is not identified in the third octaves at {_bands(silent)} Hz: noise covers the bearing there"
        )


def _bands(frequencies: Sequence[float]) -> str:
    shown = [f"{frequency:.4g}" for frequency in frequencies]
    return ", ".join(shown) if len(shown) < 5 else f"{shown[0]} .. {shown[-1]}"


def _level(fit: PathFit, source: Spectrum, low: float, high: float) -> tuple[float, float]:
    """Return the logarithm of the power gain over a band [Hz], weighted by the source, and its variance by chance."""
    inside = (source.frequency >= low) & (source.frequency < high)
    frequency, before = source.frequency[inside], source.density[inside]
    power = 2.0 * math.log(float(fit.gains[0])) + fit.log_path(frequency)
    behind = before * np.exp(power - power.max())
    by = (behind / behind.sum()) @ fit.level_gradient(frequency)
    return math.log(float(behind.sum() / before.sum())) + float(power.max()), float(by @ fit.covariance @ by)


def _levels(fit: PathFit, axis: str, source: Spectrum, unsure: dict[float, Unsure]) -> Iterator[PathLevel]:
    """Yield the gain of the path in third octaves with its intervals."""
    share = fit.share().max(axis=0)
    for middle in (band for band in unsure if band):
        inside = (fit.data.frequency >= middle / EDGE) & (fit.data.frequency < middle * EDGE)
        if np.count_nonzero(inside) < 3:
            continue
        level, variance = _level(fit, source, middle / EDGE, min(middle * EDGE, float(fit.data.frequency[-1])))
        chance = variance + unsure[middle].changes
        decibels, half = 0.5 * NEPER * level, 0.5 * NEPER * QUANTILE * math.sqrt(chance + unsure[middle].individuals)
        deviation = 0.5 * NEPER * math.sqrt(chance)
        yield PathLevel(axis, middle, decibels, decibels - half, decibels + half, float(share[inside].mean()), deviation)
