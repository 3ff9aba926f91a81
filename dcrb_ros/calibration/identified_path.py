"""The path from ring to sensor, its gain, and the white noise: what the spectra of all recordings together identify."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from dcrb_ros.calibration.estimate import QUANTILE, EstimatedParameter, PathLevel, by_factor
from dcrb_ros.calibration.healthy_recording import HealthyRecording
from dcrb_ros.calibration.path_fit import NEPER, PathFit, PathSpectra, fit_path
from dcrb_ros.calibration.simulated_bearing import RingAcceleration
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

    estimates: list[EstimatedParameter] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    """What could not be identified, and why."""
    parameters: dict[str, Any] = field(default_factory=dict)
    """Parameters of the configuration."""

    def identify(self, estimate: EstimatedParameter) -> None:
        """Add an estimate and give its value to the configuration."""
        self.estimates.append(estimate)
        self.parameters[estimate.key] = estimate.value


@dataclass
class IdentifiedPath(Part):
    """The path of each axis."""

    fits: dict[str, PathFit] = field(default_factory=dict)
    levels: list[PathLevel] = field(default_factory=list)
    residuals: list[tuple[str, Floats, Floats]] = field(default_factory=list)
    gains: dict[str, EstimatedParameter] = field(default_factory=dict)
    """Gain of each axis over the band of the source, which is what can be identified of a gain."""
    white: float = 0.0
    """Density of the white noise [m/s^2/sqrt(Hz)]."""

    def gain(self, axis: str) -> float:
        """Return the gain at rest of the first recording [-]."""
        return float(self.parameters[f"structure.gain_{axis}"])

    def divide_gains(self, factor: float) -> None:
        """Divide all gains and levels by a factor [-]: modulation by the shaft adds power, which is not the path's."""
        shift = 20.0 * math.log10(factor)
        self.levels = [replace(level, level=level.level - shift, low=level.low - shift, high=level.high - shift) for level in self.levels]
        self.gains = {axis: gain.divided(factor) for axis, gain in self.gains.items()}
        for k, estimate in enumerate(self.estimates):
            if estimate.key.startswith("structure.gain_"):
                self.estimates[k] = estimate.divided(factor)
                self.parameters[estimate.key] = estimate.value / factor


def identified_path(
    machines: Sequence[HealthyRecording], individuals: Sequence[Sequence[RingAcceleration]], step_rate: float
) -> IdentifiedPath:
    """Return the path of each axis and the noise of both; of the individuals of the bearing for each recording, the first is the source."""
    path, sources, rate = IdentifiedPath(), [bearings[0] for bearings in individuals], machines[0].rate
    for row, axis in enumerate(machines[0].axes):
        measured = [binned(power_density(machine.acceleration[row], rate), rate) for machine in machines]
        simulated = [binned(power_density(source.acceleration[COLUMNS[axis]], rate), rate) for source in sources]
        path.fits[axis] = fit_path(PathSpectra.of(measured, simulated, LOWEST, step_rate))
    _add_noise(path)
    for row, axis in enumerate(machines[0].axes):
        spectrum = power_density(sources[0].acceleration[COLUMNS[axis]], rate)
        _add_axis(path, axis, spectrum, [_unsure(m, i, row, axis) for m, i in zip(machines, individuals, strict=True)])
    if machines[0].axes == ("y",):
        path.parameters["structure.path_x"] = path.parameters["structure.path_y"]
        path.identify(replace(path.estimates[-1], key="structure.gain_x"))
        path.remarks.append("the recording has one axis: it is taken as Y, the direction of the load, and X has the same path")
    if machines[0].unit == "relative":
        path.remarks.append("the unit of the recording is relative: the gain contains it, and levels mean nothing by themselves")
    return path


class Unsure(NamedTuple):
    """Variances of the log level in a band beyond that of the fit."""

    changes: float
    """By what changes from second to second in recording and source."""
    individuals: float
    """By another individual of the bearing than the source's."""


