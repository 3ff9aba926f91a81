"""Influence of a view on the bench: the simulator at time scale 1, alternately without and with the node `viewer`.

The view is written to a file, since the cost of a window depends on the graphics hardware. Run it on an otherwise idle machine.
"""

from __future__ import annotations

import argparse
import subprocess
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import rclpy
from process import observing, processor_times

from dcrb_ros.messages.statuses import decode_diagnostics
from dcrb_ros.messages.topics import BENCH_DIAGNOSTICS, NAMESPACE, VIBRATION
from dcrb_ros.nodes.bench import node_process
from dcrb_ros.nodes.publisher import message_class, qos

START = 60.0
"""Longest wall time that the viewer may take to start [s]."""


class Reports:
    """The reports that the simulator publishes once per second."""

    def __init__(self, node: Any) -> None:
        self.values: list[dict[str, str]] = []
        node.create_subscription(message_class(BENCH_DIAGNOSTICS), BENCH_DIAGNOSTICS.name, self._take, qos(BENCH_DIAGNOSTICS), raw=True)

    def _take(self, data: bytes) -> None:
        self.values += [dict(status.values) for status in decode_diagnostics(bytes(data))[1] if "late_blocks" in status.values]

    def of(self, key: str) -> list[float]:
        """Return the values of a key while the bench ran."""
        return [float(values[key]) for values in self.values if float(values["blocks"]) > 0.0]


def busy(process: subprocess.Popen[bytes]) -> float:
    """Return the processor time of all threads of a process [s]; 0 after it has ended."""
    try:
        return sum(processor_times(process.pid).values())
    except OSError:
        return 0.0


def run(folder: Path, config: Path | None, seconds: float, *, with_viewer: bool) -> str:
    """Run the bench for ``seconds`` [s]; return a row of the table."""
    node = rclpy.create_node("observer", namespace=NAMESPACE)
    reports, simulator_busy, viewer_busy = Reports(node), 0.0, 0.0
    arguments = ["--duration", repr(seconds), "--ros-args", "-p", "time_scale:=1.0", *(["--params-file", str(config)] if config else [])]
    with ExitStack() as stack:
        viewer = None
        if with_viewer:
            viewer = stack.enter_context(node_process("viewer", ["--save", str(folder / "live.rrd")]))
            patience = time.monotonic() + START
            while node.count_subscribers(VIBRATION.resolved(NAMESPACE)) < 1 and time.monotonic() < patience:
                rclpy.spin_once(node, timeout_sec=0.1)
        started = busy(viewer) if viewer else 0.0
        with node_process("simulator", arguments) as simulator:
            while simulator.poll() is None:
                rclpy.spin_once(node, timeout_sec=0.1)
                simulator_busy = max(simulator_busy, busy(simulator))
                viewer_busy = max(viewer_busy, busy(viewer) - started) if viewer else 0.0
    node.destroy_node()
    (folder / "live.rrd").unlink(missing_ok=True)
    late, lag, factor = reports.of("late_blocks"), reports.of("lag [s]"), reports.of("real_time_factor")
    return (
        f"| {'with viewer' if with_viewer else 'alone'} | {late[-1]:.0f} | {1e3 * max(lag):.1f} | {min(factor[1:-1]):.3f} | "
        f"{simulator_busy:.1f} | {viewer_busy:.1f} |"
    )


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--duration", type=float, default=20.0, help="simulated time of a run [s]")
    parser.add_argument("--rounds", type=int, default=3, help="number of runs of each kind")
    parser.add_argument("--config", type=Path, default=None, help="configuration file of the bench")
    options = parser.parse_args()
    print("| bench | late blocks | largest lag [ms] | smallest real-time factor | simulator, processor [s] | viewer, processor [s] |")
    print("|---|---|---|---|---|---|")
    with observing(), tempfile.TemporaryDirectory() as folder:
        for _ in range(options.rounds):
            for with_viewer in (False, True):
                print(run(Path(folder), options.config, options.duration, with_viewer=with_viewer), flush=True)


if __name__ == "__main__":
    main()
