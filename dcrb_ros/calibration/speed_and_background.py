"""What a recording shows beside the noise of the bearing: speed, hum, unbalance, modulation and background."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from dcrb_ros.calibration.estimate import QUANTILE, Estimate, by_difference
from dcrb_ros.calibration.identified_path import COLUMNS, LOWEST, IdentifiedPath, Part
from dcrb_ros.calibration.lines import mains_hum, order_line, shaft_modulation, speed_fluctuation, without_lines
from dcrb_ros.calibration.measured import Measured
from dcrb_ros.calibration.source import Source
from dcrb_ros.calibration.spectra import Spectrum, binned, power_density, third_octaves
from dcrb_ros.measurement.parameters import MICRO_G
from dcrb_ros.measurement.stages.background import REFERENCE_SPEED
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.configuration import Configuration

MOST_FLUCTUATION = 0.02
"""Largest fluctuation of the speed that the bench has [-]."""
SLOWEST_RIPPLE = 6.0
"""Frequency of the shaft above which its ripple can be told from the random fluctuation up to 5 Hz [Hz]."""
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
LONGEST_ANGLE = 20.0
"""Time of the angle from which the fluctuation of the speed is estimated [s]."""


def speed_of(machines: Sequence[Measured]) -> Part:
    """Return the speed and its fluctuation, random and with the shaft."""
    found = Part()
    speeds = [machine.speed for machine in machines]
    found.estimates.append(Estimate("operating.speed", speeds[0], min(speeds), max(speeds), "rad/s"))
    tracked = [machine for machine in machines if machine.tracked]
    seen = speed_fluctuation(tracked[0].turns[: round(LONGEST_ANGLE * tracked[0].rate)], tracked[0].rate) if tracked else None
    if seen is None or seen.random < STATED:
        found.parameters |= {"operating.speed_fluctuation": 0.0, "operating.speed_ripple": 0.0}
        found.remarks.append("the fluctuation of the speed is unknown: the speed is stated, and an angle of the shaft was not measured")
        return found
    machine = tracked[0]
    values = [("speed_fluctuation", seen.random, seen.random_error)]
    if abs(machine.speed) > 2.0 * math.pi * SLOWEST_RIPPLE:
        values.append(("speed_ripple", seen.ripple, seen.ripple_error))
    else:
        found.remarks.append(
            f"the ripple of the speed is unknown: below {60.0 * SLOWEST_RIPPLE:g} rpm it is hidden by the slow fluctuation"
        )
    for name, value, error in values:
        held = min(value, MOST_FLUCTUATION)
        found.parameters[f"operating.{name}"] = held
        high = min(MOST_FLUCTUATION, max(held, value + QUANTILE * error))
        found.estimates.append(Estimate(f"operating.{name}", held, max(0.0, min(held, value - QUANTILE * error)), high, "-"))
        if value > MOST_FLUCTUATION:
            found.remarks.append(f"operating.{name} would be {value:.3g}, and the bench has at most {MOST_FLUCTUATION:g}")
    return found


def hum_of(machines: Sequence[Measured]) -> Part:
    """Return frequency and level of the mains hum, the mean of the axes."""
    found, machine = Part(), machines[0]
    seen = [mains_hum(signal, machine.rate, abs(machine.speed) / (2.0 * math.pi)) for signal in machine.acceleration]
    lines = [hum for hum, _ in seen if hum is not None]
    if not lines:
        found.remarks.append(f"no mains hum: {seen[0][1]}")
        return found
    levels = [hum.level for hum in lines]
    level = float(np.mean(levels))
    deviation = math.hypot(max(hum.error for hum in lines), 0.5 * float(np.ptp(levels)))
    found.parameters |= {"background.hum_level": level, "background.hum_frequency": round(lines[0].frequency, 3)}
    found.estimates.append(by_difference("background.hum_level", level, deviation, "m/s^2"))
    return found


def unbalance_of(machines: Sequence[Measured], sources: Sequence[Source], path: IdentifiedPath) -> Part:
    """Return the unbalance from the line of the shaft; that of the source has an unknown phase to it."""
    found, machine, source = Part(), machines[0], sources[0]
    squares, errors, own = [], [], []
    for row, axis in enumerate(machine.axes):
        gain = path.gain(axis)
        line, error = order_line(machine.acceleration[row], machine.turns, 1.0)
        sourced, _ = order_line(source.acceleration[COLUMNS[axis]], source.turns, 1.0)
        squares.append((abs(line) / gain) ** 2)
        errors.append(error / gain)
        own.append(abs(sourced) ** 2)
    scale = machine.speed**2
    total, noise, bench = (math.sqrt(float(np.mean(values))) for values in (squares, np.square(errors), own))
    if total < 3.0 * noise:
        found.remarks.append("no unbalance: the line of the shaft does not stand out of the noise")
        found.estimates.append(Estimate("background.unbalance", 0.0, 0.0, min(0.01, (total + QUANTILE * noise) / scale), "m"))
        return found
    value = math.sqrt(max(0.0, total**2 - bench**2 - noise**2)) / scale
    low, high = max(0.0, total - bench - QUANTILE * noise) / scale, (total + bench + QUANTILE * noise) / scale
    held = min(value, 0.01)
    if value > 0.01:
        found.remarks.append(
            f"the unbalance would be {value:.3g} m, and the bench has at most 0.01 m: the gain at low frequencies is unlike the rest"
        )
    found.parameters["background.unbalance"] = held
    found.estimates.append(Estimate("background.unbalance", held, min(low, held), min(0.01, max(high, held)), "m"))
    return found


def modulation_of(machines: Sequence[Measured], sources: Sequence[Source], path: IdentifiedPath) -> Part:
    """Return the modulation by the shaft from the squared envelope of the band in which the bearing is heard.

    The line at order 1 is 2 m / (1 + m^2/2) of the mean; noise in the band lowers it by its share of the power.
    """
    found, machine, source = Part(), machines[0], sources[0]
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
        line = shaft_modulation(machine.acceleration[row], machine.turns, machine.rate, *band)
        bench = shaft_modulation(source.acceleration[COLUMNS[axis]], source.turns, machine.rate, *band)
        depths.append(line.depth / share)
        errors.append(line.error / share)
        benches.append(bench.depth)
    if not depths:
        found.remarks.append("the modulation by the shaft is unknown: the bearing stands out of the noise in no octave")
        return found
    depth, error, own = float(np.mean(depths)), max(errors), float(np.mean(benches))
    value = _modulation(math.sqrt(max(0.0, depth**2 - own**2)))
    low, high = _modulation(depth - own - QUANTILE * error), _modulation(depth + own + QUANTILE * error)
    found.parameters["structure.modulation"] = value
    found.estimates.append(Estimate("structure.modulation", value, min(low, value), max(high, value), "-"))
    return found


def _modulation(depth: float) -> float:
    """Return m of 2 m / (1 + m^2/2) = depth, within 0 .. 1."""
    depth = min(max(depth, 0.0), math.sqrt(2.0))
    return min(1.0, (2.0 - math.sqrt(max(0.0, 4.0 - 2.0 * depth**2))) / depth) if depth > 1e-9 else 0.0


def _heard_band(frequency: Floats, share: Floats) -> tuple[float, float] | None:
    """Return the widest band in which the bearing has most of the power, at least an octave [Hz]; none if there is none."""
    heard = np.concatenate([[False], np.convolve(share, np.ones(9) / 9.0, "same") > 0.5, [False]])
    edges = np.flatnonzero(np.diff(heard.astype(int))).reshape(-1, 2)
    bands = [(float(frequency[begin]), float(frequency[end - 1])) for begin, end in edges]
    widest = max(bands, key=lambda band: band[1] / band[0], default=(1.0, 1.0))
    return widest if widest[1] >= 2.0 * widest[0] else None


def tones_of(machines: Sequence[Measured], path: IdentifiedPath) -> Part:
    """Return a remark on the third octaves whose power is in lines, for which the bench has no source."""
    found, machine = Part(), machines[0]
    for row, axis in enumerate(machine.axes):
        spectrum, fit = power_density(machine.acceleration[row], machine.rate), path.fits[axis]
        middle, level = third_octaves(spectrum, machine.rate)
        density = np.exp(np.interp(np.log(spectrum.frequency[1:]), np.log(fit.data.frequency), fit.modelled()[0]))
        modelled = third_octaves(Spectrum(spectrum.frequency, np.concatenate([density[:1], density]), 1.0), machine.rate)[1]
        high = [frequency for frequency, over in zip(middle, level - modelled, strict=True) if over > TONE and frequency > LOWEST]
        if high:
            bands = ", ".join(f"{frequency:.4g}" for frequency in high)
            found.remarks.append(
                f"lines that the bench does not have hold most of the power in {axis.upper()} in the third octaves at {bands} Hz"
            )
    return found


def background_of(machines: Sequence[Measured], path: IdentifiedPath, bench: Configuration, hum_frequency: float) -> Part:
    """Return what is below the band of the path beyond source and white noise: 1/f noise, or a background of the machine."""
    found, machine = Part(), machines[0]
    excesses, slopes = [], []
    for row, axis in enumerate(machine.axes):
        quiet = without_lines(machine.acceleration[row], machine.turns, machine.rate, hum_frequency)
        spectrum = binned(power_density(quiet, machine.rate), machine.rate)
        low = spectrum.frequency < LOWEST
        frequency, power = spectrum.frequency[low], np.exp(spectrum.level[low])
        fit = path.fits[axis]
        bearing = np.interp(np.log(frequency), np.log(fit.data.frequency), fit.data.source[0] + fit.log_path())
        # Lines of bearing and bench need not lie in the same bins.
        bearing = np.log(np.convolve(np.exp(np.pad(bearing, 4, "edge")), np.ones(9) / 9.0, "valid"))
        excess = power - path.white**2 - fit.gains[0] ** 2 * np.exp(bearing)
        heard = excess > 0.5 * power
        if np.count_nonzero(heard) < 0.3 * len(heard):
            continue
        excesses.append((axis, frequency, np.maximum(excess, 0.0)))
        coefficients, residuals, *_ = np.polyfit(np.log(frequency[heard]), np.log(excess[heard]), 1, full=True)
        count = int(np.count_nonzero(heard))
        scatter = math.sqrt(float(residuals[0]) / count) if len(residuals) else 0.0
        slopes.append((float(coefficients[0]), scatter, float(np.mean(np.log(excess[heard] * frequency[heard]))), count))
    if not excesses:
        found.remarks.append(f"no background below {LOWEST:g} Hz stands out of the noise")
        return found
    if all(PINK_SLOPE[0] <= slope <= PINK_SLOPE[1] and scatter <= PINK_SCATTER for slope, scatter, _, _ in slopes):
        level = float(np.mean([logarithm for _, _, logarithm, _ in slopes]))
        deviation = max(scatter / math.sqrt(count) for _, scatter, _, count in slopes)
        density = math.exp(0.5 * level) / MICRO_G
        found.parameters["sensor.pink_noise_ug"] = density
        factor = math.exp(0.5 * QUANTILE * deviation)
        found.estimates.append(Estimate("sensor.pink_noise_ug", density, density / factor, density * factor, "ug/sqrt(Hz)", log=True))
        return found
    found.remarks.append(
        f"noise below {LOWEST:g} Hz does not fall with 1/f: it is taken for a background of the machine, not for noise of the sensor"
    )
    levels = [math.sqrt(float(np.sum(excess * np.gradient(frequency)))) / path.gain(axis) for axis, frequency, excess in excesses]
    _, frequency, excess = excesses[0]
    share = np.cumsum(excess * np.gradient(frequency))
    low_edge, high_edge = (float(np.interp(part * share[-1], share, frequency)) for part in (0.05, 0.95))
    relative = abs(machine.speed) * 0.5 * bench.operating.wheel_diameter / REFERENCE_SPEED
    level = min(1e3, float(np.mean(levels)) / relative)
    spread = max(0.1, float(np.ptp(levels)) / (2.0 * float(np.mean(levels))))
    found.parameters |= {
        "background.track_level": level,
        "background.track_low": max(1.0, low_edge),
        "background.track_high": max(high_edge, 1.3 * max(1.0, low_edge)),
    }
    found.estimates.append(Estimate("background.track_level", level, level * (1.0 - spread), min(1e3, level * (1.0 + spread)), "m/s^2"))
    return found
