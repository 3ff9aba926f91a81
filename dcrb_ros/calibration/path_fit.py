"""The path as the spectral envelope between the source's spectrum and the measured one: a fit of gain, resonances and noise.

The measured density is modelled as

    P_r(f) = g_r^2 |H(f)|^2 S_r(f) + W^2,        H(s) = prod_k (s^2/z_k^2 + 2 a_k s/z_k + 1) / (s^2/p_k^2 + 2 b_k s/p_k + 1),

with the source's density S_r at the speed of recording r, one gain g_r per recording and the density W of white noise. Each factor of H is
a resonance and an antiresonance (`dcrb_ros.measurement.stages.path`), so that H has minimum phase. The squared difference of the
logarithms is least in bins of 1/48 octave, with a robust loss, as residuals of a spectrum are close to normal there. Factors are added
where the residual is largest, until the Bayesian information criterion (Schwarz 1978, Ann. Stat. 6(2), 461-464) no longer falls.

A path with zeros outside the unit circle, or a delay, has the same envelope as its minimum-phase part (Randall 2017,
"A history of cepstrum analysis and its application to mechanical problems", Mech. Syst. Signal Process. 97, 3-19).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from dcrb_ros.calibration.spectra import Binned
from dcrb_ros.measurement.stages.path import Pair
from dcrb_ros.schema.arrays import Floats

MOST_FACTORS = 16
"""Largest number of pairs of poles and zeros [-]."""
MODEL_ERROR = 0.05
"""Standard deviation of the logarithm by which the model may be wrong in a bin [-], 0.2 dB."""
FALLING_FROM = 28.0
"""Frequency from which a path that falls towards low frequencies is seen [Hz]."""
FALLING_ERROR = 0.7
"""Standard deviation of the logarithm there [-], 3 dB: lines of bearing and machine lie side by side."""
PRIOR = (0.4, 2.0)
"""Standard deviations of the logarithms of z/p and a/b before they are fitted [-]: a pair far apart must be worth it."""
DAMPINGS = (0.008, 1.5)
FACTOR = 4
"""Parameters of a factor: log p, log b, log z and log a."""
ROBUST = 3.0
"""Residuals beyond so many standard deviations count linearly [-]: lines that the bench does not have."""
PENALTY = 2.0
"""Factor of the penalty of the information criterion [-], for neighbouring bins are not quite independent."""
WIDTHS = ((3, 0.02), (9, 0.05), (25, 0.15), (61, 0.4))
"""Bins over which the residual is smoothed to find a new pair, and the damping with which it begins [-]."""
NEPER = 20.0 / math.log(10.0)
"""Decibels in a factor of e of an amplitude [dB]."""


@dataclass(frozen=True, eq=False)
class PathSpectra:
    """What the fit of one axis takes: spectra of the recordings and of the source at their speeds, in the same bins."""

    frequency: Floats
    """Shape (bins,) [Hz]."""
    measured: Floats
    """Logarithm of the measured density, shape (recordings, bins)."""
    source: Floats
    """Logarithm of the source's density, shape (recordings, bins)."""
    deviation: Floats
    """Standard deviation of their difference, shape (recordings, bins)."""
    step_rate: float
    """Rate at which the sections of the path run [Hz]."""
    lowest: float = 0.0
    """Logarithm of the lowest measured density in a third of an octave, which white noise does not exceed."""

    @staticmethod
    def of(measured: Sequence[Binned], source: Sequence[Binned], low: float, step_rate: float) -> PathSpectra:
        """Return the data; below a ``low`` frequency [Hz] the path may fall but not rise, and counts little.

        What a machine has more than its bearing there is its background.
        """
        frequency = measured[0].frequency
        kept = frequency >= FALLING_FROM
        below, beside = frequency < low, (frequency >= low) & (frequency < 2.0 * low)
        levels, deviations, lowest = [], [], math.inf
        for recording, two in zip(measured, source, strict=True):
            most = two.level + float(np.median((recording.level - two.level)[beside]))
            lowest = min(lowest, float(_smoothed(recording.level[~below], 15).min()))
            levels.append(np.where(below, np.minimum(recording.level, most), recording.level)[kept])
            deviations.append(np.sqrt(recording.variance + two.variance + np.where(below, FALLING_ERROR, MODEL_ERROR) ** 2)[kept])
        sourced = np.array([recording.level[kept] for recording in source])
        return PathSpectra(frequency[kept], np.array(levels), sourced, np.array(deviations), step_rate, lowest)


