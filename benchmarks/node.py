"""What the simulator node costs: flat out against the kernel alone, and at time scale 1.0 with a recording and a subscriber.

The node is a process of its own, this process the subscriber. Reports on /diagnostics mark the stretch that is measured.
"""

from __future__ import annotations

import argparse
import os
import signal
import statistics
import struct
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import rclpy
from process import processor_times, resident
from rclpy.executors import SingleThreadedExecutor
from real_time import kernel

from dcrb_ros.messages.statuses import decode_diagnostics
from dcrb_ros.messages.topics import BENCH_DIAGNOSTICS, NAMESPACE, SIMULATED, VIBRATION, Topic
from dcrb_ros.nodes.bench import node_process
from dcrb_ros.nodes.publisher import message_class, qos
from dcrb_ros.nodes.ros import limit_discovery
from dcrb_ros.settings.configuration import Configuration

PATIENCE = 120.0
"""Longest wait for the next report [s]; the kernels may have to be compiled before the first one."""
SETTLING = 2
"""Reports of a running model before the one that begins the stretch."""


class Mark(NamedTuple):
    """How far a node was when it reported."""

    wall: float
    """[s]."""
    simulated: float
    """[s]."""
    processor: Counter[str]
    """Processor time by thread [s]."""
    memory: float
    """Resident memory [MB]."""
    late: int
    """Late blocks."""


class Stretch(NamedTuple):
    """What a node did between two reports."""

    begin: Mark
    end: Mark
    delays: list[float]
    """Arrival of every block after its stamp, on a common line [s]."""

    @property
    def wall(self) -> float:
        """[s]."""
        return self.end.wall - self.begin.wall

    @property
    def simulated(self) -> float:
        """[s]."""
        return self.end.simulated - self.begin.simulated

    @property
    def processor(self) -> Counter[str]:
        """Processor time by thread [s]."""
        return self.end.processor - self.begin.processor


class Ear:
    """A subscriber to a node's reports, and to some of its topics."""

    def __init__(self, node: Any, pid: int, topics: Iterable[Topic]) -> None:
        self._pid, self.marks = pid, list[Mark]()
        self.arrivals: list[tuple[float, float]] = []
        self._listen(node, BENCH_DIAGNOSTICS, self._on_report)
        for topic in topics:
            self._listen(node, topic, self._on_block if topic is VIBRATION else len)

    def _listen(self, node: Any, topic: Topic, callback: Callable[[bytes], object]) -> None:
        node.create_subscription(message_class(topic), topic.resolved(NAMESPACE), callback, qos(topic), raw=True)

    def _on_block(self, data: bytes) -> None:
        seconds, nanoseconds = struct.unpack_from("<iI", data, 4)  # behind the four bytes that say how CDR is encoded
        self.arrivals.append((time.monotonic(), seconds + nanoseconds * 1e-9))

    def _on_report(self, data: bytes) -> None:
        values = decode_diagnostics(data)[1][0].values
        if int(values["blocks"]):
            processor, memory = processor_times(self._pid), resident(self._pid)
            self.marks.append(Mark(time.monotonic(), float(values["simulated [s]"]), processor, memory, int(values["late_blocks"])))

    def stretch(self) -> Stretch:
        """Return what was heard from the end of the settling on."""
        begin, end = self.marks[SETTLING], self.marks[-1]
        return Stretch(begin, end, [wall - stamp for wall, stamp in self.arrivals if begin.wall <= wall <= end.wall])


def measured(seconds: float, topics: Iterable[Topic], *settings: str) -> Stretch:
    """Return what a simulator does in a wall time [s] while this process listens to some topics."""
    node, executor = rclpy.create_node("ear", namespace=NAMESPACE), SingleThreadedExecutor()
    executor.add_node(node)
    arguments = [word for setting in settings for word in ("-p", setting)]
    try:
        with node_process("simulator", ["--ros-args", "--log-level", "warn", *arguments], dict(os.environ)) as process:
            ear, heard = Ear(node, process.pid, topics), time.monotonic()
            while len(ear.marks) <= SETTLING or ear.marks[-1].wall - ear.marks[SETTLING].wall < seconds:
                executor.spin_once(timeout_sec=0.1)
                heard = ear.marks[-1].wall if ear.marks else heard
                if process.poll() is not None or time.monotonic() - heard > PATIENCE:
                    raise RuntimeError(f"the simulator ended with {process.poll()}, or has said nothing for {PATIENCE} s")
    finally:
        executor.shutdown()
        node.destroy_node()
    return ear.stretch()


