"""What the simulator of a bearing and that of a vehicle have in common: publishing, recording, services and status."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from dcrb_ros.core.announcement import announce_compilation
from dcrb_ros.messages.bundle import Bundle
from dcrb_ros.messages.topics import BENCH_DIAGNOSTICS, CLOCK, Message, Topic
from dcrb_ros.nodes.answers import Answers
from dcrb_ros.nodes.bench_status import BenchStatus
from dcrb_ros.nodes.clock import ClockPublisher
from dcrb_ros.nodes.engine import BundleSource, Engine, Progress, Sink
from dcrb_ros.nodes.gate import Gate
from dcrb_ros.nodes.other_publishers import OtherPublishers
from dcrb_ros.nodes.pacing import Pacer
from dcrb_ros.nodes.publisher import Publisher
from dcrb_ros.nodes.recording_switch import RecordingSwitch
from dcrb_ros.nodes.refusal_counts import Refusals
from dcrb_ros.nodes.ros import installed
from dcrb_ros.nodes.served import ServedNode
from dcrb_ros.nodes.services import OVER, Services
from dcrb_ros.nodes.simulation_interfaces import PACKAGE, SimulationInterfaces
from dcrb_ros.nodes.subscriber_wait import SubscriberWait
from dcrb_ros.recordings.recorder import RunRecorder
from dcrb_ros.recordings.recorder_thread import RecorderThread
from dcrb_ros.recordings.splitting import RecordingFailed
from dcrb_ros.runtime.threads import repeating
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import validated
from dcrb_ros.text.files import expanded_path

STATUS_PERIOD = 1.0
"""Wall time between two messages on /diagnostics [s]."""


class FirstBlockLog:
    """A sink that logs how long the first block took."""

    def __init__(self, log: Callable[[str], object]) -> None:
        self._log, self._began = log, time.monotonic()

    def start(self, messages: Sequence[Message]) -> None:
        """Do nothing."""

    def write(self, bundle: Bundle) -> None:
        """Log the time of the first bundle."""
        if self._began:
            self._log(f"first block {time.monotonic() - self._began:.2f} s after the start")
            self._began = 0.0


class SimulatingNode(ServedNode):
    """Publishes and records a simulation, paced to wall time, with services and a status."""

    _source: Any

    def assemble(
        self,
        configuration: Configuration,
        begin: Callable[[Gate], BundleSource],
        topics: Iterable[Topic],
        recorder: Callable[..., RunRecorder[Any]],
        *,
        waveform: Topic,
        description: Topic,
        answers: Answers,
    ) -> None:
        """Put the parts together.

        Args:
            configuration: gives time scale, publishing and recording.
            begin: returns the source, whose bundles pass the gate.
            topics: those that the source fills.
            recorder: returns the recorder of a new folder, with the ``namespace`` and what `RecordingSwitch` adds.
            waveform: the topic whose subscribers are waited for.
            description: the latched topic by which they know the others.
            answers: the diagnoses that are waited for at the end.

        Raises:
            Refusal: the path of the recording is impossible.
        """
        self.configuration = configuration
        publishing, log, path = configuration.publishing, self.get_logger(), configuration.recording.path
        gate = Gate(Pacer(configuration.time_scale, time.monotonic), time.monotonic)
        self._clock_topics = [CLOCK] if publishing.clock else []
        self._publisher = Publisher(self, [*topics, BENCH_DIAGNOSTICS, *self._clock_topics])
        self._clocks = [ClockPublisher(self._publisher.write_messages)] if publishing.clock else []
        self.progress, self.refusals = Progress(), Refusals(log.warning)

        def record(path: Path, **options: Any) -> RecorderThread:
            return RecorderThread(recorder(path, namespace=self.get_namespace(), **options), configuration.recording.queue)

        self.recording = RecordingSwitch(record, log, expanded_path(path).absolute() if path else None)
        sinks: list[Sink] = [self.progress, *self._clocks, self._publisher, self.recording, FirstBlockLog(log.info)]
        self._source = begin(gate)
        self.engine = Engine("model", self._source, sinks, gate)
        self._waveform, self._description, self._answers = waveform, description, answers
        self._status = BenchStatus(self)
        self._others: OtherPublishers

    def _announce(self, sentence: str) -> None:
        """Log a sentence about a compilation, and keep it for the status."""
        self.compiling = sentence
        self.get_logger().info(sentence)

    def load(self) -> None:
        """Build the model, and compile its kernels if they are not; the status says so, although no callback is served yet."""
        announce_compilation(self._announce)
        with repeating(STATUS_PERIOD, self._report):
            self.engine.load()

    def start(self) -> None:
        """Start the simulation and the configured recording."""
        self.engine.prepare()
        self.receive()
        services = Services(self)
        if installed(PACKAGE):
            SimulationInterfaces(self, services)
        publishing = self.configuration.publishing
        self._others = self.watch_publishers(self._waveform, *self._clock_topics)
        self.repeat(STATUS_PERIOD, self._publish_status)
        if publishing.listeners:
            wait = SubscriberWait(self._publisher, publishing.listeners, publishing.wait, topics=(self._waveform, self._description))
            self.start_with_subscribers(wait, self.engine.start)
        else:
            self.engine.start()

    def receive(self) -> None:
        """Subscribe to commands and to what is recorded beside the simulation."""

    def on_parameters(self, changes: dict[str, Any]) -> None:
        """Apply a requested change of parameters, or refuse it."""
        with self.refusals.counted("parameters"):
            for key, value in changes.items():
                self.check_parameter(key, value)
            asked = {key: value for key, value in changes.items() if key != "time_scale"}
            scale = changes.get("time_scale")
            if scale is not None:
                validated({"time_scale": scale}, Configuration, "parameters")
            self.refuse_untimely("parameters", discarded=bool(asked))
            if asked:
                self.change(asked)
            if scale is not None:
                self.engine.gate.rescale(scale)

    def check_parameter(self, key: str, value: Any) -> None:
        """Refuse a parameter that cannot be set while the node runs, or a value of another type."""

    def change(self, changes: Mapping[str, Any]) -> None:
        """Change parameters of the simulation other than its time scale."""

    def refuse_untimely(self, what: str, *, discarded: bool = True) -> None:
        """Refuse a command or a change of parameters, named ``what``, that comes too late or is ``discarded`` by a pending reset.

        Raises:
            Refusal: the simulation that would take it has ended, or is about to be discarded.
        """
        if self.engine.ended:
            raise Refusal(f"{what}: {OVER}")
        if discarded and self.engine.gate.resetting:
            raise Refusal(f"{what}: a reset is pending, which would discard the change: give it again once the simulation is at its start")

    @property
    def ended(self) -> bool:
        """Whether the duration is over and the detector has answered, or the simulation has failed or was asked to quit."""
        stopped = self.engine.failure is not None or self.engine.gate.closed
        return self.engine.ended and (stopped or self._answers.complete(self.progress.time_ns))

    @property
    def failure(self) -> Exception | None:
        """The exception that ended the simulation, or a recording, if one did."""
        return self.engine.failure or (RecordingFailed(self.recording.first_failure) if self.recording.first_failure else None)

    def close(self) -> None:
        """Stop the simulation and finish the recording; if it was not interrupted, report a failure and wait for the delivery."""
        finished = self.engine.finished
        self.engine.close()
        self.recording.close()
        if finished:
            self._repeat_clock()
            if self.failure is not None:
                self._report()
            self._publisher.flush()

    def record_detected(self, topic: Topic) -> None:
        """Record the detector's messages on a topic; the node ends after that of the last diagnosis."""
        self._answers.take_recorded(topic, 0)

        def record(data: bytes) -> None:
            with self.refusals.suppressed(topic.name):
                time_ns = decoded_by(topic.name, topic.stamp, data)
                self._answers.take_recorded(topic, time_ns)
                if self.recording.path is None:
                    return
                self._check_stamp(topic, time_ns)
                self.recording.write_messages([Message(topic, time_ns, data)])

        self.subscribe(topic, record)

    def _check_stamp(self, topic: Topic, time_ns: int) -> None:
        """Refuse a stamp [ns] outside the signal published so far.

        The detector may answer a block before the engine's thread has counted it, hence one block of tolerance.
        """
        block_ns = math.ceil(self.configuration.publishing.block_size * 1e9 / self.configuration.sensor.sampling_rate)
        latest = self.progress.time_ns + block_ns
        if not 0 <= time_ns <= latest:
            raise Refusal(
                f"{topic.name} at {time_ns * 1e-9:g} s is not recorded: its stamp must be within 0 .. {latest * 1e-9:g} s of simulated time"
            )

    def _report(self, others: Sequence[str] = ()) -> None:
        """Publish the status on /diagnostics, with the names of the ``others`` that publish on topics of this node."""
        time_ns = self.progress.time_ns  # read once: another block may come at any time
        status = self._status.status(self.get_fully_qualified_name(), time_ns, others)
        self._publisher.write_messages([self.diagnostics(status, time_ns, self.configuration.publishing.frame)])

    def _publish_status(self) -> None:
        """Publish the status on /diagnostics, and the time of a paused simulation again on /clock."""
        self._report(self._others.names)
        self._repeat_clock()
        if self.engine.computed:
            self.compiling = ""
        self.update_parameters()

    def _repeat_clock(self) -> None:
        for clock in self._clocks:
            clock.repeat()


def decoded_by(topic: str, decode: Callable[[bytes], Any], data: bytes) -> Any:
    """Return the content of a message; a refusal names the topic."""
    try:
        return decode(bytes(data))
    except Refusal as refusal:
        raise Refusal(f"{topic}: {refusal}") from None
