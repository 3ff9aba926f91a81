"""What a machine without ROS 2, or without the middleware asked for, is told."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

from dcrb_ros.nodes.ros import check_ros
from dcrb_ros.refusal import Refusal


def test_nodes_say_what_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(Refusal, match=r"rclpy is not installed: source a ROS installation, or pip install 'dcrb_ros\[ros\]'"):
        check_ros()


def test_everything_but_the_nodes_works_without_ros(tmp_path: Path) -> None:
    # A module of the same name that cannot be imported stands before the real one.
    (tmp_path / "rclpy.py").write_text("raise ImportError('no ROS here')")
    code = "from dcrb_ros.cli.app import main; main()"
    env = {**os.environ, "PYTHONPATH": str(tmp_path)}

    def dcrb(*arguments: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run([sys.executable, "-c", code, *arguments], env=env, capture_output=True, text=True, timeout=200, check=False)

    bag, scene = tmp_path / "bag", tmp_path / "bag.rrd"
    for arguments in (
        ("simulate", "outer_ring_defect", "-o", str(bag), "--duration", "2.6"),
        ("detect", str(bag)),
        ("info", str(bag)),
        ("view", str(bag), "--save", str(scene)),
    ):
        done = dcrb(*arguments)
        assert done.returncode == 0, done.stderr
    assert scene.stat().st_size > 10_000


def test_kernels_compile_without_a_home(tmp_path: Path) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("no folder can be made below a file")
    env = {**os.environ, "XDG_CACHE_HOME": str(blocked / "cache")}
    code = "from dcrb_ros.core.contact import johnson_force; print(johnson_force(1e-5, 1e10, 0.4)[0] > 0.0)"
    done = subprocess.run([sys.executable, "-c", code], env=env, capture_output=True, text=True, timeout=200, check=False)
    assert done.stdout.strip() == "True", done.stderr
