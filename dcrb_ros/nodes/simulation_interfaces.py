"""The standard services and the action for simulators, `simulation_interfaces` (REP-2018), where that package is installed.

They control the gate of the engine, as pause, step and reset of `dcrb_ros.nodes.services` do. A step is a block.
"""

from __future__ import annotations

import importlib
from collections.abc import Awaitable, Callable
from typing import Any

from dcrb_ros.nodes.served import ServedNode
from dcrb_ros.nodes.services import OVER, TIMEOUT, Services
from dcrb_ros.schema.refusal import Refusal

PACKAGE = "simulation_interfaces"
FEATURES = (
    "SIMULATION_RESET",
    "SIMULATION_STATE_GETTING",
    "SIMULATION_STATE_SETTING",
    "SIMULATION_STATE_PAUSE",
    "STEP_SIMULATION_SINGLE",
    "STEP_SIMULATION_MULTIPLE",
    "STEP_SIMULATION_ACTION",
)
"""Names of the supported features in SimulatorFeatures. Time and state are reset together only, so neither is listed by itself."""
ABOUT = "A step is a block of publishing.block_size samples. Time scale, faults and recordings have parameters and services of their own."
POLL_PERIOD = 0.01
"""Wall time between two looks at whether the requested steps are done [s]."""
Outcome = tuple[int, str]
"""Code and message of a Result."""


class Declined(Refusal):
    """A request that is answered by a code other than that for success."""

    def __init__(self, code: int, reason: str) -> None:
        super().__init__(reason)
        self.code = code


