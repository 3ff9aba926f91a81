"""From the messages of a vehicle to the diagnoses of the comparing detector, without ROS."""

from __future__ import annotations

from dataclasses import dataclass

from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.vehicle.detector import BoxBlock, VehicleDetector
from dcrb_ros.diagnosis.vehicle.parameters import VehicleDetectorParameters
from dcrb_ros.messages.points import decode_vibration
from dcrb_ros.messages.topics import AMBIENT_TEMPERATURE, OUTER_RING_TEMPERATURE
from dcrb_ros.messages.vehicle import decode_description
from dcrb_ros.nodes.detector_input import AMBIENT_AGE, check_rate
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.stream.vehicle_description import VehicleDescription
from dcrb_ros.stream.vehicle_diagnosis import VehicleDiagnosis


class VehicleDetectorSettings(VehicleDetectorParameters):
    """The parameters of the node: those of the comparison, and in `boxes` those of the fault detector of each box."""

    boxes: DetectorParameters = DetectorParameters()


@dataclass(frozen=True)
class VehicleResponse:
    """The response to a message."""

    diagnosis: VehicleDiagnosis | None = None
    information: str = ""
    """Sentence to log as information; empty for none."""
    warning: str = ""
    """Sentence to log as a warning; empty for none."""


class VehicleDetectorInput:
    """Creates a comparing detector from the description of the vehicle and passes it the blocks of the boxes."""

    def __init__(self, settings: VehicleDetectorSettings) -> None:
        self._settings = settings
        self._detector: VehicleDetector | None = None
        self._ambient: dict[str, tuple[float, float]] = {}
        """Time [s] and temperature [deg C] of the latest reading of the air at each box."""
        self._refused = 0

    @property
    def description(self) -> VehicleDescription | None:
        """The vehicle that is watched; None before its description has arrived."""
        return self._detector.description if self._detector is not None else None

    def describe(self, data: bytes) -> VehicleResponse:
        """Take a description of the vehicle; a new one replaces the detector."""
        try:
            description = decode_description(data)
            if description == self.description:
                return VehicleResponse()
            parameters = VehicleDetectorParameters(**self._settings.model_dump(exclude={"boxes"}))
            self._detector = VehicleDetector(description, parameters, self._settings.boxes)
        except Refusal as refusal:
            return self._refuse(refusal)
        names = ", ".join(box.name for box in description.boxes)
        return VehicleResponse(information=f"watching {names} at {description.sampling_rate} Hz")

    def block(self, box: str, data: bytes) -> VehicleResponse:
        """Take a block of the waveform of a box."""
        if self._detector is None:
            return VehicleResponse()
        try:
            block, rate = decode_vibration(data), self._detector.description.sampling_rate
            check_rate(block, rate)
            measured = BoxBlock(block.first_index(rate), block.acceleration, block.shaft_angle)
            return VehicleResponse(self._detector.add({box: measured}))
        except Refusal as refusal:
            return self._refuse(refusal)

    def ambient(self, box: str, data: bytes) -> VehicleResponse:
        """Take a reading of the air at a box."""
        try:
            self._ambient[box] = 1e-9 * AMBIENT_TEMPERATURE.stamp(data), AMBIENT_TEMPERATURE.decoded(data)
        except Refusal as refusal:
            return self._refuse(refusal)
        return VehicleResponse()

    def temperature(self, box: str, data: bytes) -> VehicleResponse:
        """Take a reading of the outer ring of a box; it is compared with the latest one of the air."""
        try:
            time, temperature = 1e-9 * OUTER_RING_TEMPERATURE.stamp(data), OUTER_RING_TEMPERATURE.decoded(data)
            at, air = self._ambient.get(box, (-AMBIENT_AGE - 1.0, 0.0))
            if self._detector is not None and abs(time - at) <= AMBIENT_AGE:
                self._detector.take_temperature(box, time, temperature, air)
        except Refusal as refusal:
            return self._refuse(refusal)
        return VehicleResponse()

    def _refuse(self, refusal: Refusal) -> VehicleResponse:
        """Warn of the first refusal, the second, the fourth and so on; count all."""
        self._refused += 1
        if self._refused & (self._refused - 1):
            return VehicleResponse()
        return VehicleResponse(warning=f"refused: {refusal} ({self._refused} so far)")
