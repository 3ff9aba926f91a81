"""A user's detector as an examinee: its own process in a ROS domain of its own, fed with a recording as the live bench would."""

from __future__ import annotations

import os
import shlex
import signal
import subprocess
import tempfile
import time
from bisect import bisect_left
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import IO, Any

from dcrb_ros.exam.received_diagnosis import ReceivedDiagnosis, decode_diagnosis
from dcrb_ros.messages.bundle import Bundle
from dcrb_ros.messages.topics import DIAGNOSIS, NAMESPACE, SENSOR, VIBRATION
from dcrb_ros.nodes.pacing import Pacer
from dcrb_ros.nodes.publisher import Publisher, message_class, qos
from dcrb_ros.nodes.ros import DISCOVERY, check_ros
from dcrb_ros.recordings.replay import Replay, ReplayParameters
from dcrb_ros.runtime.refusal import Refusal

LEAD = 0.5
"""Signal sent beyond the next diagnosis expected [s]: 25 blocks, which a subscriber's queue should hold."""
LAST_WORDS = 2.0
"""Wall time without a diagnosis after which none is expected any more [s]."""
PUNCTUAL = 2.0
"""Wall time after its signal was sent within which the stamp of a diagnosis is believed [s]."""
AHEAD = 1.0
"""Signal by which a stamp may be ahead of what was sent [s], for a detector that counts samples itself."""
SETTLING = 0.3
"""Wall time between the discovery of the detector and the first block [s]."""
CHILD_END = 5.0
"""Wall time that the detector gets to end after SIGINT [s]."""
LINES = 6
"""Lines of its output that are shown when it fails."""
FIRST_DOMAIN, DOMAINS = 110, 120
"""ROS domains for exams; the low ones are people's own. 232 is the highest that works everywhere."""


class Unanswered(RuntimeError):
    """The detector said nothing on the very first scenario; the others would bring nothing either."""


@dataclass
class Answers:
    """What the detector said of a scenario."""

    opinions: list[ReceivedDiagnosis] = field(default_factory=list)
    refused: list[str] = field(default_factory=list)
    """Why messages were not understood."""
    failure: str = ""
    """What broke; empty where nothing did."""
    heard_at: float = 0.0
    """Wall time of the last diagnosis [s]."""
    begin: float = 0.0
    """When the signal begins [s]."""
    _ends: list[float] = field(default_factory=list)
    """Until when the signal had been sent after each bundle [s]."""
    _walls: list[float] = field(default_factory=list)
    """Wall time at which each bundle was sent [s]."""

    def send(self, end: float) -> None:
        """Note that the signal has been sent up to a time [s]."""
        self._ends.append(end)
        self._walls.append(time.monotonic())

    def hear(self, data: bytes) -> None:
        """Take a message on `diagnosis`."""
        self.heard_at = time.monotonic()
        try:
            opinion = decode_diagnosis(data)
            self.opinions.append(replace(opinion, signal_received=self._known(opinion.time)))
        except Refusal as refusal:
            self.refused.append(str(refusal))

    def _known(self, stamp: float) -> float:
        """Return when a diagnosis counts as given [s]: at its stamp, unless it came after a later one or long after its signal.

        Raises:
            Refusal: it judges what has not been sent yet.
        """
        sent = self._ends[-1] if self._ends else self.begin
        if stamp > sent + AHEAD:
            raise Refusal(
                f"a diagnosis is stamped {stamp:.2f} s when the signal had been sent up to {sent:.2f} s: the stamp must be the simulated "
                "time that it judges, taken from the block's header"
            )
        place = bisect_left(self._ends, stamp)
        late = place < len(self._walls) and self.heard_at - self._walls[place] > PUNCTUAL
        return max(stamp, self.latest, sent if late else stamp)

    @property
    def latest(self) -> float:
        """Latest time judged [s]."""
        return max((opinion.time for opinion in self.opinions), default=self.begin)

    @property
    def period(self) -> float:
        """Longest time between two diagnoses so far, the first one's included [s]."""
        times = sorted({self.begin, *(opinion.time for opinion in self.opinions)})
        return max((later - sooner for sooner, later in pairwise(times)), default=0.0)


