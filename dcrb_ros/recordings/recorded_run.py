"""What a recording has in common with the result of a simulation: samples, bodies, ground truth and readings, read on first use."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

from dcrb_ros.bearing.history import StateHistory
from dcrb_ros.bearing.tacho_pulses import TachoPulses
from dcrb_ros.bearing.temperature_readings import TemperatureReadings
from dcrb_ros.bearing.waveform import Waveform
from dcrb_ros.messages.description import PULSES_PER_TURN
from dcrb_ros.messages.topics import GROUND_TRUTH, ROLLER_STATES, Message, Topic
from dcrb_ros.recordings.arrays import states_of, tacho_of, temperatures_of, truths_of
from dcrb_ros.schema.arrays import Floats, Integers, Samples
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.simulation.ground_truth import GroundTruth

if TYPE_CHECKING:
    from dcrb_ros.settings.configuration import Configuration


class RecordedRun(ABC):
    """The attributes of a recording that a `SimulationResult` has, too."""

    manifest: Mapping[str, Any]

    @abstractmethod
    def messages(self, topics: Iterable[Topic] | None = None, *, namespace: str | None = None) -> Iterator[Message]:
        """Yield the messages on some topics."""

    @abstractmethod
    def waveform(self, start: float | None = None, stop: float | None = None) -> Waveform:
        """Return the samples."""

    @property
    @abstractmethod
    def configuration(self) -> Configuration:
        """Configuration of the bench."""

    @property
    @abstractmethod
    def configured(self) -> bool:
        """Whether the recording contains the configuration of the bench."""

    @property
    @abstractmethod
    def described(self) -> bool:
        """Whether the recording has no manifest."""

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
