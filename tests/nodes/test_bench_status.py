"""The status of the simulator on /diagnostics, without ROS messages."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Generator, Iterator
from types import SimpleNamespace

import pytest

pytest.importorskip("rclpy", reason="the nodes need ROS 2; everything else is tested without")

from made_up_bundles import Blocks
from node_arguments import GARBAGE
from waiting import PATIENCE, wait_for

from dcrb_ros.messages.bundle import Bundle
from dcrb_ros.messages.statuses import OK, WARN, Status
from dcrb_ros.messages.topics import DIAGNOSIS
from dcrb_ros.nodes.bench_status import BenchStatus
from dcrb_ros.nodes.engine import Engine, Progress
from dcrb_ros.nodes.gate import Gate
from dcrb_ros.nodes.pacing import Pacer
from dcrb_ros.nodes.recording_switch import RecordingSwitch
from dcrb_ros.nodes.refusal_counts import Refusals
from dcrb_ros.nodes.simulating import SimulatingNode

COMPILING = "compiling the kernels ..."


class SlowStart(Blocks):
    """A source whose first bundle is computed when it is released."""

    def __init__(self) -> None:
        super().__init__(10**9)
        self.released = threading.Event()

    def bundles(self) -> Generator[Bundle, None, None]:
        self.released.wait(PATIENCE)
        yield from super().bundles()


class Simulator:
    """An engine with its status."""

    commands, detected, behind = SimulatingNode.commands, SimulatingNode.detected, SimulatingNode.behind

    def __init__(self) -> None:
        self.source, self.progress, self.compiling = SlowStart(), Progress(), ""
        self.engine = Engine("test engine", self.source, [self.progress], Gate(Pacer(1.0, time.monotonic), time.monotonic))
        self.refusals = Refusals(lambda _: None)
        self.recording = RecordingSwitch(lambda *_, **__: pytest.fail("nothing is recorded"), None)  # type: ignore[arg-type]
        self._status = BenchStatus(self)  # type: ignore[arg-type]

    def about(self) -> tuple[str, dict[str, str]]:
        assert self.engine.prepared, "a vehicle has no silent boxes before it is set up"
        return "", {}

    @property
    def status(self) -> Status:
        return self._status.status("/dcrb/simulator", self.progress.time_ns)

    @property
    def shown(self) -> tuple[int, str, str, str]:
        """Level, message, what the model does, and the real-time factor."""
        status = self.status
        return status.level, status.message, status.values["model"], status.values["real_time_factor"]


@pytest.fixture
def simulator() -> Iterator[Simulator]:
    made = Simulator()
    made.engine.prepare()
    yield made
    made.source.released.set()
    made.engine.close()


def test_there_is_no_real_time_factor_before_the_first_block(simulator: Simulator) -> None:
    assert simulator.shown == (OK, "waiting", "waiting", "")
    simulator.engine.start()
    assert simulator.shown == (OK, "starting", "starting", "")
    simulator.source.released.set()
    wait_for(lambda: simulator.progress.bundles > 2)
    level, message, model, factor = simulator.shown
    assert (level, message, model) == (OK, "running", "running")
    assert float(factor) > 0.0


def test_a_compilation_is_a_warning_until_the_first_block(simulator: Simulator) -> None:
    simulator.engine.start()
    simulator.compiling = COMPILING
    assert simulator.shown == (WARN, COMPILING, "starting", "")
    simulator.engine.gate.pause(True)
    assert simulator.shown == (WARN, COMPILING, "paused", "")
    simulator.source.released.set()
    wait_for(lambda: simulator.engine.computed)
    assert simulator.shown == (OK, "paused", "paused", "0.000")


def test_until_the_model_is_set_up_it_is_loading_and_perhaps_compiling() -> None:
    simulator = Simulator()
    assert simulator.shown == (OK, "loading", "loading", "")
    simulator.compiling = COMPILING
    assert simulator.shown == (WARN, COMPILING, "loading", "")
    simulator.engine.prepare()
    assert simulator.shown == (OK, "waiting", "waiting", "")


def test_a_reset_starts_again(simulator: Simulator) -> None:
    simulator.source.released.set()
    simulator.engine.start()
    wait_for(lambda: simulator.progress.bundles > 0)
    simulator.source.released.clear()
    assert simulator.engine.gate.reset(PATIENCE)
    assert simulator.shown == (OK, "starting", "starting", "")


def test_malformed_diagnoses_are_counted_also_without_a_recording() -> None:
    said, received = list[str](), dict[str, Callable[[bytes], None]]()
    refusals = Refusals(said.append)
    bench = SimpleNamespace(
        _answers=SimpleNamespace(take_recorded=lambda topic, time_ns: None),
        refusals=refusals,
        recording=SimpleNamespace(path=None),
        subscribe=lambda topic, receive: received.update({topic.name: receive}),
    )
    SimulatingNode.record_detected(bench, DIAGNOSIS)  # type: ignore[arg-type]
    for data in GARBAGE:
        received[DIAGNOSIS.name](data)
    assert refusals.count(DIAGNOSIS.name) == len(GARBAGE)
    assert said[0].startswith("diagnosis: a message of")
