"""The shipped detector as a family of detectors: its default parameters, and others of a few of them."""

from __future__ import annotations

from typing import Any

import numpy.typing as npt

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.diagnosis.detector import FaultDetector
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.stream.diagnosis import Diagnosis

VARIANTS: dict[str, dict[str, object]] = {
    "shipped detector": {},
    "shipped detector, fixed band": {"band": "fixed"},
    "shipped detector, no whitening": {"whitening": 0.0},
    "shipped detector, window of 2 s": {"window": 2.0},
}
"""Parameters of each member; the first has the defaults."""


class ShippedDetector:
    """The shipped detector with some of its parameters."""

    def __init__(self, orders: Orders, rate: int, **settings: Any) -> None:
        """Make a detector of `FaultDetector`'s kind; ``settings`` are fields of `DetectorParameters`."""
        self._detector = FaultDetector(orders, rate, DetectorParameters(**settings))

    def update(self, index: int, acceleration: npt.NDArray[Any], shaft_angle: npt.NDArray[Any]) -> Diagnosis | None:
        """Process a block; see `FaultDetector.update`."""
        return self._detector.update(index, acceleration, shaft_angle)
