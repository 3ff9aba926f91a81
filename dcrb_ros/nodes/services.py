"""The simulator's services: pause, step, reset, record."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from std_srvs.srv import SetBool, Trigger

from dcrb_ros.nodes.recording_switch import wanted_path
from dcrb_ros.nodes.served import ServedNode
from dcrb_ros.schema.refusal import Refusal

TIMEOUT = 2.0
"""Wall time for which a service waits for the engine before it answers that the request is still pending [s]."""
OVER = "the simulation has ended or is quitting: start the node again"
"""Answer to requests for which it is too late."""


class Services:
    """The services; each answer says what was done, or why the request was refused."""

    def __init__(self, node: ServedNode) -> None:
        self._node, self._engine, self._recording = node, node.engine, node.recording
        for name, kind, handle in (
            ("pause", SetBool, self.pause),
            ("step", Trigger, self.step),
            ("reset", Trigger, self.reset),
            ("record", SetBool, self.record),
        ):
            node.create_service(kind, name, self._callback(name, handle))

    def _callback(self, name: str, handle: Callable[[Any], str]) -> Callable[[Any, Any], Any]:
        """Return the callback of a service; ``handle`` returns the message of its answer, or raises `Refusal`."""

        def callback(request: Any, response: Any) -> Any:
            try:
                with self._node.refusals.counted(name):
                    response.success, response.message = True, handle(request)
            except Refusal as refusal:
                response.success, response.message = False, str(refusal)
            return response

        return callback

    def _refuse_if_over(self, name: str) -> None:
        if self._engine.ended:
            raise Refusal(f"{name}: {OVER}")

    def _now(self) -> str:
        return f"{self._node.progress.time_ns * 1e-9:.6f} s of simulated time"

    def pause(self, request: Any) -> str:
        """Hold the blocks, or send them again."""
        self._refuse_if_over("pause")
        self._engine.gate.pause(request.data)
        return f"paused at {self._now()}" if request.data else f"running from {self._now()} on"

    def step(self, request: Any) -> str:
        """Send one block while paused."""
        self._refuse_if_over("step")
        if not self._engine.gate.paused:
            raise Refusal("step: the bench runs; pause it first (service pause, data: true)")
        if not self._engine.gate.step(TIMEOUT):
            self._refuse_if_over("step")
            return f"the block will be sent as soon as it is ready, after {self._now()}"
        return f"one block further: {self._now()}"

    def reset(self, request: Any) -> str:
        """Return bearing, simulated time, scenario and parameters to the start; time scale and pause stay as they are."""
        self._refuse_if_over("reset")
        done = self.restart()
        if not done:
            self._refuse_if_over("reset")
        return "at the start again: simulated time 0" + ("" if done else " as soon as the model is ready")

    def restart(self) -> bool:
        """Reset the engine; return whether it finished within `TIMEOUT`. If not, it follows as soon as the model is ready."""
        done = self._engine.reset(TIMEOUT)
        self._node.update_parameters()
        return done

    def record(self, request: Any) -> str:
        """Begin a recording, unless one is running, or finish it."""
        if not request.data:
            path = self._recording.stop()
            if path and self._recording.failed:
                raise Refusal(self._recording.state)
            if path is None:
                return "no recording runs"
            return f"{path} is finished at {self._now()}" if path.exists() else f"{path} is removed: it has no block"
        self._refuse_if_over("record")
        wanted = wanted_path(self._node.configuration.recording.path, self._node.get_namespace())
        return f"recording to {self._recording.record(wanted)}"
