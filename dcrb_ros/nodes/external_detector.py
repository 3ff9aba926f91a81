"""A user's detector as a process in its own ROS domain, to which a signal is played as the live bench would publish it."""

from __future__ import annotations

import os
import shlex
import shutil
import signal
import subprocess
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from typing import Any

from dcrb_ros.exam.evaluation import CandidateRefusal
from dcrb_ros.messages.bundle import Bundle
from dcrb_ros.messages.topics import DIAGNOSIS, NAMESPACE, SENSOR, TEMPERATURES, VIBRATION, Message, Topic
from dcrb_ros.nodes.detector_answers import PROMPT, Answers, Diagnoses
from dcrb_ros.nodes.other_publishers import OtherPublishers
from dcrb_ros.nodes.pacing import Pacer
from dcrb_ros.nodes.publisher import Publisher, subscribe
from dcrb_ros.nodes.reserved_domain import ReservedDomain
from dcrb_ros.nodes.ros import check_ros, node_in
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.replay import Replay, ReplayParameters
from dcrb_ros.runtime.child_output import ChildOutput
from dcrb_ros.runtime.children import group_guard, kill_group, kill_marked, marked_environment
from dcrb_ros.schema.refusal import Refusal

LEAD = 0.5
"""Signal sent beyond the next expected diagnosis [s]: 25 blocks, which the queue of a subscriber should hold."""
DIAGNOSIS_TIMEOUT = 5.0
"""Wall time without a diagnosis after which no more are expected [s]; DDS sends a lost last message again after up to 3 s."""
SETTLING_TIME = 0.3
"""Wall time between the discovery of the detector and the first block [s]."""
EXIT_TIMEOUT = 5.0
"""Wall time in which the detector must end after SIGINT [s]."""
MOST_OUTPUT = 64 << 20
"""Longest output in one scenario [bytes]."""
LISTENING_TIME = 0.5
"""Wall time in which other nodes in the domain are discovered before the detector starts [s]."""
GATE = 'read -r _ || exit; exec "$@" </dev/null'
"""Shell script that becomes the detector once a line arrives on its standard input, which is sent when the guard of its group has begun."""
MOST_DOMAINS = 5
"""Domains that are tried in succession before a scenario [-]."""
LOOK_EVERY = 50
"""Bundles between two looks for other publishers on the topics of the exam [-]."""


@dataclass(frozen=True)
class Feed:
    """A signal that is played to a detector, and the topic of its answers."""

    topics: Sequence[Topic]
    """Topics that are published: the output of sensors, not the ground truth."""
    awaited: Sequence[Topic]
    """Those of them to which the detector must subscribe."""
    answer: Topic
    """Topic on which the detector publishes."""
    start: Callable[[], Iterable[Message]]
    """Returns the messages that precede the first bundle."""
    bundles: Callable[[], Iterator[Bundle]]
    """Yields the signal."""


def _recording_feed(recording: Recording) -> Feed:
    """Return the signal in the recording of a bearing."""
    given: tuple[Topic, ...] = (VIBRATION, *(TEMPERATURES if len(recording.temperatures()) else ()))
    replay = Replay(ReplayParameters(bag=str(recording.path), topics=", ".join(topic.name for topic in given)))
    return Feed((*given, SENSOR), (VIBRATION,), DIAGNOSIS, replay.start, replay.bundles)


