"""Soak test with random commands and faults: no late block, no memory leak, no gap, and time stamps that never decrease.

One hour of simulated time at full speed, then ten minutes at time scale 1.0 (`make soak`); the options give shorter runs.
Run it on an otherwise idle machine, since other programs can delay blocks; elsewhere accept some with --late.
"""

from __future__ import annotations

import argparse
import random
import sys
import time
from collections import Counter
from functools import partial
from typing import Any

from geometry_msgs.msg import Wrench
from process import resident, take_own_domain
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.parameter import Parameter
from std_msgs.msg import Float64
from std_srvs.srv import SetBool

from dcrb_ros.messages.cdr import stamps
from dcrb_ros.messages.statuses import decode_diagnostics
from dcrb_ros.messages.topics import BENCH_DIAGNOSTICS, CLOCK, FEATURES, GROUND_TRUTH, ROLLER_STATES, VIBRATION, Topic
from dcrb_ros.nodes.bench import node_process
from dcrb_ros.nodes.publisher import subscribe
from dcrb_ros.nodes.ros import node_in

RATE, BLOCK = 51200, 1024
LEAK = 0.2
"""Relative growth of the resident memory after the warm-up that counts as a leak [-]."""
WARM_UP = 0.1
"""Share of the run after which the memory is first measured [-]."""
START = 120.0
"""Longest wall time without a message [s]; the kernels may have to be compiled before the first block."""


class Monitor:
    """Checks the headers of the messages and the reports of a run."""

    def __init__(self, node: Any) -> None:
        self.last: dict[str, int] = {}
        self.backwards: Counter[str] = Counter()
        self.blocks = self.gaps = 0
        self.values: dict[str, str] = {}
        self.seen = time.monotonic()
        for topic in (VIBRATION, FEATURES, ROLLER_STATES, GROUND_TRUTH, CLOCK):
            subscribe(node, topic, partial(self._on_message, topic))
        subscribe(node, BENCH_DIAGNOSTICS, self._on_report)

    def _on_message(self, topic: Topic, data: bytes) -> None:
        stamp, self.seen = int(stamps([data])[0]), time.monotonic()
        if topic is VIBRATION:
            self.blocks += 1
            index, expected = round(stamp * RATE / 1e9), round(self.last.get(topic.name, stamp) * RATE / 1e9) + BLOCK
            self.gaps += topic.name in self.last and index != expected
        self.backwards[topic.name] += stamp < self.last.get(topic.name, 0)
        self.last[topic.name] = stamp

    def _on_report(self, data: bytes) -> None:
        self.values = dict(decode_diagnostics(data)[1][0].values)

    @property
    def simulated(self) -> float:
        """Simulated time reached [s]."""
        return self.last.get(VIBRATION.name, 0) * 1e-9


class RandomCommands:
    """Sends random commands to the bench."""

    def __init__(self, node: Any, chance: random.Random) -> None:
        self._chance = chance
        self._speed = node.create_publisher(Float64, "command/speed", 10)
        self._load = node.create_publisher(Wrench, "command/load", 10)
        self._set = node.create_client(SetParametersAtomically, "simulator/set_parameters_atomically")
        self._pause = node.create_client(SetBool, "pause")
        self._bars: list[str] = []
        self._commands = [self.speed, self.load, self.defect, self.defect, self.sensor, self.invalid, self.pause, self.bar]
        self.counts: Counter[str] = Counter()

    def send(self) -> None:
        """Send a random command, which may be invalid."""
        command = self._chance.choice(self._commands)
        self.counts[command.__name__] += 1
        command()

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

    def invalid(self) -> None:
        self._speed.publish(Float64(data=self._chance.choice((float("nan"), float("inf"), 1e9))))
        self._ask({"faults.outer_1.width": self._chance.choice((-1.0, 1.0, float("nan")))})

    def pause(self) -> None:
        for asked in (True, False):
            self._pause.call_async(SetBool.Request(data=asked))

    def _ask(self, values: dict[str, Any]) -> None:
        parameters = [Parameter(key, value=value).to_parameter_msg() for key, value in values.items()]
        self._set.call_async(SetParametersAtomically.Request(parameters=parameters))


def run(name: str, scale: float, seconds: float, seed: int, most_late: int) -> bool:
    """Run the bench for ``seconds`` [s] of simulated time; print the checks and return whether all of them hold.

    At most ``most_late`` blocks may be late.
    """
    chance = random.Random(seed)
    arguments = ["--duration", repr(seconds), "--ros-args", "-p", f"time_scale:={scale!r}", "-p", "publishing.clock:=true"]
    with node_in("soak") as (node, spin), node_process("simulator", arguments) as process:
        monitor, commands = Monitor(node), RandomCommands(node, chance)
        due, warm, largest, began, looked = 1.0, 0.0, 0.0, time.monotonic(), 0.0
        while process.poll() is None and time.monotonic() - monitor.seen < START:
            spin(0.1)
            if monitor.simulated > due:
                due = monitor.simulated + chance.uniform(0.2, 4.0)
                commands.send()
            if time.monotonic() - looked > 0.2:
                looked, memory = time.monotonic(), resident(process.pid)
                largest = max(largest, memory)
                warm = memory if monitor.simulated < WARM_UP * seconds else warm
        end = time.monotonic() + 1.0
        while time.monotonic() < end:
            spin(0.1)
        if process.poll() is None:  # it has been silent for too long
            process.kill()
        status = process.wait()
    wall, ends = time.monotonic() - began, monitor.simulated + BLOCK / RATE
    late = int(monitor.values.get("late_blocks", 0))
    refusals = {kind: int(monitor.values.get(f"rejected_{kind}", 0)) for kind in ("commands", "parameters")}
    checks = {
        f"exit status 0 (was {status})": status == 0,
        f"{monitor.blocks} blocks, the last to {ends:.2f} s of {seconds:g} s": monitor.blocks > 0 and ends >= seconds,
        f"no gap ({monitor.gaps})": monitor.gaps == 0,
        f"no stamp decreases ({dict(+monitor.backwards)})": not +monitor.backwards,
        f"at most {most_late} late blocks ({late})": late <= most_late,
        f"no memory leak ({warm:.0f} MB after a tenth of the run, at most {largest:.0f} MB)": largest < warm * (1.0 + LEAK),
        f"the simulator refuses what is invalid, {commands.counts['invalid']} times ({refusals})": (
            all(refusals.values()) or not commands.counts["invalid"]
        ),
    }
    sent = f"{sum(commands.counts.values())} commands {dict(commands.counts)}, seed {seed}"
    print(f"\n{name}: {monitor.simulated:.1f} s simulated in {wall:.1f} s, {sent}")
    for check, holds in checks.items():
        print(f"  {'holds ' if holds else 'FAILED'}  {check}")
    return all(checks.values())


def main() -> int:
    """Run both parts; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--flat-out", type=float, default=3600.0, help="simulated time as fast as possible [s]; 0 for none")
    parser.add_argument("--real-time", type=float, default=600.0, help="simulated time at time scale 1.0 [s]; 0 for none")
    parser.add_argument("--seed", type=int, default=int(time.time()), help="seed of the random commands, printed for repetition")
    parser.add_argument("--late", type=int, default=0, help="number of late blocks that are accepted, for a machine that is not idle")
    options = parser.parse_args()
    parts = (("full speed", 0.0, options.flat_out), ("real time", 1.0, options.real_time))
    take_own_domain()
    outcomes = [run(name, scale, seconds, options.seed, options.late) for name, scale, seconds in parts if seconds > 0.0]
    return 0 if all(outcomes) else 1


if __name__ == "__main__":
    sys.exit(main())
