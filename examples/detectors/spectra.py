"""What the families of envelope detectors share: filters, order spectra and their lines, evidence against noise, the best band."""

from abc import abstractmethod
from typing import Literal

import numpy as np
from scipy.signal import butter, hilbert, sosfilt
from trending import PARTS, SLIP, Trending, bands, over_angle

HARMONICS = 3
"""Harmonics of a characteristic order that are added [-]."""


def struck(orders):
    """Return the order of the impacts of a defect on each part [-]; a roller strikes both rings in one turn of its own."""
    return dict(zip(PARTS, (orders["BPFO"], orders["BPFI"], 2.0 * orders["BSF"], orders["FTF"]), strict=True))


def squared_envelope(acceleration):
    """Return |a + i H(a)|^2 of the whole band, H the Hilbert transform [m^2/s^4]."""
    return np.abs(hilbert(acceleration)) ** 2


def padded(signal, samples):
    """Return a signal that begins late, filled with its mean to a number of samples, so that it has the shaft angle of the window."""
    return np.pad(signal, (samples - len(signal), 0), mode="mean")


def highpass(acceleration, rate, lowest):
    """Return the signal above a frequency [Hz] by a Butterworth filter of order 4; all of it for 0.

    The frequency is at most a quarter of the sampling rate.
    """
    if lowest <= 0.0:
        return acceleration
    return sosfilt(butter(4, min(lowest, 0.25 * rate), "highpass", fs=rate, output="sos"), acceleration)


def order_spectrum(signal, angle):
    """Return the amplitude spectrum of a signal over the shaft angle, lines at multiples of 1/turns, and the revolutions [-]."""
    even, turns = over_angle(signal, angle)
    return np.abs(np.fft.rfft((even - even.mean()) * np.hanning(len(even)))) / len(even), turns


def line_regions(spectrum, turns, order):
    """Yield for each harmonic within the spectrum its values within the slip, and those within 1.5 orders."""
    places = np.arange(len(spectrum)) / turns
    for line in order * np.arange(1, HARMONICS + 1):
        near = np.abs(places - line) <= max(SLIP * line, 1.0 / turns)
        if near.any():
            yield spectrum[near], spectrum[np.abs(places - line) <= 1.5]


def line_ratios(spectrum, turns, orders):
    """Return for each part the sum over harmonics of line over median of the spectrum around it [-]."""
    return {
        part: sum(near.max() / np.median(around) for near, around in line_regions(spectrum, turns, order))
        for part, order in struck(orders).items()
    }


def decades(spectrum, turns, orders):
    """Return -log10 p for each part: p is the probability of its lines in the order spectrum of stationary noise [-].

    Noise has exponential powers of median m: the largest of n reaches x m / ln 2 with p_k = 1 - (1 - exp(-x))^n. Fisher's method joins the
    harmonics: -2 sum ln p_k is chi-squared with two degrees of freedom for each, of which the tail is a finite sum.
    """
    found = {}
    for part, order in struck(orders).items():
        logs = []
        for near, around in line_regions(spectrum**2, turns, order):
            x = np.log(2.0) * near.max() / np.median(around)
            logs.append(np.log(len(near)) - x if x > 30.0 else np.log(-np.expm1(len(near) * np.log1p(-np.exp(-x)))))
        half, term, tail = -sum(logs), 1.0, 0.0
        for k in range(len(logs)):
            tail, term = tail + term, term * half / (k + 1)
        found[part] = (half - np.log(max(tail, 1.0))) / np.log(10.0)
    return found


class Demodulation(Trending):
    """Report the part with the strongest lines in the order spectrum of a demodulated signal; a subclass demodulates.

    With ``reference: healthy``, lines relative to the spectrum around them must grow by ``factor`` over the first windows. With
    ``reference: noise`` they need ``significance`` decades of evidence, and no healthy window. Both are independent of the gain of the
    sensor. Settings have seen no recording: ``significance`` is noise theory, ``factor`` is that of the other examples.
    """

    reference: Literal["healthy", "noise"] = "healthy"
    significance = 6.0

    def __init__(self, orders, rate, **settings):
        super().__init__(orders, rate, **settings)
        if self.reference == "noise":
            self.learning, self.factor, self.verdict = 0, 1.0, "healthy"

    @abstractmethod
    def demodulated(self, acceleration, angle):
        """Return a signal that contains the repetition of impacts as lines, at any even spacing over the window."""

    def features(self, acceleration, angle):
        """Return the ratio of the lines of every part to the spectrum around them, or their evidence relative to ``significance``."""
        spectrum, turns = order_spectrum(self.demodulated(acceleration, angle), angle)
        if self.reference == "noise":
            return {part: value / self.significance for part, value in decades(spectrum, turns, self.orders).items()}
        return line_ratios(spectrum, turns, self.orders)


def strike_count(orders, angle):
    """Return the number of impacts of the fastest defect in a window [-]."""
    return max(orders.values()) * abs(angle[-1] - angle[0]) / (2.0 * np.pi)


def best_band(acceleration, strikes, score, levels=5):
    """Return edges and squared envelope of the band whose envelope has the largest score; see `bands`.

    Bands that are too narrow to separate the impacts of the fastest defect, ``strikes`` in the signal, are left out; of such bands only,
    the widest is taken.
    """
    tree = list(bands(acceleration, levels))
    usable = [band for band in tree if len(band[2]) >= 4.0 * strikes] or [max(tree, key=lambda band: len(band[2]))]
    return max(usable, key=lambda band: score(band[2]))