class Examinee:
    """A detector's command, started anew for every scenario, so that none knows of the others."""

    def __init__(self, command: str, *, rate: float = 0.0, patience: float = 30.0) -> None:
        """Examine ``command``, fed at ``rate`` times the recorded pace, or with 0 as fast as its diagnoses come.

        It gets ``patience`` [s] of wall time to come up.

        Raises:
            Refusal: there is no ROS, no command, or no such program.
        """
        check_ros()
        self._command, self._rate, self._patience = _words(command), rate, patience
        self._domain = FIRST_DOMAIN + os.getpid() % DOMAINS

    def examine(self, bag: Path) -> Answers:
        """Return what the detector says of a recording."""
        replay = Replay(ReplayParameters(bag=str(bag), topics=VIBRATION.name))
        answers = Answers()
        with _graph(self._domain) as (node, spin), _process(self._command, self._domain) as (process, log):
            # The truth stays here: only what a sensor would give goes over the wire.
            publisher = Publisher(node, [VIBRATION, SENSOR])
            node.create_subscription(
                message_class(DIAGNOSIS), DIAGNOSIS.name, lambda data: answers.hear(bytes(data)), qos(DIAGNOSIS), raw=True
            )
            publisher.write_messages(replay.start())
            answers.failure = self._await(publisher, node, spin, process) or self._feed(replay, publisher, answers, spin, process)
            if not answers.failure and answers.refused:
                answers.failure = (
                    f"{len(answers.refused)} messages on diagnosis were not understood, the first because {answers.refused[0]}"
                )
            elif not answers.failure and not answers.opinions:
                answers.failure = (
                    f"it published nothing on {DIAGNOSIS.resolved(NAMESPACE)}; publish a DiagnosticArray there at least once in "
                    "a few seconds of signal, with the value 'verdict' and the stamp of the samples judged"
                )
            if answers.failure:
                answers.failure += _last_lines(log)
        return answers

    def _await(self, publisher: Publisher, node: Any, spin: Any, process: subprocess.Popen[bytes]) -> str:
        """Wait until the detector listens and can be heard; return why it does not."""
        end, topic = time.monotonic() + self._patience, DIAGNOSIS.resolved(NAMESPACE)
        while not (publisher.subscribers(VIBRATION) and node.count_publishers(topic)):
            spin(0.05)
            if process.poll() is not None:
                return f"it ended with status {process.returncode} before it listened"
            if time.monotonic() > end:
                missing = f"subscribe to {VIBRATION.resolved(NAMESPACE)}" if not publisher.subscribers(VIBRATION) else f"advertise {topic}"
                return f"it did not {missing} within {self._patience:g} s; do so, or allow more with --patience"
        settled = time.monotonic() + SETTLING
        while time.monotonic() < settled:
            spin(0.05)
        return ""

    def _feed(self, replay: Replay, publisher: Publisher, answers: Answers, spin: Any, process: subprocess.Popen[bytes]) -> str:
        """Send the recording and wait for the last diagnosis; return what broke."""
        pacer, end = Pacer(self._rate, time.monotonic), 0.0
        for number, bundle in enumerate(replay.bundles()):
            if number == 0:
                answers.begin = bundle.begin_ns * 1e-9
            end = bundle.end_ns * 1e-9
            self._hold(bundle, pacer, answers, spin)
            if process.poll() is not None:
                return f"it ended with status {process.returncode} at {end:.1f} s of the signal"
            publisher.write_messages(bundle.messages)
            answers.send(end)
        answers.heard_at = time.monotonic()
        while answers.latest < end - answers.period and time.monotonic() < answers.heard_at + LAST_WORDS:
            spin(0.05)
        return ""

    def _hold(self, bundle: Bundle, pacer: Pacer, answers: Answers, spin: Any) -> None:
        """Wait until a bundle may go out: at a rate when its time has come, else when its forerunners have been judged.

        A detector that does not answer yet, or seldom, is fed at the recorded pace, so that none waits for the other for ever.
        """
        begin, due = bundle.begin_ns * 1e-9, bundle.end_ns * 1e-9
        deadline = time.monotonic() + (pacer.until(begin, due) if self._rate else due - begin)
        spin(0.0)
        while time.monotonic() < deadline and (self._rate or due > answers.latest + answers.period + LEAD):
            spin(min(0.005, max(0.0, deadline - time.monotonic())))


def _words(command: str) -> list[str]:
    try:
        words = shlex.split(command)
    except ValueError as error:
        raise Refusal(f"--node '{command}' is no command: {error}; quote it as on a command line") from None
    if not words:
        raise Refusal("--node is empty: give the command that starts your detector, such as 'python3 my_detector.py'")
    return words


@contextmanager
def _graph(domain: int) -> Iterator[tuple[Any, Any]]:
    """Yield a node in a domain of its own, and what lets it listen for a while [s]."""
    import rclpy
    from rclpy.context import Context
    from rclpy.executors import SingleThreadedExecutor
    from rclpy.utilities import try_shutdown

    os.environ.setdefault(DISCOVERY, "LOCALHOST")
    context = Context()
    rclpy.init(context=context, domain_id=domain, args=[])
    node = rclpy.create_node("examiner", namespace=NAMESPACE, context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    try:
        yield node, lambda seconds: executor.spin_once(timeout_sec=seconds)
    finally:
        executor.shutdown()
        node.destroy_node()
        try_shutdown(context=context)


@contextmanager
def _process(command: Sequence[str], domain: int) -> Iterator[tuple[subprocess.Popen[bytes], IO[bytes]]]:
    """Run the detector with its output in a file; whatever happens, it and its children are ended."""
    environment = {**os.environ, "ROS_DOMAIN_ID": str(domain)}
    with tempfile.TemporaryFile() as log:
        try:
            process = subprocess.Popen(
                command, env=environment, stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT, start_new_session=True
            )
        except OSError as error:
            raise Refusal(f"--node: '{command[0]}' cannot be started: {error.strerror}; give the command as you would type it") from None
        try:
            yield process, log
        finally:
            _end(process)


def _end(process: subprocess.Popen[bytes]) -> None:
    """End a process as Ctrl-C would, and then whatever is left of its group."""
    try:
        with suppress(subprocess.TimeoutExpired, ProcessLookupError):
            os.killpg(process.pid, signal.SIGINT)
            process.wait(CHILD_END)
    finally:  # a second Ctrl-C must not leave it behind
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def _last_lines(log: IO[bytes]) -> str:
    """Return the end of what the detector printed."""
    log.flush()
    log.seek(0)
    lines = [line for line in log.read()[-20_000:].decode(errors="replace").splitlines() if line.strip()]
    return "; its last words:\n" + "\n".join(f"    {line}" for line in lines[-LINES:]) if lines else "; it printed nothing"
