"""A recording of a node that received commands is reproduced without ROS."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="the nodes need ROS 2; everything else is tested without")

from node_arguments import parameters
from ros_bench import domain, environment, graph_client, node
from separate_process import dcrb

from dcrb_ros.messages.statuses import decode_truth
from dcrb_ros.messages.topics import GROUND_TRUTH, VIBRATION
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.stream.events import LoadCommand, SpeedCommand

pytestmark = [pytest.mark.node, pytest.mark.slow]


def test_a_run_with_commands_is_reproduced_without_ros(tmp_path: Path) -> None:
    from geometry_msgs.msg import Wrench
    from std_msgs.msg import Float64

    number, bag = domain(), tmp_path / "bag"
    given = parameters(recording__path=str(bag), recording__split_duration=0.5, faults__inner_1__width=0.002)
    with graph_client(number) as client, node("simulator", given, environment(number), tmp_path / "log") as simulator:
        speed = client.node.create_publisher(Float64, "command/speed", 10)
        load = client.node.create_publisher(Wrench, "command/load", 10)
        client.connect(speed, load)

        def commands() -> list[object]:
            return [truth.event for truth in map(decode_truth, client.received[GROUND_TRUTH])]

        speed.publish(Float64(data=140.0))
        client.until(lambda: SpeedCommand(140.0) in commands(), "the speed")
        wrench = Wrench()
        wrench.force.x, wrench.force.y = 500.0, -60e3
        load.publish(wrench)
        client.until(lambda: LoadCommand(500.0, -60e3) in commands(), "the load")
        blocks = len(client.received[VIBRATION])
        client.until(lambda: len(client.received[VIBRATION]) > blocks + 40, "blocks after the commands")
        assert simulator.end(signal.SIGINT) == 0
    recording = Recording(bag)
    assert recording.complete
    assert len(recording.files) > 1
    assert [timed.command for timed in recording.commands()] == [SpeedCommand(140.0), LoadCommand(500.0, -60e3)]
    done = dcrb("simulate", "--from", str(bag))
    assert done.returncode == 0, done.stderr
    assert "the same" in done.stdout
