"""A long run with commands and faults at random: no late block, no leak, no gap, stamps that never run back.

An hour of simulated time as fast as possible, then ten minutes at time scale 1.0; `make soak`, or shorter by the options.
The machine should do nothing else: a late block may be another program's. Where the machine itself stood still it is not the bench's;
idle witnesses on every core tell (`witness.py`).
"""

from __future__ import annotations

import argparse
import math
import os
import random
import signal
import struct
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import rclpy
from geometry_msgs.msg import Wrench
from process import resident
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from std_msgs.msg import Float64
from std_srvs.srv import SetBool
from witness import Stop, Witnesses, witnesses

from dcrb_ros.messages.statuses import decode_diagnostics
from dcrb_ros.messages.topics import BENCH_DIAGNOSTICS, CLOCK, FEATURES, GROUND_TRUTH, NAMESPACE, ROLLER_STATES, VIBRATION, Topic
from dcrb_ros.nodes.publisher import message_class, qos
from dcrb_ros.nodes.ros import limit_discovery

RATE, BLOCK = 51200, 1024
LEAK = 0.2
"""Growth of the resident memory from a tenth of the run to its end that is taken for a leak [share]."""
WARM_UP = 0.1
NEAR = 0.1
"""How long a report may be on its way [s]."""
CATCHING_UP = 1.0
"""How long blocks may be late after a stop, as a share of it [-]: at twice real time it is made up for by then."""
START = 120.0
"""Longest wall time without a message [s]; the first block may have to be compiled for."""


class Watch:
    """What a run has sent so far, as far as its headers tell."""

    def __init__(self, node: Any) -> None:
        self.last: dict[str, int] = {}
        self.backwards: Counter[str] = Counter()
        self.blocks = self.gaps = 0
        self.values: dict[str, str] = {}
        self.late: list[tuple[float, float, int]] = []
        """Late blocks, with the wall times of the reports between which they came [s]."""
        self.seen = self._reported = time.monotonic()
        for topic in (VIBRATION, FEATURES, ROLLER_STATES, GROUND_TRUTH, CLOCK):
            self._listen(node, topic, self._heard(topic))
        self._listen(node, BENCH_DIAGNOSTICS, self._on_report)

    def _listen(self, node: Any, topic: Topic, callback: Callable[[bytes], None]) -> None:
        node.create_subscription(message_class(topic), topic.resolved(NAMESPACE), callback, qos(topic), raw=True)

    def _heard(self, topic: Topic) -> Callable[[bytes], None]:
        def heard(data: bytes) -> None:
            seconds, nanoseconds = struct.unpack_from("<iI", data, 4)  # behind the four bytes that say how CDR is encoded
            stamp, self.seen = seconds * 1_000_000_000 + nanoseconds, time.monotonic()
            if topic is VIBRATION:
                self.blocks += 1
                index, expected = round(stamp * RATE / 1e9), round(self.last.get(topic.name, stamp) * RATE / 1e9) + BLOCK
                self.gaps += topic.name in self.last and index != expected
            self.backwards[topic.name] += stamp < self.last.get(topic.name, 0)
            self.last[topic.name] = stamp

        return heard

    def _on_report(self, data: bytes) -> None:
        before, now = int(self.values.get("late_blocks", 0)), time.monotonic()
        self.values = dict(decode_diagnostics(data)[1][0].values)
        if (more := int(self.values["late_blocks"]) - before) > 0:
            self.late.append((self._reported, now, more))
        self._reported = now

    @property
    def simulated(self) -> float:
        """Simulated time reached [s]."""
        return self.last.get(VIBRATION.name, 0) * 1e-9

    def late_by_itself(self, stops: list[Stop]) -> int:
        """Return how many blocks were late that stops of the machine do not account for.

        Stops of a block's length account for the blocks that were due in them and while they were made up for.
        """
        own = 0
        for begin, end, count in self.late:
            stood = sum(last - first for first, last in stops if first < end + NEAR and _made_up(first, last) > begin)
            excused = math.ceil((1.0 + CATCHING_UP) * stood * RATE / BLOCK) if stood > BLOCK / RATE else 0
            own += max(0, count - excused)
        return own


def _made_up(begin: float, end: float) -> float:
    """Return the time by which a report tells the last block that a stop made late [s]."""
    return end + CATCHING_UP * (end - begin) + NEAR


