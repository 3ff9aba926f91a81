"""CYCBD, a blind deconvolution: the filter whose output is most cyclostationary at the order of a part (Buzzoni et al. 2018)."""

import numpy as np
from scipy.linalg import eigh
from spectra import struck
from trending import SLIP, Trending, over_angle

TAPS = 48
"""Length of the filter [samples]."""
CYCLES = 5
"""Harmonics of the cyclic order in the indicator [-]."""
ITERATIONS = 3
"""Steps of the iteration; the indicator rises by less than 1 % in later ones [-]."""

VARIANTS = {
    "CYCBD": {},
    "CYCBD, factor 2": {"factor": 2.0},
    "CYCBD, factor 6": {"factor": 6.0},
}
"""Settings of each member of the family; the first has the published ones."""


def cyclostationarity(acceleration, turns, order):
    """Return the indicator of second-order cyclostationarity of the best filter; 1 for a stationary signal [-].

    The filter h maximises ICS2 = sum_k |mean(|s|^2 exp(-2 pi j k order turns))|^2 / mean(|s|^2)^2 of its output s = X h, k = 0 .. CYCLES.
    With the periodic part P of |s|^2 over its mean as weights, it is the largest eigenvector of X^T diag(P) X h = lambda X^T X h; weights
    and filter are found in turn (Buzzoni et al. 2018).
    """
    lagged = np.lib.stride_tricks.sliding_window_view(acceleration, TAPS)
    phase = np.exp(-2j * np.pi * order * turns[TAPS - 1 :][:, None] * np.arange(1, CYCLES + 1))
    plain = lagged.T @ lagged
    plain += 1e-6 * np.trace(plain) / TAPS * np.eye(TAPS)
    taps, indicator = np.eye(TAPS)[0], 1.0
    for _ in range(ITERATIONS):
        power = (lagged @ taps) ** 2
        coefficients = power @ phase / power.sum()
        indicator = 1.0 + 2.0 * np.sum(np.abs(coefficients) ** 2)
        weights = 1.0 + 2.0 * np.real(phase.conj() @ coefficients)
        taps = eigh(lagged.T @ (weights[:, None] * lagged), plain, subset_by_index=(TAPS - 1, TAPS - 1))[1][:, 0]
    return indicator


def strongest(acceleration, angle, order):
    """Return the order within its slip at which the squared signal has its strongest line."""
    even, turns = over_angle(acceleration**2, angle)
    spectrum = np.abs(np.fft.rfft(even - even.mean()))
    orders = np.arange(len(spectrum)) / turns
    near = np.flatnonzero(np.abs(orders - order) <= max(SLIP * order, 1.0 / turns))
    return orders[near[np.argmax(spectrum[near])]]


class Cycbd(Trending):
    """Report the part whose cyclostationarity after deconvolution has grown most over the healthy level."""

    def features(self, acceleration, angle):
        """Return the indicator less that of a stationary signal for every part."""
        white = np.diff(acceleration)  # the impacts of rollers are high in frequency, and the level is not
        turns = np.abs(angle[1:] - angle[0]) / (2.0 * np.pi)
        orders = ((part, order) for part, order in struck(self.orders).items() if part != "cage")
        return {part: cyclostationarity(white, turns, strongest(white, angle[1:], order)) - 1.0 for part, order in orders}
