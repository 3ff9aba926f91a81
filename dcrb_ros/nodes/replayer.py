"""The replayer node: a recording behind the same topics, so that no listener can tell it from the live bench."""

from __future__ import annotations

import sys
import threading
import time
from functools import partial
from typing import TYPE_CHECKING, Any

from dcrb_ros.messages.statuses import OK, WARN, Status, encode_diagnostics
from dcrb_ros.messages.topics import BENCH_DIAGNOSTICS, CLOCK, VIBRATION, Message
from dcrb_ros.nodes.clock import ClockHand
from dcrb_ros.nodes.gate import Gate
from dcrb_ros.nodes.pacing import Pacer
from dcrb_ros.nodes.publisher import Publisher
from dcrb_ros.nodes.ros import changed, declare, running, spin
from dcrb_ros.recordings.replay import Bundle, Replay, ReplayParameters
from dcrb_ros.runtime.exit_status import exit_status
from dcrb_ros.runtime.refusal import Refusal

if TYPE_CHECKING:
    from rclpy.node import Node

LAST_BUNDLE = 1.0
"""Wall time that the thread gets to end once told to stop [s]."""
DELIVERY = 2.0
"""Wall time for which the last messages are waited for [s]."""
STILL = 0.5
"""Wall time without another subscriber after which the first block goes out [s]."""
POLL = 0.05
"""Wall time between two looks for a subscriber [s]."""


class Replayer:
    """The wires between a recording and ROS."""

    def __init__(self, node: Node, parameters: ReplayParameters) -> None:
        from rclpy.clock import Clock
        from rclpy.clock_type import ClockType

        self.node, self.parameters = node, parameters
        self.stop = threading.Event()
        self.failure: Exception | None = None
        self._replay = Replay(parameters)
        self._pacer = Pacer(parameters.rate, time.monotonic)
        self._gate = Gate(self._pacer, time.monotonic)
        clock = [CLOCK] if parameters.clock else []
        self._publisher = Publisher(node, [*self._replay.topics, BENCH_DIAGNOSTICS, *clock])
        self._time_ns = self._bundles = self._passes = 0
        self._clock = ClockHand(self._publisher, asked=parameters.clock)
        # Of wall time, whatever the node's clock: a replay that stands still reports, too.
        node.create_timer(1.0, self._report, clock=Clock(clock_type=ClockType.STEADY_TIME))
        node.add_on_set_parameters_callback(self._on_parameters)
        self._thread = threading.Thread(target=self._run, name="replay", daemon=True)

    def start(self) -> None:
        """Start to replay."""
        self._publisher.write_messages(self._replay.start())
        self._thread.start()

    def ended(self) -> bool:
        """Return whether everything was replayed."""
        return not self._thread.is_alive()

    def close(self) -> None:
        """Stop, and wait until what was published has arrived."""
        self.stop.set()
        self._gate.close()
        if self._thread.ident is not None:
            self._thread.join(LAST_BUNDLE)
        self._publisher.settle(DELIVERY)

    def _run(self) -> None:
        try:
            self._await_listener()
            while not self.stop.is_set():
                self._passes += 1
                self._play()
                if not self.parameters.loop:
                    return
        except Exception as error:  # the thread's end must reach the main thread, whatever it is
            self.failure = error

    def _await_listener(self) -> None:
        """Wait for the subscribers to the waveform, and a little for those to other topics: a recording is soon over."""
        began = changed_at = time.monotonic()
        count = 0
        while VIBRATION in self._replay.topics and time.monotonic() < began + self.parameters.wait:
            found, now = self._publisher.listeners(VIBRATION), time.monotonic()
            if found != count:
                count, changed_at = found, now
            if (count >= self.parameters.listeners and now - changed_at >= STILL) or self.stop.wait(POLL):
                return

    def _play(self) -> None:
        self._pacer.start_over()
        for bundle in self._replay.bundles():
            if not self._gate.send(bundle.begin_ns * 1e-9, bundle.due_ns * 1e-9, partial(self._emit, bundle)):
                return

    def _emit(self, bundle: Bundle) -> None:
        self._clock.tick(bundle.due_ns)
        self._publisher.write_messages(bundle.messages)
        self._time_ns = bundle.due_ns
        self._bundles += 1

    def _on_parameters(self, parameters: Any) -> Any:
        from rcl_interfaces.msg import SetParametersResult

        try:
            self.parameters = changed(self.parameters, {parameter.name: parameter.value for parameter in parameters})
        except Refusal as refusal:
            return SetParametersResult(successful=False, reason=str(refusal))
        self._gate.rescale(self.parameters.rate)
        return SetParametersResult(successful=True)

    def _report(self) -> None:
        """Publish the state of the replay on /diagnostics."""
        behind, damage = self._pacer.lag > 0.1, self._replay.recording.damage
        values = {
            "bag": str(self._replay.recording.path),
            "rate": f"{self._pacer.scale:g}",
            "recorded [s]": f"{self._time_ns * 1e-9:.3f}",
            "bundles": str(self._bundles),
            "passes": str(self._passes),
            "lag [s]": f"{self._pacer.lag:.4f}",
            "late_bundles": str(self._pacer.late),
            "damage": damage[0] if damage else "none",
        }
        words = "behind the recorded pace" if behind else damage[0] if damage else "replaying"
        status = Status(self.node.get_fully_qualified_name(), WARN if behind or damage else OK, words, values)
        self._publisher.write_messages([Message(BENCH_DIAGNOSTICS, self._time_ns, encode_diagnostics(self._time_ns, [status]))])


def run(arguments: list[str]) -> int:
    """Run the node until the recording is over or a signal comes; return the exit status."""
    with running("replayer", arguments) as (node, told):
        parameters = declare(node, ReplayParameters, run_time=("rate",))
        if told.is_set():
            return 0
        replayer = Replayer(node, parameters)
        try:
            replayer.start()
            spin(node, replayer.ended, told)
        finally:
            replayer.close()
        if isinstance(replayer.failure, Refusal):
            raise replayer.failure
        if replayer.failure is not None:
            node.get_logger().fatal(f"the replay stopped: {replayer.failure}")
            return 1
        return 0


def main() -> None:
    """Run the node as a program."""
    sys.exit(exit_status("replayer", lambda: run(sys.argv[1:])))


if __name__ == "__main__":
    main()
