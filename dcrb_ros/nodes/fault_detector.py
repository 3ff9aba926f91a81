"""The fault detector node: subscribes to the waveform, publishes diagnoses."""

from __future__ import annotations

import sys

from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.messages.encoder import diagnosis_messages
from dcrb_ros.messages.topics import DETECTED, SENSOR, VIBRATION
from dcrb_ros.nodes.base import BenchNode
from dcrb_ros.nodes.detector_input import DetectorInput, Response
from dcrb_ros.nodes.programs import main
from dcrb_ros.nodes.publisher import Publisher
from dcrb_ros.nodes.ros import run_node


class FaultDetectorNode(BenchNode):
    """Passes messages to the detector and publishes its diagnoses."""

    def __init__(self) -> None:
        """Subscribe.

        Raises:
            Refusal: the parameters are invalid.
        """
        super().__init__("fault_detector")
        self._input, self._verdict = DetectorInput(self.declare(DetectorParameters)), ""
        self._publisher = Publisher(self, DETECTED)
        self.subscribe(SENSOR, lambda data: self._publish(self._input.sensor(data)))
        self.subscribe(VIBRATION, lambda data: self._publish(self._input.block(data)))

    def _publish(self, response: Response) -> None:
        if response.information:
            self.get_logger().info(response.information)
        if response.warning:
            self.get_logger().warning(response.warning)
        for diagnosis in response.diagnoses:
            self._publisher.write_messages(diagnosis_messages(diagnosis))
            if diagnosis.verdict != self._verdict:
                self._verdict = diagnosis.verdict
                self.get_logger().info(f"{self._verdict} at {diagnosis.time:.2f} s: {diagnosis.reason}")


def run(arguments: list[str]) -> int:
    """Run the node until a termination signal arrives; return the exit status."""
    return run_node(FaultDetectorNode, arguments)


if __name__ == "__main__":
    main("fault_detector", sys.argv[1:])
