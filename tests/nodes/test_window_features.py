"""The features that a node publishes are those of its waveform, bit for bit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from node_arguments import parameters

pytest.importorskip("rclpy", reason="the nodes need ROS 2; everything else is tested without")

from ros_bench import domain, environment, graph_client, node

from dcrb_ros import extract_features
from dcrb_ros.messages.joints import decode_joints
from dcrb_ros.messages.topics.window_features import WINDOW_FEATURES
from dcrb_ros.recordings.reader import Recording

pytestmark = [pytest.mark.node, pytest.mark.slow]


def test_a_node_publishes_and_records_the_features_of_its_waveform(tmp_path: Path) -> None:
    number = domain()
    asked = {"publishing__features": "true", "time_scale": 0.0, "cage__joint": "revolute", "recording__path": str(tmp_path / "run")}
    with (
        graph_client(number) as client,
        node("simulator", [*parameters(**asked)], environment(number), tmp_path / "simulator.log") as simulator,
    ):
        client.until(lambda: len(client.received[WINDOW_FEATURES]) >= 3, f"three windows: {simulator.output}")
        assert simulator.end(2) == 0
        received = [decode_joints(data) for data in client.received[WINDOW_FEATURES]]
    table = extract_features(Recording(tmp_path / "run"))
    ends = {round(time * 1e9): values for time, values in zip(table.time, table.values, strict=True)}
    for one in received:
        assert one.names == table.names
        assert one.position.tobytes() == ends[one.stamp_ns].tobytes()
    assert np.isfinite(received[-1].position).all()
