"""Evidence that the rules of the detector evaluate: samples, levels of bands, and squared envelope spectra."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.diagnosis.demodulation import Band
from dcrb_ros.diagnosis.line_search import NO_LINES, Comb, LineFamily, LineSearch, covered
from dcrb_ros.diagnosis.order_spectrum import OrderSpectrum
from dcrb_ros.diagnosis.wandering_lines import HALF_WIDTHS, humps
from dcrb_ros.diagnosis.window import SLOWEST
from dcrb_ros.schema.arrays import Floats

AVERAGED_HOPS = 4
"""Hops over which levels are averaged: their mean scatters by less than a decibel."""
BESIDE = 4.0
"""Orders of a spectrum beyond the highest line that are searched [-]: four neighbourhoods of the local mean."""
QUIET = 40.0
"""Power of a band below that of the loudest one from which it is no evidence [dB]: accelerometers are linear within 1 %, so that a quieter
band holds products of the loud ones."""
LEAST_SHARE = 0.03
"""Power of a band over that of the detector's band below which it is no evidence [-].

Impacts of a defect excite a structure at all frequencies. Healthy rollers strike the raceway, too, where they enter the load zone. These
strikes have up to a hundredth of the power."""
REFIT = 0.003
"""Relative change of the order of a family when the lines of another one are left out [-]."""
MOST_COVERED = 0.5
"""Share of the values of a hump that lines of another family may cover [-]: a median ignores less than half of the values."""
LEAST_SIGNAL = 0.03
"""Power of a signal relative to the noise that is taken where less is left [-]: the scatter of the noise of a hop."""
SAME_SPEED = 0.03
"""Relative change of the shaft frequency from which levels are not compared [-]."""


class BandEvidence:
    """The squared envelope spectrum of one band and the families of lines in it."""

    def __init__(self, band: Band, search: SharedSearch, number: int = 0) -> None:
        """Take the spectrum of that ``number`` among those that are searched together."""
        self.band, self.shared, self._number = band, search, number
        self.clusters: dict[LineFamily, tuple[float, float]] = {}
        """What `clusters_at_spin` has found for lines of the cage."""

    @property
    def spectrum(self) -> OrderSpectrum:
        """The whole spectrum."""
        return self.shared.spectra[self._number]

    @property
    def orders(self) -> Orders:
        """Characteristic orders of the bearing."""
        return self.shared.orders

    @property
    def step(self) -> float:
        """Distance of two values of the spectrum [orders]."""
        return self.shared.search.step

    def at(self, lines: npt.ArrayLike) -> Floats:
        """Return the squared modulation depth of ``lines`` [orders] without the noise, same shape; 0 above the range searched [-]."""
        return self.shared.search.at(lines, self._number)

    def largest(self, lines: npt.ArrayLike) -> Floats:
        """Return the squared modulation depth of ``lines`` [orders] with noise and harmonics of the shaft, same shape [-]."""
        return np.square(self.spectrum.lines(lines) / self.spectrum.mean) if self.spectrum.mean > 0.0 else np.zeros(np.shape(lines))

    def noise(self, lines: npt.ArrayLike) -> Floats:
        """Return the squared modulation depth up to which each of ``lines`` [orders] is noise, same shape [-]."""
        return self.shared.search.noise(lines, self._number)

    def hump(self, order: float) -> LineFamily:
        """Return the most significant hump near an ``order``, a line that wanders; `NO_LINES` without one."""
        return self.shared.humps(order)[self._number]

    def family(self, comb: Comb, slip: float | None = None) -> LineFamily:
        """Return the strongest family of a comb in this band within a ``slip``, by default the usual one [-], searched in all bands."""
        return self.shared.families(comb, slip)[self._number]

    def remainder(self, comb: Comb, family: LineFamily, explained: npt.ArrayLike) -> LineFamily:
        """Return what remains of a ``found`` family of a comb without the ``explained`` lines [orders].

        A hump, whose median ignores sharp lines, remains as long as they cover less than half of its middle.
        """
        searched = self.shared.search.spectra[self._number]
        if not family.lines:
            near = np.abs(searched.orders - family.order) <= HALF_WIDTHS[0] * self.orders.ftf
            return family if covered(searched, explained)[near].mean() < MOST_COVERED else NO_LINES
        return LineSearch(searched, without=covered(searched, explained)).best(comb._replace(order=family.order), REFIT)


class SharedSearch:
    """The families of lines in the spectra of several bands."""

    def __init__(self, spectra: Sequence[OrderSpectrum], orders: Orders, slip: float) -> None:
        """Look for lines within ``slip`` (relative) of the kinematic ``orders`` in ``spectra`` over the same orders."""
        self.spectra, self.orders, self.slip = spectra, orders, slip
        self._families: dict[tuple[Comb, float], list[LineFamily]] = {}
        self._humps: dict[float, list[LineFamily]] = {}

    @cached_property
    def search(self) -> LineSearch:
        """The spectra, prepared for the search."""
        highest = highest_searched(self.orders, self.slip)
        return LineSearch(*(spectrum.up_to(highest) for spectrum in self.spectra))

    def families(self, comb: Comb, slip: float | None = None) -> list[LineFamily]:
        """Return the strongest family of a comb in each spectrum within a ``slip`` [-], by default the usual one."""
        key = comb, self.slip if slip is None else slip
        if key not in self._families:
            self._families[key] = self.search.families(*key)
        return self._families[key]

    def humps(self, order: float) -> list[LineFamily]:
        """Return the most significant hump near an ``order`` in each spectrum."""
        if order not in self._humps:
            found = humps(self.search.squared_depth, self.search.step, order, self.orders.ftf, self.slip)
            self._humps[order] = [
                lines._replace(amplitude=lines.depth * spectrum.mean) for lines, spectrum in zip(found, self.spectra, strict=True)
            ]
        return self._humps[order]


def highest_searched(orders: Orders, slip: float) -> float:
    """Return the highest order of a spectrum that the search needs [-].

    The families end below six times BPFO, three times BPFI and 2 BSF with sidebands; the local mean needs what is beside them.
    """
    return (1.0 + slip) * max(6.0 * orders.bpfo, 3.0 * orders.bpfi + 2.0, 6.0 * orders.bsf + 1.0) + BESIDE


@dataclass(frozen=True)
class Evidence:
    """Evidence on the bearing at the end of a hop."""

    bands: Sequence[BandEvidence]
    """All bands; the first is `whole`, the last lies below it."""
    whole: Band
    """The band of the detector."""
    high: Band
    """Its upper quarter, which may be above the usable frequencies and then is not among the `bands`."""
    shaft_frequency: float
    """Mean over the window [Hz]."""
    interval: float
    """Time between two judgements [s]."""

    @property
    def orders(self) -> Orders:
        """Characteristic orders of the bearing."""
        return self.bands[0].orders

    @cached_property
    def loud(self) -> Sequence[BandEvidence]:
        """The bands that are not too quiet beside the loudest one, nor beside that of the detector, to tell anything about the bearing."""
        least = max(band.spectrum.mean for band in self.bands) * 10.0 ** (-QUIET / 10.0)
        within = max(least, LEAST_SHARE * max((band.spectrum.mean for band in self.bands if band.band == self.whole), default=0.0))
        return [band for band in self.bands if band.spectrum.mean >= (within if band.band.low >= self.whole.low else least)]

    @cached_property
    def within(self) -> Sequence[BandEvidence]:
        """Those of them that lie within the band of the detector."""
        return [band for band in self.loud if band.band.low >= self.whole.low]

    def depths(self, lines: npt.ArrayLike) -> Floats:
        """Return the modulation depth of ``lines`` [orders] together, without the noise, in all bands, shape (bands,) [-]."""
        searches = dict.fromkeys(band.shared for band in self.bands)
        return np.concatenate([np.sqrt(shared.search.at(lines, slice(None)).sum(axis=-1)) for shared in searches])


@dataclass(frozen=True)
class SampleEvidence:
    """The samples of a hop."""

    acceleration: Floats
    """Samples that arrived and are finite, shape (samples, axes) [m/s^2]."""
    count: int
    """Samples of the hop, with the missing ones."""
    not_finite: int
    """Samples that arrived but are not finite."""
    rate: int
    """Sampling rate [Hz]."""
    sensor_range: float
    """Range of the sensor [m/s^2], 0 if it is not known."""
    hops: int
    """Hops in a window."""
    frequency: float = 0.0
    """Shaft frequency [Hz], 0 if it is not known."""

    @cached_property
    def axes(self) -> list[tuple[str, Floats]]:
        """Name and samples of each axis; a signal of one axis, which is given as two equal ones, has one."""
        columns = np.ascontiguousarray(self.acceleration.T)
        single = len(columns) == 2 and np.array_equal(*columns)
        return list(zip("X" if single else "XYZ", columns, strict=False))


class Levels(NamedTuple):
    """Power of the bands, averaged over some hops."""

    level: Floats
    """Power, shape (bands,) [dB]."""
    change: Floats
    """Change since the first average at this speed, shape (bands,) [dB]."""
    fall: float
    """Fall of the power, mean over the bands, from the lowest of the first hops to the mean of the latest [dB]."""
    signal: Floats
    """Change of the power without the noise of the sensor, NaN in bands in which there was more noise than signal, shape (bands,) [dB]."""
    signal_fall: float
    """Fall of that power, mean over those bands, from the lowest of the first hops to the highest of the latest; NaN without bands [dB]."""


class LevelHistory:
    """Averages the power of bands over the latest hops at the same shaft frequency.

    A sensor has white noise, which adds N_k = n B_k to the power of a band of width B_k and stays when the signal falls. Its density n is
    at most the lowest density of power seen in any band so far, and equal to it as soon as one band holds nothing else.
    """

    def __init__(self, widths: npt.ArrayLike, exponent: float) -> None:
        """Take the ``widths`` of the bands, shape (bands,) [Hz], and the ``exponent`` of the speed by which powers are scaled."""
        self._widths, self._exponent = np.asarray(widths, np.float64), exponent
        self._density = math.inf
        """Density of the noise, scaled as the powers are at the present frequency [(m/s^2)^2/Hz]."""
        self._latest: deque[Floats] = deque(maxlen=AVERAGED_HOPS)
        self._first: Floats | None = None
        """Powers of the first hops, shape (hops, bands) [(m/s^2)^2]."""
        self._frequency = 0.0

    def restart(self) -> None:
        """Discard all hops."""
        self._latest.clear()
        self._first = None

    def add(self, powers: Floats, frequency: float) -> Levels | None:
        """Take the powers of a hop [(m/s^2)^2] at a shaft frequency [Hz]; return the average once there are enough hops.

        Nothing is compared at an unknown frequency, given as 0, or without power in some band.
        """
        if not np.all(powers > 0.0) or frequency <= 0.0:
            return None
        if abs(frequency - self._frequency) > SAME_SPEED * self._frequency:
            self.restart()
            self._density *= (max(self._frequency, SLOWEST) / max(frequency, SLOWEST)) ** (2.0 * self._exponent)
            self._frequency = frequency
        self._latest.append(powers)
        self._density = min(self._density, float(np.min(powers / self._widths)))
        if len(self._latest) < AVERAGED_HOPS:
            return None
        latest = np.array(self._latest)
        if self._first is None:
            self._first = latest
        first, last = _decibels(self._first), _decibels(latest)
        level = last.mean(axis=0)
        fall = float(first.mean(axis=1).min() - level.mean())
        return Levels(level, level - first.mean(axis=0), fall, *self._without_noise(self._first, latest))

    def _without_noise(self, first: Floats, latest: Floats) -> tuple[Floats, float]:
        """Return `Levels.signal` and `Levels.signal_fall` of hops of shape (hops, bands) [(m/s^2)^2]."""
        noise = self._density * self._widths
        heard = first.mean(axis=0) >= 2.0 * noise
        before, now = (_decibels(np.maximum(powers - noise, LEAST_SIGNAL * noise)) for powers in (first, latest))
        signal = np.where(heard, now.mean(axis=0) - before.mean(axis=0), np.nan)
        if not heard.any():
            return signal, math.nan
        return signal, float(before[:, heard].mean(axis=1).min() - now[:, heard].mean(axis=1).max())


def _decibels(powers: Floats) -> Floats:
    return np.asarray(10.0 * np.log10(powers), np.float64)


class LevelEvidence(NamedTuple):
    """The power of the latest hops in the quarters of the detector's band and in the band below it."""

    levels: Levels
    """Those of the quarters, the last is that of the band below."""
    third: int | None
    """Index of the third quarter, none if it is above the usable frequencies."""