class Hands:
    """Somebody who commands the bench at random."""

    def __init__(self, node: Any, chance: random.Random) -> None:
        self._chance = chance
        self._speed = node.create_publisher(Float64, "command/speed", 10)
        self._load = node.create_publisher(Wrench, "command/load", 10)
        self._set = node.create_client(SetParametersAtomically, "simulator/set_parameters_atomically")
        self._pause = node.create_client(SetBool, "pause")
        self._bars: list[str] = []
        self._acts = [self.speed, self.load, self.defect, self.defect, self.sensor, self.nonsense, self.pause, self.bar]
        self.acts: Counter[str] = Counter()

    def act(self) -> None:
        """Do something, sensible or not."""
        act = self._chance.choice(self._acts)
        self.acts[act.__name__] += 1
        act()

    def speed(self) -> None:
        self._speed.publish(Float64(data=self._chance.uniform(-200.0, 200.0)))

    def load(self) -> None:
        wrench = Wrench()
        wrench.force.x, wrench.force.y = self._chance.uniform(-20e3, 20e3), -self._chance.uniform(20e3, 120e3)
        self._load.publish(wrench)

    def defect(self) -> None:
        name = self._chance.choice(("outer_1", "inner_1", "roller_1"))
        self._ask({f"faults.{name}.width": self._chance.choice((0.0, 0.001, 0.002, 0.003))})

    def sensor(self) -> None:
        self._ask({"sensor.noise_density": self._chance.uniform(0.0, 0.01), "sensor.range": self._chance.uniform(500.0, 5000.0)})

    def bar(self) -> None:
        if len(self._bars) < 2:
            self._bars.append(f"row{self._chance.randint(1, 2)}/bar{self._chance.randint(1, 16)}")
            self._ask({"faults.broken_bars": ", ".join(sorted(set(self._bars)))})

    def nonsense(self) -> None:
        self._speed.publish(Float64(data=self._chance.choice((float("nan"), float("inf"), 1e9))))
        self._ask({"faults.outer_1.width": self._chance.choice((-1.0, 1.0, float("nan")))})

    def pause(self) -> None:
        for asked in (True, False):
            self._pause.call_async(SetBool.Request(data=asked))

    def _ask(self, values: dict[str, Any]) -> None:
        parameters = [Parameter(key, value=value).to_parameter_msg() for key, value in values.items()]
        self._set.call_async(SetParametersAtomically.Request(parameters=parameters))


def run(name: str, scale: float, seconds: float, seed: int, late: int, machine: Witnesses) -> bool:
    """Run the bench for ``seconds`` [s] of simulated time; print what was found and return whether all held.

    At most ``late`` blocks may be late while the machine did not stand still.
    """
    executor = SingleThreadedExecutor()
    node = rclpy.create_node("soak", namespace=NAMESPACE)
    executor.add_node(node)
    watch, chance = Watch(node), random.Random(seed)
    hands = Hands(node, chance)
    arguments = ["--duration", repr(seconds), "--ros-args", "-p", f"time_scale:={scale!r}", "-p", "publishing.clock:=true"]
    process = subprocess.Popen([sys.executable, "-m", "dcrb_ros.nodes", "simulator", *arguments], stdin=subprocess.DEVNULL)
    due, warm, largest, began, looked = 1.0, 0.0, 0.0, time.monotonic(), 0.0
    try:
        while process.poll() is None and time.monotonic() - watch.seen < START:
            executor.spin_once(timeout_sec=0.1)
            if watch.simulated > due:
                due = watch.simulated + chance.uniform(0.2, 4.0)
                hands.act()
            if time.monotonic() - looked > 0.2:
                looked, memory = time.monotonic(), resident(process.pid)
                largest = max(largest, memory)
                warm = memory if watch.simulated < WARM_UP * seconds else warm
        end = time.monotonic() + 1.0
        while time.monotonic() < end:
            executor.spin_once(timeout_sec=0.1)
    finally:
        if process.poll() is None:
            process.kill()
        status = process.wait()
        node.destroy_node()
    wall, ends = time.monotonic() - began, watch.simulated + BLOCK / RATE
    stops = [stop for stop in machine.stops() if stop[1] > began]
    of_all, own = int(watch.values.get("late_blocks", 0)), watch.late_by_itself(stops)
    longest = max((end - begin for begin, end in stops), default=0.0)
    checks = {
        f"ends with status 0 (was {status})": status == 0,
        f"{watch.blocks} blocks, the last to {ends:.2f} s of {seconds:g} s": watch.blocks > 0 and ends >= seconds,
        f"no gap ({watch.gaps})": watch.gaps == 0,
        f"no stamp runs back ({dict(+watch.backwards)})": not +watch.backwards,
        f"no late block of the bench's own ({own}; {of_all} with those beside a stop of the machine)": own <= late,
        f"no leak ({warm:.0f} MB after a tenth, {largest:.0f} MB at most)": largest < warm * (1.0 + LEAK),
        f"nonsense refused ({watch.values.get('rejected_commands')} commands, {watch.values.get('rejected_parameters')} parameters)": bool(
            watch.values
        ),
    }
    print(f"\n{name}: {watch.simulated:.1f} s simulated in {wall:.1f} s, {sum(hands.acts.values())} acts {dict(hands.acts)}, seed {seed}")
    print(f"  the machine stood still {len(stops)} times, for {1e3 * longest:.0f} ms at most")
    for words, holds in checks.items():
        print(f"  {'holds ' if holds else 'FAILED'}  {words}")
    return all(checks.values())


def main() -> int:
    """Run both parts; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--flat-out", type=float, default=3600.0, help="simulated time as fast as possible [s]; 0 for none")
    parser.add_argument("--real-time", type=float, default=600.0, help="simulated time at time scale 1.0 [s]; 0 for none")
    parser.add_argument("--seed", type=int, default=int(time.time()), help="of the commands; printed, to repeat a run")
    parser.add_argument("--late", type=int, default=0, help="late blocks that are let pass, on a machine that does other things too")
    options = parser.parse_args()
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # so that the bench's process is ended too
    limit_discovery()
    os.environ.setdefault("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))
    rclpy.init(args=[])
    try:
        parts = (("flat out", 0.0, options.flat_out), ("real time", 1.0, options.real_time))
        with tempfile.TemporaryDirectory(prefix="soak-") as folder, witnesses(Path(folder)) as machine:
            found = [run(name, scale, seconds, options.seed, options.late, machine) for name, scale, seconds in parts if seconds > 0.0]
    finally:
        rclpy.try_shutdown()
    return 0 if all(found) else 1


if __name__ == "__main__":
    sys.exit(main())
