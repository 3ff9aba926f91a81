"""The bands in which a detector demodulates."""

from __future__ import annotations

from dcrb_ros.diagnosis.demodulation import Band, band_tree
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.schema.refusal import Refusal

QUARTERS = 4
"""Parts of the detector's band in which levels are compared."""
NYQUIST_SHARE = 0.45
"""Highest usable frequency relative to the sampling rate [-]: anti-alias filters act above it."""


def bands_of(rate: int, p: DetectorParameters) -> tuple[Band, Band, tuple[Band, ...]]:
    """Return the whole band, its upper quarter, and all bands: the whole, its parts, and the band below it."""
    highest = NYQUIST_SHARE * rate
    high = min(p.band_high, highest)
    if high < 1.25 * p.band_low:
        raise Refusal(
            f"band_low = {p.band_low:g} Hz leaves no band below {high:g} Hz, the smaller of band_high and {NYQUIST_SHARE:g} of the "
            f"sampling rate of {rate} Hz: it must be at most {high / 1.25:g} Hz; lower it or sample faster"
        )
    whole, quarters = Band(p.band_low, high), band_tree(p.band_low, p.band_high, (QUARTERS,))
    parts = band_tree(p.band_low, high)[1:] if p.band == "kurtogram" else ()
    below = Band(0.5 * p.band_low, p.band_low)
    return whole, quarters[-1], (whole, *parts, below)
