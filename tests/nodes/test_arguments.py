"""Arguments of nodes that are refused before the node does anything."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="the nodes need ROS 2; everything else is tested without")

from ros_bench import PATIENCE, domain, environment

pytestmark = [pytest.mark.node, pytest.mark.slow]


@pytest.mark.parametrize(
    ("command", "sentence"),
    [
        ("simulator --ros-args -p time_scale:=0.0 --duration 1", "'--duration 1' follows --ros-args but is no argument of ROS"),
        ("simulator --ros-args --params-file missing.yaml", "--params-file missing.yaml: there is no such file"),
        ("replayer --ros-args --params-file missing.yaml", "--params-file missing.yaml: there is no such file"),
        ("fault_detector --ros-args --params-file /dev/zero", "/dev/zero is a device: give a regular file"),
        ("fault_detector --ros-args --params-file nothing.yaml", "Couldn't parse params file: '--params-file nothing.yaml'"),
        ("hot_box_detector --ros-args -p learn", "Couldn't parse parameter override rule"),
        ("viewer --connect nonsense", "--connect nonsense is not the address of a viewer"),
        ("viewer --connect rerun+http://127.0.0.1:1/proxy", "no viewer answers at 127.0.0.1:1"),
        ("viewer --connect rerun+http://127.0.0.1:99999/proxy", "is not the address of a viewer"),
    ],
)
def test_an_argument_that_is_not_understood_is_refused_in_a_sentence(command: str, sentence: str, tmp_path: Path) -> None:
    (tmp_path / "nothing.yaml").write_text("not: [parameters", encoding="utf-8")
    words = [sys.executable, "-m", "dcrb_ros.nodes", *command.split()]
    done = subprocess.run(words, env=environment(domain()), cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert done.returncode == 2, done.stderr
    assert sentence in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert " at /" not in done.stderr