def kernel_factors(duration: float, runs: int) -> tuple[float, float]:
    """Return simulated over wall and over processor time of the kernel alone [-], medians of some runs of a duration [s]."""
    run, found = kernel(Configuration()), list[tuple[float, float]]()
    run(0.2)
    for _ in range(runs):
        wall, processor = time.perf_counter(), time.process_time()
        run(duration)
        found.append((duration / (time.perf_counter() - wall), duration / (time.process_time() - processor)))
    return statistics.median(wall for wall, _ in found), statistics.median(processor for _, processor in found)


def flat_out(seconds: float, folder: Path) -> None:
    """Print what the node reaches as fast as it goes, each way for a wall time [s]."""
    ways: dict[str, tuple[tuple[Topic, ...], list[str]]] = {
        "nobody listens": ((), []),
        "a subscriber to every topic": (SIMULATED, []),
        "recording": ((), [f"recording.path:={folder / 'flat'}"]),
        "recording and the subscriber": (SIMULATED, [f"recording.path:={folder / 'both'}"]),
    }
    print("| flat out | x real time | of the kernel | simulated over processor time | of the kernel |\n|---|---|---|---|---|")
    for name, (topics, settings) in ways.items():
        wall, processor = kernel_factors(0.5, 5)
        found = measured(seconds, topics, "time_scale:=0.0", *settings)
        own, own_processor = found.simulated / found.wall, found.simulated / found.processor.total()
        print(
            f"| {name} | {own:.2f} | {100 * own / wall:.0f} % of {wall:.2f} | {own_processor:.2f} | "
            f"{100 * own_processor / processor:.0f} % of {processor:.2f} |",
            flush=True,
        )


def real_time(seconds: float, folder: Path) -> None:
    """Print what the node takes at time scale 1.0 with a recording and a subscriber to every topic, in a wall time [s]."""
    found = measured(seconds, SIMULATED, "time_scale:=1.0", f"recording.path:={folder / 'real'}")
    shares = Counter({name: 100.0 * used / found.wall for name, used in found.processor.items()})
    delays = np.array(found.delays)
    jitter = 1e3 * np.abs(delays - np.median(delays))
    p50, p99 = np.percentile(jitter, [50.0, 99.0])
    print(f"\n| time scale 1.0, recording, a subscriber to every topic, {found.wall:.0f} s | | asked |\n|---|---|---|")
    print(f"| processor | {shares.total():.1f} % of a core | at most 40 % |")
    for name, share in shares.most_common():
        if share >= 0.1:
            print(f"| ... thread `{name}` | {share:.1f} % | |")
    print(f"| publication jitter p50, p99, most ({len(jitter)} blocks) | {p50:.2f}, {p99:.2f}, {jitter.max():.1f} ms | p99 under 5 ms |")
    print(f"| late blocks | {found.end.late - found.begin.late} | 0 |")
    print(f"| resident memory | {found.begin.memory:.0f} MB, then {found.end.memory:.0f} MB | flat |", flush=True)


def main() -> None:
    """Print two tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--flat-out", type=float, default=4.0, help="wall time of each way flat out [s]; 0 for none")
    parser.add_argument("--duration", type=float, default=20.0, help="wall time at time scale 1.0 [s]; 0 for none")
    options = parser.parse_args()
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # so that the node's process is ended too
    limit_discovery()
    os.environ.setdefault("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))
    print(f"Load of the machine before: {os.getloadavg()[0]:.1f}\n")
    rclpy.init(args=[])
    try:
        with tempfile.TemporaryDirectory(prefix="dcrb-") as folder:
            if options.flat_out > 0.0:
                flat_out(options.flat_out, Path(folder))
            if options.duration > 0.0:
                real_time(options.duration, Path(folder))
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
