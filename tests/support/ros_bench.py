"""Nodes as processes, and a client that receives their messages and calls their services."""

from __future__ import annotations

import os
import secrets
import socket
import subprocess
import sys
import time
from collections import defaultdict, deque
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from typing import Any

from dcrb_ros.messages.statuses import decode_diagnostics
from dcrb_ros.messages.topics import BENCH_DIAGNOSTICS, CLOCK, DETECTED, NAMESPACE, SIMULATED, VIBRATION, Topic
from dcrb_ros.nodes.publisher import message_class, qos
from dcrb_ros.nodes.reserved_domain import FIRST_PORT, LOOPBACK
from dcrb_ros.nodes.ros import node_in

PATIENCE = 600.0
"""Longest wait for anything [s]; a cold compile on a busy machine is the longest."""
PROMPT = 3.0
"""Longest time that a node takes to end after a signal [s], on a machine that starts a process at once; see `Node.end_promptly`."""
AGAIN = 60.0
"""Time without an answer after which a request is repeated [s]."""
TURN = 0.02
"""Wall time for which callbacks are served between two looks at a condition [s], so that a slow look does not delay the messages."""
QUEUE = 10_000
"""Messages that wait for the client; none is lost while a test does something else."""

LAST_SAFE_DOMAIN = 101
"""Domain up to which no discovery port is among those that Linux gives to any program."""

_reserved: deque[socket.socket] = deque(maxlen=16)
"""Sockets at the ports of the domains that this process took last; a domain is free again when its socket is deleted."""


def domain() -> int:
    """Return a ROS domain that no other test process on this machine uses, reserved as `dcrb_ros.nodes.reserved_domain` does."""
    for _ in range(10_000):
        number = secrets.randbelow(LAST_SAFE_DOMAIN) + 1
        port = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        try:
            port.bind((LOOPBACK, FIRST_PORT + number))
        except OSError:
            port.close()
        else:
            _reserved.append(port)
            return number
    raise AssertionError("all ROS domains for tests are reserved")


