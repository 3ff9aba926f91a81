"""The services and the action of `simulation_interfaces`, with substitutes for its definitions: that package is not on PyPI."""

from __future__ import annotations

import inspect
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="the nodes need ROS 2; everything else is tested without")

import simulation_definitions as definitions
from made_up_bundles import Blocks
from ros_bench import domain, graph_client
from simulation_definitions import Result, SimulationState, SimulatorFeatures
from std_srvs.srv import SetBool
from waiting import PATIENCE, wait_for

from dcrb_ros.nodes.bench_status import BenchStatus
from dcrb_ros.nodes.engine import Engine, Progress
from dcrb_ros.nodes.gate import Gate
from dcrb_ros.nodes.pacing import Pacer
from dcrb_ros.nodes.recording_switch import RecordingSwitch
from dcrb_ros.nodes.refusal_counts import Refusals
from dcrb_ros.nodes.services import Services
from dcrb_ros.nodes.simulating import SimulatingNode
from dcrb_ros.nodes.simulation_interfaces import SimulationInterfaces
from dcrb_ros.settings.configuration import Configuration

pytestmark = pytest.mark.slow

STOPPED, PLAYING, PAUSED, QUITTING = range(4)
OK, FAILED = Result.RESULT_OK, Result.RESULT_OPERATION_FAILED
ALREADY, ERROR, INCORRECT = 101, 102, 103
ENDLESS = 10**9


def answer_of(proceed: Callable[[], Any]) -> Any:
    """Return the answer to a call that `Bench.begin` has begun."""
    answers = [proceed()]

    def arrived() -> bool:
        if answers[-1] is None:
            answers.append(proceed())
        return answers[-1] is not None

    wait_for(arrived)
    return answers[-1]


class Goal:
    """The handle of a goal, as rclpy's action server gives it to the callback."""

    def __init__(self, steps: int) -> None:
        self.request = definitions.SimulateSteps.Goal(steps)
        self.is_cancel_requested = False
        self.feedback: list[definitions.SimulateSteps.Feedback] = []
        self.outcome = ""
        self.publish_feedback = self.feedback.append

    def succeed(self) -> None:
        self.outcome += "succeeded"

    def abort(self) -> None:
        self.outcome += "aborted"

    def canceled(self) -> None:
        self.outcome += "canceled"


class Bench:
    """The part of a simulator that the services see, with an engine in a thread."""

    commands, detected, behind, compiling = SimulatingNode.commands, SimulatingNode.detected, SimulatingNode.behind, ""
    about = SimulatingNode.about

    def __init__(self, count: int = ENDLESS, *, paused: bool = False) -> None:
        self.configuration, self.progress = Configuration(), Progress()
        self.log: list[str] = []
        self.refusals = Refusals(self.log.append)
        self.recording = RecordingSwitch(lambda *_, **__: pytest.fail("nothing is recorded"), None)  # type: ignore[arg-type]
        self.engine = Engine("test engine", Blocks(count), [self.progress], Gate(Pacer(1.0, time.monotonic), time.monotonic))
        self.offered: dict[str, tuple[Any, Callable[[Any, Any], Any]]] = {}
        self.periodic: list[Callable[[], None]] = []
        services = Services(self)  # type: ignore[arg-type]
        self.own = set(self.offered)
        SimulationInterfaces(self, services)  # type: ignore[arg-type]
        self.engine.prepare()
        self.engine.gate.pause(paused)
        self.engine.start()

    def create_service(self, kind: Any, name: str, callback: Callable[[Any, Any], Any], /, *, callback_group: Any = None) -> None:
        self.offered[name] = kind, callback

    def offer_action(self, kind: Any, name: str, execute: Callable[[Any], Any], /, *, callback_group: Any = None) -> None:
        self.offered[name] = kind, execute

    def get_namespace(self) -> str:
        return "/dcrb"

    def update_parameters(self) -> None:
        """Do nothing: there are no parameters."""

    def repeat(self, period: float, callback: Callable[[], None], /) -> Callable[[], None]:
        self.periodic.append(callback)
        return callback

    def destroy_timer(self, timer: Callable[[], None], /) -> None:
        self.periodic.remove(timer)

    def begin(self, name: str, request: Any = None) -> Callable[[], Any]:
        """Call a service; return a function that returns its answer, or None as long as there is none."""
        kind, callback = self.offered[name]
        if isinstance(request, Goal):
            return self._proceeding(callback(request))
        return self._proceeding(callback(kind.Request() if request is None else request, kind.Response()))

    def _proceeding(self, answer: Any) -> Callable[[], Any]:
        if not inspect.iscoroutine(answer):
            return lambda: answer

        def proceed() -> Any:
            for timer in list(self.periodic):
                timer()
            try:
                answer.send(None)
            except StopIteration as end:
                return end.value
            return None

        return proceed

    def ask(self, name: str, request: Any = None) -> Any:
        """Call a service and return its answer."""
        return answer_of(self.begin(name, request))

    def set(self, state: int) -> Any:
        return self.ask("set_simulation_state", definitions.SetSimulationState.Request(SimulationState(state))).result

    @property
    def state(self) -> int:
        answer = self.ask("get_simulation_state")
        assert answer.result == Result(OK, "")
        return int(answer.state.state)

    def step(self, steps: int) -> Any:
        return self.ask("step_simulation", definitions.StepSimulation.Request(steps)).result

    def reset(self, scope: int) -> Any:
        return self.ask("reset_simulation", definitions.ResetSimulation.Request(scope)).result


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    definitions.install(monkeypatch)
    found = Bench()
    yield found
    found.engine.close()


