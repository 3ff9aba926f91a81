"""The speed of a shaft that nobody measures, from the lines of its bearing."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dcrb_ros.bearing.kinematics import Orders
from dcrb_ros.diagnosis.envelope import OrderSpectrum

Floats = npt.NDArray[np.float64]

STEP = 5e-4
"""Step of the shaft frequencies tried, relative: half of what three harmonics over a window of seconds resolve."""
LEVEL_HELD = 30.0
"""Level beyond which a line counts no more for the speed [dB], so that one line does not outvote a family."""
NEIGHBOURS = 0.02
"""Shaft frequencies nearer than this are the same one, relative."""
HARMONICS = np.array([1.0, 2.0, 3.0])
SIDEBANDS = np.array([-2.0, -1.0, 0.0, 1.0, 2.0])


class Estimate(NamedTuple):
    """A shaft frequency as the signal tells it."""

    frequency: float
    """Shaft frequency [Hz]."""
    score: float
    """Level of the lines it explains, the more lines the more: their sum over the root of their number [dB]."""
    rival: float
    """Score of the best other frequency over its own [-]."""


def teeth_of_families(orders: Orders) -> list[Floats]:
    """Return the orders at which each family of lines stands."""
    return [
        np.arange(1.0, 5.0) * orders.bpfo,
        np.add.outer(HARMONICS * orders.bpfi, SIDEBANDS).ravel(),
        np.add.outer(HARMONICS * 2.0 * orders.bsf, SIDEBANDS * orders.ftf).ravel(),
    ]


def estimated_frequency(spectra: Sequence[OrderSpectrum], unit: float, orders: Orders, slowest: float, fastest: float) -> Estimate:
    """Return the shaft frequency from ``slowest`` to ``fastest`` [Hz] that explains the lines of ``spectra`` best.

    The spectra are over multiples of ``unit`` [Hz]. In each the family that fits best counts: the varying compliance in one, a defect in
    another.
    """
    tried = np.exp(np.arange(np.log(slowest), np.log(fastest), STEP))
    score = np.zeros(len(tried))
    for spectrum in spectra:
        background = spectrum.background(float(spectrum.orders[-1]))
        if background <= 0.0:
            continue
        level = np.clip(10.0 * np.log10(np.maximum(spectrum.amplitude / background, 1e-12)), 0.0, LEVEL_HELD)
        fits = [_fit(tried[:, None] * (teeth / unit), spectrum.orders, level) for teeth in teeth_of_families(orders)]
        score += np.max(fits, axis=0)
    best = int(np.argmax(score))
    others = np.abs(np.log(tried / tried[best])) > NEIGHBOURS
    rival = float(score[others].max(initial=0.0)) / max(float(score[best]), np.finfo(np.float64).tiny)
    return Estimate(float(tried[best]), float(score[best]), rival)


def _fit(places: Floats, orders: Floats, level: Floats) -> Floats:
    """Return how well lines at ``places``, a row for each frequency tried, are met."""
    return np.asarray(np.interp(places, orders, level, right=0.0).sum(axis=1) / np.sqrt(places.shape[1]), np.float64)