def environment(number: int, **changes: str) -> dict[str, str]:
    """Return the environment of a node in domain ``number`` that communicates on this machine only."""
    return {**os.environ, "ROS_DOMAIN_ID": str(number), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", **changes}


class Node:
    """A node's process with its output."""

    def __init__(self, name: str, arguments: list[str], env: dict[str, str], log: Path) -> None:
        self._log, self._env = log, env
        with log.open("wb") as output:
            self.process = subprocess.Popen(
                [sys.executable, "-m", "dcrb_ros.nodes", name, *arguments], env=env, stdout=output, stderr=subprocess.STDOUT
            )

    @property
    def output(self) -> str:
        """Everything the node has printed."""
        return self._log.read_text(errors="replace")

    def end(self, number: int) -> int:
        """Send a signal and return the exit status."""
        self.process.send_signal(number)
        return self.process.wait(PATIENCE)

    def end_promptly(self, number: int) -> int:
        """Send a signal and return the exit status; the node may take `PROMPT` and some starts of a process at the present load."""
        began = time.monotonic()
        status = self.end(number)
        took = time.monotonic() - began
        if took > PROMPT:
            began = time.monotonic()
            subprocess.run([sys.executable, "-c", "import rclpy"], env=self._env, timeout=PATIENCE, check=True)
            start = time.monotonic() - began
            assert took < PROMPT + 5.0 * start, f"it took {took:.1f} s to end, and a process takes {start:.1f} s to start"
        return status


@contextmanager
def node(name: str, arguments: list[str], env: dict[str, str], log: Path) -> Iterator[Node]:
    """Run a node, which is ended in any case."""
    started = Node(name, arguments, env, log)
    try:
        yield started
    finally:
        if started.process.poll() is None:
            started.process.kill()
        started.process.wait(PATIENCE)


def patient_qos(topic: Topic) -> Any:
    """Return the quality of service of a subscription of the client: that of the topic, with a longer queue."""
    quality = qos(topic)
    quality.depth = QUEUE
    return quality


class GraphClient:
    """A node in the test process that keeps the raw messages on every topic.

    They are taken only while the client waits (`until`), in the order of their topic; topics are not ordered among one another.
    """

    simulator = "simulator"
    """Name of the node whose parameters are set."""

    def __init__(self, number: int) -> None:
        os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
        self.number, self._resources = number, ExitStack()
        self.node, self._spin = self._resources.enter_context(node_in("listener", number))
        self.received: dict[Topic, list[bytes]] = defaultdict(list)
        self.published: dict[Topic, list[float]] = defaultdict(list)
        """Wall times at which the messages were published [s], since the epoch."""
        # The waveform last: a bench counts its subscribers before it sends a block, and has then discovered the other subscriptions.
        for topic in sorted((*SIMULATED, *DETECTED, BENCH_DIAGNOSTICS, CLOCK), key=lambda topic: topic is VIBRATION):
            self.listen(topic, topic.resolved(NAMESPACE), self.received[topic], self.published[topic])

    def listen(self, topic: Topic, name: str, kept: list[bytes], published: list[float]) -> None:
        """Keep the messages on a topic of an absolute name, and the wall times at which they were published [s]."""

        def keep(data: Any, about: Any) -> None:
            kept.append(bytes(data))
            published.append(about["source_timestamp"] * 1e-9)

        self.node.create_subscription(message_class(topic), name, keep, patient_qos(topic), raw=True)

    def ask(self, kind: Any, name: str, *, again: float = AGAIN, **fields: Any) -> Any:
        """Call a service of the bench and return its answer.

        An answer is lost if the service has not discovered the client yet. The request is repeated after every ``again`` seconds without an
        answer; a request that changes nothing may be repeated soon.
        """
        client = self.node.create_client(kind, name)
        self.until(client.service_is_ready, f"the service {name}")
        begin, futures = time.monotonic(), []

        def answered() -> bool:
            if time.monotonic() >= begin + (again * len(futures) if futures else 0.0):
                futures.append(client.call_async(kind.Request(**fields)))
            return any(future.done() for future in futures)

        self.until(answered, f"the answer of {name}")
        self.node.destroy_client(client)
        return next(future.result() for future in futures if future.done())

    def set(self, **values: Any) -> tuple[bool, str]:
        """Set parameters of the simulator atomically; return whether they were accepted, and the reason."""
        from rcl_interfaces.srv import SetParametersAtomically
        from rclpy.parameter import Parameter

        wanted = [Parameter(key.replace("__", "."), value=value).to_parameter_msg() for key, value in values.items()]
        result = self.ask(SetParametersAtomically, f"{self.simulator}/set_parameters_atomically", parameters=wanted).result
        return result.successful, result.reason

    @property
    def status(self) -> dict[str, str]:
        """The values of the simulator's last status, empty before the first."""
        found = self.received[BENCH_DIAGNOSTICS]
        return dict(decode_diagnostics(found[-1])[1][0].values) if found else {}

    def connect(self, *publishers: Any, count: int = 1) -> None:
        """Wait until publishers of this node have ``count`` subscribers each, and until the bench knows the publishers.

        A message to a subscriber that has not yet discovered its publisher may be lost; two later reports of the bench show that it has.
        """
        self.until(lambda: all(publisher.get_subscription_count() >= count for publisher in publishers), "the subscriptions")
        self.reports(2)

    def reports(self, count: int) -> None:
        """Wait for ``count`` reports that the bench publishes from now on."""
        begin = time.time()
        self.until(lambda: sum(sent > begin for sent in self.published[BENCH_DIAGNOSTICS]) >= count, f"{count} reports of the bench")

    def until(self, reached: Callable[[], Any], why: str) -> None:
        """Serve callbacks until a condition holds; fail after `PATIENCE`. The condition may look at messages that have not arrived yet."""

        def holds() -> bool:
            try:
                return bool(reached())
            except LookupError:
                return False

        end = time.monotonic() + PATIENCE
        while not holds():
            assert time.monotonic() < end, (
                f"waited {PATIENCE} s for {why}; received { {t.name: len(m) for t, m in self.received.items()} }, "
                f"the status is {self.status}"
            )
            self.serve(TURN)

    def serve(self, seconds: float) -> None:
        """Serve callbacks for some wall time [s]."""
        end = time.monotonic() + seconds
        while (remaining := end - time.monotonic()) > 0.0:
            self._spin(remaining)

    def close(self) -> None:
        """Leave the ROS graph."""
        self._resources.close()


def graph_client(number: int) -> closing[GraphClient]:
    """Return a context with a client in a ROS domain."""
    return closing(GraphClient(number))
