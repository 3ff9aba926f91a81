"""The gate: pause, step, reset, another time scale in the middle of a wait."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import pytest
from waiting import PATIENCE, wait_for

from dcrb_ros.nodes.gate import Gate
from dcrb_ros.nodes.pacing import Pacer


class CountingPacer(Pacer):
    """A pacer that counts how often it is asked for a wait."""

    def __init__(self, scale: float) -> None:
        super().__init__(scale, time.monotonic)
        self.asked = 0

    def until(self, begin: float, end: float) -> float:
        wait = super().until(begin, end)
        self.asked += 1
        return wait


class Sender:
    """A thread that sends blocks of 20 ms through a gate."""

    def __init__(self, scale: float) -> None:
        self.pacer = CountingPacer(scale)
        self.gate = Gate(self.pacer, time.monotonic)
        self.sent: list[int] = []
        self.thread = threading.Thread(target=self._run, daemon=True)
        self.thread.start()

    def _run(self) -> None:
        number = 0
        while not self.gate.closed:
            if self.gate.send(0.02 * number, 0.02 * (number + 1), lambda n=number: self.sent.append(n)):  # type: ignore[misc]
                number += 1
            elif not self.gate.closed:
                number = 0
                self.gate.finish_reset()

    def close(self) -> None:
        self.gate.close()
        self.thread.join(PATIENCE)
        assert not self.thread.is_alive()


class FixedPacer(Pacer):
    """A pacer that asks for the same wait before every block and counts the calls."""

    def __init__(self, wait: float) -> None:
        super().__init__(1.0, time.monotonic)
        self.wait, self.asked, self.restarts = wait, 0, 0

    def until(self, begin: float, end: float) -> float:
        wait = self.wait  # read first: a test changes it as soon as it sees the call
        self.asked += 1
        return wait

    def restart(self) -> None:
        self.restarts += 1


def gate_of(wait: float) -> tuple[Gate, FixedPacer]:
    pacer = FixedPacer(wait)
    return Gate(pacer, time.monotonic), pacer


def test_a_block_is_sent_once_it_is_due() -> None:
    gate, pacer = gate_of(0.05)
    began, sent = time.monotonic(), list[float]()
    assert gate.send(0.0, 0.02, lambda: sent.append(time.monotonic()))
    assert len(sent) == 1
    assert sent[0] - began >= 0.05
    assert pacer.asked == 1  # one deadline per block
    assert gate.send(0.02, 0.04, lambda: sent.append(time.monotonic()))
    assert sent[1] - sent[0] >= 0.05


def test_a_block_that_is_due_now_is_sent_without_a_wait() -> None:
    readings = iter([7.0, 7.0])  # one for the deadline, one for the time that remains
    pacer = FixedPacer(0.0)
    gate, sent = Gate(pacer, lambda: next(readings)), list[bool]()
    assert gate.send(0.0, 0.02, lambda: sent.append(True))
    assert sent == [True]


def test_nothing_is_sent_after_a_pause_but_steps() -> None:
    sender = Sender(0.0)
    wait_for(lambda: len(sender.sent) > 100)
    assert sender.gate.open
    sender.gate.pause(True)
    assert (sender.gate.paused, sender.gate.open) == (True, False)
    held = list(sender.sent)
    for count in range(1, 6):
        assert sender.gate.step(PATIENCE)
        assert len(sender.sent) == len(held) + count
    sender.gate.pause(False)
    wait_for(lambda: len(sender.sent) > len(held) + 100)
    sender.close()
    assert sender.sent == list(range(len(sender.sent)))


def test_a_gate_with_deadlines_is_not_open() -> None:
    assert not gate_of(0.0)[0].open


@pytest.mark.parametrize("steps", [1, 3])
def test_each_step_sends_one_block_without_a_deadline(steps: int) -> None:
    gate, pacer = gate_of(PATIENCE)
    gate.pause(True)
    assert not any(gate.step(0.0) for _ in range(steps))  # nobody sends yet
    sent: list[int] = []
    for number in range(steps):
        assert gate.send(0.0, 0.02, lambda n=number: sent.append(n))  # type: ignore[misc]
    assert (sent, pacer.asked) == (list(range(steps)), 0)
    thread = threading.Thread(target=lambda: gate.send(0.0, 0.02, lambda: sent.append(-1)), daemon=True)
    thread.start()
    thread.join(0.05)
    assert thread.is_alive()  # held again
    gate.close()
    thread.join(PATIENCE)
    assert sent == list(range(steps))


def test_requested_steps_are_counted_until_a_pause_discards_the_rest() -> None:
    gate, _ = gate_of(PATIENCE)
    gate.pause(True)
    assert not gate.stepping
    assert gate.request_steps(3) == 3
    assert gate.stepping
    for count in (1, 2):
        assert gate.send(0.0, 0.02, lambda: None)
        assert (gate.stepped, gate.stepping) == (count, True)
    gate.pause(True)
    assert (gate.stepped, gate.stepping) == (2, False)


def test_only_blocks_sent_while_paused_are_steps() -> None:
    gate, _ = gate_of(0.0)
    assert gate.send(0.0, 0.02, lambda: None)
    assert gate.stepped == 0


@pytest.mark.parametrize("end", [lambda gate: gate.close(), lambda gate: gate.reset(0.0)], ids=["close", "reset"])
def test_nothing_is_stepping_during_a_reset_and_after_the_end(end: Callable[[Gate], object]) -> None:
    gate, _ = gate_of(PATIENCE)
    gate.pause(True)
    gate.request_steps(2)
    end(gate)
    assert not gate.stepping


def test_steps_requested_before_a_pause_are_forgotten() -> None:
    gate, _ = gate_of(0.0)
    assert not gate.step(0.0)
    gate.pause(True)
    sent: list[bool] = []
    thread = threading.Thread(target=lambda: gate.send(0.0, 0.02, lambda: sent.append(True)), daemon=True)
    thread.start()
    thread.join(0.05)
    gate.close()
    thread.join(PATIENCE)
    assert not sent


def test_only_the_end_of_a_pause_restarts_the_deadlines() -> None:
    gate, pacer = gate_of(0.0)
    gate.pause(False)
    gate.pause(True)
    gate.pause(True)
    assert pacer.restarts == 0
    gate.pause(False)
    assert pacer.restarts == 1
    assert not gate.paused


@pytest.mark.parametrize("change", [lambda gate: gate.pause(False), lambda gate: gate.rescale(2.0)], ids=["pause", "rescale"])
def test_a_change_during_a_wait_determines_the_deadline_again(change: object) -> None:
    gate, pacer = gate_of(1e6)
    sent: list[bool] = []
    thread = threading.Thread(target=lambda: gate.send(0.0, 0.02, lambda: sent.append(True)), daemon=True)
    thread.start()
    wait_for(lambda: pacer.asked == 1)
    pacer.wait = 0.0
    change(gate)  # type: ignore[operator]
    thread.join(PATIENCE)
    assert (sent, pacer.asked) == ([True], 2)


def test_a_new_scale_is_passed_to_the_pacer() -> None:
    gate, pacer = gate_of(0.0)
    gate.rescale(0.0)
    assert (pacer.scale, gate.open) == (0.0, True)


def test_a_reset_interrupts_a_long_wait() -> None:
    sender = Sender(1e-6)  # the second block is due after five hours
    wait_for(lambda: sender.sent == [0])
    assert sender.gate.reset(PATIENCE)
    sender.gate.rescale(0.0)
    wait_for(lambda: len(sender.sent) > 10)
    sender.close()
    assert sender.sent == [0, *range(len(sender.sent) - 1)]


def test_a_finished_reset_restarts_the_deadlines_and_forgets_steps() -> None:
    gate, pacer = gate_of(0.0)
    gate.pause(True)
    assert not gate.step(0.0)
    assert not gate.reset(0.0)
    assert not gate.send(0.0, 0.02, lambda: None)  # discarded
    gate.finish_reset()
    assert pacer.restarts == 1
    assert gate.paused
    gate.pause(False)
    assert gate.send(0.0, 0.02, lambda: None)


def test_a_reset_during_a_pause_leaves_no_step_behind() -> None:
    sender = Sender(0.0)
    wait_for(lambda: len(sender.sent) > 10)
    sender.gate.pause(True)
    assert sender.gate.reset(PATIENCE)
    before = len(sender.sent)
    for count in range(1, 4):
        assert sender.gate.step(PATIENCE)
        assert sender.sent[before:] == list(range(count))
    sender.close()


def test_a_step_requested_while_a_reset_is_pending_is_sent_from_the_start() -> None:
    gate, _ = gate_of(PATIENCE)
    gate.pause(True)
    assert not gate.step(0.0)  # before the reset, which discards it
    assert not gate.reset(0.0)
    assert gate.resetting
    answers, sent = list[bool](), list[bool]()
    stepper = threading.Thread(target=lambda: answers.append(gate.step(PATIENCE)), daemon=True)
    stepper.start()
    wait_for(lambda: gate.stepping)
    assert not gate.send(0.0, 0.02, lambda: None)  # the bundle made before the reset
    gate.finish_reset()
    assert not gate.resetting
    stepper.join(0.05)
    assert stepper.is_alive()  # nothing was sent yet
    assert gate.send(0.0, 0.02, lambda: sent.append(True))
    stepper.join(PATIENCE)
    assert (answers, sent, gate.stepping) == ([True], [True], False)


def test_a_step_that_a_reset_or_a_pause_discards_is_reported() -> None:
    for discard in (lambda gate: gate.reset(0.0), lambda gate: gate.pause(True)):
        gate, _ = gate_of(PATIENCE)
        gate.pause(True)
        answers: list[bool] = []
        stepper = threading.Thread(target=lambda g=gate, a=answers: a.append(g.step(PATIENCE)), daemon=True)  # type: ignore[misc]
        stepper.start()
        wait_for(lambda g=gate: g.stepping)
        discard(gate)
        stepper.join(PATIENCE)
        assert answers == [False]


def test_start_over_is_passed_to_the_pacer() -> None:
    pacer = Pacer(1e-6, time.monotonic)
    gate, sent = Gate(pacer, time.monotonic), list[int]()
    for number in range(3):
        gate.start_over()
        assert gate.send(0.0, 0.02, lambda n=number: sent.append(n))  # type: ignore[misc]
    assert sent == [0, 1, 2]


def test_a_scale_near_zero_waits_and_can_be_changed() -> None:
    sender = Sender(1e-13)
    wait_for(lambda: sender.sent)
    assert sender.thread.is_alive()
    for scale in (5e-324, 0.0):
        asked = sender.pacer.asked
        sender.gate.rescale(scale)
        wait_for(lambda known=asked: sender.pacer.asked > known)
    wait_for(lambda: len(sender.sent) > 100)
    sender.close()


@pytest.mark.parametrize("paused", [True, False])
def test_close_ends_every_wait(paused: bool) -> None:
    sender = Sender(1e-6)
    wait_for(lambda: sender.sent == [0])
    sender.gate.pause(paused)
    sender.close()
    assert not sender.gate.step(PATIENCE)
    assert not sender.gate.reset(PATIENCE)
    assert not sender.gate.send(0.0, 0.02, lambda: None)


def test_a_timeout_is_reported() -> None:
    gate, _ = gate_of(0.0)
    gate.pause(True)
    assert not gate.step(0.01)
    assert not gate.reset(0.01)
