"""The fault detector as a lifecycle node, in a process of its own, through its transitions."""

from __future__ import annotations

import itertools
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="the nodes need ROS 2; everything else is tested without")

from made_up_blocks import blocks
from node_arguments import parameters
from ros_bench import GraphClient, Node, domain, environment, graph_client, node

from dcrb_ros.bearing.payload import body_names
from dcrb_ros.messages.encoder import BlockEncoder
from dcrb_ros.messages.topics import DIAGNOSIS, NAMESPACE, SENSOR, VIBRATION
from dcrb_ros.nodes.publisher import Publisher
from dcrb_ros.settings.configuration import Configuration

pytestmark = [pytest.mark.node, pytest.mark.slow]

UNCONFIGURED, INACTIVE, ACTIVE, FINALIZED = 1, 2, 3, 4  # lifecycle_msgs/msg/State
CONFIGURE, CLEANUP, ACTIVATE, DEACTIVATE, ACTIVE_SHUTDOWN = 1, 2, 3, 4, 7  # lifecycle_msgs/msg/Transition


class Manager:
    """What manages a detector, and sends it blocks of noise."""

    def __init__(self, client: GraphClient, process: Node) -> None:
        self.client, self.process = client, process
        configuration = Configuration()
        encoder = BlockEncoder(configuration, body_names(configuration))
        self._bench = Publisher(client.node, (SENSOR, VIBRATION))
        self._bench.write_messages(message for message in encoder.start() if message.topic == SENSOR)
        self._messages = ([message for message in encoder.encode(block) if message.topic == VIBRATION] for block in blocks(10000))
        self.sent = 0

    @property
    def state(self) -> int:
        from lifecycle_msgs.srv import GetState

        return int(self.client.ask(GetState, "fault_detector/get_state", again=10.0).current_state.id)

    def request(self, transition: int) -> bool:
        from lifecycle_msgs.msg import Transition
        from lifecycle_msgs.srv import ChangeState

        return bool(self.client.ask(ChangeState, "fault_detector/change_state", transition=Transition(id=transition)).success)

    def set(self, key: str, value: float) -> tuple[bool, str]:
        from rcl_interfaces.srv import SetParametersAtomically
        from rclpy.parameter import Parameter

        wanted = [Parameter(key, value=value).to_parameter_msg()]
        result = self.client.ask(SetParametersAtomically, "fault_detector/set_parameters_atomically", parameters=wanted).result
        return result.successful, result.reason

    def diagnosed(self, count: int, after: float | None = None) -> list[float]:
        """Send blocks until ``count`` diagnoses later than ``after`` have arrived, by default than what was sent; return their times [s].

        The blocks come in real time, so that the detector keeps up and none is lost.
        """
        sent, start = self.sent, time.monotonic()
        earliest = sent * BLOCK if after is None else after

        def times() -> list[float]:
            return [time for data in self.client.received[DIAGNOSIS] if (time := DIAGNOSIS.stamp(data) * 1e-9) > earliest]

        def arrived() -> bool:
            if len(times()) >= count:
                return True
            if (self.sent - sent) * BLOCK <= time.monotonic() - start:
                self.send(1)
            return False

        self.client.until(arrived, "diagnoses")
        return times()[:count]

    def send(self, count: int) -> None:
        """Send blocks."""
        for _ in range(count):
            self._bench.write_messages(next(self._messages))
            self.sent += 1

    def await_subscribers(self, count: int) -> None:
        """Wait until the waveform has so many subscribers; the client is one."""
        self.client.until(lambda: self._bench.subscribers(VIBRATION) == count, f"{count} subscribers to the waveform")


@pytest.fixture
def manager(tmp_path: Path) -> Iterator[Manager]:
    number = domain()
    arguments = ["--managed", *parameters(window=0.5, least_window=0.5, hop=0.1)]
    with graph_client(number) as client, node("fault_detector", arguments, environment(number), tmp_path / "log") as process:
        yield Manager(client, process)


BLOCK = 1024 / 51200
"""Length of a block [s]."""


def test_a_manager_controls_the_detector(manager: Manager) -> None:
    assert manager.state == UNCONFIGURED
    assert manager.set("hop", 0.2) == (True, "")
    accepted, reason = manager.set("hop", -1.0)
    assert (accepted, "hop" in reason) == (False, True)
    assert manager.request(ACTIVATE) is False
    assert manager.state == UNCONFIGURED

    assert manager.request(CONFIGURE)
    assert manager.state == INACTIVE
    accepted, reason = manager.set("hop", 0.3)
    assert (accepted, reason) == (
        False,
        "parameters: hop cannot change while the detector is configured; deactivate and clean it up first",
    )

    assert manager.request(ACTIVATE)
    assert manager.state == ACTIVE
    manager.await_subscribers(2)
    times = manager.diagnosed(3)
    assert [later - earlier for earlier, later in itertools.pairwise(times)] == pytest.approx([0.2, 0.2])

    assert manager.request(DEACTIVATE)
    assert manager.state == INACTIVE
    manager.await_subscribers(1)
    begin = manager.sent * BLOCK
    manager.send(50)
    end = manager.sent * BLOCK
    assert manager.request(ACTIVATE)
    manager.await_subscribers(2)
    assert all(time >= end for time in manager.diagnosed(2, after=begin))

    assert manager.request(DEACTIVATE)
    assert manager.request(CLEANUP)
    assert manager.state == UNCONFIGURED
    manager.client.until(lambda: manager.client.node.count_publishers(DIAGNOSIS.resolved(NAMESPACE)) == 0, "no publisher")
    assert manager.set("hop", 10.0) == (True, "")
    assert not manager.request(CONFIGURE)  # the window is shorter
    assert manager.set("hop", 0.1) == (True, "")
    assert manager.request(CONFIGURE)
    assert manager.request(ACTIVATE)
    manager.await_subscribers(2)
    times = manager.diagnosed(2)
    assert times[1] - times[0] == pytest.approx(0.1)

    assert manager.request(ACTIVE_SHUTDOWN)
    assert manager.state == FINALIZED
    refused = "parameters: hop cannot change once the detector is finalized; start a new node"
    assert manager.set("hop", 0.3) == (False, refused)
    manager.await_subscribers(1)
    assert manager.process.end(signal.SIGINT) == 0, manager.process.output
    assert "a callback failed" not in manager.process.output
