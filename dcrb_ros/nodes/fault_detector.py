"""The fault detector node: subscribes to the waveform and the temperatures, publishes diagnoses.

With ``--managed`` it is a lifecycle node: a manager configures it, activates it, deactivates it and cleans it up.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from typing import Any

from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.lifecycle import LifecycleNodeMixin, LifecycleState, TransitionCallbackReturn

from dcrb_ros.diagnosis.detector import check_parameters
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.messages.encoder import diagnosis_messages
from dcrb_ros.messages.topics import AMBIENT_TEMPERATURE, DETECTED, DIAGNOSIS, OUTER_RING_TEMPERATURE, SENSOR, VIBRATION
from dcrb_ros.nodes.base import BenchNode
from dcrb_ros.nodes.detector_input import DetectorInput, Response
from dcrb_ros.nodes.programs import main
from dcrb_ros.nodes.publisher import Publisher
from dcrb_ros.nodes.ros import own_arguments, run_node
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.files import flatten, parameter_fields, validated
from dcrb_ros.stream.diagnosis import Diagnosis

KEYS = tuple(field.key for field in parameter_fields(DetectorParameters))
SUCCESS = TransitionCallbackReturn.SUCCESS


class DetectorTopics:
    """Passes the messages of a bench to a detector and publishes its diagnoses, on the topics of a node."""

    def __init__(self, node: BenchNode, parameters: DetectorParameters) -> None:
        """Prepare a detector that receives nothing yet.

        Raises:
            Refusal: the parameters do not fit each other, or their baseline cannot be read.
        """
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


class FaultDetectorNode(BenchNode):
    """A detector that works from its start to its end."""

    def __init__(self, parameters: DetectorParameters | None = None) -> None:
        """Subscribe, with ``parameters``, by default those given to the node by ROS.

        Raises:
            Refusal: the parameters are invalid.
        """
        super().__init__("fault_detector")
        self.watch_publishers(DIAGNOSIS)
        DetectorTopics(self, self.declare(DetectorParameters, adjust=lambda given: parameters or given)).subscribe()


class ManagedDetectorNode(LifecycleNodeMixin, BenchNode):
    """Publishes diagnoses while it is active. Its parameters can be set until it is configured, and again after a cleanup."""

    def __init__(self) -> None:
        """Declare the parameters and wait for transitions.

        Raises:
            Refusal: the parameters are invalid.
        """
        BenchNode.__init__(self, "fault_detector")
        self._topics: DetectorTopics | None = None
        self._parameters_given = self.declare(DetectorParameters, run_time=KEYS)
        check_parameters(self._parameters_given)
        LifecycleNodeMixin.__init__(self)
        self.watch_publishers(DIAGNOSIS)
        self._service_change_state.callback = self._answering(self._service_change_state.callback)
        self.get_logger().info("waiting for the transition configure")

    def _answering(self, change: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
        """Return the callback of the service change_state, which answers also if the transition is not possible.

        That of rclpy raises an exception, so the client would wait forever.
        """

        def answer(request: Any, response: Any) -> Any:
            try:
                return change(request, response)
            except rclpy_implementation.RCLError:
                transition = request.transition.label or request.transition.id
                self.get_logger().warning(
                    f"transition {transition} is not possible in the present state; get_available_transitions lists those that are"
                )
                response.success = False
                return response

        return answer

    def on_parameters(self, changes: dict[str, Any]) -> None:
        """Take parameters for the next configuration; refuse them while the node is configured, and once it is finalized."""
        keys = ", ".join(changes)
        if self._state_machine.current_state[1] == "finalized":
            raise Refusal(f"parameters: {keys} cannot change once the detector is finalized; start a new node")
        if self._topics is not None:
            raise Refusal(f"parameters: {keys} cannot change while the detector is configured; deactivate and clean it up first")
        self._parameters_given = validated({**flatten(self._parameters_given.model_dump()), **changes}, DetectorParameters, "parameters")

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Create the detector with the present parameters, and its publishers; fail if they do not fit each other."""
        try:
            self._topics = DetectorTopics(self, self._parameters_given)
        except Refusal as refusal:
            self.get_logger().error(str(refusal))
            return TransitionCallbackReturn.FAILURE
        return SUCCESS

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Receive the waveform."""
        self._configured.subscribe()
        return SUCCESS

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Receive nothing; what the detector has learned is kept."""
        self._configured.unsubscribe()
        return SUCCESS

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Discard detector and publishers."""
        if self._topics is not None:
            self._topics.close()
        self._topics = None
        return SUCCESS

    on_shutdown = on_cleanup
    """For good; the process waits for a termination signal."""

    @property
    def _configured(self) -> DetectorTopics:
        assert self._topics is not None  # the state machine allows these transitions after configure only
        return self._topics


def run(arguments: list[str], parameters: DetectorParameters | None = None) -> int:
    """Run the node until a termination signal arrives; return the exit status."""
    parser = argparse.ArgumentParser(prog="fault_detector", description="The fault detector as a ROS 2 node.")
    parser.add_argument("--managed", action="store_true", help="wait as a lifecycle node for the transitions configure and activate")
    managed = own_arguments(parser, arguments).managed
    return run_node(ManagedDetectorNode if managed else lambda: FaultDetectorNode(parameters), arguments)


if __name__ == "__main__":
    main("fault_detector", sys.argv[1:])
