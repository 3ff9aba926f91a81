"""Envelope spectra of a recording, window by window, and the lines at which faults show."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from dcrb_ros.block import Floats, Samples
from dcrb_ros.kinematics import Orders
from dcrb_ros.viewer.content import Times, Waveform

WINDOW = 1.0
"""Length of a window [s]."""
HOP = 0.5
"""Time between the ends of two windows [s]."""
HIGHEST_ORDER = 30.0
"""Order up to which spectra are shown [-]."""
ORDER_STEP = 0.025
"""Distance of the orders at which spectra are shown [-]."""
FEWEST_TURNS = 3.0
"""Turns of the shaft that a window needs [-]."""
MARGIN_PERIODS = 30.0
"""Periods of the band's lower edge left out at both ends of a window, where its envelope wraps round [-]."""


@dataclass(frozen=True)
class Spectra:
    """Envelope spectra over time, as levels over the background."""

    time_ns: Times
    """End of each window [ns]."""
    orders: Floats
    """Multiples of the shaft frequency [-]."""
    level: Floats
    """Level over the background, shape (windows, orders) [dB]."""
    shaft_frequency: Floats
    """Mean shaft frequency of each window [Hz]."""


@dataclass(frozen=True)
class Comb:
    """A fault and the lines at which it shows."""

    name: str
    orders: tuple[float, ...]
    """Its harmonics as multiples of the shaft frequency [-]."""


def fault_combs(orders: Orders) -> list[Comb]:
    """Return the harmonics of BPFO, BPFI, 2BSF and FTF up to `HIGHEST_ORDER`; of FTF the first four."""
    bases = {"BPFO": orders.bpfo, "BPFI": orders.bpfi, "2BSF": 2.0 * orders.bsf, "FTF": orders.ftf}
    combs = []
    for name, base in bases.items():
        most = 4 if name == "FTF" else int(HIGHEST_ORDER / base)
        combs.append(Comb(name, tuple(base * k for k in range(1, most + 1) if base * k < HIGHEST_ORDER)))
    return combs


def windows(sample_count: int, rate: int) -> Iterator[slice]:
    """Yield the windows of a waveform; all of it as one when it is shorter than a window."""
    length, hop = round(WINDOW * rate), round(HOP * rate)
    if sample_count <= length:
        yield slice(0, sample_count)
        return
    for end in range(length, sample_count + 1, hop):
        yield slice(end - length, end)


def rising_angle(shaft_angle: Samples) -> Floats | None:
    """Return the unwrapped angle [rad], taken positive in the sense of rotation; ``None`` unless the shaft turns on and on."""
    angle = np.unwrap(shaft_angle.astype(np.float64))
    if angle[-1] < angle[0]:
        angle = -angle
    turns = (angle[-1] - angle[0]) / (2.0 * math.pi)
    return angle if turns >= FEWEST_TURNS and bool((np.diff(angle) > 0.0).all()) else None


def envelope_spectra(waveform: Waveform, band: tuple[float, float]) -> Spectra | None:
    """Return the spectra of the squared envelope of ``band`` [Hz]; ``None`` when the shaft turns in no window."""
    from dcrb_ros.diagnosis.envelope import order_spectrum, squared_envelope

    orders = np.arange(ORDER_STEP, HIGHEST_ORDER, ORDER_STEP)
    margin = round(MARGIN_PERIODS * waveform.rate / band[0])
    found: list[tuple[int, Floats, float]] = []
    for window in windows(len(waveform.time_ns), waveform.rate):
        inside = slice(window.start + margin, window.stop - margin)
        angle = rising_angle(waveform.shaft_angle[inside]) if inside.stop - inside.start > margin else None
        if angle is None:
            continue
        envelope = squared_envelope(waveform.acceleration[window], waveform.rate, band)[margin:-margin]
        places, amplitude = order_spectrum(envelope, angle, HIGHEST_ORDER)
        frequency = (angle[-1] - angle[0]) * waveform.rate / (2.0 * math.pi * (len(angle) - 1))
        found.append((int(waveform.time_ns[window.stop - 1]), np.interp(orders, places[1:], amplitude[1:]), frequency))
    if not found:
        return None
    times, amplitudes, frequencies = zip(*found)
    return Spectra(np.array(times, np.int64), orders, over_background(np.array(amplitudes)), np.array(frequencies))


def over_background(amplitude: Floats) -> Floats:
    """Return the level of each amplitude over the median within an order on either side, shape (windows, orders) [dB]."""
    from scipy.ndimage import median_filter

    width = 2 * round(1.0 / ORDER_STEP) + 1
    floor = median_filter(amplitude, size=(1, width), mode="nearest")
    smallest = np.finfo(np.float64).tiny
    return np.asarray(20.0 * np.log10(np.maximum(amplitude, smallest) / np.maximum(floor, smallest)), np.float64)
