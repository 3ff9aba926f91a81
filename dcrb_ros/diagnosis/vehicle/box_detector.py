"""The fault detector of an axle box, with evidence that the wheels and kinks of the rail hardly disturb."""

from __future__ import annotations

from typing import Any

import numpy as np

from dcrb_ros.diagnosis.demodulation import Demodulator
from dcrb_ros.diagnosis.evidence import Evidence, highest_searched
from dcrb_ros.diagnosis.order_spectrum import order_spectra
from dcrb_ros.diagnosis.rule import Finding
from dcrb_ros.diagnosis.segments import Segment
from dcrb_ros.diagnosis.thermal_detector import ThermalFaultDetector
from dcrb_ros.diagnosis.vehicle.arrival import TurnEnvelopes
from dcrb_ros.diagnosis.vehicle.turn_average import TurnAverage
from dcrb_ros.diagnosis.window import Window
from dcrb_ros.schema.verdicts import Component
from dcrb_ros.stream.diagnosis import Diagnosis


class BoxDetector(ThermalFaultDetector):
    """A `ThermalFaultDetector` that also keeps a window of the signal without what repeats in every turn."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        """Prepare as `ThermalFaultDetector`."""
        super().__init__(*arguments, **options)
        p, hops = self.parameters, max(1, round(self.parameters.window / self.parameters.hop))
        demodulator = Demodulator(self._bands, self.rate, self._hop + 2 * self._margin, p.whitening)
        bins = self._window.bins_per_turn
        self._rest = Window(demodulator, self.rate, self._hop, self._margin, bins, hops, p.speed_exponent)
        self._average = TurnAverage(self._hop, self._margin, hops)

    def _diagnosed(self, segment: Segment) -> Diagnosis:
        """Take a segment into both windows."""
        if segment.first:
            self._rest.clear()
        self._rest.add(self._average.removed(segment), self.parameters.fastest, useless=False)
        return super()._diagnosed(segment)

    def own_evidence(self, share: float) -> tuple[Evidence, dict[Component, Finding], TurnEnvelopes] | None:
        """Return the evidence of the present window without the wheels, with rare impacts limited, the findings in it, and the envelopes.

        It is None without a judgement. No squared envelope counts with more than the value that it exceeds in a ``share`` of the time [-].
        Kinks of a rail are rarer than the impacts of a damaged bearing, but larger.
        """
        if self._sensor.flaw or self._what_is_missing() or not self._rest.tracked:
            return None
        envelopes, missing = self._rest.envelopes()
        most = np.quantile(envelopes[:, ~missing], 1.0 - share, axis=1).astype(np.float32)
        highest = max(self._highest_order, highest_searched(self.orders, self.parameters.slip))
        limited = np.minimum(envelopes, most[:, None])
        spectra = order_spectra(limited, missing, self._rest.bins_per_turn, highest)
        evidence = self._evidence(spectra, self._rest.frequency)
        # The last band lies below that of the detector.
        return evidence, self._combination.findings(evidence), TurnEnvelopes(limited[:-1], self._rest.bins_per_turn)
