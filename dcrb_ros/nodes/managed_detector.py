"""The fault detector as a lifecycle node: a manager configures it, activates it, deactivates it and cleans it up."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.lifecycle import LifecycleNodeMixin, LifecycleState, TransitionCallbackReturn

from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.messages.topics import DIAGNOSIS
from dcrb_ros.nodes.base import BenchNode
from dcrb_ros.nodes.detector_topics import DetectorTopics
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.files import flatten, parameter_fields, validated

KEYS = tuple(field.key for field in parameter_fields(DetectorParameters))
SUCCESS = TransitionCallbackReturn.SUCCESS


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
        """Take parameters for the next configuration; refuse them while the node is configured, and if there is no next one."""
        if self._state_machine.current_state[1] == "finalized":  # by a shutdown or a failed transition
            raise Refusal(f"parameters: {', '.join(changes)} would have no effect, because the detector is finalized; start the node anew")
        if self._topics is not None:
            keys = ", ".join(changes)
            raise Refusal(f"parameters: {keys} cannot change while the detector is configured; deactivate and clean it up first")
        self._parameters_given = validated({**flatten(self._parameters_given.model_dump()), **changes}, DetectorParameters, "parameters")

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Create the detector with the present parameters, and its publishers."""
        self._topics = DetectorTopics(self, self._parameters_given)
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
        """Forget detector and publishers."""
        self._forget()
        return SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Forget detector and publishers for good; the process waits for a termination signal."""
        self._forget()
        return SUCCESS

    @property
    def _configured(self) -> DetectorTopics:
        assert self._topics is not None  # the state machine allows these transitions after configure only
        return self._topics

    def _forget(self) -> None:
        if self._topics is not None:
            self._topics.close()
        self._topics = None
