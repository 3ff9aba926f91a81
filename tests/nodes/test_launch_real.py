"""The launch files with the real `launch`, where it and a colcon installation of this package exist. `launch` of ROS is not on PyPI."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="the nodes need ROS 2; everything else is tested without")
pytest.importorskip("launch_ros", reason="launch_ros comes with ROS 2 from system packages, not from PyPI")

from ament_index_python.packages import PackageNotFoundError, get_package_prefix
from ros_bench import PATIENCE, domain, environment, graph_client

from dcrb_ros.messages.points import decode_vibration
from dcrb_ros.messages.topics import VIBRATION
from dcrb_ros.recordings.reader import Recording

ROOT = Path(__file__).parents[2]
LAUNCH = """
import sys
from launch import LaunchService
from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource

file, *given = sys.argv[1:]
service, arguments = LaunchService(argv=given), [tuple(word.split(":=", 1)) for word in given]
service.include_launch_description(IncludeLaunchDescription(PythonLaunchDescriptionSource(file), launch_arguments=arguments))
sys.exit(service.run())
"""


def installed() -> bool:
    """Return whether the executables are where `launch_ros` looks for them."""
    try:
        return (Path(get_package_prefix("dcrb_ros")) / "lib" / "dcrb_ros" / "simulator").exists()
    except PackageNotFoundError:
        return False


pytestmark = [
    pytest.mark.node,
    pytest.mark.skipif(not installed(), reason="launch finds executables of a colcon installation only"),
    pytest.mark.slow,
]


@contextmanager
def launched(file: str, number: int, log: Path, *given: str) -> Iterator[subprocess.Popen[bytes]]:
    """Run a launch file with its output in ``log``; yield the process."""
    command = [sys.executable, "-c", LAUNCH, str(ROOT / "launch" / f"{file}.launch.py"), *given]
    with log.open("wb") as output:
        process = subprocess.Popen(command, env=environment(number), stdout=output, stderr=subprocess.STDOUT)
    try:
        yield process
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
        process.wait(PATIENCE)


def test_ctrl_c_ends_every_node_with_status_0(tmp_path: Path) -> None:
    number, bag, log = domain(), tmp_path / "bag", tmp_path / "log"
    with (
        graph_client(number) as client,
        launched("bench", number, log, "config:=outer_ring_defect", f"record:={bag}", "clock:=True") as run,
    ):
        client.until(lambda: len(client.received[VIBRATION]) > 60, "sixty blocks")
        assert decode_vibration(client.received[VIBRATION][0]).stamp_ns == 0
        run.send_signal(signal.SIGINT)
        run.wait(PATIENCE)
    words = log.read_text()
    assert words.count("process has finished cleanly") == 2, words
    assert "Traceback" not in words
    assert Recording(bag).complete


def test_a_typo_ends_the_launch_with_the_suggestion(tmp_path: Path) -> None:
    log = tmp_path / "log"
    with launched("bench", domain(), log, "config:=outer_ring_defct") as run:
        assert run.wait(PATIENCE) == 1
    assert "did you mean 'outer_ring_defect'" in log.read_text()
    assert "process started" not in log.read_text()


@pytest.mark.parametrize("rate", ["rate:=2.0", "rate:=0.0"])
def test_the_end_of_the_replay_ends_the_launch(rate: str, tmp_path: Path) -> None:
    log = tmp_path / "log"
    with launched("replay", domain(), log, f"bag:={ROOT / 'bags' / 'outer_ring_defect'}", rate) as run:
        assert run.wait(PATIENCE) == 0
    words = log.read_text()
    assert words.count("process has finished cleanly") == 2, words
    assert "outer_ring at" in words


def test_a_launch_of_a_stated_duration_ends_with_a_verdict(tmp_path: Path) -> None:
    log = tmp_path / "log"
    with launched("bench", domain(), log, "config:=outer_ring_defect", "duration:=4.0", "time_scale:=0.0") as run:
        assert run.wait(PATIENCE) == 0
    assert "outer_ring at" in log.read_text()


def test_a_failed_node_makes_the_launch_fail(tmp_path: Path) -> None:
    number, log = domain(), tmp_path / "log"
    with graph_client(number) as client, launched("bench", number, log, "config:=outer_ring_defect") as run:
        client.until(lambda: client.received[VIBRATION], "a block")
        started = re.compile(r"simulator-\d+\]: process started with pid \[(\d+)\]")
        client.until(lambda: started.search(log.read_text()), "the number of the simulator's process")
        (simulator,) = started.findall(log.read_text())
        os.kill(int(simulator), signal.SIGKILL)
        assert run.wait(PATIENCE) == 1
    assert "simulator in dcrb has failed with status -9" in log.read_text()
