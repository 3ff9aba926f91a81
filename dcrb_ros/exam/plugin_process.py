"""A detector written in Python as a candidate that runs in a process of its own, within limits of time, memory and output."""

from __future__ import annotations

import pickle
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from multiprocessing.util import Finalize
from typing import Any

from dcrb_ros.exam.detector_process import FAILED, LEFTOVER, MESSAGE, NOTHING, READY, REFUSED, STATUSES, VERDICT, Begin, Request
from dcrb_ros.exam.detector_run import Signal, arrived, detector_blocks
from dcrb_ros.exam.evaluation import AnyOutcome, CandidateRefusal, Outcome
from dcrb_ros.exam.limits import Limits
from dcrb_ros.exam.packets import receive_packet, send_packet
from dcrb_ros.exam.running_detector import checked_output
from dcrb_ros.messages.received_diagnosis import ReceivedDiagnosis, decode_diagnosis
from dcrb_ros.runtime.child_output import ChildOutput
from dcrb_ros.runtime.children import group_guard, kill_group, kill_marked, marked_environment
from dcrb_ros.schema.printable import printable
from dcrb_ros.schema.refusal import Refusal

MOST_OUTPUT = 16 << 20
"""Longest output of a detector in one scenario [bytes]."""
MIB = 1 << 20
"""[bytes]"""
EXIT_PATIENCE = 2.0
"""Time in which a process must end after it has closed its socket [s]."""
PROGRAM = "import sys; sys.path[:] = {path!r}; from {module} import main; main()"
"""What the interpreter runs; the modules that can be imported are those of this process."""


class DetectorFailure(RuntimeError):
    """The detector failed in a scenario."""