class NodeProgram:
    """A detector given by its command, which is started anew for every scenario."""

    parallel = False

    def __init__(self, command: str, *, name: str = "", rate: float = 0.0, patience: float = 30.0) -> None:
        """Prepare to run a command.

        Args:
            command: starts the detector.
            name: name in the report; by default the command.
            rate: recorded over wall time; with 0 the signal is sent as fast as its diagnoses arrive.
            patience: wall time in which it must subscribe and advertise its topic [s].

        Raises:
            Refusal: ROS is not installed, the command is empty or malformed, or every domain is reserved.
        """
        check_ros()
        self.name = name or command
        self._command, self._rate, self._patience = _split(command), rate, patience
        self._reservations = [ReservedDomain()]

    @property
    def domain(self) -> int:
        """ROS domain, reserved until this object is deleted."""
        return self._reservations[-1].number

    def play(self, feed: Feed, answers: Answers) -> str:
        """Play a signal to the detector and collect its answers; return why it failed, or an empty text.

        Another program that publishes on the topics of the exam in the domain is a failure, too, and no answer counts then.

        Raises:
            CandidateRefusal: the program does not exist.
        """
        with ExitStack() as stack:
            try:
                node, spin, publisher, watch = self._in_quiet_domain(feed, stack)
            except _NoQuietDomain as error:
                return f"{error}; the detector was not started"
            answers.rate = self._rate
            process, output = stack.enter_context(_process(self._command, self.domain))
            subscribe(node, feed.answer, answers.receive)
            publisher.write_messages(feed.start())
            failure = self._connect(feed, publisher, node, spin, process) or self._send(feed, publisher, answers, spin, process, watch)
            topic = feed.answer.resolved(NAMESPACE)
            if not failure and answers.refused:
                failure = f"{len(answers.refused)} messages on {feed.answer.name} are invalid, the first because {answers.refused[0]}"
            elif not failure and not answers.valid:
                failure = (
                    f"it published nothing on {topic}; publish a DiagnosticArray there at least once in "
                    "a few seconds of signal, with the value 'verdict' and the stamp of the samples judged; a container receives "
                    "samples only with --network host --ipc host"
                )
            if used := watch.check():
                answers.forget()
                failure = used
            if failure:
                excess = f"; it printed more than {MOST_OUTPUT >> 20} MiB" if output.excessive else ""
                failure += excess + (output.last_lines() or "; it printed nothing")
        return failure

    def _in_quiet_domain(self, feed: Feed, stack: ExitStack) -> tuple[Any, Any, Publisher, _DomainWatch]:
        """Return a node, the function that serves it, its publisher and its watch, in another domain if the present one is used."""
        used = ""
        for attempt in range(MOST_DOMAINS):
            if attempt:
                try:
                    self._reservations.append(ReservedDomain())
                except Refusal as refusal:
                    raise _NoQuietDomain(f"{used}, and {refusal}") from None
            with ExitStack() as trial:
                node, spin = trial.enter_context(node_in("examiner", self.domain))
                publisher, watch = Publisher(node, feed.topics), _DomainWatch(node, feed.topics, feed.answer, self.domain)
                used = watch.listen(spin)
                if not used:
                    stack.enter_context(trial.pop_all())
                    return node, spin, publisher, watch
        raise _NoQuietDomain(f"{used}; so were {MOST_DOMAINS - 1} others")

    def _connect(self, feed: Feed, publisher: Publisher, node: Any, spin: Any, process: subprocess.Popen[bytes]) -> str:
        """Wait until the detector has subscribed and advertised its topic; return why it has not."""
        deadline, topic = time.monotonic() + self._patience, feed.answer.resolved(NAMESPACE)
        while (missing := [each for each in feed.awaited if not publisher.subscribers(each)]) or not node.count_publishers(topic):
            spin(0.05)
            if process.poll() is not None:
                remedy = "" if process.returncode else "; a class is given with --python FILE:CLASS"
                return f"it ended with status {process.returncode} before it subscribed{remedy}"
            if time.monotonic() > deadline:
                undone = f"subscribe to {missing[0].resolved(NAMESPACE)}" if missing else f"advertise {topic}"
                return f"it did not {undone} within {self._patience:g} s; do so, or allow more with --patience"
        settled = time.monotonic() + SETTLING_TIME
        while time.monotonic() < settled:
            spin(0.05)
        return ""

    def _send(
        self, feed: Feed, publisher: Publisher, answers: Answers, spin: Any, process: subprocess.Popen[bytes], watch: _DomainWatch
    ) -> str:
        """Publish the signal and wait for the last answer; return why the detector failed."""
        pacer, end = Pacer(self._rate, time.monotonic), 0.0
        for number, bundle in enumerate(feed.bundles()):
            if number == 0:
                answers.begin = bundle.begin_ns * 1e-9
            end = bundle.end_ns * 1e-9
            self._wait(bundle, pacer, answers, spin)
            if process.poll() is not None:
                return f"it ended with status {process.returncode} at {end:.1f} s of the signal"
            publisher.write_messages(bundle.messages)
            answers.signal_sent(end)
            if number % LOOK_EVERY == 0 and (used := watch.check()):
                return used
        answers.received_at = time.monotonic()
        while answers.latest < end - answers.period and time.monotonic() < answers.received_at + DIAGNOSIS_TIMEOUT:
            spin(0.05)
        return ""

    def _wait(self, bundle: Bundle, pacer: Pacer, answers: Answers, spin: Any) -> None:
        """Wait until a bundle may be sent: at its deadline if there is a rate, otherwise when the previous signal has been judged.

        Without a rate, the wait is no longer than the bundle itself, so that a detector with rare diagnoses is not waited for endlessly. At
        most `PROMPT` of signal beyond the last diagnosis is sent without a wait, or a prompt one would count as late.
        """
        begin, end = bundle.begin_ns * 1e-9, bundle.end_ns * 1e-9
        deadline = time.monotonic() + (pacer.until(begin, end) if self._rate else end - begin)
        spin(0.0)
        while time.monotonic() < deadline and (self._rate or end > answers.latest + min(answers.period + LEAD, PROMPT)):
            spin(min(0.005, max(0.0, deadline - time.monotonic())))


