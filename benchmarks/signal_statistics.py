"""Statistics that a simulated and a measured signal of the same kind of defect must share."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from impact_trains import delays, scatter_of, shared_jitter, train_of
from line_ratio import kurtogram_ratio, line_ratio
from spectrum_shares import band_level, cut_off, octave_kurtosis

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.diagnosis.demodulation import Band
from dcrb_ros.validation.realism import lines_of, squared_envelope, statistics, wide_band

JITTER_HIGH, JITTER_SPLIT = 1.2e4, 0.4
"""Upper edge of the two bands in which the times of impacts are compared [Hz], and share of their width below their common edge [-]."""
MIDDLE, UPPER = Band(5e3, 1e4), Band(1e4, 2e4)
"""Bands whose share of the power is stated."""


class SignalStatistics(NamedTuple):
    """Statistics of one axis of a bearing with a line at one order."""

    ratio: float
    """R, the sum over three harmonics of a line over the median of the spectrum around it, envelope of 2 to 20 kHz [-]."""
    kurtogram_ratio: float
    """R in the band with the largest spectral kurtosis below 0.43 of the sampling rate [-]."""
    energy_scatter: float
    """Standard deviation of the energies of the impacts over their mean, c_E [-]."""
    neighbour: float
    """Correlation of the strengths of consecutive impacts [-]."""
    element: float
    """Correlation of the strengths of impacts of the same rolling element [-]."""
    shaft: float
    """Share of the variance of the strengths that follows the angle of the shaft [-]."""
    jitter: float
    """Standard deviation of the time errors of the impacts that a lower and an upper band share [ms]."""
    depth: float
    """Amplitude of the line over the mean squared envelope [-]."""
    crest: float
    """Level of the 99.5th percentile of the envelope over its median [dB]."""
    cage: float
    """Median depth of the first harmonics of FTF [-]."""
    sidebands: float
    """Mean amplitude of the lines one shaft frequency beside the line over its own [-]."""
    harmonic_8: float
    """Depth of the eighth harmonic [-]."""
    kurtosis: float
    """Fourth moment over the square of the second [-]: 3 for noise."""
    middle: float
    """Power between 5 and 10 kHz over all power [dB]."""
    upper: float
    """Power between 10 and 20 kHz over all power [dB]."""
    cut_off: float
    """Frequency below which 95 % of the power lies [kHz]."""
    octave_1: float
    """Spectral kurtosis between 1 and 2 kHz [-]: 0 for noise."""
    octave_2: float
    """Between 2 and 4 kHz [-]."""
    octave_4: float
    """Between 4 and 8 kHz [-]."""
    octave_8: float
    """Between 8 and 16 kHz [-]."""


def signal_statistics(
    signal: npt.NDArray[np.floating], rate: float, shaft_frequency: float, orders: Orders, elements: int, order: float | None = None
) -> SignalStatistics:
    """Return the statistics of one axis, a ``signal`` of shape (samples,) in any unit; rate and shaft frequency in Hz.

    A row of the bearing has some rolling ``elements``; ``order`` is the kinematic order of the impacts [-], BPFO by default.

    Raises:
        Refusal: the signal is too short, or its sampling rate leaves no band.
    """
    values = np.asarray(signal, np.float64) - float(np.mean(signal))
    order = orders.bpfo if order is None else order
    found = statistics(values, rate, shaft_frequency, orders, order)
    squared, its_rate = squared_envelope(values, rate)
    frequency = lines_of(squared, its_rate).fitted(order * shaft_frequency)
    train = train_of(squared, its_rate, frequency)
    low, high = wide_band(rate).low, min(wide_band(rate).high, JITTER_HIGH)
    middle = low + JITTER_SPLIT * (high - low)
    halves = [squared_envelope(values, rate, band) for band in (Band(low, middle), Band(middle, high))]
    late = [delays(half, half_rate, train, its_rate) for half, half_rate in halves]
    return SignalStatistics(
        line_ratio(squared, its_rate, frequency, shaft_frequency),
        kurtogram_ratio(values, rate, frequency, shaft_frequency),
        *scatter_of(train, elements, shaft_frequency),
        1e3 * shared_jitter(late),
        found.bpfo_depth,
        found.crest,
        found.cage_depth,
        found.sidebands,
        found.harmonics[1],
        found.kurtosis,
        band_level(values, rate, MIDDLE),
        band_level(values, rate, UPPER),
        1e-3 * cut_off(values, rate),
        *octave_kurtosis(values, rate),
    )