@dataclass(frozen=True, eq=False)
class PathFit:
    """The fitted path of one axis."""

    data: PathSpectra
    gains: Floats
    """Gain of each recording, shape (recordings,) [-]."""
    pairs: tuple[Pair, ...]
    white: float
    """Density of the white noise [m/s^2/sqrt(Hz)]."""
    covariance: Floats
    """Of the parameters: log W^2, log g^2 of each recording, and log p, log b, log z and log a of each pair."""
    parameters: Floats

    def log_path(self, frequency: Floats | None = None) -> Floats:
        """Return the logarithm of |H|^2 without the gain, in the bins or at other frequencies [Hz], of their shape."""
        at = self.data.frequency if frequency is None else frequency
        return _log_factors(self.parameters[1 + len(self.gains) :], at, self.data.step_rate)[0]

    def share(self) -> Floats:
        """Return the share of the bearing in the modelled density, shape (recordings, bins) [-]; the rest is noise."""
        return _evaluated(self.parameters, self.data)[1]

    def modelled(self) -> Floats:
        """Return the logarithm of the modelled density, shape (recordings, bins)."""
        return _evaluated(self.parameters, self.data)[0]

    def residual(self) -> Floats:
        """Return measured over modelled density, shape (recordings, bins) [dB]."""
        return np.asarray(0.5 * NEPER * (self.data.measured - self.modelled()), np.float64)

    def level_gradient(self, frequency: Floats) -> Floats:
        """Return the derivatives of log g^2 |H|^2 of the first recording at frequencies [Hz], shape (frequencies, parameters)."""
        gradient = np.zeros((len(frequency), len(self.parameters)))
        gradient[:, 1] = 1.0
        gradient[:, 1 + len(self.gains) :] = _log_factors(self.parameters[1 + len(self.gains) :], frequency, self.data.step_rate)[1]
        return gradient


def fit_path(data: PathSpectra, *, white: float | None = None) -> PathFit:
    """Return the path that explains the spectra of one axis; ``white`` is the density of the white noise if known [m/s^2/sqrt(Hz)]."""
    difference = data.measured - data.source
    floor = data.lowest if white is None else 2.0 * math.log(max(white, 1e-12))
    start = np.array([floor - 0.3 * (white is None), *np.median(difference, axis=1)])
    known = white is not None
    best = _refined(start, data, known)
    score = _cost(best, data)
    while (len(best) - len(start)) // FACTOR < MOST_FACTORS:
        tries = [_refined(np.concatenate([best, factor]), data, known) for factor in _new_factors(best, data)]
        costs = [_cost(tried, data) for tried in tries]
        if score - min(costs) < 0.5 * PENALTY * FACTOR * math.log(data.measured.size):
            break
        best, score = tries[int(np.argmin(costs))], min(costs)
    return _result(best, data, known)


def _result(parameters: Floats, data: PathSpectra, known: bool) -> PathFit:
    recordings = len(data.measured)
    residual, jacobian = _residuals(parameters, data)
    points = data.measured.size
    misfit = float(np.sqrt(np.mean(np.minimum(np.abs(residual[:points]), ROBUST) ** 2)))
    used = np.abs(residual) < 2.0 * ROBUST
    information = jacobian[used].T @ jacobian[used]
    if known:
        information[0, :] = information[:, 0] = 0.0
        information[0, 0] = 1e12
    # A floor that the bearing's noise covers has no information; the prior is that it may be anything below.
    covariance = np.linalg.pinv(information + 1e-3 * np.eye(len(parameters))) * max(1.0, misfit) ** 2
    factors = np.exp(parameters[1 + recordings :].reshape(-1, FACTOR))
    return PathFit(
        data,
        np.exp(0.5 * parameters[1 : 1 + recordings]),
        tuple(Pair(*map(float, factor)) for factor in factors[np.argsort(factors[:, 0])]),
        math.exp(0.5 * float(parameters[0])),
        covariance,
        parameters,
    )


def _refined(start: Floats, data: PathSpectra, known: bool) -> Floats:
    """Return the parameters at which the cost has a minimum near ``start``."""
    from scipy.optimize import least_squares

    recordings, factors = len(data.measured), (len(start) - 1 - len(data.measured)) // FACTOR
    ends = [math.log(float(data.frequency[at])) for at in (0, -1)]
    low, high = (
        np.concatenate([[floor], np.full(recordings, gain), np.tile([ends[at], math.log(DAMPINGS[at])], 2 * factors)])
        for at, (floor, gain) in enumerate(((-70.0, -60.0), (40.0, 60.0)))
    )
    if known:
        low[0], high[0] = start[0] - 1e-9, start[0] + 1e-9
    kept: dict[str, Any] = {}

    def residuals(parameters: Floats) -> Floats:
        kept["at"], (values, kept["jacobian"]) = parameters.copy(), _residuals(parameters, data)
        return values

    def jacobian(parameters: Floats) -> Floats:
        if "at" not in kept or not np.array_equal(kept["at"], parameters):
            residuals(parameters)
        return np.asarray(kept["jacobian"], np.float64)

    solution = least_squares(
        residuals,
        np.clip(start, low + 1e-10, high - 1e-10),
        jac=jacobian,
        bounds=(low, high),
        loss="soft_l1",
        f_scale=ROBUST,
        x_scale="jac",
        max_nfev=40,
        ftol=1e-5,
        xtol=1e-6,
    )
    return np.asarray(solution.x, np.float64)


