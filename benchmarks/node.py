"""Cost of the simulator node: at full speed relative to the kernel alone, and at time scale 1.0 with a recording, a subscriber or a view.

The node runs in a process of its own; this process is the subscriber. The measured interval is given by reports on /diagnostics. The view
is written to a file, since the cost of a window depends on the graphics hardware.
"""

from __future__ import annotations

import os
import statistics
import tempfile
import time
from collections.abc import Iterable
from contextlib import ExitStack
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from process import processor_times, resident, take_own_domain
from real_time import kernel_factor

from dcrb_ros.messages.cdr import stamps
from dcrb_ros.messages.statuses import decode_diagnostics
from dcrb_ros.messages.topics import BENCH_DIAGNOSTICS, NAMESPACE, SIMULATED, VIBRATION, Topic
from dcrb_ros.nodes.bench import node_process
from dcrb_ros.nodes.publisher import subscribe
from dcrb_ros.nodes.ros import node_in
from dcrb_ros.settings.configuration import Configuration

PATIENCE = 120.0
"""Longest wait for the next report [s]; the kernels may have to be compiled before the first one."""
SETTLING = 2
"""Number of reports of the running node before the measured interval [-]."""


class Report(NamedTuple):
    """Progress and cost of a node at the time of a report."""

    wall: float
    """[s]."""
    simulated: float
    """[s]."""
    processor: dict[str, float]
    """Processor time by thread [s]."""
    memory: float
    """Resident memory [MB]."""
    late: int
    """Late blocks."""
    viewer: float
    """Processor time of the viewer [s]."""


class Interval(NamedTuple):
    """Progress and cost of a node between two reports."""

    begin: Report
    end: Report
    delays: list[float]
    """Arrival time of every block minus its stamp, with an arbitrary constant offset [s]."""

    @property
    def wall(self) -> float:
        """[s]."""
        return self.end.wall - self.begin.wall

    @property
    def simulated(self) -> float:
        """[s]."""
        return self.end.simulated - self.begin.simulated

    @property
    def processor(self) -> dict[str, float]:
        """Processor time by thread [s]."""
        return {name: used - self.begin.processor.get(name, 0.0) for name, used in self.end.processor.items()}


class Subscriber:
    """A subscriber to a node's reports and to some of its topics."""

    def __init__(self, node: Any, pid: int, topics: Iterable[Topic], viewer: int | None) -> None:
        self._pid, self._viewer, self.reports = pid, viewer, list[Report]()
        self.arrivals: list[tuple[float, float]] = []
        subscribe(node, BENCH_DIAGNOSTICS, self._on_report)
        for topic in topics:
            subscribe(node, topic, self._on_block if topic is VIBRATION else lambda _: None)

    def _on_block(self, data: bytes) -> None:
        self.arrivals.append((time.monotonic(), int(stamps([data])[0]) * 1e-9))

    def _on_report(self, data: bytes) -> None:
        values = decode_diagnostics(data)[1][0].values
        if int(values["blocks"]):
            processor, memory = processor_times(self._pid), resident(self._pid)
            viewer = sum(processor_times(self._viewer).values()) if self._viewer is not None else 0.0
            simulated, late = float(values["simulated [s]"]), int(values["late_blocks"])
            self.reports.append(Report(time.monotonic(), simulated, processor, memory, late, viewer))

    def interval(self) -> Interval:
        """Return the interval after settling."""
        begin, end = self.reports[SETTLING], self.reports[-1]
        return Interval(begin, end, [wall - stamp for wall, stamp in self.arrivals if begin.wall <= wall <= end.wall])


def measured(seconds: float, topics: Iterable[Topic], *settings: str, view: Path | None = None) -> Interval:
    """Return the progress and cost of a simulator in a wall time [s] while this process subscribes to some topics, and a viewer to all."""
    arguments = [word for setting in settings for word in ("-p", setting)]
    with node_in("subscriber") as (node, spin), ExitStack() as stack:
        viewer = stack.enter_context(node_process("viewer", ["--save", str(view)])) if view else None
        patience = time.monotonic() + PATIENCE
        while viewer and node.count_subscribers(VIBRATION.resolved(NAMESPACE)) < 1 and time.monotonic() < patience:
            spin(0.1)
        if viewer and viewer.poll() is not None:
            raise RuntimeError(f"the viewer ended with status {viewer.poll()}")
        process = stack.enter_context(node_process("simulator", ["--ros-args", "--log-level", "warn", *arguments]))
        subscriber = Subscriber(node, process.pid, topics, viewer.pid if viewer else None)
        reports, last = subscriber.reports, time.monotonic()
        while len(reports) <= SETTLING or reports[-1].wall - reports[SETTLING].wall < seconds:
            spin(0.1)
            last = reports[-1].wall if reports else last
            if process.poll() is not None or time.monotonic() - last > PATIENCE:
                raise RuntimeError(f"the simulator ended with status {process.poll()}, or sent no report for {PATIENCE} s")
    return subscriber.interval()


