"""Parameters of a node: what others may set, without a process of its own."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="the nodes need ROS 2; everything else is tested without")

import rclpy
from made_up_blocks import recorded
from rclpy.parameter import Parameter

from dcrb_ros.nodes.base import BenchNode
from dcrb_ros.nodes.replayer import ReplayerNode
from dcrb_ros.nodes.simulator import RUN_TIME
from dcrb_ros.recordings.replay import ReplayParameters
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import flatten


class Asked(BenchNode):
    """A node with the parameters of the simulator that keeps what it is asked for, and refuses what is fixed."""

    def __init__(self) -> None:
        super().__init__("asked")
        self.changes: list[dict[str, Any]] = []
        self.declare(Configuration, run_time=RUN_TIME)

    def on_parameters(self, changes: dict[str, Any]) -> None:
        self.changes.append(changes)
        for key in changes:
            if key not in RUN_TIME:
                raise Refusal(f"{key} is fixed")


@pytest.fixture
def ros(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")
    rclpy.init(args=[])
    try:
        yield
    finally:
        rclpy.try_shutdown()


@pytest.fixture
def node(ros: None) -> Iterator[Asked]:
    asked = Asked()
    yield asked
    asked.destroy_node()


def answer(node: BenchNode, **values: Any) -> tuple[bool, str]:
    """Return the answer to a request."""
    result = node.set_parameters_atomically([Parameter(key.replace("__", "."), value=value) for key, value in values.items()])
    return result.successful, result.reason


def test_every_parameter_may_be_set_to_the_value_that_it_has(node: Asked) -> None:
    present = [node.get_parameter(name) for name in node.list_parameters([], 0).names]
    assert {parameter.name for parameter in present} > set(flatten(Configuration().model_dump()))
    assert [(one.name, node.set_parameters_atomically([one]).reason) for one in present] == [(one.name, "") for one in present]
    assert {key for changes in node.changes for key in changes} == set(RUN_TIME)


def test_an_integer_is_the_present_value_of_a_number(node: Asked) -> None:
    assert answer(node, operating__load=100000, bearing__rows=2) == (True, "")
    assert node.changes == []


def test_a_fixed_parameter_refuses_another_value_and_takes_the_request_with_it(node: Asked) -> None:
    assert answer(node, bearing__rows=1) == (False, "bearing.rows is fixed")
    assert answer(node, bearing__rows=2.0) == (False, "bearing.rows is fixed")
    assert answer(node, faults__outer_1__width=0.002, bearing__rows=1)[0] is False
    assert node.get_parameter("faults.outer_1.width").value == 0.0
    assert answer(node, faults__outer_1__width=0.002, bearing__rows=2) == (True, "")
    assert node.get_parameter("faults.outer_1.width").value == 0.002
    assert node.changes[-1] == {"faults.outer_1.width": 0.002}


def test_a_replay_that_refuses_a_fixed_parameter_keeps_its_rate(ros: None, tmp_path: Path) -> None:
    replayer = ReplayerNode(ReplayParameters(bag=str(recorded(tmp_path / "bag", 3)), rate=1.0))
    assert answer(replayer, rate=5.0, loop=True) == (False, "parameters: loop is fixed while the replay runs: give it at the start")
    assert (replayer.get_parameter("rate").value, replayer._engine.gate.pacer.scale) == (1.0, 1.0)
    assert answer(replayer, rate=-1.0)[0] is False
    assert answer(replayer, rate=5.0, loop=False) == (True, "")
    assert (replayer.get_parameter("rate").value, replayer._engine.gate.pacer.scale) == (5.0, 5.0)
    replayer.destroy_node()
