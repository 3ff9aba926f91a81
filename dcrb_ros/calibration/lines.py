"""Lines of the mains and of the shaft, the fluctuation of the speed, and the modulation of the envelope by the shaft."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from dcrb_ros.diagnosis.features.envelope_lines import envelope_order_spectrum
from dcrb_ros.diagnosis.order_tracking import forward_turns
from dcrb_ros.schema.arrays import Floats

MAINS = (50.0, 60.0, 50.0 / 3.0)
"""Frequencies of the mains in grids and railways [Hz]."""
OFF_MAINS = 0.003
"""Largest relative departure of a grid's frequency [-]."""
LINE_RATIO = 20.0
"""Power of a line over the median of its neighbours from which it counts as one [-]: noise reaches it once in 10^6 lines."""
APART = 3.0
"""Distance from a harmonic of the shaft from which a line is distinct from it, in resolutions of the whole recording [-]."""


@dataclass(frozen=True)
class Hum:
    """Mains hum in a signal."""

    frequency: float
    """[Hz]"""
    level: float
    """Amplitude of the fundamental [m/s^2]."""
    error: float
    """Standard deviation of the amplitude [m/s^2]."""


def mains_hum(signal: Floats, rate: int, shaft_frequency: float) -> tuple[Hum | None, str]:
    """Return the strongest hum of the mains in a signal, shape (samples,), or none and why.

    A line is sought in the spectrum within 0.3 % of each frequency of the mains; its amplitude is a fit by least squares.
    """
    samples = len(signal)
    taper = np.hanning(samples + 1)[:-1]
    power = np.abs(np.fft.rfft(signal * taper)) ** 2
    spacing = rate / samples
    hums: list[tuple[float, Hum]] = []
    reason = "no line of the mains stands out of the noise"
    for mains in MAINS:
        low, high = math.floor(mains * (1.0 - OFF_MAINS) / spacing), math.ceil(mains * (1.0 + OFF_MAINS) / spacing) + 1
        if high + 1 >= len(power):
            continue
        at = low + int(np.argmax(power[low:high]))
        around = power[max(1, low - 60) : high + 60]
        if power[at] < LINE_RATIO * float(np.median(around)):
            continue
        beside = np.log(np.maximum(power[at - 1 : at + 2], np.finfo(np.float64).tiny))
        curvature = beside[0] - 2.0 * beside[1] + beside[2]
        frequency = (at + (0.5 * (beside[0] - beside[2]) / curvature if curvature < 0.0 else 0.0)) * spacing
        order = max(1, round(frequency / shaft_frequency)) if shaft_frequency > 0.0 else 1
        if abs(frequency - order * shaft_frequency) < APART * spacing:
            reason = f"a line at {frequency:.4g} Hz may be the mains or order {order} of the shaft"
            continue
        angle = np.asarray(2.0 * math.pi * frequency / rate * np.arange(samples), np.float64)
        amplitude, error = fitted_line(signal, angle, float(np.median(around)) / float(taper @ taper))
        hums.append((float(power[at]), Hum(float(frequency), abs(amplitude), error)))
    if not hums:
        return None, reason
    return max(hums, key=lambda hum: hum[0])[1], ""


def fitted_line(signal: Floats, angle: Floats, noise: float) -> tuple[complex, float]:
    """Return the complex amplitude of exp(i angle) in a signal by least squares, and its standard deviation.

    ``noise`` is the median of |X|^2 around the line over the energy of the taper; that of a chi-square of two degrees is ln 2 of its mean.
    """
    design = np.column_stack([np.cos(angle), np.sin(angle)])
    (cosine, sine), *_ = np.linalg.lstsq(design, signal, rcond=None)
    return complex(cosine, sine), math.sqrt(2.0 * noise / math.log(2.0) / len(signal))


def order_line(signal: Floats, turns: Floats, order: float) -> tuple[complex, float]:
    """Return the complex amplitude of a harmonic of the shaft, and its standard deviation from the orders between harmonics."""
    window = np.hanning(len(signal) + 1)[:-1]

    def amplitude(at: float) -> complex:
        return complex(2.0 * np.sum(signal * window * np.exp(-2j * np.pi * at * turns)) / window.sum())

    total = abs(float(turns[-1] - turns[0]))
    offsets = np.array([-9, -7, -5, 5, 7, 9]) * min(0.05, max(0.02, 1.0 / total))
    return amplitude(order), float(np.sqrt(np.mean([abs(amplitude(order + offset)) ** 2 for offset in offsets]) / 2.0))


