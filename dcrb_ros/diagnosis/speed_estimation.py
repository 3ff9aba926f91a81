"""Shaft speed estimated from the lines of the bearing, for signals without a tachometer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.diagnosis.order_spectrum import HARMONICS, SHAFT_SIDEBANDS, OrderSpectrum
from dcrb_ros.schema.arrays import Floats

STEP = 5e-4
"""Relative step of the shaft frequencies that are tried [-]: half the resolution of three harmonics over a window of seconds."""
HIGHEST_LEVEL = 30.0
"""Level to which a line is limited [dB], so that one line does not outweigh a family."""
NEIGHBOURS = 0.02
"""Relative difference below which two shaft frequencies count as the same [-]."""


class SpeedEstimate(NamedTuple):
    """A shaft frequency estimated from the signal."""

    frequency: float
    """Shaft frequency [Hz]."""
    score: float
    """Sum of the levels of the lines that it explains over the square root of their number [dB]."""
    rival: float
    """Score of the best other frequency relative to this one [-]."""


def line_orders(orders: Orders) -> list[Floats]:
    """Return the orders of the lines of each family: BPFO, BPFI, twice BSF, with their sidebands."""
    return [
        np.arange(1.0, 5.0) * orders.bpfo,
        np.add.outer(HARMONICS * orders.bpfi, SHAFT_SIDEBANDS).ravel(),
        np.add.outer(HARMONICS * 2.0 * orders.bsf, SHAFT_SIDEBANDS * orders.ftf).ravel(),
    ]


def estimated_frequency(spectra: Sequence[OrderSpectrum], unit: float, orders: Orders, slowest: float, fastest: float) -> SpeedEstimate:
    """Return the shaft frequency from ``slowest`` to ``fastest`` [Hz] that explains the lines of ``spectra`` best.

    The spectra are over multiples of ``unit`` [Hz]. In each of them only the family that fits best counts: in one band it may be the
    varying compliance, in another a defect.
    """
    tried = np.exp(np.arange(np.log(slowest), np.log(fastest), STEP))
    score = np.zeros(len(tried))
    for spectrum in spectra:
        background = spectrum.background(float(spectrum.orders[-1]))
        if background <= 0.0:
            continue
        level = np.clip(10.0 * np.log10(np.maximum(spectrum.amplitude / background, 1e-12)), 0.0, HIGHEST_LEVEL)
        fits = [_fit(tried[:, None] * (lines / unit), spectrum.orders, level) for lines in line_orders(orders)]
        score += np.max(fits, axis=0)
    best = int(np.argmax(score))
    others = np.abs(np.log(tried / tried[best])) > NEIGHBOURS
    rival = float(score[others].max(initial=0.0)) / max(float(score[best]), np.finfo(np.float64).tiny)
    return SpeedEstimate(float(tried[best]), float(score[best]), rival)


def _fit(lines: Floats, orders: Floats, level: Floats) -> Floats:
    """Return the score of lines at given orders, shape (frequencies, lines), as an array of shape (frequencies,)."""
    return np.asarray(np.interp(lines, orders, level, right=0.0).sum(axis=1) / np.sqrt(lines.shape[1]), np.float64)
