"""The squared envelope spectrum of a signal, over frequency or, by order tracking, over orders of the shaft."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dcrb_ros.bearing.fault_lines import BearingLike
from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.bearing.waveform import Signal, Waveform, signal_of
from dcrb_ros.diagnosis.demodulation import NYQUIST_SHARE, Band, Demodulator
from dcrb_ros.diagnosis.order_spectrum import order_spectra
from dcrb_ros.diagnosis.order_tracking import LEAST_TURNS, bin_edges, bin_means, forward_turns, reverses
from dcrb_ros.schema.arguments import checked_arguments, numbers, of_type
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.numbers import finite_number
from dcrb_ros.schema.refusal import Refusal

DEFAULT_BAND = (2000.0, 20000.0)
"""Band of the envelope [Hz]: above the mode of the housing, below the filter of the converter."""
LEAST_LINES = 64
"""Least product of the duration of a signal and the width of its band, about the number of lines of the spectrum [-]."""


@dataclass(frozen=True, eq=False, repr=False)
class EnvelopeSpectrum:
    """Squared envelope spectrum of one band; arrays of shape (lines,), equally spaced from 0."""

    frequency: Floats
    """Frequency [Hz]; of a tracked spectrum the order times the mean shaft frequency."""
    order: Floats
    """Multiples of the shaft frequency [-]; NaN where that is unknown."""
    amplitude: Floats
    """One-sided amplitude of the squared envelope [(m/s^2)^2]."""
    mean: float
    """Mean of the squared envelope, twice the power in the band [(m/s^2)^2]."""
    band: tuple[float, float]
    """Edges of the band [Hz]."""
    shaft_frequency: float
    """Mean frequency of the shaft [Hz]; NaN without a shaft angle."""
    orders: Orders
    """Characteristic orders of the bearing; NaN where it is unknown."""
    tracked: bool
    """Whether the envelope was resampled over the angle of the shaft."""

    def __repr__(self) -> str:
        axis = f"orders up to {self.order[-1]:.4g}" if self.tracked else f"frequencies up to {self.frequency[-1]:.4g} Hz"
        return f"<EnvelopeSpectrum: {len(self.amplitude)} lines, {axis}, of the band from {Band(*self.band)}>"

    def at(self, order: npt.ArrayLike) -> Floats:
        """Return the largest amplitude within two lines of each order, shape like ``order`` [(m/s^2)^2].

        Raises
        ------
        Refusal
            An order outside the spectrum, or a spectrum without orders, because the speed is unknown.
        """
        if math.isnan(self.order[-1]):
            raise Refusal("the spectrum has no orders, for the speed is unknown: use at_frequency, or give shaft_angle")
        return self._nearest("order", order, self.order)

    def at_frequency(self, frequency: npt.ArrayLike) -> Floats:
        """Return the largest amplitude within two lines of each frequency [Hz], shape like ``frequency`` [(m/s^2)^2].

        Raises
        ------
        Refusal
            A frequency outside the spectrum.
        """
        return self._nearest("frequency", frequency, self.frequency)

    def _nearest(self, name: str, given: npt.ArrayLike, axis: Floats) -> Floats:
        """Return the largest of the five lines around each place on an axis."""
        numbers(name, given)
        wanted = np.asarray(given)
        if wanted.dtype.kind not in "iuf":
            raise Refusal(f"{name} = {given!r} is not a number")
        outside = wanted[~((wanted >= 0.0) & (wanted <= axis[-1]))]
        if outside.size:
            unit = "" if name == "order" else " Hz"
            raise Refusal(f"{name} {outside.flat[0]:g}{unit} is outside 0 .. {axis[-1]:g}{unit}")
        near = np.clip(np.rint(wanted / axis[1]).astype(np.int64)[..., None] + np.arange(-2, 3), 0, len(self.amplitude) - 1)
        return np.asarray(self.amplitude[near].max(axis=-1), np.float64)


@checked_arguments(order_tracking=of_type(bool, np.bool_, type(None)))
def envelope_spectrum(
    signal: Signal | npt.ArrayLike,
    sampling_rate: float | None = None,
    *,
    band: tuple[float, float] | None = None,
    shaft_angle: npt.ArrayLike | None = None,
    bearing: BearingLike | None = None,
    order_tracking: bool | None = None,
) -> EnvelopeSpectrum:
    """Return the squared envelope spectrum of a signal in one band.

    The signal is band-passed and demodulated (analytic signal), the squared magnitudes of all axes are added, and their spectrum
    is taken with a Hann window. With order tracking the squared envelope is first resampled over the angle of the shaft, so that a
    changing speed does not smear the lines. Randall and Antoni 2011, "Rolling element bearing diagnostics - A tutorial".

    Parameters
    ----------
    signal
        A `SimulationResult`, `Recording` or `Waveform` without lost samples, or accelerations of shape (samples, axes) or (samples,)
        [m/s^2].
    sampling_rate
        Sampling rate of plain arrays [Hz].
    band
        Edges of the band [Hz]; by default 2 kHz to 20 kHz, or to 0.45 of the sampling rate where that is less.
    shaft_angle
        Rotation of the inner ring beside plain arrays, shape (samples,) [rad].
    bearing
        Geometry or orders of the bearing beside plain arrays; with it `plot_envelope_spectrum` draws the fault lines.
    order_tracking
        Whether to resample over the angle of the shaft; by default wherever there is a shaft angle.

    Returns
    -------
    EnvelopeSpectrum
        Frequency [Hz], order [-] and amplitude [(m/s^2)^2].

    Raises
    ------
    Refusal
        Lost samples, a signal shorter than 64 over the width of the band, a band outside 0 .. half the sampling rate, or order
        tracking without a shaft angle, over fewer than 4 turns or with a shaft that turns back.

    Examples
    --------
    A tone at 5 kHz whose amplitude varies 100 times a second has a line at 100 Hz. Its squared envelope is
    (1 + 0.5 cos)^2 = 1.125 + cos + 0.125 cos(2 ...), so the amplitude of that line is 1:

    >>> import numpy as np
    >>> import dcrb_ros
    >>> t = np.arange(51200) / 51200.0
    >>> x = (1.0 + 0.5 * np.cos(2 * np.pi * 100 * t)) * np.sin(2 * np.pi * 5000 * t)
    >>> spectrum = dcrb_ros.envelope_spectrum(x, 51200, band=(4000, 6000))
    >>> peak = np.argmax(spectrum.amplitude)
    >>> float(spectrum.frequency[peak].round()), float(spectrum.amplitude[peak].round(2))
    (100.0, 1.0)
    """
    waveform, axes = _waveform(signal, sampling_rate, shaft_angle, bearing)
    edges = _checked_band(band, waveform.sampling_rate)
    tracked = waveform.tracked if order_tracking is None else order_tracking
    rate, samples = waveform.sampling_rate, len(waveform)
    if waveform.duration * (edges[1] - edges[0]) < LEAST_LINES:
        least = math.ceil(LEAST_LINES * rate / (edges[1] - edges[0]))
        raise Refusal(f"{samples} samples are too few for the band of {Band(*edges)}: give at least {least}, or a wider band")
    bank = Demodulator((Band(*edges),), rate, samples)
    ((positions, squared),) = bank.squared_envelopes(waveform.acceleration[:, :axes])
    width = edges[1] - edges[0]
    shaft_frequency = waveform.shaft_frequency
    # Bins half as wide as a period of the fastest change that the band can carry, in seconds or in turns.
    if tracked:
        turns = _forward_turns(waveform)
        per_unit = max(1, math.ceil(width / shaft_frequency))
        borders = np.interp(bin_edges(0.0, float(turns[-1]), per_unit), turns, np.arange(samples, dtype=np.float64))
    else:
        per_unit = max(1, math.ceil(width))
        borders = bin_edges(0.0, (samples - 1) / rate, per_unit) * rate
    binned = bin_means(positions, squared, borders)
    ((lines, amplitude, mean),) = order_spectra(binned[None, :], np.zeros(len(binned), np.bool_), per_unit)
    unit = shaft_frequency if tracked else 1.0
    frequency = lines * unit
    order = lines if tracked else lines / shaft_frequency if shaft_frequency > 0.0 else np.full(len(lines), np.nan)
    return EnvelopeSpectrum(frequency, order, amplitude.astype(np.float64), mean, edges, shaft_frequency, waveform.orders, tracked)


def _waveform(
    signal: Signal | npt.ArrayLike, sampling_rate: float | None, shaft_angle: npt.ArrayLike | None, bearing: BearingLike | None
) -> tuple[Waveform, int]:
    """Return the waveform of a signal, and how many of its columns count."""
    waveform = signal_of(signal, sampling_rate, shaft_angle=shaft_angle, bearing=bearing).waveform()
    axes = 1 if not isinstance(signal, Signal) and np.ndim(signal) == 1 else waveform.acceleration.shape[1]
    if not np.isfinite(waveform.acceleration).all():
        raise Refusal("the acceleration has values that are not finite: leave these samples out, and take the stretch before or after them")
    gap = np.flatnonzero(np.diff(waveform.index) != 1)
    if len(gap):
        at = waveform.time[gap[0]]
        raise Refusal(f"{waveform!r} lacks samples after {at:.4f} s: take a stretch without gaps, such as .between(stop={at:.4f})")
    return waveform, axes


def _checked_band(band: tuple[float, float] | None, rate: int) -> tuple[float, float]:
    """Return the edges of a band [Hz], or refuse them."""
    low, high = _edges((DEFAULT_BAND[0], min(DEFAULT_BAND[1], NYQUIST_SHARE * rate)) if band is None else band)
    if not 0.0 < low < high <= 0.5 * rate:
        raise Refusal(
            f"band = ({low:g}, {high:g}) Hz is not within 0 .. {0.5 * rate:g} Hz, half the sampling rate: give (low, high) with low < high"
        )
    return low, high


def _edges(band: Sequence[float]) -> tuple[float, float]:
    """Return the two edges of a band [Hz]."""
    if isinstance(band, str) or not isinstance(band, (Sequence, np.ndarray)) or len(band) != 2:
        raise Refusal(f"band = {band!r} is not a pair of frequencies: give (low, high) in Hz")
    return finite_number("the lower edge of the band,", band[0], "Hz"), finite_number("the upper edge of the band,", band[1], "Hz")


def trackable(waveform: Waveform) -> bool:
    """Return whether a waveform has a shaft angle that turns far enough in one direction for order tracking."""
    turns = waveform.turns if waveform.tracked else np.zeros(1)
    return bool(abs(turns[-1]) >= LEAST_TURNS and not reverses(turns))


def _forward_turns(waveform: Waveform) -> Floats:
    """Return the turns of the shaft since the first sample, counted forwards."""
    if not waveform.tracked:
        raise Refusal(f"{waveform!r} cannot be order-tracked: give shaft_angle [rad], or order_tracking=False for a spectrum in Hz")
    turns = waveform.turns
    if abs(turns[-1]) < LEAST_TURNS:
        raise Refusal(
            f"the shaft makes {abs(turns[-1]):.2g} turns where order tracking needs {LEAST_TURNS:g}: take a longer signal, "
            "or order_tracking=False for a spectrum in Hz"
        )
    if reverses(turns):
        raise Refusal("the shaft turns back within the signal: take a stretch in one direction, or order_tracking=False")
    return forward_turns(turns)
