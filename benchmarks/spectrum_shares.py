"""Where in the spectrum the power and the impulses of a signal are."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy import signal

from dcrb_ros.diagnosis.demodulation import Band, Demodulator, kurtosis
from dcrb_ros.schema.arrays import Floats

SEGMENT = 8192
"""Samples of the segments of a power spectrum."""
OCTAVES = (Band(1e3, 2e3), Band(2e3, 4e3), Band(4e3, 8e3), Band(8e3, 16e3))
"""Octaves in which the spectral kurtosis is stated."""
USABLE = 0.45
"""Highest frequency relative to the sampling rate at which a band may end [-]."""


def _density(values: npt.NDArray[np.floating], rate: float) -> tuple[Floats, Floats]:
    frequency, density = signal.welch(np.asarray(values, np.float64), rate, nperseg=min(SEGMENT, len(values)))
    return np.asarray(frequency, np.float64), np.asarray(density, np.float64)


def band_level(values: npt.NDArray[np.floating], rate: float, band: Band) -> float:
    """Return the power in a band over all power [dB], NaN where the band ends above the usable range of the sampling rate [Hz]."""
    if band.high > 0.5 * rate:
        return float("nan")
    frequency, density = _density(values, rate)
    inside = (frequency >= band.low) & (frequency < band.high)
    return 10.0 * float(np.log10(max(density[inside].sum() / density.sum(), 1e-12)))


def cut_off(values: npt.NDArray[np.floating], rate: float, share: float = 0.95) -> float:
    """Return the frequency [Hz] below which a share of the power lies."""
    frequency, density = _density(values, rate)
    total = np.cumsum(density)
    return float(frequency[np.searchsorted(total, share * total[-1])])


def octave_kurtosis(values: npt.NDArray[np.floating], rate: float) -> tuple[float, ...]:
    """Return the spectral kurtosis in each of `OCTAVES` [-]: 0 for noise; NaN where the sampling rate [Hz] ends the octave."""
    usable = tuple(octave for octave in OCTAVES if octave.high <= USABLE * rate)
    envelopes = Demodulator(usable, round(rate), len(values)).squared_envelopes(np.asarray(values)[:, None])
    found = [float(kurtosis(squared[None])[0]) for _, squared in envelopes]
    return (*found, *[float("nan")] * (len(OCTAVES) - len(usable)))
