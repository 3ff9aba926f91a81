"""The simulator's services: pause, step, reset, record."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from dcrb_ros.nodes.recording_switch import wanted_path
from dcrb_ros.runtime.refusal import Refusal

if TYPE_CHECKING:
    from dcrb_ros.nodes.simulator import Simulator

PATIENCE = 2.0
"""Wall time that a service waits for the model before it answers that it is still at work [s]."""


class Services:
    """Answers to the services; each says what it did, or why not."""

    def __init__(self, simulator: Simulator) -> None:
        from std_srvs.srv import SetBool, Trigger

        self._of = simulator
        for name, kind, answer in (
            ("pause", SetBool, self.pause),
            ("step", Trigger, self.step),
            ("reset", Trigger, self.reset),
            ("record", SetBool, self.record),
        ):
            simulator.node.create_service(kind, name, self._answering(name, answer))

    def _answering(self, name: str, answer: Callable[[Any], str]) -> Callable[[Any, Any], Any]:
        """Return a service's callback; what ``answer`` returns is its message, what it refuses is not done."""

        def callback(request: Any, response: Any) -> Any:
            try:
                with self._of.refusals.counted(name):
                    response.success, response.message = True, answer(request)
            except Refusal as refusal:
                response.success, response.message = False, str(refusal)
            return response

        return callback

    def _now(self) -> str:
        return f"{self._of.progress.simulated_ns * 1e-9:.6f} s of simulated time"

    def pause(self, request: Any) -> str:
        """Hold the blocks back or let them go on."""
        self._of.gate.pause(request.data)
        return f"paused at {self._now()}" if request.data else f"running from {self._now()} on"

    def step(self, request: Any) -> str:
        """Let one block out while paused."""
        if not self._of.gate.paused:
            raise Refusal("step: the bench runs; pause it first (service pause, data: true)")
        if not self._of.gate.step(PATIENCE):
            return f"the block goes out as soon as it is ready, after {self._now()}"
        return f"one block further: {self._now()}"

    def reset(self, request: Any) -> str:
        """Begin anew: bearing, simulated time, scenario and parameters as at the start, but for the time scale and a pause."""
        done = self._of.gate.reset(PATIENCE)
        self._of.show_parameters()
        return "at the start again: simulated time 0" + ("" if done else " as soon as the model is ready")

    def record(self, request: Any) -> str:
        """Begin a recording where none runs, or finish it."""
        tape = self._of.tape
        if not request.data:
            path = tape.stop()
            if path and tape.failed:
                raise Refusal(tape.state)
            return f"{path} is finished at {self._now()}" if path else "no recording runs"
        wanted = wanted_path(self._of.configuration.recording.path, self._of.node.get_namespace())
        return f"recording to {tape.path or self._of.record_on(wanted)}"
