"""Commands in processes of their own, each with its status, output, processor time and memory.

A parent that has imported everything forks a child per command, so that a command costs what it does, not the start of an interpreter.
"""

from __future__ import annotations

import contextlib
import gc
import importlib
import json
import os
import resource
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import IO, NamedTuple

MODULES = (
    "cli.app",
    "diagnosis.detection",
    "exam.exam_file",
    "exchange.importing",
    "exchange.export",
    "nodes.detector_input",
    "plots.overview",
    "recordings.recovery",
    "recordings.replay",
    "recordings.reproduction",
    "runtime.literal_console",
    "simulation.loop",
    "sweep.loader",
    "sweep.plan",
    "viewer.document",
    "viewer.live",
    "viewer.show",
)
LIBRARIES = ("h5py", "pyarrow.parquet", "scipy.io", "rich.table", "matplotlib.pyplot")
MOST_MEMORY = 4 << 30
"""Address space of a command [bytes]: a command that asks for more fails instead of the machine."""
PATIENCE = 600
"""Least limit of the wall time of a command [s]: one that waits for ever uses no processor time."""


LONGEST = 10_000_000
"""Longest output that is read [bytes]."""


class Measured(NamedTuple):
    """The outcome of a command."""

    status: int
    """Exit status; negative if a signal ended it."""
    stdout: str
    stderr: str
    seconds: float
    """Processor time [s]."""
    resident: float
    """Largest resident memory [MB]."""

    @property
    def output(self) -> str:
        """Standard output and standard error output."""
        return self.stdout + self.stderr


