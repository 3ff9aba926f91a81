"""What the fault detector node makes of messages, without ROS: every block that it cannot use is answered by a diagnosis that says why."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from dcrb_ros.bearing.kinematics import Orders
from dcrb_ros.diagnosis.detector import Diagnosis, FaultDetector
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.messages.description import decode_range, decode_sensor
from dcrb_ros.messages.points import Vibration, decode_vibration
from dcrb_ros.messages.topics import SENSOR
from dcrb_ros.runtime.refusal import Refusal

RATE_TOLERANCE = 0.01
"""Departure of the samples' times from the sampling rate that is believed, relative."""
HELD = 50
"""Blocks kept for a description that comes after them, one second by default: topics have no order among each other."""


@dataclass(frozen=True)
class Said:
    """What comes of a message."""

    diagnoses: tuple[Diagnosis, ...] = ()
    news: str = ""
    complaint: str = ""


class Hearing:
    """The detector behind the messages: made by the sensor's description, fed by the blocks."""

    def __init__(self, parameters: DetectorParameters) -> None:
        self._parameters = parameters
        self._detector: FaultDetector | None = None
        self._about: tuple[int, Orders] | None = None
        self._held: deque[Vibration] = deque(maxlen=HELD)
        self._refused = 0
        self._time = 0.0

    def sensor(self, data: bytes) -> Said:
        """Take the sensor's description, and the blocks that came before it."""
        try:
            about = decode_sensor(data)
            if about != self._about:
                rate, orders = about
                self._detector = FaultDetector(orders, rate, self._parameters)
                self._about = about
                news = f"watching a bearing at {rate} Hz, BPFO {orders.bpfo:.3f}, BPFI {orders.bpfi:.3f} orders"
            else:
                news = ""  # another range of the sensor is nothing to begin anew for
            if self._detector is not None:
                self._detector.sensor_range = decode_range(data)
            told = [self._judge(self._held.popleft()) for _ in range(len(self._held))]
            complaint = next((said.complaint for said in told if said.complaint), "")
            return Said(tuple(diagnosis for said in told for diagnosis in said.diagnoses), news, complaint)
        except Refusal as refusal:
            return self._refuse(refusal)

    def block(self, data: bytes) -> Said:
        """Take a block of the waveform."""
        try:
            block = decode_vibration(data)
            self._time = block.stamp_ns * 1e-9
            if self._detector is not None:
                return self._judge(block)
            full = len(self._held) == HELD
            self._held.append(block)
            if full:
                raise Refusal(f"blocks come, but no description on {SENSOR.name} that tells the rate and the bearing: publish it, latched")
            return Said()
        except Refusal as refusal:
            return self._refuse(refusal)

    def _judge(self, block: Vibration) -> Said:
        """Give a block to the detector, or refuse it."""
        if self._detector is None:
            return Said()
        try:
            _check_rate(block, self._detector.rate)
            diagnosis = self._detector.update(block.first_index(self._detector.rate), block.acceleration, block.shaft_angle)
            return Said((diagnosis,) if diagnosis else ())
        except Refusal as refusal:
            return self._refuse(refusal)

    def _refuse(self, refusal: Refusal) -> Said:
        """Say the first refusals of a series, then fewer and fewer; all are counted."""
        self._refused += 1
        if self._refused & (self._refused - 1):
            return Said()
        words = f"{refusal} ({self._refused} so far)"
        return Said((Diagnosis(0, self._time, "waiting", f"refused: {words}"),), complaint=words)


def _check_rate(block: Vibration, rate: int) -> None:
    if len(block.offsets_ns) < 2:
        return
    step = float(np.median(np.diff(block.offsets_ns.astype(np.int64))))
    if abs(step * rate - 1e9) > RATE_TOLERANCE * 1e9 + rate:
        raise Refusal(
            f"samples come every {step:.0f} ns where {rate} Hz on {SENSOR.name} mean {1e9 / rate:.0f} ns: "
            "one of them is wrong, describe the sensor anew"
        )
