"""The gate: pause, step, reset, another time scale in the middle of a wait."""

from __future__ import annotations

import threading
import time

import pytest
from waiting import PATIENCE, wait_for

from dcrb_ros.nodes.gate import Gate
from dcrb_ros.nodes.pacing import Pacer


class Model:
    """A thread that sends blocks of 20 ms through a gate."""

    def __init__(self, scale: float) -> None:
        self.gate = Gate(Pacer(scale, time.monotonic), time.monotonic)
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


def test_nothing_goes_out_after_a_pause() -> None:
    model = Model(0.0)
    wait_for(lambda: len(model.sent) > 100)
    model.gate.pause(True)
    held = list(model.sent)
    for count in range(1, 6):
        assert model.gate.step(PATIENCE)
        assert len(model.sent) == len(held) + count
    model.gate.pause(False)
    wait_for(lambda: len(model.sent) > len(held) + 100)
    model.close()
    assert model.sent == list(range(len(model.sent)))


def test_a_reset_begins_anew_even_in_a_long_wait() -> None:
    model = Model(1e-6)  # the second block is due in five hours
    wait_for(lambda: model.sent == [0])
    assert model.gate.reset(PATIENCE)
    model.gate.rescale(0.0)
    wait_for(lambda: len(model.sent) > 10)
    model.close()
    assert model.sent == [0, *range(len(model.sent) - 1)]


def test_a_scale_next_to_nothing_waits_and_can_be_changed() -> None:
    model = Model(1e-13)
    wait_for(lambda: model.sent)
    assert model.thread.is_alive()
    model.gate.rescale(5e-324)
    time.sleep(0.01)
    model.gate.rescale(0.0)
    wait_for(lambda: len(model.sent) > 100)
    model.close()


@pytest.mark.parametrize("paused", [True, False])
def test_closing_ends_every_wait(paused: bool) -> None:
    model = Model(1e-6)
    wait_for(lambda: model.sent == [0])
    model.gate.pause(paused)
    model.close()
    assert not model.gate.step(0.1)
    assert not model.gate.reset(0.1)


def test_what_the_model_cannot_do_in_time_is_said() -> None:
    gate = Gate(Pacer(1.0, time.monotonic), time.monotonic)
    gate.pause(True)
    assert not gate.step(0.01)
    assert not gate.reset(0.01)
