"""The fault detector of an axle box, with evidence that the wheels and kinks of the rail hardly disturb."""

from __future__ import annotations

import copy
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.diagnosis.combination import Combination
from dcrb_ros.diagnosis.demodulation import Demodulator
from dcrb_ros.diagnosis.evidence import highest_searched
from dcrb_ros.diagnosis.heat_rule import HeatFinding
from dcrb_ros.diagnosis.order_spectrum import order_spectra
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.rule import BearingRule
from dcrb_ros.diagnosis.segments import Segment
from dcrb_ros.diagnosis.thermal_detector import ThermalFaultDetector
from dcrb_ros.diagnosis.vehicle.arrival import TurnEnvelopes
from dcrb_ros.diagnosis.vehicle.comparison import Judgement
from dcrb_ros.diagnosis.vehicle.parameters import VehicleDetectorParameters
from dcrb_ros.diagnosis.vehicle.turn_average import TurnAverage
from dcrb_ros.diagnosis.window import Window
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.stream.diagnosis import Diagnosis

BEFORE, AFTER = 2e-3, 0.012
"""Time before and after a kink of the rail in which an envelope shows it [s]: lateness of the other box, and the ringing of the structure.

With 8 to 30 ms, healthy bearings beside joints had 5 to 9 dB less evidence than with 0, and 12 ms left the least in the mean."""


DEPTHS = tuple(name for name in DetectorParameters.model_fields if name.endswith("_depth"))
"""Parameters of the rules that require a modulation depth."""


class OwnWindow(NamedTuple):
    """The squared envelopes of a window without what repeats in every turn."""

    envelopes: npt.NDArray[np.float32]
    """Shape (bands, bins) [(m/s^2)^2]."""
    missing: npt.NDArray[np.bool_]
    """Shape (bins,)."""
    times: Floats
    """Time of each bin since the start, shape (bins,) [s]."""
    frequency: float
    """Mean shaft frequency [Hz]."""
    seconds: float
    """Length of the signal [s]."""
    begin: float
    """As `TurnEnvelopes.begin` [turns]."""


class BoxDetector(ThermalFaultDetector):
    """A `ThermalFaultDetector` that also keeps a window of the signal without what repeats in every turn."""

    def __init__(self, orders: Orders, rate: int, comparison: VehicleDetectorParameters, parameters: DetectorParameters) -> None:
        """Prepare as `ThermalFaultDetector` with ``parameters``, and for the ``comparison`` with other boxes."""
        super().__init__(orders, rate, parameters)
        self._rare = comparison.rare
        usual, faint = ([fainter(rule, relief) for rule in self.rules] for relief in (0.0, comparison.relief))
        self._copied = [*usual, *faint]
        """Rules for the window without the wheels, which learn from it alone."""
        self._usual, self._faint = (Combination(rules, self.parameters.release_margin) for rules in (usual, faint))
        p = self.parameters
        demodulator = Demodulator(self._bands, self.rate, self._hop + 2 * self._margin, p.whitening, tones=False)
        bins = self._window.bins_per_turn
        self._rest = Window(demodulator, self.rate, self._hop, self._margin, bins, p.hops, p.speed_exponent)
        self._average = TurnAverage(self._hop, self._margin, p.hops)
        self._end = 0.0
        """Time at which the window ends [s]."""

    def take_bearing(self, bearing: object) -> None:
        """Take the geometry of the bearing; see `FaultDetector.take_bearing`."""
        super().take_bearing(bearing)
        for rule in self._copied:
            rule.take_bearing(bearing)

    def align(self, origin: int) -> None:
        """Begin hops as `Segmenter.align`."""
        self._segmenter.align(origin)

    def _diagnosed(self, segment: Segment) -> Diagnosis:
        """Take a segment into both windows."""
        if segment.first:
            self._rest.clear()
        self._rest.add(self._average.removed(segment), self.parameters.fastest, useless=False)
        self._end = (segment.last + 1 - self._margin) / self.rate
        return super()._diagnosed(segment)

    @property
    def troubles(self) -> tuple[HeatFinding, ...]:
        """Confirmed troubles of the bearing, by its temperature and by the level of its vibration."""
        judgement = self._monitor.judgement_at(self._end)
        found = judgement and judgement.confirmed, self._noise_finding if self._loud.confirmed else None
        return tuple(finding for finding in found if finding is not None)

    @property
    def flaw(self) -> str:
        """The flaw of the sensor, or nothing."""
        return self._sensor.flaw

    def own_window(self) -> OwnWindow | None:
        """Return the present window without the wheels; None without a judgement."""
        if self.flaw or self._what_is_missing() or not self._rest.tracked:
            return None
        seconds = len(self._rest) * self._hop / self.rate
        return OwnWindow(*self._rest.envelopes(), self._end - self._rest.ages(), self._rest.frequency, seconds, self._rest.begin)

    def judgement(self, window: OwnWindow, kinks: Floats) -> Judgement:
        """Return the evidence of a window without kinks of the rail and other rare impacts.

        The ringing after each of the ``kinks`` [s] counts as missing. Of the rest, no squared envelope counts with more than the value that
        it exceeds in the share ``rare`` of the time [-]. Kinks are rarer than the impacts of a damaged bearing, but larger.
        """
        missing = window.missing | _rings(window.times, kinks)
        missing = window.missing if missing.mean() > self.parameters.most_missing else missing
        most = np.quantile(window.envelopes[:, ~missing], 1.0 - self._rare, axis=1).astype(np.float32)
        highest = max(self._highest_order, highest_searched(self.orders, self.parameters.slip))
        limited = np.minimum(window.envelopes, most[:, None])
        spectra = order_spectra(limited, missing, self._rest.bins_per_turn, highest)
        evidence = self._evidence(spectra, window.frequency)
        if missing.any():
            limited = np.where(missing, limited[:, ~missing].mean(axis=1, dtype=np.float64).astype(np.float32)[:, None], limited)
        # The last band lies below that of the detector.
        envelopes = TurnEnvelopes(limited[:-1], self._rest.bins_per_turn, window.begin)
        return Judgement(evidence, self._usual.findings(evidence), self._faint.findings(evidence), envelopes)


def fainter(rule: BearingRule[Any], relief: float) -> BearingRule[Any]:
    """Return a copy of a rule that requires lines fainter by ``relief`` [dB]."""
    copied = copy.copy(rule)
    copied.p = rule.p.model_copy(update={name: getattr(rule.p, name) * 10.0 ** (-relief / 10.0) for name in DEPTHS})
    return copied


def _rings(times: Floats, kinks: Floats) -> npt.NDArray[np.bool_]:
    """Return which of some increasing times lie within the ringing of a kink [s]."""
    rings = np.zeros(len(times), np.bool_)
    for first, last in zip(*np.searchsorted(times, [kinks - BEFORE, kinks + AFTER]), strict=True):
        rings[first:last] = True
    return rings