def test_the_listed_features_are_those_that_are_offered(bench: Bench) -> None:
    found = bench.ask("get_simulator_features").features
    names = {value: name for name, value in vars(SimulatorFeatures).items() if name.isupper()}
    assert [names[feature] for feature in found.features] == [
        "SIMULATION_RESET",
        "SIMULATION_STATE_GETTING",
        "SIMULATION_STATE_SETTING",
        "SIMULATION_STATE_PAUSE",
        "STEP_SIMULATION_SINGLE",
        "STEP_SIMULATION_MULTIPLE",
        "STEP_SIMULATION_ACTION",
    ]
    assert set(bench.offered) - bench.own == {
        "get_simulator_features",
        "get_simulation_state",
        "set_simulation_state",
        "step_simulation",
        "reset_simulation",
        "simulate_steps",
    }
    assert found.spawn_formats == []
    assert "block" in found.custom_info


TRANSITIONS = {
    (STOPPED, STOPPED): ALREADY,
    (STOPPED, PLAYING): OK,  # "Stopped simulation can be played"
    (STOPPED, PAUSED): OK,  # "It can also be paused, which means starting simulation in a paused state immediately"
    (STOPPED, QUITTING): OK,
    (PLAYING, STOPPED): OK,  # "Simulation is playing, can be either paused or stopped"
    (PLAYING, PLAYING): ALREADY,
    (PLAYING, PAUSED): OK,
    (PLAYING, QUITTING): OK,
    (PAUSED, STOPPED): OK,  # "Simulation is paused, can be either stopped (which will reset it) or played"
    (PAUSED, PLAYING): OK,
    (PAUSED, PAUSED): ALREADY,
    (PAUSED, QUITTING): OK,
    (QUITTING, STOPPED): INCORRECT,  # "Simulation interfaces will become unavailable after quitting"
    (QUITTING, PLAYING): INCORRECT,
    (QUITTING, PAUSED): INCORRECT,
    (QUITTING, QUITTING): ALREADY,
}
"""Result of each transition, by the state before and the requested one; the quotes are comments of SimulationState.msg."""


@pytest.mark.parametrize("before", [STOPPED, PLAYING, PAUSED, QUITTING])
@pytest.mark.parametrize("target", [STOPPED, PLAYING, PAUSED, QUITTING])
def test_every_transition_is_made_or_refused_as_the_definitions_say(bench: Bench, before: int, target: int) -> None:
    wait_for(lambda: bench.progress.bundles > 0)
    if before != PLAYING:
        assert bench.set(before) == Result(OK, "")
    assert bench.state == before
    answer, code = bench.set(target), TRANSITIONS[before, target]
    assert answer.result == code
    assert bool(answer.error_message) == (code != OK)
    assert bench.state == (before if code == INCORRECT else target)
    assert bench.refusals.count("set_simulation_state") == (code == INCORRECT)


