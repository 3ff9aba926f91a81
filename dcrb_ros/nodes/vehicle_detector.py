"""The vehicle detector node: subscribes to all axle boxes of a vehicle, compares them, and publishes verdicts on its parts."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from typing import Any

from dcrb_ros.messages.joints import encode_joints
from dcrb_ros.messages.topics import AMBIENT_TEMPERATURE, ENVELOPE_SPECTRUM, OUTER_RING_TEMPERATURE, SENSOR, VIBRATION, Message, Topic
from dcrb_ros.messages.topics.vehicle import VEHICLE_DESCRIPTION, VEHICLE_DETECTED, VEHICLE_DIAGNOSIS, VEHICLE_INDICATORS
from dcrb_ros.messages.vehicle import BASE, encode_vehicle_diagnosis
from dcrb_ros.nodes.base import BenchNode
from dcrb_ros.nodes.detector_input import Response
from dcrb_ros.nodes.programs import main
from dcrb_ros.nodes.publisher import Publisher
from dcrb_ros.nodes.ros import own_arguments, run_node
from dcrb_ros.nodes.vehicle_detector_input import VehicleDetectorInput, VehicleDetectorSettings
from dcrb_ros.stream.vehicle_diagnosis import VehicleDiagnosis


class VehicleDetectorNode(BenchNode):
    """Compares the boxes that the description of the vehicle names."""

    def __init__(self, settings: VehicleDetectorSettings | None = None) -> None:
        """Subscribe to the description, with ``settings``, by default those given to the node by ROS.

        Raises:
            Refusal: the settings are invalid.
        """
        super().__init__("vehicle_detector")
        self._input = VehicleDetectorInput(self.declare(VehicleDetectorSettings, adjust=lambda given: settings or given))
        self.watch_publishers(VEHICLE_DIAGNOSIS)
        self._publisher, self._spectra = Publisher(self, VEHICLE_DETECTED), Publisher(self, ())
        """Verdicts on the vehicle, and envelope spectra of its boxes."""
        self._boxes: tuple[str, ...] = ()
        self._receivers: list[Any] = []
        self._verdicts: dict[str, str] = {}
        self.subscribe(VEHICLE_DESCRIPTION, self._describe)
        self.log_wait(VEHICLE_DESCRIPTION)

    def close(self) -> None:
        """Leave the topics."""
        self._publisher.close()
        self._spectra.close()

    def _describe(self, data: bytes) -> None:
        self._respond(self._input.describe(data))
        description = self._input.description
        names = tuple(box.name for box in description.boxes) if description is not None else ()
        if names == self._boxes:
            return
        for subscription in self._receivers:
            self.destroy_subscription(subscription)
        self._boxes = names
        self._spectra.close()
        self._spectra = Publisher(self, [ENVELOPE_SPECTRUM.below(name) for name in names])
        # The first box last: the simulator counts the subscribers to its waveform before it sends a block.
        self._receivers = [
            self._receive(name, topic, take)
            for name in reversed(names)
            for topic, take in (
                (SENSOR, self._input.sensor),
                (AMBIENT_TEMPERATURE, self._input.ambient),
                (OUTER_RING_TEMPERATURE, self._input.temperature),
                (VIBRATION, self._input.block),
            )
        ]

    def _receive(self, name: str, topic: Topic, take: Callable[[bytes, str], Response[VehicleDiagnosis]]) -> Any:
        return self.subscribe(topic.below(name), lambda data: self._respond(take(data, name)))

    def _respond(self, response: Response[VehicleDiagnosis]) -> None:
        response.log(self.get_logger())
        for diagnosis in response.diagnoses:
            self._publish(diagnosis)

    def _publish(self, diagnosis: VehicleDiagnosis) -> None:
        time_ns, indicators = diagnosis.time_ns, diagnosis.indicators
        self._publisher.write_messages(
            [
                Message(VEHICLE_INDICATORS, time_ns, encode_joints(time_ns, list(indicators), list(indicators.values()), frame=BASE)),
                Message(VEHICLE_DIAGNOSIS, time_ns, encode_vehicle_diagnosis(diagnosis)),
            ]
        )
        self._spectra.write_messages(spectra_of(diagnosis))
        for name, status in diagnosis.statuses.items():
            if status.verdict != self._verdicts.get(name, "waiting"):
                self.get_logger().info(f"{name}: {status.verdict} at {diagnosis.time:.2f} s: {status.reason}")
            self._verdicts[name] = status.verdict


def spectra_of(diagnosis: VehicleDiagnosis) -> Iterator[Message]:
    """Yield the envelope spectrum of each box that has one, as a bench's fault detector publishes it."""
    for name, box in diagnosis.boxes.items():
        topic = ENVELOPE_SPECTRUM.below(name)
        data = topic.encode(box, name)
        if data is not None:
            yield Message(topic, box.time_ns, data)


def run(arguments: list[str], parameters: VehicleDetectorSettings | None = None) -> int:
    """Run the node until a termination signal arrives; return the exit status."""
    parser = argparse.ArgumentParser(prog="vehicle_detector", description="The detector that compares the axle boxes of a vehicle.")
    own_arguments(parser, arguments)
    return run_node(lambda: VehicleDetectorNode(parameters), arguments)


if __name__ == "__main__":
    main("vehicle_detector", sys.argv[1:])