def full_speed(seconds: float, folder: Path) -> None:
    """Print the speed of the node in several set-ups, each measured for a wall time [s]."""
    setups: dict[str, tuple[tuple[Topic, ...], list[str]]] = {
        "no subscriber": ((), []),
        "a subscriber to every topic": (SIMULATED, []),
        "recording": ((), [f"recording.path:={folder / 'flat'}"]),
        "recording and subscriber": (SIMULATED, [f"recording.path:={folder / 'both'}"]),
    }
    print("| `dry` as fast as possible | simulated seconds per second | speed relative to the kernel |\n|---|---|---|")
    for name, (topics, settings) in setups.items():
        alone = kernel_factor(Configuration(), 0.5, 5)
        measurement = measured(seconds, topics, "time_scale:=0.0", *settings)
        speed = measurement.simulated / sum(measurement.processor.values())
        print(f"| {name} | {speed:.1f} | {100 * speed / alone:.0f} % |", flush=True)


def real_time(seconds: float, folder: Path) -> None:
    """Print the cost of the node at time scale 1.0 with a recording and a subscriber to every topic, measured for a wall time [s]."""
    quiet = os.getloadavg()[1] <= (os.cpu_count() or 1) - 1  # the other processes leave a core to the node
    measurement = measured(seconds, SIMULATED, "time_scale:=1.0", f"recording.path:={folder / 'real'}")
    shares = {name: 100.0 * used / measurement.wall for name, used in measurement.processor.items()}
    delays = np.array(measurement.delays)
    jitter = 1e3 * np.abs(delays - np.median(delays))
    p50, p99 = np.percentile(jitter, [50.0, 99.0])
    print(f"\n| time scale 1.0, recording, a subscriber to every topic, {measurement.wall:.0f} s | | required |\n|---|---|---|")
    print(f"| processor | {sum(shares.values()):.1f} % of a core | at most 40 % |")
    for name, share in sorted(shares.items(), key=lambda item: -item[1]):
        if share >= 0.1:
            print(f"| ... thread `{name}` | {share:.1f} % | |")
    found_jitter = f"{p50:.2f}, {p99:.2f}, {jitter.max():.1f} ms"
    if quiet:
        print(f"| publication jitter p50, p99, largest ({len(jitter)} blocks) | {found_jitter} | p99 under 5 ms |")
        print(f"| late blocks | {measurement.end.late - measurement.begin.late} | 0 |")
    else:
        print("| jitter and late blocks | not measured: other processes waited for the cores | |")
    print(f"| resident memory | {measurement.begin.memory:.0f} MB, then {measurement.end.memory:.0f} MB | flat |", flush=True)


def views(rounds: int, seconds: float, folder: Path) -> None:
    """Print the influence of a view at time scale 1.0: medians of runs in turn without and with it, each measured for a wall time [s]."""
    shares: dict[str, list[tuple[float, float]]] = {"alone": [], "with viewer": []}
    for number in range(rounds):
        for name, runs in shares.items():
            run = measured(seconds, (), "time_scale:=1.0", view=folder / f"{number}.rrd" if name == "with viewer" else None)
            runs.append((sum(run.processor.values()) / run.wall, (run.end.viewer - run.begin.viewer) / run.wall))
    print("\n| at real time | simulator, % of a core | viewer, % of a core |\n|---|---|---|")
    for name, runs in shares.items():
        simulator, viewer = (100.0 * statistics.median(column) for column in zip(*runs, strict=True))
        print(f"| {name} | {simulator:.1f} | {viewer:.1f} |", flush=True)


def main() -> None:
    """Print the tables."""
    take_own_domain()
    with tempfile.TemporaryDirectory(prefix="dcrb-") as folder:
        full_speed(4.0, Path(folder))
        real_time(20.0, Path(folder))
        views(3, 20.0, Path(folder))


if __name__ == "__main__":
    main()
