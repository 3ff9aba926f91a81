"""The fault detector on the topics of a node, the plain or the managed one."""

from __future__ import annotations

from typing import Any

from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.messages.encoder import diagnosis_messages
from dcrb_ros.messages.topics import AMBIENT_TEMPERATURE, DETECTED, OUTER_RING_TEMPERATURE, SENSOR, VIBRATION
from dcrb_ros.nodes.base import BenchNode
from dcrb_ros.nodes.detector_input import DetectorInput, Response
from dcrb_ros.nodes.publisher import Publisher
from dcrb_ros.stream.diagnosis import Diagnosis


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
        self._node.log_wait(SENSOR, VIBRATION)

    def unsubscribe(self) -> None:
        """Receive nothing any more; the detector keeps what it has learned."""
        for subscription in self._subscriptions:
            self._node.destroy_subscription(subscription)
        self._subscriptions = []

    def close(self) -> None:
        """Leave the topics."""
        self.unsubscribe()
        self._publisher.close()

    def _publish(self, response: Response[Diagnosis]) -> None:
        log = self._node.get_logger()
        response.log(log)
        for diagnosis in response.diagnoses:
            self._publisher.write_messages(diagnosis_messages(diagnosis, self._input.frame))
            if diagnosis.verdict != self._verdict:
                self._verdict = diagnosis.verdict
                log.info(f"{self._verdict} at {diagnosis.time:.2f} s: {diagnosis.reason}")
