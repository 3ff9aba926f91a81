"""From messages to diagnoses, without ROS: a block that cannot be used is answered by a diagnosis with the reason."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import deque
from dataclasses import dataclass, replace
from typing import Any, Generic, TypeVar

import numpy as np

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.diagnosis.detector import check_parameters
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.thermal_detector import ThermalFaultDetector
from dcrb_ros.messages.cdr import FRAME
from dcrb_ros.messages.description import decode_entry, decode_frame, decode_range, decode_sensor
from dcrb_ros.messages.points import Vibration, decode_vibration
from dcrb_ros.messages.topics import AMBIENT_TEMPERATURE, OUTER_RING_TEMPERATURE, SENSOR
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.stream.diagnosis import Diagnosis

RATE_TOLERANCE = 0.01
"""Accepted relative difference between the spacing of the samples and the sampling rate."""
OUT_OF_ORDER = 1.0
"""Time by which a reading of the air may be later than one of the ring that arrives after it [s]."""
RATE_SPAN, RATE_ERROR = 2.0, 5e-4
"""Time over which the stamps of the blocks give a sampling rate [s], and its largest relative error that needs no warning [-]."""
EARLY_NS = 1_500_000_000
"""Signal kept until the description arrives [ns]: it is repeated every second, and the order of messages on two topics is undefined."""
MAX_EARLY, MAX_EARLY_BLOCKS = 1 << 22, 1 << 14
"""Samples and blocks kept until then at most."""

AMBIENT_AGE = 60.0
"""Time between a reading of the air and one of the bearing up to which they are compared [s]."""


Judgement = TypeVar("Judgement")
"""A diagnosis of a bearing or of a vehicle."""


@dataclass(frozen=True)
class Response(Generic[Judgement]):
    """The response to a message."""

    diagnoses: tuple[Judgement, ...] = ()
    information: str = ""
    """Sentence to log as information; empty for none."""
    warning: str = ""
    """Sentence to log as a warning; empty for none."""

    def log(self, log: Any) -> None:
        """Log the sentences."""
        if self.information:
            log.info(self.information)
        if self.warning:
            log.warning(self.warning)


class MessageInput(ABC, Generic[Judgement]):
    """Takes the readings of temperatures, and counts refusals."""

    def __init__(self) -> None:
        self._ambient: dict[str, list[tuple[float, float]]] = {}
        """Times [s] and temperatures [deg C] of the latest two readings of the air by box, that of a single bench without a name."""
        self._waiting: dict[str, tuple[float, float]] = {}
        """Time [s] and temperature [deg C] of a reading of the outer ring by box that waits for one of the air."""
        self.unpaired = 0
        """Readings of the outer ring that no reading of the air was near enough to."""
        self._stamped: dict[str, StampedRate] = {}
        """Sampling rate by the stamps of each box."""
        self._refused = 0

    def ambient(self, data: bytes, box: str = "") -> Response[Judgement]:
        """Take a reading of the air at a box."""
        try:
            time, temperature = 1e-9 * AMBIENT_TEMPERATURE.stamp(data), AMBIENT_TEMPERATURE.decoded(data)
            earlier = [reading for reading in self._ambient.get(box, []) if reading[0] < time]
            self._ambient[box] = [*earlier[-1:], (time, temperature)]
            if box in self._waiting and self._waiting[box][0] <= time:
                self._compare(box)
        except Refusal as refusal:
            return self.refuse(refusal)
        return Response()

    def temperature(self, data: bytes, box: str = "") -> Response[Judgement]:
        """Take a reading of the outer ring of a box.

        It is compared with the nearer one of the reading of the air before it and the next one, or with the one before it if the next one
        of the outer ring comes first.
        """
        try:
            time, temperature = 1e-9 * OUTER_RING_TEMPERATURE.stamp(data), OUTER_RING_TEMPERATURE.decoded(data)
            if box in self._waiting and self._waiting[box][0] < time:
                self._compare(box)
            self._waiting[box] = time, temperature
            at = self._ambient[box][-1][0] if box in self._ambient else -math.inf
            if time <= at <= time + OUT_OF_ORDER:
                self._compare(box)
            elif at > time:  # of a run before a reset
                del self._ambient[box]
        except Refusal as refusal:
            return self.refuse(refusal)
        return Response()

    def _compare(self, box: str) -> None:
        """Pass on the waiting reading of a box with the nearest one of the air, or count it if there is none within `AMBIENT_AGE`."""
        time, temperature = self._waiting.pop(box)
        near = [(abs(time - at), air) for at, air in self._ambient.get(box, []) if abs(time - at) <= AMBIENT_AGE]
        if near:
            self.take_temperature(box, time, temperature, min(near)[1])
        else:
            self.unpaired += 1

    def rate_warning(self, block: Vibration, rate: int, box: str = "") -> str:
        """Take the stamp of a block of a box; return what is wrong with the sampling rate [Hz] once it shows, otherwise nothing."""
        if box not in self._stamped or self._stamped[box].rate != rate:
            self._stamped[box] = StampedRate(rate)
        stamped = self._stamped[box]
        before = stamped.wrong
        stamped.add(block)
        return "" if before or not stamped.wrong else f"{box}: {stamped.wrong}" if box else stamped.wrong

    @abstractmethod
    def take_temperature(self, box: str, time: float, temperature: float, air: float) -> None:
        """Take the temperatures of outer ring and air [deg C] of a box at a time [s]."""

    def diagnoses_of(self, reason: str) -> tuple[Judgement, ...]:
        """Return the diagnoses that answer a refusal."""
        return ()

    def refuse(self, refusal: Refusal) -> Response[Judgement]:
        """Answer the first refusal, the second, the fourth and so on; count all."""
        self._refused += 1
        if self._refused & (self._refused - 1):
            return Response()
        reason = f"refused: {refusal} ({self._refused} so far)"
        return Response(self.diagnoses_of(reason), warning=reason)


class DetectorInput(MessageInput[Diagnosis]):
    """Creates a detector from the sensor description and passes it the blocks of the waveform."""

    def __init__(self, parameters: DetectorParameters) -> None:
        """Check the parameters, and wait for a description.

        Raises:
            Refusal: the parameters do not fit each other, or their baseline cannot be read.
        """
        super().__init__()
        check_parameters(parameters)
        self._parameters = parameters
        self._detector: ThermalFaultDetector | None = None
        self._description: tuple[int, Orders] | None = None
        self._lacking = f"blocks arrive, but no description on {SENSOR.name} with the rate and the bearing: publish it, latched"
        """Why there is no detector."""
        self._early: deque[Vibration] = deque()
        """Blocks that arrived before the description."""
        self._early_samples = 0
        self.frame = FRAME
        """Frame id of the sensor, as its description has it."""
        self._time = 0.0

    def sensor(self, data: bytes) -> Response[Diagnosis]:
        """Take a sensor description; process the blocks that arrived before it."""
        try:
            description, information = decode_sensor(data), ""
            if description != self._description:  # a change of the range alone does not restart the detector
                rate, orders = description
                self._detector = self._description = None  # if this one is refused, the bearing is no longer the former one
                detector = ThermalFaultDetector(orders, rate, self._parameters)
                detector.take_bearing(decode_entry(data, "bearing"))
                self._detector, self._description = detector, description
                information = f"watching a bearing at {rate} Hz, BPFO {orders.bpfo:.3f}, BPFI {orders.bpfi:.3f} orders"
            if self._detector is not None:
                self._detector.sensor_range = decode_range(data)
            self.frame = decode_frame(data)
            early, self._early, self._early_samples = self._early, deque(), 0
            responses = [self._update(block) for block in early]
            warning = next((response.warning for response in responses if response.warning), "")
            return Response(tuple(diagnosis for response in responses for diagnosis in response.diagnoses), information, warning)
        except Refusal as refusal:
            self._lacking = str(refusal)
            return self.refuse(refusal)

    def block(self, data: bytes) -> Response[Diagnosis]:
        """Take a block of the waveform."""
        try:
            block = decode_vibration(data)
            self._time = block.stamp_ns * 1e-9
            if self._detector is not None:
                return self._update(block)
            self._early.append(block)
            self._early_samples += len(block.shaft_angle)
            if self._drop_early():
                raise Refusal(self._lacking)
            return Response()
        except Refusal as refusal:
            return self.refuse(refusal)

    def take_temperature(self, box: str, time: float, temperature: float, air: float) -> None:
        """Pass a reading to the detector, once there is one."""
        if self._detector is not None:
            self._detector.take_temperature(time, temperature, air)

    def diagnoses_of(self, reason: str) -> tuple[Diagnosis, ...]:
        """Return a diagnosis without verdict."""
        return (Diagnosis(0, self._time, "waiting", reason),)

    def _drop_early(self) -> bool:
        """Drop the oldest of the early blocks where there are too many; return whether there were."""
        newest, excess = self._early[-1].stamp_ns, False
        while len(self._early) > 1 and (
            newest - self._early[0].stamp_ns > EARLY_NS or self._early_samples > MAX_EARLY or len(self._early) > MAX_EARLY_BLOCKS
        ):
            self._early_samples -= len(self._early.popleft().shaft_angle)
            excess = True
        return excess

    def _update(self, block: Vibration) -> Response[Diagnosis]:
        """Pass a block to the detector, or refuse it."""
        if self._detector is None:
            return Response()
        try:
            check_rate(block, self._detector.rate)
            warning = self.rate_warning(block, self._detector.rate)
            diagnosis = self._detector.update(block.first_index(self._detector.rate), block.acceleration, block.shaft_angle)
            return Response((self._remarked(diagnosis),) if diagnosis else (), warning=warning)
        except Refusal as refusal:
            return self.refuse(refusal)

    def _remarked(self, diagnosis: Diagnosis) -> Diagnosis:
        """Return a diagnosis that says how many temperatures were not used, and what is wrong with the sampling rate."""
        lonely = f"{self.unpaired} temperatures of the outer ring had no reading of the air within {AMBIENT_AGE:g} s, and were not used"
        remarks = [remark for remark in (lonely if self.unpaired else "", self._stamped[""].wrong) if remark]
        return replace(diagnosis, remarks=(*diagnosis.remarks, *remarks)) if remarks else diagnosis


class StampedRate:
    """Compares a sampling rate with that by the stamps of consecutive blocks.

    If the rate is too high by a thousandth, samples seem to be missing after every block, and all of the signal is useless.
    """

    def __init__(self, rate: int) -> None:
        """Prepare for a ``rate`` [Hz]."""
        self.rate = rate
        self._begin = self._end = 0
        """Stamp of the first block, and end of the latest one by the rate [ns]."""
        self._samples = self._latest = 0
        """Samples since the first block, and of the latest block."""
        self.wrong = ""
        """What is wrong with the rate by the stamps since samples were lost, once they span `RATE_SPAN`; empty for nothing."""

    def add(self, block: Vibration) -> None:
        """Take the stamp and the length of a block."""
        seconds, gap = 1e-9 * (block.stamp_ns - self._begin), 1e-9 * (block.stamp_ns - self._end) * self.rate
        lost = abs(gap) > 1.0 + RATE_TOLERANCE * self._latest  # or the signal has restarted
        if not lost and seconds >= RATE_SPAN:
            stamped, off = self._samples / seconds, abs(self._samples - seconds * self.rate)
            # Both ends of the span may jitter, by as much as passes for no loss.
            wrong = off > max(RATE_ERROR * self._samples, 2.0 * (1.0 + RATE_TOLERANCE * self._latest))
            self.wrong = (
                f"the stamps give {stamped:.0f} Hz, not the {self.rate} Hz of the description: publish the true rate" if wrong else ""
            )
        if lost:
            self._begin, self._samples = block.stamp_ns, 0
        self._latest = len(block.shaft_angle)
        self._samples += self._latest
        self._end = block.stamp_ns + round(1e9 * self._latest / self.rate)


def check_rate(block: Vibration, rate: int) -> None:
    """Refuse a block whose samples are not as far apart as a sampling rate [Hz] says.

    Raises:
        Refusal: the spacing differs by more than `RATE_TOLERANCE`.
    """
    if len(block.offsets_ns) < 2:
        return
    step = float(np.median(np.diff(block.offsets_ns.astype(np.int64))))
    if abs(step * rate - 1e9) > RATE_TOLERANCE * 1e9 + rate:
        raise Refusal(
            f"the samples are {step:.0f} ns apart, but {rate} Hz on {SENSOR.name} mean {1e9 / rate:.0f} ns: "
            "one of the two is wrong, publish a correct description"
        )
