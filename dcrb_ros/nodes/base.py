"""Base class of the nodes: life cycle, subscriptions, timers and status."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Any

from rclpy.clock import Clock
from rclpy.clock_type import ClockType

from dcrb_ros.messages.cdr import FRAME
from dcrb_ros.messages.statuses import Status, encode_diagnostics
from dcrb_ros.messages.topics import BENCH_DIAGNOSTICS, DIAGNOSIS, NAMESPACE, Message, Topic
from dcrb_ros.nodes.answers import Answers
from dcrb_ros.nodes.other_publishers import OtherPublishers
from dcrb_ros.nodes.parameters import ParameterNode
from dcrb_ros.nodes.publisher import subscribe
from dcrb_ros.nodes.qos_overrides import overridable
from dcrb_ros.nodes.subscriber_wait import SubscriberWait

POLL_PERIOD = 0.05
"""Wall time between two counts of subscribers [s]."""


class BenchNode(ParameterNode):
    """A node with the life cycle that `dcrb_ros.nodes.ros.run_node` drives: construct, `load`, `start`, spin until `ended`, `close`."""

    purpose = "node"
    """Name of what the node runs, for the message about its failure."""

    def __init__(self, name: str) -> None:
        super().__init__(name, NAMESPACE)

    def load(self) -> None:
        """Do what takes long and leaves nothing behind if a signal interrupts it."""

    def start(self) -> None:
        """Start the work of the node; its callbacks are not served yet."""

    @property
    def ended(self) -> bool:
        """Whether the work has ended by itself."""
        return False

    @property
    def failure(self) -> Exception | None:
        """The exception that ended the work, if one did."""
        return None

    def close(self) -> None:
        """End the work; also called if it has not started."""

    def subscribe(self, topic: Topic, callback: Callable[[bytes], None]) -> Any:
        """Pass the bytes of each message on a topic to ``callback``; return the subscription, whose QoS parameters may override."""
        return subscribe(self, topic, callback, qos_overriding_options=overridable())

    def log_wait(self, *topics: Topic) -> None:
        """Log the topics on which the node waits for messages."""
        names = " and ".join(self.resolve_topic_name(topic.name) for topic in topics)
        self.get_logger().info(f"waiting for messages on {names}")

    def offer_action(self, kind: Any, name: str, execute: Callable[[Any], Awaitable[Any]], /, *, callback_group: Any = None) -> Any:
        """Offer an action whose goals are all accepted, and may be cancelled; ``execute`` gets the handle of a goal."""
        from rclpy.action.server import ActionServer, CancelResponse

        return ActionServer(self, kind, name, execute, callback_group=callback_group, cancel_callback=lambda _: CancelResponse.ACCEPT)

    def start_with_subscribers(self, wait: SubscriberWait, start: Callable[[], None]) -> None:
        """Call ``start`` once the subscribers have joined, or after the longest wait without them."""
        if wait.listeners:
            plural = "" if wait.listeners == 1 else "s"
            self.get_logger().info(f"waiting for {wait.listeners} subscriber{plural} to {wait.topic.name}, at most {wait.timeout:g} s")

        def poll() -> None:
            if wait.over():
                timer.cancel()
                if wait.missing:
                    self.get_logger().warning(wait.missing)
                start()

        timer = self.repeat(POLL_PERIOD, poll)

    def follow_detector(self, topic: Topic = DIAGNOSIS) -> Answers:
        """Return the diagnoses of a detector in the namespace of this node."""
        name = self.resolve_topic_name(topic.name)
        answers = Answers(lambda: self.count_publishers(name), self.get_logger().warning)
        self.subscribe(topic, answers.take)
        return answers

    def watch_publishers(self, *topics: Topic) -> OtherPublishers:
        """Warn about other publishers on topics of this node, within two seconds."""
        others = OtherPublishers(self, topics, self.get_logger().warning)
        self.repeat(1.0, others.look)
        return others

    def diagnostics(self, status: Status, time_ns: int, frame: str = FRAME) -> Message:
        """Return a status for /diagnostics, stamped with the wall clock, or with the simulated time [ns] if ``use_sim_time`` is set."""
        simulated = self.get_parameter("use_sim_time").value
        stamp_ns = time_ns if simulated else self.get_clock().now().nanoseconds
        return Message(BENCH_DIAGNOSTICS, stamp_ns, encode_diagnostics(stamp_ns, [status], frame))

    def repeat(self, period: float, callback: Callable[[], None]) -> Any:
        """Return a timer that calls ``callback`` every ``period`` of wall time [s], whatever ``use_sim_time`` says."""
        return self.create_timer(period, callback, clock=Clock(clock_type=ClockType.STEADY_TIME))
