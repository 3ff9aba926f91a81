"""The wayside hot-box detector node: reads the axle box of a running bench once per passage."""

from __future__ import annotations

import argparse
import sys

from dcrb_ros.diagnosis.wayside import AxleBoxes, Wayside, WaysideParameters
from dcrb_ros.messages.cdr import decoded
from dcrb_ros.messages.topics import GROUND_TRUTH, NAMESPACE, WAYSIDE, WAYSIDE_ALARM, WAYSIDE_TEMPERATURE, Message
from dcrb_ros.messages.topics.wayside import encode_alarm, encode_reading
from dcrb_ros.nodes.base import BenchNode
from dcrb_ros.nodes.programs import main
from dcrb_ros.nodes.publisher import Publisher
from dcrb_ros.nodes.refusal_counts import Refusals
from dcrb_ros.nodes.ros import own_arguments, run_node
from dcrb_ros.stream.block import Truth

OTHERS = {"box [deg C]", "opposite_box [deg C]", "opposite_outer_ring [deg C]", "ambient [deg C]"}
"""Temperatures that are needed beside those of the outer rings."""
NOT_WARM = "the ground truth has no temperatures: set thermal.law = network on the bench"


def boxes_of(truth: Truth) -> AxleBoxes | None:
    """Return the axle boxes of a ground truth; None where it has no temperatures."""
    t = truth.thermal
    rings = [value for name, value in t.items() if name.startswith("row") and name.endswith("outer_ring [deg C]")]
    if not rings or not t.keys() >= OTHERS:
        return None
    return AxleBoxes(t["box [deg C]"], max(rings), t["opposite_box [deg C]"], t["opposite_outer_ring [deg C]"], t["ambient [deg C]"])


class HotBoxDetectorNode(BenchNode):
    """Follows the ground truth of a bench, as the equipment beside the track measures the real box."""

    def __init__(self) -> None:
        """Subscribe.

        Raises:
            Refusal: the parameters are invalid.
        """
        super().__init__("hot_box_detector")
        self._line = self.declare(WaysideParameters)
        self._wayside, self._before_ns = self._run(), 0
        self._warned, self._refusals = False, Refusals(self.get_logger().warning)
        self.watch_publishers(*WAYSIDE)
        self._publisher = Publisher(self, WAYSIDE)
        self.subscribe(GROUND_TRUTH, self._receive)
        self.log_wait(GROUND_TRUTH)

    def _run(self) -> Wayside:
        """Return the line at the start of a run; the nodes of the boxes of a vehicle have noise of their own."""
        return Wayside(self._line, self.get_namespace().removeprefix(NAMESPACE))

    def close(self) -> None:
        """Leave the topics."""
        self._publisher.close()

    def _receive(self, data: bytes) -> None:
        """Take a ground truth; a malformed one is ignored, and logged less and less often."""
        with self._refusals.suppressed(GROUND_TRUTH.name):
            self._take(data)

    def _take(self, data: bytes) -> None:
        truth = GROUND_TRUTH.decoded(data)
        boxes = boxes_of(truth)
        if boxes is None:
            if not self._warned:
                self._warned = True
                self.get_logger().warning(NOT_WARM)
            return
        if truth.time_ns < self._before_ns:  # the bench was reset
            self._wayside = self._run()
        self._before_ns = truth.time_ns
        passage = self._wayside.follow(truth.time_ns, truth.speed, boxes, truth.thermal.get("acceleration", 1.0))
        if passage is None:
            return
        frame = str(decoded(data, GROUND_TRUTH.type).header.frame_id)
        messages = (
            Message(WAYSIDE_TEMPERATURE, passage.time_ns, encode_reading(passage, self._line.noise, frame)),
            Message(WAYSIDE_ALARM, passage.time_ns, encode_alarm(passage, frame)),
        )
        self._publisher.write_messages(messages)
        where = f"at {passage.distance:.1f} km: {passage.reason}"
        if passage.alarm:  # rclpy ties the severity to the line of the call
            self.get_logger().warning(f"hot box {where}")
        else:
            self.get_logger().info(f"passage {where}")


def run(arguments: list[str]) -> int:
    """Run the node until a termination signal arrives; return the exit status."""
    parser = argparse.ArgumentParser(prog="hot_box_detector", description="A line of wayside hot-box detectors as a ROS 2 node.")
    own_arguments(parser, arguments)
    return run_node(HotBoxDetectorNode, arguments)


if __name__ == "__main__":
    main("hot_box_detector", sys.argv[1:])