def _residuals(parameters: Floats, data: PathSpectra) -> tuple[Floats, Floats]:
    """Return the residuals and their derivatives: bins of all recordings, and the pairs over their prior."""
    recordings = len(data.measured)
    modelled, share = _evaluated(parameters, data)
    _, by_factor = _log_factors(parameters[1 + recordings :], data.frequency, data.step_rate)
    values = (modelled - data.measured) / data.deviation
    jacobian = np.zeros((*data.measured.shape, len(parameters)))
    jacobian[..., 0] = np.exp(parameters[0] - modelled)
    for recording in range(recordings):
        jacobian[recording, :, 1 + recording] = share[recording]
    jacobian[..., 1 + recordings :] = share[..., None] * by_factor[None]
    jacobian /= data.deviation[..., None]
    factors = parameters[1 + recordings :].reshape(-1, FACTOR)
    prior = np.zeros((2 * len(factors), len(parameters)))
    for k in range(len(factors)):
        for kind, deviation in enumerate(PRIOR):
            at = 1 + recordings + FACTOR * k + kind
            prior[2 * k + kind, at], prior[2 * k + kind, at + 2] = -1.0 / deviation, 1.0 / deviation
    return np.concatenate([values.ravel(), prior @ parameters]), np.concatenate([jacobian.reshape(-1, len(parameters)), prior])


def _cost(parameters: Floats, data: PathSpectra) -> float:
    """Return half the robust sum of squares, as `scipy.optimize.least_squares` counts it."""
    residual = _residuals(parameters, data)[0]
    return float(np.sum(ROBUST**2 * (np.sqrt(1.0 + (residual / ROBUST) ** 2) - 1.0)))


def _evaluated(parameters: Floats, data: PathSpectra) -> tuple[Floats, Floats]:
    """Return the logarithm of the modelled density and the share of the bearing in it, shape (recordings, bins)."""
    recordings = len(data.measured)
    path, _ = _log_factors(parameters[1 + recordings :], data.frequency, data.step_rate)
    bearing = data.source + parameters[1 : 1 + recordings, None] + path
    total = np.logaddexp(bearing, parameters[0])
    return total, np.exp(bearing - total)


def _log_factors(factors: Floats, frequency: Floats, step_rate: float) -> tuple[Floats, Floats]:
    """Return log |H|^2 at frequencies [Hz] and its derivatives by the parameters of each factor, shape (frequencies, factors).

    On the imaginary axis s^2/p^2 + 2 b s/p + 1 has the square (1 - v^2)^2 + (2 b v)^2 at v = tan(pi f/rate) / tan(pi p/rate), the bilinear
    transform prewarped at p.
    """
    total = np.zeros(len(frequency))
    gradient = np.zeros((len(frequency), len(factors)))
    tangent = np.tan(np.pi * frequency / step_rate)
    for k in range(0, len(factors), 2):
        sign = -1.0 if k % FACTOR == 0 else 1.0
        angle, damping = math.pi * math.exp(factors[k]) / step_rate, math.exp(factors[k + 1])
        v = tangent / math.tan(angle)
        damped = (2.0 * damping * v) ** 2
        square = (1.0 - v**2) ** 2 + damped
        total += sign * np.log(square)
        by_place = -4.0 * v**2 * (1.0 - v**2) + 2.0 * damped
        gradient[:, k] = -sign * by_place / square * (2.0 * angle / math.sin(2.0 * angle))
        gradient[:, k + 1] = sign * 2.0 * damped / square
    return total, gradient


def _new_factors(parameters: Floats, data: PathSpectra) -> Iterator[Floats]:
    """Yield a resonance or an antiresonance of each width where the smoothed residual is largest."""
    modelled, share = _evaluated(parameters, data)
    weight = (share / data.deviation) ** 2
    total = np.maximum(weight.sum(axis=0), 1e-12)
    residual = np.sum(weight * (data.measured - modelled) / np.maximum(share, 0.2), axis=0) / total
    for width, damping in WIDTHS:
        smooth = _smoothed(residual, width)
        at = int(np.argmax(np.abs(smooth) * np.sqrt(_smoothed(total, width))))
        frequency, sharp = math.log(float(data.frequency[at])), math.log(damping)
        wide = sharp + 0.5 * float(np.clip(abs(smooth[at]), 0.5, 4.0))
        yield np.array([frequency, sharp, frequency, wide] if smooth[at] > 0.0 else [frequency, wide, frequency, sharp])


def _smoothed(values: Floats, width: int) -> Floats:
    """Return running means; at the ends, of what is there."""
    width = min(width, len(values))
    kernel = np.ones(width)
    return np.convolve(values, kernel, "same") / np.convolve(np.ones(len(values)), kernel, "same")