def without_lines(signal: Floats, turns: Floats, rate: int, hum_frequency: float) -> Floats:
    """Return a signal without its first five harmonics of the shaft and three of the mains [Hz], 0 for none, fitted by least squares."""
    angles: list[Floats] = [np.asarray(2.0 * math.pi * k * turns, np.float64) for k in range(1, 6)]
    if hum_frequency:
        time = np.arange(len(signal), dtype=np.float64) / rate
        angles += [np.asarray(2.0 * math.pi * k * hum_frequency * time, np.float64) for k in (1, 2, 3)]
    design = np.column_stack([part(angle) for angle in angles for part in (np.cos, np.sin)])
    # The columns are nearly orthogonal over many turns: the normal equations are small and sound.
    solution = np.linalg.solve(design.T @ design + 1e-9 * len(signal) * np.eye(design.shape[1]), design.T @ signal)
    return np.asarray(signal - design @ solution, np.float64)


@dataclass(frozen=True)
class Fluctuation:
    """Fluctuation of a measured speed, root mean squares over the speed [-]."""

    random: float
    random_error: float
    ripple: float
    ripple_error: float


def speed_fluctuation(turns: Floats, rate: int) -> Fluctuation:
    """Return the slow random fluctuation, 0.1 to 5 Hz, and the ripple at the orders 1 and 2 of a measured angle.

    The departure of the angle from a steady turn is split: harmonics of the angle are fitted by least squares, and the rest below 5 Hz is
    differentiated. A departure of the amplitude a [rad] at order k is a fluctuation of the speed by k a / sqrt(2).
    """
    step = max(1, rate // 1000)
    seconds = len(turns) / rate
    angle = 2.0 * math.pi * turns[::step]
    position = np.linspace(-1.0, 1.0, len(angle))
    departure = angle - np.polynomial.polynomial.Polynomial.fit(position, angle, 1)(position)
    # A Fourier series below 5 Hz with the ends free: the slow fluctuation.
    slow = [np.ones(len(angle)), position]
    most = max(1, int(5.0 * seconds))
    for k in range(1, most + 1):
        slow += [np.cos(math.pi * k * position), np.sin(math.pi * k * position)]
    harmonics = [part(k * angle) for k in (1.0, 2.0) for part in (np.cos, np.sin)]
    design = np.column_stack([*slow, *harmonics])
    solution, *_ = np.linalg.lstsq(design, departure, rcond=None)
    residual = departure - design @ solution
    slow_angle = design[:, : len(slow)] @ solution[: len(slow)]
    mean = abs(float(angle[-1] - angle[0])) / seconds
    speeds = np.gradient(slow_angle, step / rate)
    trimmed = speeds[len(speeds) // 20 : -max(1, len(speeds) // 20)]
    random = float(np.std(trimmed)) / mean
    amplitudes = solution[len(slow) :].reshape(2, 2)
    orders = np.array([1.0, 2.0])
    ripple = math.sqrt(float(np.sum((orders[:, None] * amplitudes) ** 2)) / 2.0)
    scatter = float(np.std(residual)) * math.sqrt(2.0 / len(angle)) * math.sqrt(5.0)
    # The slowest fluctuations that matter pass some 0.5 s times over: as many independent values.
    return Fluctuation(random, random / math.sqrt(2.0 * max(1.0, seconds)), ripple, scatter)


def shaft_modulation(signal: Floats, turns: Floats, rate: int, low: float, high: float) -> tuple[float, float]:
    """Return the line of the shaft in the squared envelope of a band [Hz] over the mean of that envelope, and its standard deviation [-].

    The noise of the orders around it is subtracted from its power.
    """
    spectrum = envelope_order_spectrum(signal, forward_turns(turns), rate, low, high)
    mean = max(spectrum.mean, np.finfo(np.float64).tiny)
    line = float(spectrum.lines(np.array([1.0]))[0]) / mean
    around = spectrum.lines(np.concatenate([np.linspace(0.75, 0.92, 12), np.linspace(1.08, 1.25, 12)])) / mean
    noise = float(np.mean(around**2))
    return math.sqrt(max(0.0, line**2 - noise)), math.sqrt(0.5 * noise)
