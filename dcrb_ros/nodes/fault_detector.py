"""The fault detector node: blocks in, verdicts out."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.messages.encoder import diagnosis_messages
from dcrb_ros.messages.topics import DETECTED, SENSOR, VIBRATION
from dcrb_ros.nodes.detector_input import Hearing, Said
from dcrb_ros.nodes.publisher import Publisher, message_class, qos
from dcrb_ros.nodes.ros import declare, running, spin
from dcrb_ros.runtime.exit_status import exit_status

if TYPE_CHECKING:
    from rclpy.node import Node


class DetectorWire:
    """The wires between the topics and the detector."""

    def __init__(self, node: Node, parameters: DetectorParameters) -> None:
        self.node, self._hearing, self._verdict = node, Hearing(parameters), ""
        self._publisher = Publisher(node, DETECTED)
        node.create_subscription(message_class(SENSOR), SENSOR.name, self._on_sensor, qos(SENSOR), raw=True)
        node.create_subscription(message_class(VIBRATION), VIBRATION.name, self._on_block, qos(VIBRATION), raw=True)

    def _on_sensor(self, data: bytes) -> None:
        self._tell(self._hearing.sensor(bytes(data)))

    def _on_block(self, data: bytes) -> None:
        self._tell(self._hearing.block(bytes(data)))

    def _tell(self, said: Said) -> None:
        if said.news:
            self.node.get_logger().info(said.news)
        if said.complaint:
            self.node.get_logger().warning(said.complaint)
        for diagnosis in said.diagnoses:
            self._publisher.write_messages(diagnosis_messages(diagnosis))
            if diagnosis.verdict != self._verdict:
                self._verdict = diagnosis.verdict
                self.node.get_logger().info(f"{self._verdict} at {diagnosis.time:.2f} s: {diagnosis.reason}")


def run(arguments: list[str]) -> int:
    """Run the node until a signal comes; return the exit status."""
    with running("fault_detector", arguments) as (node, told):
        DetectorWire(node, declare(node, DetectorParameters))
        spin(node, lambda: False, told)
    return 0


def main() -> None:
    """Run the node as a program."""
    sys.exit(exit_status("fault_detector", lambda: run(sys.argv[1:])))


if __name__ == "__main__":
    main()
