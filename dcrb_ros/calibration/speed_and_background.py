"""What a recording shows beside the noise of the bearing: speed, hum, unbalance, modulation and background."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dcrb_ros.calibration.estimate import QUANTILE, EstimatedParameter, by_difference, by_factor
from dcrb_ros.calibration.healthy_recording import HealthyRecording
from dcrb_ros.calibration.identified_path import COLUMNS, LOWEST, IdentifiedPath, Part
from dcrb_ros.calibration.lines import mains_hum, order_line, shaft_modulation, speed_fluctuation, without_lines
from dcrb_ros.calibration.simulated_bearing import RingAcceleration
from dcrb_ros.calibration.spectra import Binned, Spectrum, binned, power_density, third_octaves
from dcrb_ros.measurement.parameters import MICRO_G
from dcrb_ros.measurement.stages.background import REFERENCE_SPEED
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.configuration import Configuration

MOST_FLUCTUATION = 0.02
"""Largest fluctuation of the speed that the bench has [-]."""
SLOWEST_RIPPLE = 6.0
"""Frequency of the shaft above which its ripple is distinct from the random fluctuation up to 5 Hz [Hz]."""
TONE = 4.0
"""Level of a third octave over the model from which its lines hold most of the power [dB]."""
STATED = 1e-6
"""Fluctuation below which an angle follows from a stated speed [-]: single precision leaves 1e-9 of it, a machine 1e-5 at least."""
PINK_SLOPE = (-1.5, -0.6)
"""Slopes of the logarithms of power and frequency that count as 1/f noise [-]."""
PINK_SCATTER = 0.5
"""Largest scatter of the logarithm about that slope [-], 2 dB."""
LOWEST_ENVELOPE = 400.0
"""Lower end of the band whose envelope shows the modulation [Hz]: lines of the shaft, the mains and single rollers lie below."""
SMOOTHED = 9
"""Bins of the spectrum over which the share of the bearing is averaged [-]."""
LONGEST_ANGLE = 20.0
"""Time of the angle from which the fluctuation of the speed is estimated [s]."""


def speed_of(machines: Sequence[HealthyRecording]) -> Part:
    """Return the speed and its fluctuation, random and with the shaft."""
    part = Part()
    speeds = [machine.speed for machine in machines]
    part.estimates.append(EstimatedParameter("operating.speed", speeds[0], min(speeds), max(speeds), "rad/s"))
    tracked = [machine for machine in machines if machine.tracked]
    seen = speed_fluctuation(tracked[0].turns[: round(LONGEST_ANGLE * tracked[0].rate)], tracked[0].rate) if tracked else None
    if seen is None or seen.random < STATED:
        part.parameters |= {"operating.speed_fluctuation": 0.0, "operating.speed_ripple": 0.0}
        part.remarks.append("the fluctuation of the speed is unknown: the speed is stated, and an angle of the shaft was not measured")
        return part
    machine = tracked[0]
    values = [("speed_fluctuation", seen.random, seen.random_error)]
    if abs(machine.speed) > 2.0 * math.pi * SLOWEST_RIPPLE:
        values.append(("speed_ripple", seen.ripple, seen.ripple_error))
    else:
        part.remarks.append(f"the ripple of the speed is unknown: below {60.0 * SLOWEST_RIPPLE:g} rpm it is hidden by the slow fluctuation")
    for name, value, error in values:
        held = min(value, MOST_FLUCTUATION)
        low, high = max(0.0, min(held, value - QUANTILE * error)), min(MOST_FLUCTUATION, max(held, value + QUANTILE * error))
        part.identify(EstimatedParameter(f"operating.{name}", held, low, high, "-"))
        if value > MOST_FLUCTUATION:
            part.remarks.append(f"operating.{name} would be {value:.3g}, and the bench has at most {MOST_FLUCTUATION:g}")
    return part


def hum_of(machine: HealthyRecording) -> Part:
    """Return frequency and level of the mains hum, the mean of the axes."""
    part = Part()
    seen = [mains_hum(signal, machine.rate, abs(machine.speed) / (2.0 * math.pi)) for signal in machine.acceleration]
    lines = [hum for hum, _ in seen if hum is not None]
    if not lines:
        part.remarks.append(f"no mains hum: {seen[0][1]}")
        return part
    levels = [hum.level for hum in lines]
    level = float(np.mean(levels))
    deviation = math.hypot(max(hum.error for hum in lines), 0.5 * float(np.ptp(levels)))
    part.parameters["background.hum_frequency"] = round(lines[0].frequency, 3)
    part.identify(by_difference("background.hum_level", level, deviation, "m/s^2"))
    return part


def unbalance_of(machine: HealthyRecording, source: RingAcceleration, path: IdentifiedPath) -> Part:
    """Return the unbalance from the line of the shaft; that of the source has an unknown phase to it."""
    part = Part()
    squares, errors, benches = [], [], []
    for row, axis in enumerate(machine.axes):
        gain = path.gain(axis)
        line, error = order_line(machine.acceleration[row], machine.turns, 1.0)
        sourced, _ = order_line(source.acceleration[COLUMNS[axis]], source.turns, 1.0)
        squares.append((abs(line) / gain) ** 2)
        errors.append(error / gain)
        benches.append(abs(sourced) ** 2)
    scale = machine.speed**2
    total, noise, bench = (math.sqrt(float(np.mean(values))) for values in (squares, np.square(errors), benches))
    if total < 3.0 * noise:
        part.remarks.append("no unbalance: the line of the shaft does not stand out of the noise")
        part.estimates.append(EstimatedParameter("background.unbalance", 0.0, 0.0, min(0.01, (total + QUANTILE * noise) / scale), "m"))
        return part
    value = math.sqrt(max(0.0, total**2 - bench**2 - noise**2)) / scale
    low, high = max(0.0, total - bench - QUANTILE * noise) / scale, (total + bench + QUANTILE * noise) / scale
    held = min(value, 0.01)
    if value > 0.01:
        part.remarks.append(
            f"the unbalance would be {value:.3g} m, and the bench has at most 0.01 m: the gain at low frequencies is unlike the rest"
        )
    part.identify(EstimatedParameter("background.unbalance", held, min(low, held), min(0.01, max(high, held)), "m"))
    return part


def modulation_of(machine: HealthyRecording, source: RingAcceleration, path: IdentifiedPath) -> Part:
    """Return the modulation by the shaft from the squared envelope of the band in which the bearing rises above the noise.

    The line at order 1 is 2 m / (1 + m^2/2) of the mean; noise in the band lowers it by its share of the power.
    """
    part = Part()
    depths, errors, benches = [], [], []
    for row, axis in enumerate(machine.axes):
        fit = path.fits[axis]
        above = fit.data.frequency >= LOWEST_ENVELOPE
        band = _heard_band(fit.data.frequency[above], fit.share()[0][above])
        if band is None:
            continue
        inside = (fit.data.frequency >= band[0]) & (fit.data.frequency <= band[1])
        power = np.exp(fit.data.measured[0][inside]) * np.gradient(fit.data.frequency)[inside]
        share = float(np.sum(power * fit.share()[0][inside]) / np.sum(power))
        depth, error = shaft_modulation(machine.acceleration[row], machine.turns, machine.rate, *band)
        simulated, _ = shaft_modulation(source.acceleration[COLUMNS[axis]], source.turns, machine.rate, *band)
        depths.append(depth / share)
        errors.append(error / share)
        benches.append(simulated)
    if not depths:
        part.remarks.append("the modulation by the shaft is unknown: the bearing stands out of the noise in no octave")
        return part
    depth, error, simulated = float(np.mean(depths)), max(errors), float(np.mean(benches))
    value = _modulation(math.sqrt(max(0.0, depth**2 - simulated**2)))
    low, high = _modulation(depth - simulated - QUANTILE * error), _modulation(depth + simulated + QUANTILE * error)
    part.identify(EstimatedParameter("structure.modulation", value, min(low, value), max(high, value), "-"))
    return part


def _modulation(depth: float) -> float:
    """Return m of 2 m / (1 + m^2/2) = depth, within 0 .. 1."""
    depth = min(max(depth, 0.0), math.sqrt(2.0))
    return min(1.0, (2.0 - math.sqrt(max(0.0, 4.0 - 2.0 * depth**2))) / depth) if depth > 1e-9 else 0.0


def _heard_band(frequency: Floats, share: Floats) -> tuple[float, float] | None:
    """Return the widest band in which the bearing has most of the power, at least an octave [Hz]; none if there is none."""
    if len(share) < SMOOTHED:  # np.convolve would return more values than the spectrum has
        return None
    heard = np.concatenate([[False], np.convolve(share, np.ones(SMOOTHED) / SMOOTHED, "same") > 0.5, [False]])
    edges = np.flatnonzero(np.diff(heard.astype(int))).reshape(-1, 2)
    bands = [(float(frequency[begin]), float(frequency[end - 1])) for begin, end in edges]
    widest = max(bands, key=lambda band: band[1] / band[0], default=(1.0, 1.0))
    return widest if widest[1] >= 2.0 * widest[0] else None


def tones_of(machine: HealthyRecording, path: IdentifiedPath) -> Part:
    """Return a remark on the third octaves whose power is in lines, for which the bench has no source."""
    part = Part()
    for row, axis in enumerate(machine.axes):
        spectrum, fit = power_density(machine.acceleration[row], machine.rate), path.fits[axis]
        middle, level = third_octaves(spectrum, machine.rate)
        density = np.exp(np.interp(np.log(spectrum.frequency[1:]), np.log(fit.data.frequency), fit.modelled()[0]))
        modelled = third_octaves(Spectrum(spectrum.frequency, np.concatenate([density[:1], density]), 1.0), machine.rate)[1]
        high = [frequency for frequency, over in zip(middle, level - modelled, strict=True) if over > TONE and frequency > LOWEST]
        if high:
            bands = ", ".join(f"{frequency:.0f}" for frequency in high)
            part.remarks.append(
                f"lines that the bench does not have hold most of the power in {axis.upper()} in the third octaves at {bands} Hz"
            )
    return part


def background_of(machine: HealthyRecording, path: IdentifiedPath, bench: Configuration, hum_frequency: float) -> Part:
    """Return what is below the band of the path beyond source and white noise: 1/f noise, or a background of the machine.

    ``hum_frequency`` is that of the mains hum [Hz], 0 for none.
    """
    part = Part()
    quiet = {
        axis: without_lines(signal, machine.turns, machine.rate, hum_frequency)
        for axis, signal in zip(machine.axes, machine.acceleration, strict=True)
    }
    spectra = [_excess(binned(power_density(signal, machine.rate), machine.rate), axis, path) for axis, signal in quiet.items()]
    excesses = [excess for excess in spectra if np.count_nonzero(excess.heard) >= 0.3 * len(excess.heard)]
    if not excesses:
        part.remarks.append(f"no background below {LOWEST:g} Hz stands out of the noise")
    elif (pink := _pink_noise(excesses)) is not None:
        part.identify(pink)
    else:
        part.remarks.append(
            f"noise below {LOWEST:g} Hz does not fall with 1/f: it is taken for a background of the machine, not for noise of the sensor"
        )
        _add_background(part, excesses, path, abs(machine.speed) * 0.5 * bench.operating.wheel_diameter)
    return part


class Excess(NamedTuple):
    """Power density of an axis below the band of the path, beyond that of bearing and white noise; arrays of shape (bins,)."""

    axis: str
    frequency: Floats
    """[Hz]"""
    density: Floats
    """[(m/s^2)^2/Hz]"""
    heard: npt.NDArray[np.bool_]
    """Bins in which it has more than half of the power."""

    @property
    def power(self) -> Floats:
        """Power in each bin, shape (bins,) [(m/s^2)^2]."""
        return np.asarray(np.maximum(self.density, 0.0) * np.gradient(self.frequency), np.float64)


def _excess(spectrum: Binned, axis: str, path: IdentifiedPath) -> Excess:
    """Return the power density of an axis without those of the bearing behind the path and of the white noise."""
    low, fit = spectrum.frequency < LOWEST, path.fits[axis]
    frequency, power = spectrum.frequency[low], np.exp(spectrum.level[low])
    bearing = np.interp(np.log(frequency), np.log(fit.data.frequency), fit.data.source[0] + fit.log_path())
    # Lines of bearing and bench need not lie in the same bins.
    bearing = np.log(np.convolve(np.exp(np.pad(bearing, 4, "edge")), np.ones(9) / 9.0, "valid"))
    density = power - path.white**2 - fit.gains[0] ** 2 * np.exp(bearing)
    return Excess(axis, frequency, density, density > 0.5 * power)


def _pink_noise(excesses: Sequence[Excess]) -> EstimatedParameter | None:
    """Return the density of 1/f noise at 1 Hz, the mean of the axes; none if the density of an axis does not fall like it."""
    levels, deviations = [], []
    for _, frequency, density, heard in excesses:
        logarithms, count = (np.log(frequency[heard]), np.log(density[heard])), int(np.count_nonzero(heard))
        coefficients, residuals, *_ = np.polyfit(*logarithms, 1, full=True)
        scatter = math.sqrt(float(residuals[0]) / count) if len(residuals) else 0.0
        if not PINK_SLOPE[0] <= coefficients[0] <= PINK_SLOPE[1] or scatter > PINK_SCATTER:
            return None
        levels.append(float(np.mean(np.log(density[heard] * frequency[heard]))))
        deviations.append(scatter / math.sqrt(count))
    value = math.exp(0.5 * float(np.mean(levels))) / MICRO_G
    return by_factor("sensor.pink_noise_ug", value, 0.5 * max(deviations), "ug/sqrt(Hz)")


def _add_background(part: Part, excesses: Sequence[Excess], path: IdentifiedPath, vehicle_speed: float) -> None:
    """Add level and band of a background of the machine at a speed of the vehicle [m/s]: 5 to 95 % of its power are in the band."""
    levels = [math.sqrt(float(np.sum(excess.power))) / path.gain(excess.axis) for excess in excesses]
    share = np.cumsum(excesses[0].power)
    low, high = (float(np.interp(part * share[-1], share, excesses[0].frequency)) for part in (0.05, 0.95))
    level = min(1e3, float(np.mean(levels)) / (vehicle_speed / REFERENCE_SPEED))
    spread = max(0.1, float(np.ptp(levels)) / (2.0 * float(np.mean(levels))))
    part.parameters |= {"background.track_low": max(1.0, low), "background.track_high": max(high, 1.3 * max(1.0, low))}
    part.identify(EstimatedParameter("background.track_level", level, level * (1.0 - spread), min(1e3, level * (1.0 + spread)), "m/s^2"))
