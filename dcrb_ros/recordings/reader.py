"""Reading recordings, complete or damaged."""

from __future__ import annotations

import os
import warnings
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dcrb_ros.bearing.frequencies import Orders, characteristic_orders
from dcrb_ros.bearing.history import StateHistory
from dcrb_ros.bearing.tacho_pulses import TachoPulses
from dcrb_ros.bearing.temperature_readings import TemperatureReadings
from dcrb_ros.bearing.waveform import Piece, Waveform
from dcrb_ros.messages.description import PULSES_PER_TURN, decode_range
from dcrb_ros.messages.points import Vibration, decode_vibration
from dcrb_ros.messages.statuses import decode_truth
from dcrb_ros.messages.topic import chosen_topics
from dcrb_ros.messages.topics import (
    DETECTED,
    GROUND_TRUTH,
    NAMESPACE,
    ROLLER_STATES,
    SENSOR,
    SIMULATED,
    VIBRATION,
    Message,
    Topic,
)
from dcrb_ros.recordings.arrays import (
    RecordedVerdict,
    joined_waveform,
    states_of,
    tacho_of,
    temperatures_of,
    truths_of,
    verdicts_of,
)
from dcrb_ros.recordings.digest import SampleDigests, samples_in, stated_samples
from dcrb_ros.recordings.foreign_files import refuse_foreign
from dcrb_ros.recordings.latched import in_order, of_one_bench, of_one_run
from dcrb_ros.recordings.manifest import DAMAGE, OUTCOME, Outcome, not_understood, stated_bearing, stated_range
from dcrb_ros.recordings.recorded_files import RecordedFiles
from dcrb_ros.recordings.vehicle_folder import box_of, record_name
from dcrb_ros.schema.arguments import of_type, optional
from dcrb_ros.schema.arrays import Floats, Integers, Samples
from dcrb_ros.schema.numbers import sampling_rate
from dcrb_ros.schema.refusal import AlteredSamples, Refusal
from dcrb_ros.settings.parameters import Bearing
from dcrb_ros.simulation.ground_truth import GroundTruth, commands_in
from dcrb_ros.stream.event_text import decode_command
from dcrb_ros.stream.events import TimedCommand

if TYPE_CHECKING:
    import pandas as pd

    from dcrb_ros.settings.configuration import Configuration