class DetectorProcess:
    """A process in which new detectors of one class run, one scenario after another."""

    imported: bytes
    """What the program has sent after the import."""

    def __init__(self, given: str, limits: Limits, module: str = "dcrb_ros.exam.detector_process") -> None:
        """Start the process and import the detector ``given`` as `load_plugin` takes it; ``module`` contains the program.

        Raises:
            CandidateRefusal: it cannot be imported within the limits.
        """
        self._limits, self._resources, self.closed = limits, ExitStack(), False
        self._environment = marked_environment()
        self._channel, theirs = socket.socketpair()
        self._output = ChildOutput(MOST_OUTPUT, self._kill)
        number = str(theirs.fileno())
        guard = self._resources.enter_context(group_guard(0.0))
        self._process = subprocess.Popen(
            [sys.executable, "-u", "-c", PROGRAM.format(path=sys.path, module=module), number, given, str(limits.memory * MIB)],
            stdin=subprocess.DEVNULL,
            stdout=self._output.writing,
            stderr=subprocess.STDOUT,
            pass_fds=[theirs.fileno()],
            env=self._environment,
            start_new_session=True,
        )
        guard(self._process.pid)
        theirs.close()
        self._output.begin()
        try:
            slow = f"its import took longer than {limits.scenario:g} s{self._option('--scenario-limit')}"
            _, self.imported = self._answered(limits.scenario, slow, "while it was imported")
        except DetectorFailure as failure:
            self.close()
            raise CandidateRefusal(f"--python {given} cannot be used: {failure}{self._output.last_line()}") from None
        except Refusal as refusal:
            self.close()
            raise CandidateRefusal(str(refusal)) from None
        except BaseException:
            self.close()
            raise

    def diagnose(self, signal: Signal) -> Outcome:
        """Return the outcome of a new detector for a signal; after a failure the process is closed.

        Raises:
            Refusal: the signal cannot be read, or the detector has no ``update`` or returns an unknown verdict.
        """
        outcome = Outcome()
        with self.guarded(outcome):
            for diagnosis in self._diagnoses(signal):
                outcome.received.append(diagnosis)
        return outcome

    @contextmanager
    def guarded(self, outcome: AnyOutcome) -> Iterator[None]:
        """Write to an outcome why the detector failed in the exchange of a scenario. After a failure the process is closed."""
        self._output.restart()
        try:
            yield
        except DetectorFailure as failure:
            self.close()
            outcome.failure = f"{failure}{self._output.last_lines()}"
        except BaseException:
            self.close()
            raise

    def _diagnoses(self, signal: Signal) -> Iterator[ReceivedDiagnosis]:
        rate, before = signal.sampling_rate, 0
        blocks = ((block, block.first_index, block.end) for block in detector_blocks(signal))
        for kind, content, end in self.answers(Begin(signal.orders, rate, pickle.dumps(signal.bearing)), blocks, rate):
            try:
                if kind == MESSAGE:
                    yield arrived(decode_diagnosis(content), before, end, rate)
                elif kind == VERDICT:
                    yield ReceivedDiagnosis((end - 1) / rate, str(checked_output(content.decode(errors="replace"))))
                elif kind != NOTHING:
                    raise DetectorFailure("its process sent an invalid answer")
            except Refusal as refusal:
                raise DetectorFailure(str(refusal)) from None
            before = end

    def answers(self, begin: Request, blocks: Iterable[tuple[Request, int, int]], rate: int) -> Iterator[tuple[bytes, bytes, int]]:
        """Begin a scenario and send its blocks, each with the index of its first sample and the one after its last, at a rate [Hz].

        Yield kind and content of every answer, with the end of the block.

        Raises:
            DetectorFailure: the detector failed.
        """
        start, seconds = time.monotonic(), 0.0
        self._asked(begin, start, 0.0, "at the beginning")
        for block, first, end in blocks:
            seconds = end / rate
            kind, content = self._asked(block, start, seconds, f"at {first / rate:.2f} s of the signal")
            yield kind, content, end
        kind, _ = self._asked(None, start, seconds, "after the last block")
        if kind == LEFTOVER:
            self.close()

    def _asked(self, request: Request | None, start: float, recorded: float, where: str) -> tuple[bytes, bytes]:
        """Send a request and return kind and content of the answer."""
        limits = self._limits
        rest = start + recorded + limits.scenario - time.monotonic()
        if rest < limits.block:
            slow = f"the scenario took {limits.scenario:g} s longer than its recorded time{self._option('--scenario-limit')}"
        else:
            slow = f"a block took longer than {limits.block:g} s {where}{self._option('--block-limit')}"
        seconds = max(0.0, min(rest, limits.block))
        try:
            send_packet(self._channel, pickle.dumps(request, pickle.HIGHEST_PROTOCOL), max(seconds, 1e-3))
        except TimeoutError:
            raise DetectorFailure(slow) from None
        except OSError:
            pass  # it has ended, which the missing answer shows
        return self._answered(seconds, slow, where)

    def _answered(self, seconds: float, slow: str, where: str) -> tuple[bytes, bytes]:
        try:
            packet = receive_packet(self._channel, seconds)
        except TimeoutError:
            raise DetectorFailure(slow) from None
        if self._output.excessive:
            raise DetectorFailure(f"it printed more than {MOST_OUTPUT // MIB} MiB {where}")
        if not packet:
            raise DetectorFailure(f"{self._end()} {where}")
        kind, content = packet[:1], packet[1:]
        if kind in (REFUSED, FAILED):
            sentence = printable(content.decode(errors="replace"))
            if kind == REFUSED:
                raise Refusal(sentence)
            memory = f"; it may use {self._limits.memory} MiB{self._option('--memory-limit')}" if "MemoryError" in sentence else ""
            raise DetectorFailure(f"{sentence}{memory}")
        if kind not in (READY, NOTHING, MESSAGE, VERDICT, STATUSES, LEFTOVER):
            raise DetectorFailure(f"its process sent an invalid answer {where}")
        return kind, content

    def _option(self, name: str) -> str:
        """Return the option for a limit in brackets, where there is one."""
        return f" ({name})" if self._limits.options else ""

    def _end(self) -> str:
        """Return how the process ended."""
        try:
            status = self._process.wait(EXIT_PATIENCE)
        except subprocess.TimeoutExpired:
            return "its process closed its connection"
        return f"its process ended with exit status {status}" if status >= 0 else f"its process was ended by {_signal_name(-status)}"

    def _kill(self) -> None:
        kill_group(self._process.pid)

    def close(self) -> None:
        """End the process and its children, also those in a session of their own."""
        if not self.closed:
            self.closed = True
            self._kill()
            self._process.wait()
            kill_marked(self._environment)
            self._channel.close()
            self._resources.close()


DEFAULT_LIMITS = Limits()
_PROCESSES: dict[tuple[str, Limits], DetectorProcess] = {}
"""The process of each detector, reused for the next scenario; it ends with this one."""


@dataclass(frozen=True)
class ProcessDetector:
    """A detector written in Python as a candidate; every scenario has a new detector, and none has the exam's process."""

    name: str
    given: str
    """``module:Class``, ``file.py:Class`` or the name of an entry point."""
    limits: Limits = DEFAULT_LIMITS
    parallel: bool = True

    def diagnose(self, signal: Signal) -> Outcome:
        """Return the outcome for a signal; see `DetectorProcess.diagnose`."""
        try:
            with running_process(self.given, self.limits) as process:
                return process.diagnose(signal)
        except CandidateRefusal as refusal:  # it could be imported before
            return Outcome(failure=str(refusal))


@contextmanager
def running_process(given: str, limits: Limits) -> Iterator[DetectorProcess]:
    """Yield the process of a detector, a new one if there is none or it was closed; it is kept for the next scenario.

    Raises:
        CandidateRefusal: the detector cannot be imported.
    """
    key = given, limits
    process = _PROCESSES.pop(key, None)
    if process is None or process.closed:
        process = DetectorProcess(*key)
        Finalize(None, process.close, exitpriority=0)  # also in a worker, which calls no function of atexit
    yield process
    if not process.closed:
        _PROCESSES[key] = process


def _signal_name(number: int) -> Any:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"
