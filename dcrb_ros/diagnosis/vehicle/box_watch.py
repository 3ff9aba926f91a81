"""One axle box under watch: its fault detector, and what it measures of wheels and track, hop by hop."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy.typing as npt

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.diagnosis.demodulation import NYQUIST_SHARE, Band
from dcrb_ros.diagnosis.heat_rule import HeatFinding
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.vehicle.box_detector import BoxDetector, OwnWindow
from dcrb_ros.diagnosis.vehicle.contact import Contact, ContactMonitor
from dcrb_ros.diagnosis.vehicle.parameters import VehicleDetectorParameters
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.stream.diagnosis import Diagnosis
from dcrb_ros.stream.vehicle_description import BoxDescription


@dataclass(frozen=True)
class BoxHop:
    """What one box concluded at the end of a hop."""

    diagnosis: Diagnosis
    """The diagnosis of the box by itself."""
    own: OwnWindow | None
    """The window to be judged without wheels and kinks; None without a judgement of the bearing."""
    contact: Contact | None
    """None while the window begins anew."""
    troubles: tuple[HeatFinding, ...]
    """Confirmed troubles of the bearing; the diagnosis has them beside lines that may be those of another box."""
    flaw: str
    """The flaw of the sensor, or nothing; the diagnosis lacks it beside a trouble."""

    @property
    def index(self) -> int:
        """Index of the last sample of the hop."""
        return self.diagnosis.index


class BoxWatch:
    """Takes the blocks of one box, and keeps the hops that have not been compared yet."""

    def __init__(self, box: BoxDescription, rate: int, parameters: VehicleDetectorParameters, box_parameters: DetectorParameters) -> None:
        """Prepare for the bearing of a box, sampled at ``rate`` [Hz]."""
        self.name, self.detector = box.name, BoxDetector(Orders.from_dict(box.orders), rate, parameters, box_parameters)
        self.detector.take_bearing(box.bearing)
        self.detector.sensor_range = box.sensor_range
        p, q = box_parameters, parameters
        usable = NYQUIST_SHARE * rate
        wheel, kink = Band(q.wheel_low, min(q.wheel_high, usable)), Band(q.kink_low, min(q.kink_high, usable))
        if wheel.low >= wheel.high or kink.low >= kink.high:
            raise Refusal(
                f"the bands of wheels and kinks, {q.wheel_low:g} to {q.wheel_high:g} Hz and {q.kink_low:g} to {q.kink_high:g} Hz, are "
                f"empty below {usable:g} Hz, the usable part of the sampling rate: change them or sample faster"
            )
        self._monitor = ContactMonitor(rate, p.hop_samples(rate), p.hops, (wheel, kink), p.gap_samples(rate), q.event)
        self._contacts: deque[Contact] = deque(maxlen=4)
        self.hops: deque[BoxHop] = deque()
        """Hops that have not been compared yet."""
        self.reached = -1
        """Index of the last sample that arrived since the start or the last restart."""
        self.since = 0
        """Index of the last sample of the last hop, or of the first sample since the start or the last restart."""
        self.missed: Counter[str] = Counter()
        """Samples of each other box that have arrived since the last one of this box."""

    def align(self, origin: int) -> None:
        """Begin hops as `Segmenter.align`, so that those of all boxes are of the same samples."""
        self.detector.align(origin)
        self._monitor.align(origin)

    def take(self, index: int, acceleration: npt.NDArray[Any], shaft_angle: npt.NDArray[Any] | None) -> bool:
        """Take samples, at most as many as a hop has; return whether the signal restarts with them."""
        restarts = self.detector.restarts
        diagnosis = self.detector.update(index, acceleration, shaft_angle)
        self._contacts.extend(self._monitor.add(index, acceleration, shaft_angle))
        restarted = self.detector.restarts > restarts
        if restarted:
            self.forget()
        if self.reached < 0:
            self.since = index
        self.reached = max(self.reached, index + len(acceleration) - 1)
        if diagnosis is not None:
            contact = next((contact for contact in reversed(self._contacts) if contact.end == diagnosis.index), None)
            self.since = diagnosis.index
            self.hops.append(BoxHop(diagnosis, self.detector.own_window(), contact, self.detector.troubles, self.detector.flaw))
        return restarted

    def forget(self) -> None:
        """Discard what has not been compared yet: its indices are of a time before a restart."""
        self.hops.clear()
        self.reached = -1


def boxes_apart(watches: Mapping[str, BoxWatch], patience: int, rate: int) -> dict[str, str]:
    """Return the boxes whose samples arrive, but differ in time by more than a ``patience`` [samples] from most others, with the reason.

    A box from which nothing has arrived for as long is silent and has no vote; ``rate`` is the sampling rate [Hz].
    """
    reached = {
        name: watch.reached for name, watch in watches.items() if watch.reached >= 0 and max(watch.missed.values(), default=0) <= patience
    }

    def votes(index: int) -> int:
        return sum(abs(index - other) <= patience for other in reached.values())

    most = max(reached.values(), key=lambda index: (votes(index), index), default=0)
    return {
        name: f"its samples are {abs(index - most) / rate:.1f} s {'behind' if index < most else 'ahead of'} those of the others"
        for name, index in reached.items()
        if abs(index - most) > patience
    }
