"""Whether a view slows the bench: the simulator at time scale 1, alone and watched by the node `viewer`, in turn.

The view is written into a file; what a window takes for drawing depends on the graphics of the machine. It should do nothing else.
"""

from __future__ import annotations

import argparse
import os
import signal
import subprocess
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import rclpy

from dcrb_ros.messages.statuses import decode_diagnostics
from dcrb_ros.messages.topics import BENCH_DIAGNOSTICS, NAMESPACE, VIBRATION
from dcrb_ros.nodes.bench import node_process
from dcrb_ros.nodes.publisher import message_class, qos
from dcrb_ros.nodes.ros import limit_discovery

START = 60.0
"""Longest wall time that the viewer may take to come up [s]."""
TICK = os.sysconf("SC_CLK_TCK")


class Reports:
    """What the simulator says of itself, once a second."""

    def __init__(self, node: Any) -> None:
        self.values: list[dict[str, str]] = []
        node.create_subscription(message_class(BENCH_DIAGNOSTICS), BENCH_DIAGNOSTICS.name, self._take, qos(BENCH_DIAGNOSTICS), raw=True)

    def _take(self, data: bytes) -> None:
        self.values += [dict(status.values) for status in decode_diagnostics(bytes(data))[1] if "late_blocks" in status.values]

    def of(self, key: str) -> list[float]:
        """Return the values of a key that came while the bench ran."""
        return [float(values[key]) for values in self.values if float(values["blocks"]) > 0.0]


def busy(process: subprocess.Popen[bytes]) -> float:
    """Return the time that a process has had on processors, all its threads together [s]; 0 once it has ended."""
    try:
        fields = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / TICK


def run(folder: Path, config: Path | None, seconds: float, *, watched: bool) -> str:
    """Run the bench for ``seconds`` [s]; return a row of the table."""
    node = rclpy.create_node("onlooker", namespace=NAMESPACE)
    reports, simulator_busy, viewer_busy = Reports(node), 0.0, 0.0
    arguments = ["--duration", repr(seconds), "--ros-args", "-p", "time_scale:=1.0", *(["--params-file", str(config)] if config else [])]
    with ExitStack() as stack:
        viewer = None
        if watched:
            viewer = stack.enter_context(node_process("viewer", ["--save", str(folder / "live.rrd")], dict(os.environ)))
            patience = time.monotonic() + START
            while node.count_subscribers(VIBRATION.resolved(NAMESPACE)) < 1 and time.monotonic() < patience:
                rclpy.spin_once(node, timeout_sec=0.1)
        started = busy(viewer) if viewer else 0.0
        with node_process("simulator", arguments, dict(os.environ)) as simulator:
            while simulator.poll() is None:
                rclpy.spin_once(node, timeout_sec=0.1)
                simulator_busy = max(simulator_busy, busy(simulator))
                viewer_busy = max(viewer_busy, busy(viewer) - started) if viewer else 0.0
    node.destroy_node()
    (folder / "live.rrd").unlink(missing_ok=True)
    late, lag, factor = reports.of("late_blocks"), reports.of("lag [s]"), reports.of("real_time_factor")
    return (
        f"| {'watched' if watched else 'alone'} | {late[-1]:.0f} | {1e3 * max(lag):.1f} | {min(factor[1:-1]):.3f} | "
        f"{simulator_busy:.1f} | {viewer_busy:.1f} |"
    )


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--duration", type=float, default=20.0, help="simulated time of a run [s]")
    parser.add_argument("--rounds", type=int, default=3, help="runs of either kind")
    parser.add_argument("--config", type=Path, default=None, help="configuration of the bench, a file")
    options = parser.parse_args()
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # so that the nodes are ended too
    limit_discovery()
    os.environ.setdefault("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))
    rclpy.init(args=[])
    print("| bench | late blocks | largest lag [ms] | least real-time factor | simulator on processors [s] | viewer on processors [s] |")
    print("|---|---|---|---|---|---|")
    try:
        with tempfile.TemporaryDirectory() as folder:
            for _ in range(options.rounds):
                for watched in (False, True):
                    print(run(Path(folder), options.config, options.duration, watched=watched), flush=True)
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
