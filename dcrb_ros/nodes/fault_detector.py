"""The fault detector node: subscribes to the waveform and the temperatures, publishes diagnoses."""

from __future__ import annotations

import argparse
import sys
from typing import Any

from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.messages.encoder import diagnosis_messages
from dcrb_ros.messages.topics import AMBIENT_TEMPERATURE, DETECTED, DIAGNOSIS, OUTER_RING_TEMPERATURE, SENSOR, VIBRATION
from dcrb_ros.nodes.base import BenchNode
from dcrb_ros.nodes.detector_input import DetectorInput, Response
from dcrb_ros.nodes.programs import main
from dcrb_ros.nodes.publisher import Publisher
from dcrb_ros.nodes.ros import own_arguments, run_node


class DetectorTopics:
    """Passes the messages of a bench to a detector and publishes its diagnoses, on the topics of a node."""

    def __init__(self, node: BenchNode, parameters: DetectorParameters) -> None:
        """Prepare a detector that receives nothing yet."""
        self._node, self._input, self._verdict = node, DetectorInput(parameters), ""
        self._publisher = Publisher(node, DETECTED)
        self._subscriptions: list[Any] = []

    def subscribe(self) -> None:
        """Receive sensor description, waveform and temperatures."""
        self._subscriptions = [
            self._node.subscribe(SENSOR, lambda data: self._publish(self._input.sensor(data))),
            self._node.subscribe(VIBRATION, lambda data: self._publish(self._input.block(data))),
            self._node.subscribe(AMBIENT_TEMPERATURE, lambda data: self._publish(self._input.ambient(data))),
            self._node.subscribe(OUTER_RING_TEMPERATURE, lambda data: self._publish(self._input.temperature(data))),
        ]

    def unsubscribe(self) -> None:
        """Receive nothing any more; the detector keeps what it has learned."""
        for subscription in self._subscriptions:
            self._node.destroy_subscription(subscription)
        self._subscriptions = []

    def close(self) -> None:
        """Leave the topics."""
        self.unsubscribe()
        self._publisher.close()

    def _publish(self, response: Response) -> None:
        log = self._node.get_logger()
        if response.information:
            log.info(response.information)
        if response.warning:
            log.warning(response.warning)
        for diagnosis in response.diagnoses:
            self._publisher.write_messages(diagnosis_messages(diagnosis, self._input.frame))
            if diagnosis.verdict != self._verdict:
                self._verdict = diagnosis.verdict
                log.info(f"{self._verdict} at {diagnosis.time:.2f} s: {diagnosis.reason}")


class FaultDetectorNode(BenchNode):
    """A detector that works from its start to its end."""

    def __init__(self) -> None:
        """Subscribe.

        Raises:
            Refusal: the parameters are invalid.
        """
        super().__init__("fault_detector")
        self.watch_publishers(DIAGNOSIS)
        DetectorTopics(self, self.declare(DetectorParameters)).subscribe()


def run(arguments: list[str]) -> int:
    """Run the node until a termination signal arrives; return the exit status."""
    parser = argparse.ArgumentParser(prog="fault_detector", description="The fault detector as a ROS 2 node.")
    parser.add_argument("--managed", action="store_true", help="wait as a lifecycle node for the transitions configure and activate")
    if own_arguments(parser, arguments).managed:
        from dcrb_ros.nodes.managed_detector import ManagedDetectorNode

        return run_node(ManagedDetectorNode, arguments)
    return run_node(FaultDetectorNode, arguments)


if __name__ == "__main__":
    main("fault_detector", sys.argv[1:])