class ExternalDetector(NodeProgram):
    """A detector of a bearing given by its command as a candidate."""

    def diagnose(self, recording: Recording) -> Diagnoses:
        """Return the diagnoses for a recording; see `play` for the errors."""
        diagnoses = Diagnoses()
        diagnoses.failure = self.play(_recording_feed(recording), diagnoses)
        return diagnoses


class _NoQuietDomain(Exception):
    """Other programs publish on the topics of the exam in every domain that was tried."""


class _DomainWatch:
    """Looks for other publishers on the topics of an exam: a second exam, or a bench, in the same ROS domain."""

    def __init__(self, node: Any, topics: Sequence[Topic], answer: Topic, domain: int) -> None:
        self._node, self._answer, self._domain, self._others = node, answer, domain, list[str]()
        self._publishers = OtherPublishers(node, topics, self._others.append)
        self._detectors = OtherPublishers(node, [answer], lambda _: None)

    def listen(self, spin: Any) -> str:
        """Look for `LISTENING_TIME`, also on the topic of the answers, before the detector starts; return as `check` does."""
        detectors = OtherPublishers(self._node, [self._answer], self._others.append)
        deadline = time.monotonic() + LISTENING_TIME
        while time.monotonic() < deadline:
            spin(0.05)
            detectors.look()
            if used := self.check():
                return used
        return ""

    def check(self) -> str:
        """Look once; return which other publisher there is, or an empty text.

        More than one node on the topic of the answers are more than the detector.
        """
        self._publishers.look()
        self._detectors.look()
        if len(names := self._detectors.names) > 1:
            self._others.append(f"one of {', '.join(names)}, each of which publishes on {self._answer.resolved(NAMESPACE)}")
        return f"ROS domain {self._domain} of the exam is used by another program: {self._others[0]}" if self._others else ""


def _split(command: str) -> list[str]:
    try:
        words = shlex.split(command)
    except ValueError as error:
        raise Refusal(f"--node '{command}' is not a valid command: {error}; quote it as on a command line") from None
    if not words:
        raise Refusal("--node is empty: give the command that starts your detector, such as 'python3 my_detector.py'")
    return words


@contextmanager
def _process(command: Sequence[str], domain: int) -> Iterator[tuple[subprocess.Popen[bytes], ChildOutput]]:
    """Run the detector and keep the end of its output; its process group is ended in any case, even if this process is killed.

    Processes that have left the group are killed at the end.
    """
    environment = {**marked_environment(), "ROS_DOMAIN_ID": str(domain)}
    groups: list[int] = []
    output = ChildOutput(MOST_OUTPUT, lambda: kill_group(groups[0]))
    with group_guard(EXIT_TIMEOUT) as guard:
        program = shutil.which(command[0])
        if program is None:
            raise CandidateRefusal(f"--node: '{command[0]}' cannot be started: no such program; give the command as you would type it")
        process = subprocess.Popen(
            ["/bin/sh", "-c", GATE, "gate", program, *command[1:]],
            env=environment,
            stdin=subprocess.PIPE,
            stdout=output.writing,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        groups.append(process.pid)
        try:
            guard(process.pid)
            assert process.stdin is not None
            with suppress(BrokenPipeError), process.stdin as gate:
                gate.write(b"\n")
            output.begin()
            yield process, output
        finally:
            try:
                _end(process)
            finally:
                kill_marked(environment)


def _end(process: subprocess.Popen[bytes]) -> None:
    """End a process like Ctrl-C, and then kill what remains of its group."""
    try:
        with suppress(subprocess.TimeoutExpired, ProcessLookupError):
            os.killpg(process.pid, signal.SIGINT)
            process.wait(EXIT_TIMEOUT)
    finally:  # even after a second Ctrl-C
        kill_group(process.pid)
        process.wait()
