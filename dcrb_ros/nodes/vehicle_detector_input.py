"""From the messages of a vehicle to the diagnoses of the comparing detector, without ROS."""

from __future__ import annotations

from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.vehicle.detector import BoxBlock, VehicleDetector, check_box_parameters
from dcrb_ros.diagnosis.vehicle.parameters import VehicleDetectorParameters
from dcrb_ros.messages.description import decode_range, decode_sensor
from dcrb_ros.messages.points import decode_vibration
from dcrb_ros.messages.vehicle import decode_description
from dcrb_ros.nodes.detector_input import MessageInput, Response, check_rate
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.stream.vehicle_description import VehicleDescription
from dcrb_ros.stream.vehicle_diagnosis import VehicleDiagnosis


class VehicleDetectorSettings(VehicleDetectorParameters):
    """The parameters of the node: those of the comparison, and in `boxes` those of the fault detector of each box."""

    boxes: DetectorParameters = DetectorParameters()


class VehicleDetectorInput(MessageInput[VehicleDiagnosis]):
    """Creates a comparing detector from the description of the vehicle and passes it the blocks of the boxes."""

    def __init__(self, settings: VehicleDetectorSettings) -> None:
        """Check the settings, and wait for a description.

        Raises:
            Refusal: the parameters of the boxes do not fit each other, or name a baseline, which is that of a single bearing.
        """
        super().__init__()
        check_box_parameters(settings.boxes)
        self._settings = settings
        self._detector: VehicleDetector | None = None
        self._lacking = ""
        """Why there is no detector: the refusal of the latest description; empty before one and while there is a detector."""

    @property
    def description(self) -> VehicleDescription | None:
        """The vehicle that is watched; None before its description has arrived."""
        return self._detector.description if self._detector is not None else None

    def describe(self, data: bytes) -> Response[VehicleDiagnosis]:
        """Take a description of the vehicle; a new one replaces the detector."""
        try:
            description = decode_description(data)
            if description == self.description:
                return Response()
            parameters = VehicleDetectorParameters(**self._settings.model_dump(exclude={"boxes"}))
            self._detector = None  # the former vehicle is no longer watched, whether this one is refused or not
            self._detector, self._lacking = VehicleDetector(description, parameters, self._settings.boxes), ""
        except Refusal as refusal:
            self._lacking = "" if self._detector is not None else str(refusal)
            return self.refuse(refusal)
        names = ", ".join(box.name for box in description.boxes)
        return Response(information=f"watching {names} at {description.sampling_rate} Hz")

    def sensor(self, data: bytes, box: str) -> Response[VehicleDiagnosis]:
        """Take the description of the sensor of a box, whose range may have changed since that of the vehicle."""
        try:
            decode_sensor(data)
            if self._detector is not None:
                self._detector.take_range(box, decode_range(data))
        except Refusal as refusal:
            return self.refuse(refusal)
        return Response()

    def block(self, data: bytes, box: str) -> Response[VehicleDiagnosis]:
        """Take a block of the waveform of a box."""
        if self._detector is None:
            return self.refuse(Refusal(self._lacking)) if self._lacking else Response()
        try:
            block, rate = decode_vibration(data), self._detector.description.sampling_rate
            check_rate(block, rate)
            measured = BoxBlock(block.first_index(rate), block.acceleration, block.shaft_angle)
            diagnosis = self._detector.add({box: measured})
            return Response((diagnosis,) if diagnosis else (), warning=self.rate_warning(block, rate, box))
        except Refusal as refusal:
            return self.refuse(refusal)

    def take_temperature(self, box: str, time: float, temperature: float, air: float) -> None:
        """Pass a reading to the detector, once there is one."""
        if self._detector is not None:
            self._detector.take_temperature(box, time, temperature, air)
