"""The engine: bundles in order, pause, step, reset, loop, failure. No ROS."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import fields, replace
from types import SimpleNamespace

import numpy as np
import pytest
from made_up_blocks import blocks
from made_up_bundles import BLOCK_NS, Blocks
from waiting import PATIENCE, wait_for

from dcrb_ros.messages.bundle import Bundle
from dcrb_ros.messages.topics import SENSOR, Message
from dcrb_ros.nodes import engine as engine_module
from dcrb_ros.nodes.engine import Engine, Progress
from dcrb_ros.nodes.gate import Gate
from dcrb_ros.nodes.pacing import Pacer
from dcrb_ros.runtime.threads import NamedThread
from dcrb_ros.stream.states import Account


class Log:
    """A sink that keeps the topics and the numbers of the blocks, and the thread that wrote last."""

    def __init__(self) -> None:
        self.received: list[str | int] = []
        self.thread = ""

    @property
    def blocks(self) -> list[int]:
        return [entry for entry in self.received if isinstance(entry, int)]

    def start(self, messages: Sequence[Message]) -> None:
        self.received += [message.topic.name for message in messages]

    def write(self, bundle: Bundle) -> None:
        self.received.append(bundle.begin_ns // BLOCK_NS)
        self.thread = threading.current_thread().name


def engine_of(source: Blocks, *sinks: Log | Progress, scale: float = 0.0, loop: bool = False) -> Engine:
    return Engine("test engine", source, sinks, Gate(Pacer(scale, time.monotonic), time.monotonic), loop=loop)


def run(engine: Engine) -> None:
    engine.prepare()
    engine.start()


def test_every_sink_receives_the_start_and_all_bundles_in_order_from_the_engine_thread() -> None:
    logs, progress = [Log(), Log()], Progress()
    engine = engine_of(Blocks(100), *logs, progress)
    assert not engine.ended
    run(engine)
    wait_for(lambda: engine.ended)
    for log in logs:
        assert log.received == [SENSOR.name, *range(100)]
        assert log.thread == "test engine"
    assert (progress.bundles, progress.time_ns) == (100, 100 * BLOCK_NS)
    assert engine.failure is None


def test_a_reset_starts_the_source_and_the_sinks_again() -> None:
    source, log, progress = Blocks(10**9), Log(), Progress()
    engine = engine_of(source, log, progress)
    run(engine)
    wait_for(lambda: progress.bundles > 20)
    engine.gate.pause(True)
    before = len(log.received)
    assert engine.gate.reset(PATIENCE)
    assert log.received == [SENSOR.name, *range(before - 1), SENSOR.name]
    assert (progress.bundles, progress.time_ns) == (0, 0)
    assert engine.gate.step(PATIENCE)
    assert engine.gate.step(PATIENCE)
    assert log.received[before:] == [SENSOR.name, 0, 1]
    assert (source.starts, source.open_iterators) == (2, 1)
    engine.close()
    assert source.open_iterators == 0


def test_a_reset_before_the_start_is_done_at_once() -> None:
    source, log = Blocks(3), Log()
    engine = engine_of(source, log)
    engine.prepare()
    assert engine.reset(0.0)
    assert (log.received, source.starts, engine.gate.resetting) == ([SENSOR.name, SENSOR.name], 2, False)
    engine.start()
    wait_for(lambda: engine.ended)
    assert log.blocks == [0, 1, 2]


def test_close_interrupts_a_long_wait() -> None:
    source, log = Blocks(10), Log()
    engine = engine_of(source, log, scale=1e-6)  # the second block is due after five hours
    run(engine)
    wait_for(lambda: log.blocks == [0])
    engine.close()
    assert engine.ended
    assert (log.blocks, source.open_iterators) == ([0], 0)


@pytest.mark.parametrize("close", [lambda engine: engine.close(), lambda engine: engine.gate.close()], ids=["engine", "gate"])
def test_an_engine_closed_before_its_start_has_ended(close: Callable[[Engine], None]) -> None:
    log = Log()
    engine = engine_of(Blocks(10), log)
    assert not engine.ended
    close(engine)
    assert engine.ended
    engine.start()  # the wait for subscribers may still be running
    wait_for(lambda: engine.ended)
    assert log.blocks == []


def test_a_loop_starts_again_at_the_end_and_sends_the_first_bundle_at_once() -> None:
    log = Log()
    engine = engine_of(Blocks(1), log, scale=1e-6, loop=True)  # each pass has only the bundle without a deadline
    run(engine)
    wait_for(lambda: len(log.blocks) > 20)
    engine.close()
    assert set(log.blocks) == {0}
    assert engine.passes >= len(log.blocks)


@pytest.mark.parametrize("where", ["source", "sink"])
def test_a_failure_ends_the_engine_and_is_kept(where: str) -> None:
    class Broken(Log):
        def write(self, bundle: Bundle) -> None:
            raise OSError("broken")

    engine = engine_of(Blocks(3, OSError("broken")), Log() if where == "source" else Broken())
    run(engine)
    wait_for(lambda: engine.ended)
    assert str(engine.failure) == "broken"


def test_progress_starts_at_zero_and_keeps_the_last_residual_of_the_energy_balance() -> None:
    progress = Progress()
    assert (progress.time_ns, progress.bundles, progress.energy_residual) == (0, 0, None)
    made = replace(next(blocks(1)), states=[SimpleNamespace(lubrication="films", thermal="temperatures")])
    account = Account(*[2.0**k for k in range(len(fields(Account)))])
    for number, block in enumerate((replace(made, energy=account), made, None)):
        progress.write(Bundle(number * BLOCK_NS, (number + 1) * BLOCK_NS, (), block))
        assert (progress.time_ns, progress.bundles) == ((number + 1) * BLOCK_NS, number + 1)
        assert progress.energy_residual == account.residual != 0.0
        assert (progress.lubrication, progress.thermal) == ("films", "temperatures")
    progress.start([])
    assert vars(progress) == vars(Progress())


def test_the_deadlines_are_those_of_the_bundles_in_seconds() -> None:
    asked: list[tuple[float, float]] = []

    class Spy(Pacer):
        def until(self, begin: float, end: float) -> float:
            asked.append((begin, end))
            return 0.0

    engine = Engine("test engine", Blocks(3), [Log()], Gate(Spy(1.0, time.monotonic), time.monotonic))
    run(engine)
    wait_for(lambda: engine.ended)
    assert np.array(asked) == pytest.approx(np.array([[0.0, 0.02], [0.02, 0.04], [0.04, 0.06]]), rel=1e-9)


def test_a_source_is_played_once_unless_the_engine_is_to_loop() -> None:
    log = Log()
    gate = Gate(Pacer(0.0, time.monotonic), time.monotonic)
    engine = Engine("test engine", Blocks(3), [log], gate)
    assert engine.passes == 0
    run(engine)
    wait_for(lambda: engine.ended)
    assert (engine.passes, log.blocks) == (1, [0, 1, 2])
    with pytest.raises(TypeError):
        Engine("test engine", Blocks(3), [log], gate, True)  # type: ignore[call-arg]


def test_passes_are_counted_in_a_loop_and_after_a_reset() -> None:
    class Closing(Log):
        """A sink that closes the gate at its fifth bundle."""

        def write(self, bundle: Bundle) -> None:
            super().write(bundle)
            if len(self.blocks) == 5:
                engine.gate.close()

    log, source = Closing(), Blocks(1)
    engine = engine_of(source, log, loop=True)
    run(engine)
    wait_for(lambda: engine.ended)
    assert (engine.passes, log.blocks, source.starts) == (5, [0] * 5, 1)
    source = Blocks(10**9)
    engine = engine_of(source, Progress())
    run(engine)
    for passes in (1, 2, 3):
        wait_for(lambda known=passes: engine.passes == known)
        assert engine.gate.reset(PATIENCE)
    wait_for(lambda: engine.passes == 4)
    assert source.starts == 4
    engine.close()


def test_close_leaves_a_thread_that_does_not_end_after_less_than_a_second(monkeypatch: pytest.MonkeyPatch) -> None:
    waits: list[float | None] = []

    class Stuck(NamedThread):
        ident = 1

        def is_alive(self) -> bool:
            return True

        def join(self, timeout: float | None = None) -> None:
            waits.append(timeout)

    monkeypatch.setattr(engine_module, "NamedThread", Stuck)
    engine = engine_of(Blocks(1), Log())
    engine.close()
    assert engine.gate.closed
    assert not engine.ended
    (wait,) = waits
    assert wait is not None
    assert 0.0 < wait < 1.0