def _unsure(machine: HealthyRecording, individuals: Sequence[RingAcceleration], row: int, axis: str) -> dict[float, Unsure]:
    """Return the variances in each third octave by its middle [Hz]; at 0 Hz, those of all of them.

    The source is one individual and the machine's bearing is another, so that the variance between individuals counts twice. It is that of
    mean logarithms of the density, which the fit compares, and it is known from a few only, which Student's t accounts for.
    """
    rate, variances = machine.rate, {}
    signals = machine.acceleration[row], individuals[0].acceleration[COLUMNS[axis]]
    spectra = [binned(power_density(individual.acceleration[COLUMNS[axis]], rate), rate) for individual in individuals]
    bands = {float(middle): (middle / EDGE, middle * EDGE) for middle in middles(rate) if middle > LOWEST / EDGE}
    for middle, (low, high) in (bands | {0.0: (LOWEST, HIGHEST_SHARE * rate)}).items():
        levels = [spectrum.level[(spectrum.frequency >= low) & (spectrum.frequency < high)] for spectrum in spectra]
        between = float(np.var([level.mean() for level in levels], ddof=1)) if len(spectra) > 1 and len(levels[0]) else 0.0
        variances[middle] = Unsure(sum(fluctuation(signal, rate, low, high) for signal in signals), 2.0 * FEW**2 * between)
    return variances


def _add_noise(path: IdentifiedPath) -> None:
    """Combine the white noise of the axes, which the bench has in common; fit the other axis anew with it."""
    heard = {axis: int(np.count_nonzero(1.0 - fit.share().max(axis=0) > HEARD)) >= FEWEST_BINS for axis, fit in path.fits.items()}
    known = [fit for axis, fit in path.fits.items() if heard[axis]]
    if not known:
        lowest = min(fit.white for fit in path.fits.values())
        highest = math.exp(0.5 * min(fit.data.lowest for fit in path.fits.values()))
        path.white = lowest
        path.identify(EstimatedParameter("sensor.noise_density", lowest, 0.0, max(lowest, highest), "m/s^2/sqrt(Hz)"))
        path.remarks.append(
            "the noise of the sensor is covered by the bearing in the whole band: only its upper bound is known, "
            f"{highest:.3g} m/s^2/sqrt(Hz)"
        )
        return
    variances = np.array([0.25 * float(fit.covariance[0, 0]) for fit in known])
    logarithms = np.log([fit.white for fit in known])
    white = float(np.exp(np.sum(logarithms / variances) / np.sum(1.0 / variances)))
    deviation = math.hypot(math.sqrt(1.0 / np.sum(1.0 / variances)), 0.5 * float(np.ptp(logarithms)))
    if float(np.ptp(logarithms)) > 0.2:
        path.remarks.append(
            f"the noise differs between the axes, {known[0].white:.3g} and {known[-1].white:.3g} m/s^2/sqrt(Hz): the bench has one, "
            "their mean"
        )
    path.white = white
    path.parameters["sensor.white_noise_ug"] = 0.0
    path.identify(by_factor("sensor.noise_density", white, deviation, "m/s^2/sqrt(Hz)"))
    for axis, fit in path.fits.items():
        if not heard[axis]:
            path.fits[axis] = fit_path(fit.data, white=white)


def _add_axis(path: IdentifiedPath, axis: str, source: Spectrum, unsure: Sequence[dict[float, Unsure]]) -> None:
    """Add gain, sections and levels in third octaves of an axis; ``source`` is the spectrum of the first source."""
    fit = path.fits[axis]
    whole, variance = _level(fit, source, LOWEST, float(fit.data.frequency[-1]))
    variance += unsure[0][0.0].changes
    if len(fit.gains) > 1:  # gains that differ between recordings are less certain by as much
        variance += 4.0 * float(np.var(np.log(fit.gains), ddof=1))
    deviation, wider = 0.5 * math.sqrt(variance), 0.5 * math.sqrt(variance + unsure[0][0.0].individuals)
    path.parameters[f"structure.path_{axis}"] = text_of(fit.pairs)
    path.identify(by_factor(f"structure.gain_{axis}", float(fit.gains[0]), deviation, "-"))
    path.gains[axis] = by_factor(f"gain_{axis}", math.exp(0.5 * whole), wider, "-")
    levels = list(_levels(fit, axis, source, unsure[0]))
    path.levels += levels
    path.residuals.append((axis, fit.data.frequency, fit.residual()[0]))
    silent = [level.frequency for level in levels if not level.identified]
    if silent:
        path.remarks.append(
            f"the path in {axis.upper()} is not identified in the third octaves at {_bands(silent)} Hz: noise covers the bearing there"
        )


def _bands(frequencies: Sequence[float]) -> str:
    shown = [f"{frequency:.0f}" for frequency in frequencies]
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