def test_pausing_a_stopped_simulation_takes_no_step(bench: Bench) -> None:
    bench.set(STOPPED)
    assert bench.set(PAUSED) == Result(OK, "")
    assert (bench.progress.bundles, bench.progress.time_ns) == (0, 0)


def test_no_block_follows_a_request_to_quit(bench: Bench) -> None:
    wait_for(lambda: bench.progress.bundles > 0)
    assert bench.set(QUITTING) == Result(OK, "")
    sent = bench.progress.bundles
    wait_for(lambda: bench.engine.ended)
    assert bench.progress.bundles == sent


def test_a_simulation_that_has_ended_is_quitting_and_takes_no_requests(monkeypatch: pytest.MonkeyPatch) -> None:
    definitions.install(monkeypatch)
    bench = Bench(count=1)
    wait_for(lambda: bench.engine.ended)
    assert bench.state == QUITTING
    answers = {"set_simulation_state": bench.set(STOPPED), "step_simulation": bench.step(1), "reset_simulation": bench.reset(0)}
    codes = {"set_simulation_state": INCORRECT, "step_simulation": FAILED, "reset_simulation": Result.RESULT_INCORRECT_STATE}
    for name, answer in answers.items():
        assert answer == Result(codes[name], f"{name}: the simulation has ended or is quitting: start the node again")
        assert bench.refusals.count(name) == 1