class SimulationInterfaces:
    """Offers features, state, step and reset; every answer has a Result with the code of its outcome."""

    def __init__(self, node: ServedNode, services: Services) -> None:
        """Offer the services on ``node``; ``services`` restarts the engine."""
        from rclpy.callback_groups import ReentrantCallbackGroup

        self._node, self._engine, self._services = node, node.engine, services
        messages, kinds, actions = (importlib.import_module(f"{PACKAGE}.{part}") for part in ("msg", "srv", "action"))
        self._state, self._features, self._code = messages.SimulationState, messages.SimulatorFeatures, messages.Result
        self._scope, self._transition = kinds.ResetSimulation.Request, kinds.SetSimulationState.Response
        # Other requests are served while the answer to step_simulation waits for the blocks.
        group = ReentrantCallbackGroup()
        node.create_service(kinds.GetSimulatorFeatures, "get_simulator_features", self.features, callback_group=group)
        for name, kind, handle in (
            ("get_simulation_state", kinds.GetSimulationState, self.get_state),
            ("set_simulation_state", kinds.SetSimulationState, self.set_state),
            ("step_simulation", kinds.StepSimulation, self.step),
            ("reset_simulation", kinds.ResetSimulation, self.reset),
        ):
            node.create_service(kind, name, self._callback(name, handle), callback_group=group)
        self._steps = actions.SimulateSteps
        node.offer_action(self._steps, "simulate_steps", self.simulate_steps, callback_group=group)

    def _callback(self, name: str, handle: Callable[[Any, Any], Awaitable[Outcome]]) -> Callable[[Any, Any], Awaitable[Any]]:
        """Return the callback of a service; ``handle`` returns the outcome, or raises `Declined`, which is counted."""

        async def callback(request: Any, response: Any) -> Any:
            try:
                with self._node.refusals.counted(name):
                    outcome = await handle(request, response)
            except Declined as declined:
                outcome = declined.code, str(declined)
            response.result.result, response.result.error_message = outcome
            return response

        return callback

    @property
    def state(self) -> int:
        """Present state, a constant of SimulationState: stopped means paused at the start by a request to stop, quitting that no more
        blocks follow.
        """
        if self._engine.gate.closed or self._engine.ended:
            return int(self._state.STATE_QUITTING)
        if not self._engine.gate.paused:
            return int(self._state.STATE_PLAYING)
        stopped = self._engine.gate.stopped and self._node.progress.bundles == 0
        return int(self._state.STATE_STOPPED if stopped else self._state.STATE_PAUSED)

    def features(self, request: Any, response: Any) -> Any:
        """Answer which features are supported."""
        response.features.features = [getattr(self._features, name) for name in FEATURES]
        response.features.custom_info = ABOUT
        return response

    async def get_state(self, request: Any, response: Any) -> Outcome:
        """Answer the present state."""
        response.state.state = self.state
        return self._code.RESULT_OK, ""

    async def set_state(self, request: Any, response: Any) -> Outcome:
        """Play, pause, stop or quit."""
        target = request.state.state
        transitions = {
            self._state.STATE_STOPPED: self._stop,
            self._state.STATE_PLAYING: lambda: self._engine.gate.pause(False),
            self._state.STATE_PAUSED: lambda: self._engine.gate.pause(True),
            self._state.STATE_QUITTING: self._engine.gate.close,
        }
        if target not in transitions:
            raise Declined(
                self._transition.INCORRECT_TRANSITION,
                f"set_simulation_state: {target} is not a state that can be set; use 0 (stopped), 1 (playing), 2 (paused) or 3 (quitting)",
            )
        if target == self.state:
            return self._transition.ALREADY_IN_TARGET_STATE, f"the simulation is in state {target} already"
        if self.state == self._state.STATE_QUITTING:
            raise Declined(self._transition.INCORRECT_TRANSITION, f"set_simulation_state: {OVER}")
        transitions[target]()
        return self._code.RESULT_OK, ""

    def _stop(self) -> None:
        self._engine.gate.pause(True, stopped=True)
        if not self._services.restart():
            raise Declined(self._transition.STATE_TRANSITION_ERROR, _pending("set_simulation_state"))

    async def step(self, request: Any, response: Any) -> Outcome:
        """Send the requested number of blocks while paused; answer when they have been sent."""
        await self._send("step_simulation", request.steps, lambda sent: None)
        return self._code.RESULT_OK, ""

    async def simulate_steps(self, goal: Any) -> Any:
        """Send the number of blocks of a goal while paused, with a feedback for each; return the result when they have been sent.

        If the goal is cancelled, the remaining blocks are held.
        """
        result, told = self._steps.Result(), 0

        def report(sent: int) -> None:
            nonlocal told
            while told < sent:
                told += 1
                goal.publish_feedback(self._steps.Feedback(completed_steps=told, remaining_steps=goal.request.steps - told))
            if goal.is_cancel_requested and self._engine.gate.paused:
                self._engine.gate.pause(True)

        try:
            with self._node.refusals.counted("simulate_steps"):
                await self._send("simulate_steps", goal.request.steps, report)
            result.result.result = self._code.RESULT_OK
            goal.succeed()
        except Declined as declined:
            result.result.result, result.result.error_message = declined.code, str(declined)
            goal.canceled() if goal.is_cancel_requested else goal.abort()
        return result

    async def _send(self, name: str, steps: int, report: Callable[[int], None]) -> None:
        """Send a number of blocks while paused; ``report`` is called with the number of those sent whenever it is looked at.

        Raises:
            Declined: the simulation is not paused, or not all of the blocks were sent.
        """
        gate = self._engine.gate
        if self.state == self._state.STATE_QUITTING:
            raise Declined(self._code.RESULT_OPERATION_FAILED, f"{name}: {OVER}")
        if self.state != self._state.STATE_PAUSED:
            raise Declined(
                self._code.RESULT_OPERATION_FAILED,
                f"{name}: the simulation is in state {self.state}; pause it first (set_simulation_state, state 2)",
            )
        last = gate.request_steps(steps)

        def sent_so_far() -> int:
            return max(0, steps - max(0, last - gate.stepped))  # those of earlier requests are sent first

        await self._steps_done(last, lambda: report(sent_so_far()))
        sent = sent_so_far()
        if sent < steps:
            raise Declined(
                self._code.RESULT_OPERATION_FAILED,
                f"{name}: {sent} of {steps} blocks were sent; a pause, a reset or the end of the run stopped the others",
            )

    async def _steps_done(self, last: int, look: Callable[[], None]) -> None:
        """Wait until the ``last`` step is done or none remains; call ``look`` at every poll, the last time after that step."""
        from rclpy.task import Future

        done = Future()

        def check() -> None:
            if done.done():
                return
            gate = self._engine.gate
            over = self._engine.ended or gate.stepped >= last or not gate.stepping
            look()
            if over:
                done.set_result(None)

        timer = self._node.repeat(POLL_PERIOD, check)
        try:
            await done
        finally:
            self._node.destroy_timer(timer)

    async def reset(self, request: Any, response: Any) -> Outcome:
        """Return bearing and simulated time to the start."""
        scope, both = request.scope, self._scope.SCOPE_TIME | self._scope.SCOPE_STATE
        if scope != self._scope.SCOPE_DEFAULT and scope & both != both:
            raise Declined(
                self._code.RESULT_FEATURE_UNSUPPORTED,
                f"reset_simulation: scope {scope} is not supported, because time and state are reset together; use {self._scope.SCOPE_ALL}",
            )
        if self.state == self._state.STATE_QUITTING:
            raise Declined(self._code.RESULT_INCORRECT_STATE, f"reset_simulation: {OVER}")
        if not self._services.restart():
            raise Declined(self._code.RESULT_OPERATION_FAILED, _pending("reset_simulation"))
        return self._code.RESULT_OK, ""


def _pending(name: str) -> str:
    return f"{name}: the reset was requested but not done within {TIMEOUT:g} s; it follows when the present block is computed"
