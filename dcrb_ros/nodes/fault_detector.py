"""The fault detector node: blocks in, verdicts out."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from dcrb_ros.diagnosis.detector import Diagnosis, FaultDetector
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.guard import guarded
from dcrb_ros.kinematics import Orders
from dcrb_ros.messages import decode_sensor, decode_vibration, diagnosis_messages
from dcrb_ros.nodes.ros import check_ros, create_node, declare, spin, stay_on_this_machine, stop_on_signals
from dcrb_ros.refusal import Refusal
from dcrb_ros.sinks.publisher import Publisher, message_class, qos
from dcrb_ros.topics import DETECTED, SENSOR, VIBRATION

if TYPE_CHECKING:
    from rclpy.node import Node


class DetectorWire:
    """The wires between the topics and the detector."""

    def __init__(self, node: Node, parameters: DetectorParameters) -> None:
        self.node, self._parameters = node, parameters
        self._detector: FaultDetector | None = None
        self._rate = 0
        self._orders: Orders | None = None
        self._verdict = ""
        self._refused = 0
        self._publisher = Publisher(node, DETECTED)
        node.create_subscription(message_class(SENSOR), SENSOR.name, self._on_sensor, qos(SENSOR), raw=True)
        node.create_subscription(message_class(VIBRATION), VIBRATION.name, self._on_block, qos(VIBRATION), raw=True)

    def _on_sensor(self, data: bytes) -> None:
        try:
            rate, orders = decode_sensor(bytes(data))
            if (rate, orders) == (self._rate, self._orders):
                return  # another range of the sensor is nothing to begin anew for
            self._orders = orders
            self._detector, self._rate = FaultDetector(orders, rate, self._parameters), rate
            self.node.get_logger().info(f"watching a bearing at {self._rate} Hz, BPFO {orders.bpfo:.3f}, BPFI {orders.bpfi:.3f} orders")
        except Refusal as refusal:
            self._complain(refusal)

    def _on_block(self, data: bytes) -> None:
        if self._detector is None:
            return
        try:
            block = decode_vibration(bytes(data))
            diagnosis = self._detector.update(block.first_index(self._rate), block.acceleration, block.shaft_angle)
        except Refusal as refusal:
            self._complain(refusal)
            return
        if diagnosis is not None:
            self._tell(diagnosis)

    def _tell(self, diagnosis: Diagnosis) -> None:
        self._publisher.write_messages(diagnosis_messages(diagnosis))
        if diagnosis.verdict != self._verdict:
            self._verdict = diagnosis.verdict
            self.node.get_logger().info(f"{diagnosis.verdict} at {diagnosis.time:.2f} s: {diagnosis.reason}")

    def _complain(self, refusal: Refusal) -> None:
        """Log the first refusal of a series; the others are only counted."""
        self._refused += 1
        if self._refused & (self._refused - 1) == 0:
            self.node.get_logger().warning(f"{refusal} ({self._refused} so far)")


def run(arguments: list[str]) -> int:
    """Run the node until a signal comes; return the exit status."""
    check_ros()
    import rclpy
    from rclpy.signals import SignalHandlerOptions
    from rclpy.utilities import try_shutdown

    told = stop_on_signals()
    stay_on_this_machine()
    rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
    node = create_node("fault_detector")
    try:
        DetectorWire(node, declare(node, DetectorParameters))
        spin(node, lambda: False, told)
        return 0
    finally:
        node.destroy_node()
        try_shutdown()


def main() -> None:
    """Run the node as a program."""
    sys.exit(guarded("fault_detector", lambda: run(sys.argv[1:])))


if __name__ == "__main__":
    main()