class Recording:
    """A recording of the bench, or of imported data: a rosbag2 folder or a single file of one.

    It has the attributes of a `SimulationResult` except ``clean``, which is not recorded. They are read from the file on first use.

    A recording that `ros2 bag record` made beside the bench has no manifest; the description of the sensor in it takes its place.
    A box of a vehicle has the path of the vehicle's recording and its name, such as ``run/axle_1.left``.

    Raises
    ------
    Refusal
        There is no recording, it is not a recording of the bench, or its folder has a file of another recording.

    Examples
    --------
    >>> import dcrb_ros
    >>> recording = dcrb_ros.Recording("bags/outer_ring_defect")
    >>> recording.acceleration.shape, recording.sampling_rate, list(recording.truth.faults)
    ((153600, 2), 51200, ['outer_1'])
    """

    def __init__(self, path: str | Path) -> None:
        if not isinstance(path, (str, os.PathLike)):
            raise Refusal(f"{path!r} is not the path of a recording: give a folder made by dcrb simulate or dcrb bench, or an .mcap file")
        self.path = Path(path)
        source, self.box = box_of(self.path)
        """The name of the box in the recording of a vehicle; empty for a bench."""
        self._files = RecordedFiles(source)
        self.stored, self.damage = self._files.stored, self._files.damage
        """The files in order; a sentence for each part that could not be read so far."""
        refuse_foreign(source, self.stored)
        self.manifest = self._files.manifest(self.path, self.box)
        if self.manifest.get("format", 1) != 1 and self.outcome is None:
            self._files.report(f"{self.files[-1].name}: the end is missing, the recording was cut off")
        self._bearing = stated_bearing(self.manifest, self.path) if self.configured else None
        self._digests: SampleDigests | None = None

    def __repr__(self) -> str:
        rate, samples = self.manifest.get("sampling_rate", 0), (self.outcome or {}).get("samples", 0)
        length = f"{samples / rate:.4g} s" if rate and samples else "of unknown length"
        return f"<Recording {self.path}: {length} at {rate / 1e3:g} kHz, {self._content()}{'' if self.complete else ', damaged'}>"

    def _content(self) -> str:
        if not self.configured:
            return "imported data" if self.imported else "no manifest"
        try:
            return self.configuration.summary
        except Refusal:
            return "a configuration of another version"

    @property
    def files(self) -> list[Path]:
        """The files in order."""
        return [file.path for file in self.stored]

    @property
    def complete(self) -> bool:
        """Whether everything read so far was intact."""
        return not self.damage

    @cached_property
    def configuration(self) -> Configuration:
        """Configuration of the bench.

        Raises
        ------
        Refusal
            The recording contains imported data, it has no manifest, or this version does not understand the configuration.
        """
        from dcrb_ros.settings.configuration import Configuration  # imports the kernels, which many readers do not need
        from dcrb_ros.settings.sensor import as_recorded

        if self.described:
            raise Refusal(
                f"{self.path} has no manifest, so the configuration of its bench is unknown: give a recording made by dcrb simulate, "
                "dcrb bench or the service record"
            )
        if self.imported:
            raise Refusal(f"{self.path} contains imported data, not a run of the bench: it has no configuration")
        try:
            return Configuration.model_validate(as_recorded(self.manifest["configuration"]))
        except DAMAGE as error:
            raise not_understood(error, self.manifest, self.path) from None

    @property
    def configured(self) -> bool:
        """Whether the recording contains the configuration of the bench."""
        return not (self.imported or self.described)

    @property
    def imported(self) -> bool:
        """Whether the recording contains imported data."""
        return "imported" in self.manifest

    @property
    def described(self) -> bool:
        """Whether the recording has no manifest, so that the description of the sensor takes its place."""
        return "described_by" in self.manifest

    @property
    def bearing(self) -> Bearing | None:
        """The bearing of the bench, from the configuration or the description of the sensor; None if it is unknown."""
        if self._bearing is not None:
            return self._bearing
        about = None if self.imported else self.manifest.get("sensor", {}).get("bearing")
        try:
            return Bearing.model_validate(about) if about else None
        except ValueError:
            return None

    @property
    def namespace(self) -> str:
        """Namespace of the topics."""
        return str(self.manifest.get("namespace", NAMESPACE))

    @cached_property
    def sampling_rate(self) -> int:
        """Sampling rate [Hz]."""
        return sampling_rate(self.manifest.get("sampling_rate"), f"the manifest of {self.path}")

    @cached_property
    def orders(self) -> Orders:
        """Characteristic orders of the bearing."""
        if self._bearing is not None:
            return characteristic_orders(self._bearing)
        try:
            return Orders.from_dict(self.manifest["orders"])
        except Refusal as refusal:
            raise Refusal(f"the manifest of {self.path}: {refusal}") from None
        except DAMAGE:
            raise Refusal(f"the manifest of {self.path} gives no fault orders: import the data again") from None

    @cached_property
    def outcome(self) -> Mapping[str, Any] | None:
        """The outcome record at the end of the recording; None if it was cut off."""
        records = [record for record in self.stored[-1].metadata() if record.name == record_name(OUTCOME, self.box)]
        return self._files.content(records[-1], "outcome", self.stored[-1].path.name) if records else None

    def commands(self) -> list[TimedCommand]:
        """Return the commands of the run, from the outcome record or from the ground truth."""
        entries = (self.outcome or {}).get("commands")
        if isinstance(entries, list):
            try:
                return [decode_command(entry) for entry in entries]
            except DAMAGE:
                self._files.report("the commands in the manifest are damaged")
        return commands_in(decode_truth(message.data) for message in self.messages((GROUND_TRUTH,)))

    def messages(self, topics: Iterable[Topic] | None = None, *, namespace: str | None = None) -> Iterator[Message]:
        """Yield the messages on some topics, by default on all topics of the bench, in the order of the file.

        Raises
        ------
        Refusal
            ``topics`` are not topics, such as names, or ``namespace`` is not a text. The recording has no manifest, and describes a second
            bench after the first. The waveform is that of two runs one after the other, whose samples have the same times.
        """
        optional(of_type(str))("namespace", namespace)
        prefix = self.namespace if namespace is None else namespace
        chosen = frozenset((*SIMULATED, *DETECTED) if topics is None else chosen_topics(topics))
        wanted = {topic.resolved(prefix): topic for topic in (chosen | {SENSOR} if self.described else chosen)}
        messages = (
            Message(wanted[entry.channel.topic], entry.message.log_time, entry.message.data) for entry in self._files.messages(wanted)
        )
        if self.described:
            # The log times are not those of the bench, nor is the order.
            described = of_one_bench(in_order(messages), self.path, self.sampling_rate, self.orders)
            messages = (message for message in described if message.topic in chosen)
        return of_one_run(messages, self.path)

    def vibrations(self) -> Iterator[Vibration]:
        """Yield the blocks of the waveform; see `ranged_vibrations`."""
        return (vibration for vibration, _ in self.ranged_vibrations())

    def ranged_vibrations(self) -> Iterator[tuple[Vibration, float]]:
        """Yield the blocks of the waveform, each with the sensor's range at that time [m/s^2]; 0 if it is unknown.

        After the last block, a warning `AlteredSamples` says if the samples do not match the digest that the recording states.

        Raises
        ------
        Refusal
            The recording has no waveform, or contains two runs one after the other; see `messages`.
        """
        outcome, sensor_range = Outcome(self.sampling_rate), stated_range(self.manifest)
        for message in self.messages((SENSOR, VIBRATION)):
            if message.topic == SENSOR:
                sensor_range = decode_range(message.data)
                continue
            block = decode_vibration(message.data)
            outcome.add_block(block)
            yield block, sensor_range
        if not outcome.samples:
            raise Refusal(f"{self.path} contains no messages on {VIBRATION.resolved(self.namespace)}: give a recording of the bench")
        if mismatch := self.compared(outcome).mismatch:
            warnings.warn(f"{self.path}: {mismatch}", AlteredSamples, stacklevel=2)

    def digests(self) -> SampleDigests:
        """Return the samples that the recording states and those that it contains, which are read unless the waveform was."""
        if self._digests is not None:
            return self._digests
        outcome = Outcome(self.sampling_rate)
        for message in self.messages((VIBRATION,)):
            outcome.add(message)
        return self.compared(outcome)

    def compared(self, outcome: Outcome) -> SampleDigests:
        """Keep and return the comparison of all samples, which were added to ``outcome``, with those that the recording states."""
        later_part = self.complete and self.stored[0].number > 0
        self._digests = SampleDigests(stated_samples(self.outcome), samples_in(outcome), later_part)
        return self._digests

    def pieces(self) -> Iterator[Piece]:
        """Yield the blocks of the waveform with their first samples, as `dcrb_ros.detect` takes them."""
        for block, sensor_range in self.ranged_vibrations():
            yield Piece(block.first_index(self.sampling_rate), block.acceleration, block.shaft_angle, sensor_range)

    def waveform(self, start: float | None = None, stop: float | None = None) -> Waveform:
        """Return the samples with ``start <= time < stop`` [s], all of them by default.

        Raises
        ------
        Refusal
            The recording has no waveform, or no sample in that time.

        Examples
        --------
        >>> from dcrb_ros import Recording
        >>> Recording("bags/outer_ring_defect").waveform(1.0, 1.5)
        <Waveform: 0.5 s at 51.2 kHz (25600 samples), shaft at 20.00 Hz>
        """
        return joined_waveform(self.pieces(), self.sampling_rate, self.orders, self.path, start, stop)

    @cached_property
    def states(self) -> StateHistory:
        """The bodies over time: azimuth, speed and inner normal force, and the contacts where ``roller_contacts`` was recorded.

        Raises
        ------
        Refusal
            The recording has no ``roller_states``.
        """
        if (states := states_of(self.messages)) is None:
            raise Refusal(f"{self!r} has no messages on {ROLLER_STATES.name}: record this topic too, or simulate it again")
        return states

    @cached_property
    def truth(self) -> GroundTruth:
        """The ground truth over time; of imported data it is empty."""
        return GroundTruth(truths_of([message.data for message in self.messages((GROUND_TRUTH,))]))

    @cached_property
    def temperatures(self) -> TemperatureReadings:
        """The readings of the temperature sensors [deg C]; empty if they were not recorded."""
        thermal = self.manifest["configuration"].get("thermal") if self.configured else None
        if isinstance(thermal, Mapping) and thermal.get("law") == "none":
            return TemperatureReadings.none()  # without reading the file
        return temperatures_of(self.messages)

    @property
    def pulses_per_turn(self) -> int:
        """Pulses of the tacho per turn of the shaft; 0 without a tacho."""
        pulses = self.manifest.get("sensor", {}).get(PULSES_PER_TURN, 0)
        return pulses if isinstance(pulses, int) and pulses > 0 else 0

    @cached_property
    def tacho(self) -> TachoPulses:
        """The pulses of the tacho; empty if they were not recorded."""
        return tacho_of(self.messages, self.pulses_per_turn)

    @cached_property
    def _whole(self) -> Waveform:
        return self.waveform()

    @property
    def acceleration(self) -> Samples:
        """Acceleration in X and Y, shape (samples, 2) [m/s^2]; `Recording.waveform` reads a part of it."""
        return self._whole.acceleration

    @property
    def shaft_angle(self) -> Samples:
        """Rotation of the inner ring, wrapped to [0, 2 pi), shape (samples,) [rad]; NaN without a tacho."""
        return self._whole.shaft_angle

    @property
    def index(self) -> Integers:
        """Index of each sample since the start, shape (samples,); it jumps where samples were lost."""
        return self._whole.index

    @property
    def sensor_range(self) -> float:
        """Range of the sensor at the end [m/s^2]; 0 if unknown."""
        return self._whole.sensor_range

    @property
    def time(self) -> Floats:
        """Time of each sample since the start of the run, shape (samples,) [s]."""
        return self._whole.time

    @property
    def duration(self) -> float:
        """Time from the first sample to the end of the last [s]."""
        return self._whole.duration

    @property
    def tracked(self) -> bool:
        """Whether every sample has a shaft angle."""
        return self._whole.tracked

    @property
    def turns(self) -> Floats:
        """Turns of the shaft since the first sample, signed, shape (samples,) [-]; meaningless across lost samples."""
        return self._whole.turns

    @property
    def shaft_frequency(self) -> float:
        """Mean frequency of the shaft [Hz], 0 for a single sample; NaN without a shaft angle."""
        return self._whole.shaft_frequency

    def between(self, start: float | None = None, stop: float | None = None) -> Waveform:
        """Return the samples with ``start <= time < stop`` [s], as `Recording.waveform` does."""
        return self.waveform(start, stop)

    def verdicts(self) -> list[RecordedVerdict]:
        """Return the verdicts that a detector published during the recording; empty without a detector."""
        return verdicts_of(self.messages)

    def to_pandas(self) -> pd.DataFrame:
        """Return the waveform as a DataFrame over time [s]; see `Waveform.to_pandas`. States and ground truth have one of their own.

        Raises
        ------
        Refusal
            pandas is not installed, or the recording has no waveform.
        """
        return self.waveform().to_pandas()

    def counts(self) -> dict[str, int]:
        """Return the number of messages per topic."""
        return dict(sorted(Counter(entry.channel.topic for entry in self._files.messages()).items()))