class Commands:
    """The parent, which runs one command after the other."""

    def __init__(self) -> None:
        """Start the parent; it ends with the process that started it."""
        self._process = subprocess.Popen([sys.executable, __file__], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def run(self, *arguments: str, seconds: float = 30.0) -> Measured:
        """Run a command in the present folder and environment for at most some ``seconds`` of processor time.

        ``@sensor FILE`` is a live sensor description.
        """
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(json.dumps([arguments, seconds, str(Path.cwd()), dict(os.environ)]) + "\n")
        self._process.stdin.flush()
        return Measured(*json.loads(self._process.stdout.readline()))

    def run_many(self, commands: Sequence[Sequence[str]], *, seconds: float = 30.0) -> list[Measured]:
        """Run commands one after the other in one child, which is quicker; one that ends the child is run again on its own."""
        answers: list[Measured] = []
        while len(answers) < len(commands):
            rest = commands[len(answers) :]
            ran = self.run("@many", json.dumps([list(command) for command in rest]), seconds=seconds * len(rest))
            answers += [Measured(*json.loads(line)) for line in ran.stdout.splitlines() if line.startswith("[")]
            if len(answers) < len(commands):
                answers.append(self.run(*commands[len(answers)], seconds=seconds))
        return answers

    def close(self) -> None:
        """End the parent."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.close()
        self._process.stdout.close()
        self._process.wait()

    def reference(self) -> float:
        """Return the processor time that the machine needs at present for a fixed task, the median of five [s]."""
        return statistics.median(self.run("@reference").seconds for _ in range(5))


@contextlib.contextmanager
def commands() -> Iterator[Commands]:
    """Yield a parent for commands."""
    parent = Commands()
    try:
        yield parent
    finally:
        parent.close()


def _serve() -> None:
    for name in LIBRARIES:
        with contextlib.suppress(ImportError):
            importlib.import_module(name)
    for name in MODULES:
        importlib.import_module(f"dcrb_ros.{name}")
    gc.freeze()  # Otherwise a collection in a child copies the memory of its parent page by page.
    for line in sys.stdin:
        arguments, seconds, folder, environment = json.loads(line)
        print(json.dumps(_measured(arguments, seconds, folder, environment)), flush=True)


def _measured(arguments: Sequence[str], seconds: float, folder: str, environment: dict[str, str]) -> Measured:
    with tempfile.TemporaryFile() as output, tempfile.TemporaryFile() as errors:
        child = os.fork()
        if not child:
            os.chdir(folder)
            os.environ.clear()
            os.environ.update(environment)
            os._exit(_run(arguments, seconds, output.fileno(), errors.fileno()))
        _, ended, usage = os.wait4(child, 0)
        stdout, stderr = (_text(file) for file in (output, errors))
    return Measured(os.waitstatus_to_exitcode(ended), stdout, stderr, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024)


def _text(file: IO[bytes]) -> str:
    file.seek(0)
    return file.read(LONGEST).decode(errors="replace")


def _run(arguments: Sequence[str], seconds: float, output: int, errors: int) -> int:
    resource.setrlimit(resource.RLIMIT_CPU, (int(seconds) + 1, int(seconds) + 1))
    resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.alarm(max(PATIENCE, int(seconds)))
    os.dup2(output, 1)
    os.dup2(errors, 2)
    try:
        match arguments:
            case ["@sensor", file]:
                _feed(Path(file))
            case ["@reference"]:
                _reference()
            case ["@many", several]:
                _several(json.loads(several), output)
            case _:
                _command(arguments)
    except SystemExit as end:
        return int(end.code or 0)
    except BaseException as error:
        print(f"Traceback: {error!r}", file=sys.stderr)
        return 99
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
    return 0


def _several(commands: Sequence[Sequence[str]], output: int) -> None:
    """Run commands; print the status, the output and the cost of each as a line of JSON."""
    with os.fdopen(os.dup(output), "w") as lines:
        for arguments in commands:
            begin = time.process_time()
            with tempfile.TemporaryFile() as stdout, tempfile.TemporaryFile() as stderr:
                os.dup2(stdout.fileno(), 1)
                os.dup2(stderr.fileno(), 2)
                try:
                    _command(arguments)
                    status = 0
                except SystemExit as end:
                    status = int(end.code or 0)
                except BaseException as error:
                    print(f"Traceback: {error!r}", file=sys.stderr)
                    status = 99
                sys.stdout.flush()
                sys.stderr.flush()
                texts = _text(stdout), _text(stderr)
            resident = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
            print(json.dumps([status, *texts, time.process_time() - begin, resident]), file=lines, flush=True)


def _command(arguments: Sequence[str]) -> None:
    from dcrb_ros.cli.app import main

    sys.argv = ["dcrb", *arguments]
    main()


def _reference() -> None:
    """Read 800 keys with the YAML reader in Python, a task that allocates as the commands do and shares nothing with them."""
    import yaml

    yaml.load("".join(f"key{number}: {number}\n" for number in range(800)), Loader=yaml.SafeLoader)


def _feed(file: Path) -> None:
    """Pass a sensor description and two hops of a fast shaft to the detector as a node does, and to the live view."""
    import numpy as np

    from dcrb_ros.diagnosis.parameters import DetectorParameters
    from dcrb_ros.messages.plain import encode_text
    from dcrb_ros.messages.points import encode_vibration
    from dcrb_ros.nodes.detector_input import DetectorInput
    from dcrb_ros.schema.refusal import Refusal
    from dcrb_ros.stream.block import Block
    from dcrb_ros.viewer.live import bench_info

    data = encode_text(file.read_text())
    detector = DetectorInput(DetectorParameters())
    answers = [detector.sensor(data)]
    for number in range(60):
        index = 1024 * number + np.arange(1024)
        white = np.random.default_rng(number).normal(0.0, 10.0, (1024, 2))
        # White noise is that of a dead sensor.
        acceleration = np.stack([np.convolve(column, np.full(16, 0.25), "same") for column in white.T], axis=1).astype(np.float32)
        block = Block(1024 * number, 51200, acceleration, np.mod(3.0 * index, 2.0 * np.pi).astype(np.float32), acceleration)
        answers.append(detector.block(encode_vibration(block, acceleration)))
    print(*(answer.warning for answer in answers if answer.warning), *(one.reason for answer in answers for one in answer.diagnoses))
    try:
        print(bench_info(data, "live"))
    except Refusal as refusal:
        print(refusal)


if __name__ == "__main__":
    _serve()
