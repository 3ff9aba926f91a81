"""Signals at random instants to dcrb bench and the nodes, from their start to ten seconds later (`make signals`): SIGINT, SIGTERM, kill -9.

A run fails if it prints a traceback, ends by a signal that it should have handled, leaves a process or a file in the temporary directory,
or loses more than a second of its recording. The options repeat a run; the seed is printed. Signals that arrive before the first lines of
the program, while the Python interpreter starts, are counted by themselves: no program can handle them.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter, deque
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import psutil

from dcrb_ros.messages.cdr import stamps
from dcrb_ros.messages.topics import VIBRATION
from dcrb_ros.nodes.publisher import subscribe
from dcrb_ros.nodes.ros import node_in
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.schema.refusal import Refusal

ROOT = Path(__file__).resolve().parents[1]
COMMAND = [sys.executable, "-m", "dcrb_ros.cli.program"]
NODE = [sys.executable, "-m", "dcrb_ros.nodes"]
PROGRAMS = ("bench", "simulator", "replayer", "fault_detector", "viewer")
KINDS = (signal.SIGINT, signal.SIGTERM, signal.SIGKILL)
LATEST = 10.0
"""Latest instant of a signal after the start [s]."""
SECOND = (0.0, 1.0)
"""Wall time between the first signal and a second one [s]."""
MARK = "DCRB_SIGNALS_RUN"
"""Environment variable by which the processes of a run are found."""
PATIENCE = 30.0
"""Longest wait for the end of a process [s]; `launch` gives a node 15 s."""
LOST = 1.0
"""Longest simulated time that may be missing at the end of a recording [s]."""
TRACES = ("Traceback", "Exception ignored", "Fatal Python error")
STOPPED = 130


@dataclass(frozen=True)
class Shot:
    """A signal to a program at an instant."""

    program: str
    kind: signal.Signals
    instant: float
    """After the start of the program [s]."""
    second: float | None = None
    """Time after which the signal is sent again [s]; None for a single signal."""

    def __str__(self) -> str:
        again = "" if self.second is None else f" and again {self.second:.2f} s later"
        return f"{self.kind.name} to {self.program} after {self.instant:.2f} s{again}"


@dataclass(frozen=True)
class Outcome:
    """The behaviour of a program after a signal."""

    flaws: tuple[str, ...]
    started: bool
    """Whether the program handled signals when the first one was sent."""
    took: float
    """Wall time from the signal to the end of all processes [s]."""
    output: str


def command_of(program: str, folder: Path) -> list[str]:
    """Return the command of a program that runs longer than `LATEST` and records into a folder."""
    bag = folder / "bag"
    if program == "bench":
        return [*COMMAND, "bench", "outer_ring_defect", "--duration", "60", "--record", str(bag)]
    arguments = {
        "simulator": ["--duration", "60", "--ros-args", "-p", f"recording.path:={bag}"],
        "replayer": ["--ros-args", "-p", f"bag:={ROOT / 'bags' / 'outer_ring_defect'}", "-p", "loop:=true", "-p", "wait:=1.0"],
        "viewer": ["--save", str(folder / "view.rrd")],
    }
    return [*NODE, program, *arguments.get(program, [])]


def marked(mark: str) -> list[psutil.Process]:
    """Return the processes with a mark in their environment that are not zombies."""
    processes = [process for process in psutil.process_iter(("environ", "status")) if (process.info["environ"] or {}).get(MARK) == mark]
    return [process for process in processes if process.info["status"] != psutil.STATUS_ZOMBIE]


def handles_signals(process: int) -> bool:
    """Return whether a process has a handler for SIGTERM, which Python itself does not install."""
    lines = Path(f"/proc/{process}/status").read_text().splitlines()
    caught = next(int(line.split()[1], 16) for line in lines if line.startswith("SigCgt"))
    return bool(caught >> (signal.SIGTERM - 1) & 1)


def await_end(mark: str) -> list[psutil.Process]:
    """Wait until no process has the mark, up to `PATIENCE`; kill and return those that remain."""
    deadline = time.monotonic() + PATIENCE
    while (remaining := marked(mark)) and time.monotonic() < deadline:
        time.sleep(0.05)
    for process in remaining:
        process.kill()
    return remaining


def fire(shot: Shot, folder: Path, domain: int) -> Outcome:
    """Start a program, send the signal, and check its end."""
    mark, temporary, log = f"{os.getpid()}-{folder.name}", folder / "tmp", folder / "log"
    temporary.mkdir()
    ros = {"ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    environment = {**os.environ, **ros, MARK: mark, "TMPDIR": str(temporary)}
    blocks: deque[bytes] = deque(maxlen=1)
    with node_in("signals", domain) as (node, spin), log.open("wb") as output:
        subscribe(node, VIBRATION, blocks.append)
        command = command_of(shot.program, folder)
        process = subprocess.Popen(
            command, env=environment, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT, start_new_session=True
        )
        begin = time.monotonic()
        try:
            while (remaining := begin + shot.instant - time.monotonic()) > 0.0:
                spin(remaining)
            heard, started, sent = sum(stamps(blocks)) * 1e-9, handles_signals(process.pid), time.monotonic()
            process.send_signal(shot.kind)
            if shot.second is not None:
                time.sleep(shot.second)
                process.send_signal(shot.kind)
            process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            pass
        finally:
            unended = await_end(mark)
            process.wait()
    words = log.read_text(errors="replace")
    flaws = ending_flaws(shot, process.returncode, words) if started else []
    flaws += recording_flaws(shot, folder / "bag", heard)
    flaws += [f"{len(unended)} processes remained"] if unended else []
    flaws += [f"{', '.join(path.name for path in temporary.iterdir())} remained"] if any(temporary.iterdir()) else []
    return Outcome(tuple(flaws), started, time.monotonic() - sent, words)


def ending_flaws(shot: Shot, status: int, words: str) -> list[str]:
    """Return the errors in the exit status and the output of a program."""
    if shot.kind is signal.SIGKILL:
        return [f"a child printed {trace}" for trace in TRACES if trace in words]
    expected = (0, 1, STOPPED) if shot.program == "bench" else (0,)
    flaws = [] if status in expected else [f"it ended with status {status}"]
    return flaws + [f"it printed {trace}" for trace in TRACES if trace in words]


def recorded(bag: Path) -> float:
    """Return the simulated time up to which a recording that may be incomplete can be read [s]; 0 without one."""
    try:
        return max((message.time_ns for message in Recording(bag).messages()), default=0) * 1e-9
    except (Refusal, OSError):
        return 0.0


def recording_flaws(shot: Shot, bag: Path, heard: float) -> list[str]:
    """Return the errors in the recording of a simulation that had published the block at ``heard`` [s] before the signal."""
    if shot.program not in ("bench", "simulator") or heard == 0.0:
        return []
    # A killed simulator cannot finish its recording.
    handled = shot.kind is not signal.SIGKILL or shot.program == "bench"
    flaws = ["its recording is incomplete"] if handled and not Recording(bag).complete else []
    end = recorded(bag)
    if end < heard - (0.0 if handled else LOST):
        flaws.append(f"its recording ends at {end:.2f} s, and {heard:.2f} s were published")
    return flaws


def shots(count: int, chance: random.Random) -> Iterator[Shot]:
    """Yield random shots; every fourth is a pair of signals."""
    for number in range(count):
        kind = chance.choice(KINDS)
        again = chance.uniform(*SECOND) if number % 4 == 0 and kind is not signal.SIGKILL else None
        yield Shot(chance.choice(PROGRAMS), kind, chance.uniform(0.0, LATEST), again)


BOXES = 4
SIGTERM_AFTER = 5.0
"""Wall time after which `launch` sends SIGTERM to a node that has not ended after SIGINT, by default [s]."""
RUNNING = 20.0
"""Wall time for which the axle boxes run [s]."""


def end_axle_boxes(domain: int) -> tuple[list[int], float]:
    """Run four simulators and four detectors, end them as `launch` does after Ctrl-C; return their exit statuses and the time taken [s]."""
    environment = {**os.environ, "ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    commands = [
        [*NODE, name, "--ros-args", "-r", f"__ns:=/wagon/box{box}"] for box in range(BOXES) for name in ("simulator", "fault_detector")
    ]
    processes = [subprocess.Popen(command, env=environment, stdin=subprocess.DEVNULL, stderr=subprocess.DEVNULL) for command in commands]
    time.sleep(RUNNING)
    sent = time.monotonic()
    # Ctrl-C reaches a node twice: from the terminal and from launch.
    for _ in range(2):
        for process in processes:
            process.send_signal(signal.SIGINT)
    try:
        while any(process.poll() is None for process in processes) and time.monotonic() - sent < SIGTERM_AFTER:
            time.sleep(0.05)
        for process in processes:
            process.send_signal(signal.SIGTERM)
        statuses = [process.wait(PATIENCE) for process in processes]
    finally:
        for process in processes:
            process.kill()
    return statuses, time.monotonic() - sent


def main() -> int:
    """Fire the shots; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=100, help="number of random instants")
    parser.add_argument("--seed", type=int, default=int(time.time()), help="seed of the instants, printed for repetition")
    options = parser.parse_args()
    signal.signal(signal.SIGINT, signal.default_int_handler)  # in the background it would be ignored, also by the programs
    print(f"seed {options.seed}", flush=True)
    counts: Counter[str] = Counter()
    failed = early = 0
    longest, first = 0.0, 1 + os.getpid() % 90
    with tempfile.TemporaryDirectory(prefix="signals-") as folder:
        for number, shot in enumerate(shots(options.runs, random.Random(options.seed))):
            folder_of_run = Path(folder) / str(number)
            folder_of_run.mkdir()
            # The next run begins in another domain, in which nothing of this one is left.
            outcome = fire(shot, folder_of_run, first + number % 10)
            counts[f"{shot.kind.name} {shot.program}"] += 1
            failed += bool(outcome.flaws)
            early += not outcome.started
            longest = max(longest, outcome.took)
            if outcome.flaws:
                print(f"FAILED  {shot}: {'; '.join(outcome.flaws)}\n{outcome.output}", flush=True)
    print(f"{options.runs} signals {dict(sorted(counts.items()))}")
    print(f"{early} arrived while the interpreter started; the longest end took {longest:.1f} s; {failed} failed")
    statuses, took = end_axle_boxes(first)
    print(f"{len(statuses)} processes of {BOXES} axle boxes ended with {statuses} within {took:.1f} s of Ctrl-C")
    return 1 if failed or any(statuses) else 0


if __name__ == "__main__":
    sys.exit(main())