@pytest.mark.parametrize("name", ["pause", "step", "reset", "record"])
def test_the_services_of_the_node_take_no_requests_after_the_end(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    definitions.install(monkeypatch)
    bench = Bench(count=1)
    wait_for(lambda: bench.engine.ended)
    answer = bench.ask(name, SetBool.Request(data=True) if name in ("pause", "record") else None)
    assert (answer.success, answer.message) == (False, f"{name}: the simulation has ended or is quitting: start the node again")
    assert bench.refusals.count(name) == 1


@pytest.mark.parametrize("name", ["step", "reset"])
def test_a_request_that_the_end_overtakes_is_refused(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    definitions.install(monkeypatch)
    bench = Bench(count=1, paused=True)

    def ends(timeout: float) -> bool:
        bench.engine.close()
        return False

    monkeypatch.setattr(bench.engine.gate, name, ends)
    answer = bench.ask(name)
    assert (answer.success, answer.message) == (False, f"{name}: the simulation has ended or is quitting: start the node again")


def test_stopping_returns_to_the_start_and_holds_there(bench: Bench) -> None:
    wait_for(lambda: bench.progress.bundles > 2)
    assert bench.set(STOPPED).result == OK
    assert (bench.progress.bundles, bench.engine.gate.paused) == (0, True)


def test_a_stopped_simulation_is_paused_before_it_is_stepped(bench: Bench) -> None:
    bench.set(STOPPED)
    assert bench.step(1).result == FAILED
    assert bench.set(PAUSED).result == OK
    assert bench.step(1).result == OK
    assert (bench.progress.bundles, bench.state) == (1, PAUSED)
    assert bench.set(STOPPED).result == OK
    assert bench.progress.bundles == 0


def test_the_services_of_both_kinds_control_the_same_pause(bench: Bench) -> None:
    from std_srvs.srv import SetBool

    bench.set(STOPPED)
    assert bench.ask("pause", SetBool.Request(data=False)).success
    assert bench.state == PLAYING
    wait_for(lambda: bench.progress.bundles > 0)
    assert bench.ask("pause", SetBool.Request(data=True)).success
    assert bench.state == PAUSED
    assert bench.ask("reset").success
    assert bench.state == PAUSED  # at the start, but no longer stopped


@pytest.mark.parametrize("target", [SimulationState.STATE_NO_WORLD, SimulationState.STATE_LOADING_WORLD, 77])
def test_a_state_that_cannot_be_set_is_refused_and_counted(bench: Bench, target: int) -> None:
    answer = bench.set(target)
    assert answer.result == INCORRECT
    assert answer.error_message.startswith(f"set_simulation_state: {target} is not a state that can be set; use 0 (stopped)")
    assert bench.refusals.count("set_simulation_state") == 1
    assert bench.state == PLAYING


def test_quitting_ends_the_engine(bench: Bench) -> None:
    assert bench.set(QUITTING).result == OK
    wait_for(lambda: bench.engine.ended)
    assert bench.state == QUITTING


def test_steps_are_refused_unless_paused(bench: Bench) -> None:
    answer = bench.step(3)
    assert (answer.result, bench.refusals.count("step_simulation")) == (FAILED, 1)
    assert answer.error_message == "step_simulation: the simulation is in state 1; pause it first (set_simulation_state, state 2)"


@pytest.mark.parametrize("steps", [0, 1, 7])
def test_as_many_blocks_as_requested_are_sent_before_the_answer(bench: Bench, steps: int) -> None:
    bench.set(PAUSED)
    before = bench.progress.bundles
    assert bench.step(steps) == Result(OK, "")
    assert (bench.progress.bundles - before, bench.state, bench.periodic) == (steps, PAUSED, [])


@pytest.mark.parametrize("interrupt", [lambda bench: bench.set(PLAYING), lambda bench: bench.reset(0), lambda bench: bench.engine.close()])
def test_an_interrupted_request_says_how_many_blocks_were_sent(bench: Bench, interrupt: Callable[[Bench], Any]) -> None:
    bench.set(PAUSED)
    before = bench.engine.gate.stepped
    proceed = bench.begin("step_simulation", definitions.StepSimulation.Request(ENDLESS))
    wait_for(lambda: proceed() is None and bench.engine.gate.stepped > before)
    interrupt(bench)
    answer, sent = answer_of(proceed).result, bench.engine.gate.stepped - before
    assert answer.result == FAILED
    assert answer.error_message.startswith(f"step_simulation: {sent} of {ENDLESS} blocks were sent; a pause, a reset or the end")


def test_requests_that_overlap_count_their_own_blocks(bench: Bench) -> None:
    bench.set(PAUSED)
    before = bench.engine.gate.stepped
    first, second = (bench.begin("step_simulation", definitions.StepSimulation.Request(steps)) for steps in (ENDLESS, 7))
    wait_for(lambda: first() is None and second() is None and bench.engine.gate.stepped > before + 20)
    bench.set(PLAYING)
    sent = bench.engine.gate.stepped - before
    for proceed, count, steps in ((first, sent, ENDLESS), (second, 0, 7)):
        answer = answer_of(proceed).result
        assert answer.result == FAILED
        assert answer.error_message.startswith(f"step_simulation: {count} of {steps} blocks were sent")


@pytest.mark.parametrize("steps", [0, 1, 7])
def test_the_action_reports_every_block(bench: Bench, steps: int) -> None:
    bench.set(PAUSED)
    before, goal = bench.progress.bundles, Goal(steps)
    assert bench.ask("simulate_steps", goal).result == Result(OK, "")
    assert (bench.progress.bundles - before, bench.state, bench.periodic, goal.outcome) == (steps, PAUSED, [], "succeeded")
    assert [(f.completed_steps, f.remaining_steps) for f in goal.feedback] == [(k + 1, steps - k - 1) for k in range(steps)]


def test_the_action_is_aborted_unless_paused(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    goal = Goal(3)
    answer = bench.ask("simulate_steps", goal).result
    assert (answer.result, goal.outcome, goal.feedback) == (FAILED, "aborted", [])
    assert answer.error_message == "simulate_steps: the simulation is in state 1; pause it first (set_simulation_state, state 2)"
    monkeypatch.setattr("dcrb_ros.nodes.bench_status.installed", lambda package: True)
    status = BenchStatus(bench).status("/dcrb/simulator", 0)  # type: ignore[arg-type]
    assert status.values["rejected_calls"] == "1"
    assert "energy_residual [J]" not in status.values  # these blocks have no energy account


@pytest.mark.parametrize("outcome", ["canceled", "aborted"])
def test_a_cancelled_or_interrupted_action_holds_the_other_blocks(bench: Bench, outcome: str) -> None:
    bench.set(PAUSED)
    goal = Goal(ENDLESS)
    proceed = bench.begin("simulate_steps", goal)
    wait_for(lambda: proceed() is None and len(goal.feedback) > 2)
    if outcome == "canceled":
        goal.is_cancel_requested = True
    else:
        bench.set(PAUSED)
        bench.engine.gate.pause(True)
    answer = answer_of(proceed).result
    assert (answer.result, goal.outcome, bench.state) == (FAILED, outcome, PAUSED)
    assert answer.error_message.startswith(f"simulate_steps: {bench.engine.gate.stepped} of {ENDLESS} blocks were sent")
    assert goal.feedback[-1].completed_steps == bench.engine.gate.stepped


def test_the_end_of_the_run_ends_a_request_for_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    definitions.install(monkeypatch)
    bench = Bench(count=5, paused=True)
    assert bench.step(9).error_message.startswith("step_simulation: 5 of 9 blocks were sent")


@pytest.mark.parametrize("scope", [0, 3, 7, 255])
def test_time_and_state_are_reset_together(bench: Bench, scope: int) -> None:
    bench.set(PAUSED)
    bench.step(4)
    assert bench.reset(scope) == Result(OK, "")
    assert (bench.progress.bundles, bench.progress.time_ns, bench.state) == (0, 0, PAUSED)


@pytest.mark.parametrize("scope", [1, 2, 4, 5])
def test_a_part_of_the_reset_is_not_supported(bench: Bench, scope: int) -> None:
    bench.set(PAUSED)
    bench.step(4)
    sent, answer = bench.progress.bundles, bench.reset(scope)
    assert answer.result == Result.RESULT_FEATURE_UNSUPPORTED
    assert answer.error_message == (f"reset_simulation: scope {scope} is not supported, because time and state are reset together; use 255")
    assert (bench.progress.bundles, bench.refusals.count("reset_simulation")) == (sent, 1)


def test_a_reset_that_takes_long_is_reported(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bench.engine.gate, "reset", lambda timeout: False)
    assert bench.reset(0).result == FAILED
    stopped = bench.set(STOPPED)
    assert (stopped.result, "not done within 2 s" in stopped.error_message) == (ERROR, True)


def translated(kind: Any, request: Any, callback: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
    """Return the callback of a Trigger service that answers as one of another kind would answer ``request``."""

    async def answer(_: Any, response: Any) -> Any:
        found = (await callback(request, kind.Response())).result
        response.success, response.message = found.result == OK, found.error_message
        return response

    return answer


@pytest.mark.node
def test_a_node_serves_others_during_steps_and_answers_before_it_quits(monkeypatch: pytest.MonkeyPatch) -> None:
    import rclpy
    from std_srvs.srv import SetBool, Trigger

    from dcrb_ros.nodes.base import BenchNode
    from dcrb_ros.nodes.ros import spin

    definitions.install(monkeypatch)
    requests = {
        "step_simulation": definitions.StepSimulation.Request(ENDLESS),
        "set_simulation_state": definitions.SetSimulationState.Request(SimulationState(QUITTING)),
    }

    class Wired(Bench, BenchNode):
        """A bench with the services of the standard library of ROS in place of those that cannot be sent here."""

        def __init__(self) -> None:
            BenchNode.__init__(self, "simulator")
            Bench.__init__(self)

        def create_service(self, kind: Any, name: str, callback: Callable[[Any, Any], Any], /, **options: Any) -> Any:
            if name in requests:
                kind, callback = Trigger, translated(kind, requests[name], callback)
            return BenchNode.create_service(self, kind, name, callback, **options) if kind in (SetBool, Trigger) else None

        repeat = BenchNode.repeat
        destroy_timer = BenchNode.destroy_timer
        get_namespace = BenchNode.get_namespace

    number = domain()
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    rclpy.init(args=[], domain_id=number)
    bench = Wired()

    def serve() -> None:
        spin(bench, lambda: bench.engine.ended, threading.Event())
        bench.destroy_node()
        rclpy.try_shutdown()

    server = threading.Thread(target=serve, daemon=True)
    server.start()
    with graph_client(number) as client:
        assert client.ask(SetBool, "pause", data=True).success
        stepping = client.node.create_client(Trigger, "step_simulation")
        client.until(stepping.service_is_ready, "the service")
        answer = stepping.call_async(Trigger.Request())
        client.until(lambda: bench.engine.gate.stepped > 0, "a step")
        assert client.ask(SetBool, "pause", data=True).success
        client.until(answer.done, "the answer to the interrupted steps")
        assert "a pause, a reset or the end" in answer.result().message
        assert client.ask(Trigger, "set_simulation_state").success
        server.join(PATIENCE)  # before the client is destroyed: no two threads destroy nodes at once
    assert not server.is_alive()
