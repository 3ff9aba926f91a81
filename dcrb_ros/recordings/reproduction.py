"""Reproduction of a recorded run: the same configuration, seed and commands must produce the same samples.

That requires the same software, the same results of the mathematical functions of C library and numpy, and processors that all have fused
multiply-add, or all have none.
"""

from __future__ import annotations

import hashlib
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Generic, TypeVar

from dcrb_ros.messages.points import MOST_SAMPLES as LONGEST_BLOCK
from dcrb_ros.messages.points import SAMPLE, index_at, packed
from dcrb_ros.messages.topics import SIMULATED
from dcrb_ros.recordings.digest import SHOWN, RecordedSamples, SampleDigests, samples_in, stated_samples
from dcrb_ros.recordings.manifest import Outcome, model_fingerprint, software
from dcrb_ros.recordings.mathematics import FUNCTIONS
from dcrb_ros.recordings.mcap_reader import MAX_RECORD
from dcrb_ros.recordings.processor import processor, processor_difference
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recorder import Made, Recorder, RunRecorder
from dcrb_ros.runtime.version import __version__
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.schema.simulated_time import MAX_DURATION
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.simulation.scenario import scheduled_changes
from dcrb_ros.stream.block import Block
from dcrb_ros.stream.events import CommandSchedule

Simulated = TypeVar("Simulated")
"""The simulation of a bench or of a vehicle."""
ALIKE = (
    "although model, software, processor and mathematical functions are alike; the recording matches its own digest, so a command is "
    "missing in it, or the samples depend on something that recordings do not name"
)
"""What is known of different samples without a recorded reason."""


class NotReproduced(RuntimeError):
    """The samples differ from the recorded ones."""


def recorded_samples(recording: Recording) -> RecordedSamples:
    """Return range and hash of the recorded samples, from the outcome record or else from the waveform.

    Raises:
        Refusal: there is no outcome record, and the waveform has a gap.
    """
    stated = stated_samples(recording.outcome)
    if stated is not None:
        _check_stated(stated, recording)
        return stated
    rate, publishing = recording.sampling_rate, recording.configuration.publishing
    contiguous, outcome = not (publishing.loss_probability or publishing.burst_period), Outcome(rate)
    for block in recording.vibrations():
        index, reached = block.first_index(rate), outcome.end_index
        if contiguous and reached and index != reached:
            raise Refusal(f"{recording.path} is damaged: the samples {reached} .. {index - 1} are missing, so it cannot be checked")
        outcome.add_block(block)
    return samples_in(outcome)


def _check_stated(stated: RecordedSamples, recording: Recording) -> None:
    """Refuse an outcome record that states a longer run than the messages show; a chunk that cannot be read may hold some of them."""
    rate = recording.sampling_rate
    last = index_at(max((message.time_ns for message in recording.messages(SIMULATED)), default=0), rate)
    unread = len(recording.damage) * MAX_RECORD // SAMPLE.itemsize
    # A recording of the sensor description alone does not show how long the run was.
    most = min(last + LONGEST_BLOCK + unread, MAX_DURATION * rate) if last else MAX_DURATION * rate
    if not 0 <= stated.first_index <= stated.end <= most or stated.count > stated.end - stated.first_index:
        raise Refusal(
            f"{recording.path} is damaged: its outcome record states {stated.count} samples from {stated.first_index} to {stated.end}, but "
            f"its last message belongs to sample {last}: simulate the configuration anew"
        )


class ComparedSamples:
    """The samples of a bearing as they are simulated again, compared with those in its recording."""

    def __init__(self, recording: Recording) -> None:
        self.recorded = recorded_samples(recording)
        """The samples that are to be reproduced."""
        self.digests: SampleDigests = recording.digests()
        if self.digests.read.count and not self.digests.comparable:
            self.recorded = self.digests.read
        self._digest = hashlib.sha256()

    @property
    def sha256(self) -> str:
        """Digest of the simulated samples."""
        return self._digest.hexdigest()

    def add(self, block: Block) -> None:
        """Include what the recording has of a simulated block; another box of a vehicle may have been recorded for longer."""
        recorded = slice(max(0, self.recorded.first_index - block.index), max(0, self.recorded.end - block.index))
        if len(block.shaft_angle[recorded]) and not block.lost:
            self._digest.update(packed(block.acceleration[recorded], block.shaft_angle[recorded]))

    @property
    def mismatch(self) -> str:
        """A sentence if the recording does not match its own digest; the empty string if it does."""
        if not self.digests.mismatch:
            return ""
        agreeing = {self.recorded.sha256: "the stated digest", self.digests.read.sha256: "the samples read"}.get(self.sha256, "neither")
        return f"{self.digests.mismatch}; the simulation agrees with {agreeing}"


class RunReproduction(ABC, Generic[Simulated, Made]):
    """Simulates a recorded run again, with its commands, and compares the samples of every bearing."""

    def __init__(self, path: Path, bearings: Mapping[str, Recording]) -> None:
        """Read the samples of the recording of each bearing by name; that of a bench has the name "".

        Raises:
            Refusal: it contains imported data or no samples.
        """
        self.path = path
        self.compared = {name: ComparedSamples(recording) for name, recording in bearings.items()}
        """The samples of each bearing by name."""
        self._first = next(iter(bearings.values()))
        if not any(compared.recorded.count for compared in self.compared.values()):
            raise Refusal(f"{path} contains no samples to reproduce")
        self.duration = max(compared.recorded.end for compared in self.compared.values()) / self._first.sampling_rate
        """Simulated time from the start of the run to the end of the recording [s]."""

    @abstractmethod
    def simulation(self) -> Simulated:
        """Return the simulation of the run at its start."""

    @abstractmethod
    def recorder(self, path: Path, simulation: Simulated) -> RunRecorder[Made]:
        """Return the recorder that writes the run to a new recording."""

    @abstractmethod
    def blocks(self, simulation: Simulated) -> Iterator[Made]:
        """Yield the blocks of the run, with the commands applied at their times."""

    def check(self) -> None:
        """Compare the samples with the recorded ones.

        Raises:
            NotReproduced: they differ.
        """
        for name, compared in self.compared.items():
            if compared.mismatch:
                raise NotReproduced(f"{self.path / name}: {compared.mismatch}")
        different = {name: compared for name, compared in self.compared.items() if compared.sha256 != compared.recorded.sha256}
        if different:
            names, first = ", ".join(filter(None, different)), next(iter(different.values()))
            digests = f"sha256 {first.sha256[:SHOWN]} instead of {first.recorded.sha256[:SHOWN]}"
            samples = f"the samples of {names}" if names else "the samples"
            raise NotReproduced(f"{samples} differ from those of {self.path} ({digests}): {self.difference() or ALIKE}")

    def difference(self) -> str:
        """Return how model, software or processor differ from those that made the recording; the empty string if they do not."""
        manifest = self._first.manifest
        processors = processor_difference(manifest.get("processor"), processor())
        return "; ".join(filter(None, (_model_difference(manifest), _software_difference(manifest), processors)))


class Reproduction(RunReproduction[Simulation, Block]):
    """Reproduces the run in the recording of a bench."""

    def __init__(self, recording: Recording) -> None:
        super().__init__(recording.path, {"": recording})
        self.recording = recording
        self.configuration = recording.configuration

    def simulation(self) -> Simulation:
        """Return the bench at the start of the run."""
        scenario = self.recording.manifest.get("scenario")
        return Simulation(self.configuration, scheduled_changes(scenario, self.configuration, f"{self.path}: scenario") if scenario else ())

    def recorder(self, path: Path, simulation: Simulation) -> Recorder:
        """Return the recorder of the bench."""
        return Recorder(path, self.configuration, simulation.bodies, scenario=self.recording.manifest.get("scenario"))

    def blocks(self, simulation: Simulation) -> Iterator[Block]:
        """Yield the blocks of the run, with the commands applied at their times."""
        schedule = CommandSchedule(self.recording.commands())
        schedule.apply_due(simulation)
        for block in simulation.blocks(self.duration):
            self.compared[""].add(block)
            yield block
            schedule.apply_due(simulation)


def _model_difference(manifest: Mapping[str, Any]) -> str:
    version, model = manifest.get("dcrb_ros", "of an unknown version"), manifest.get("model", "unknown")
    if version == __version__ and model == model_fingerprint():
        return ""
    return f"it was made by dcrb_ros {version} with model {model}, this is {__version__} with model {model_fingerprint()}"


def _software_difference(manifest: Mapping[str, Any]) -> str:
    recorded = manifest.get("software", {})
    differing = [
        f"{name} {recorded.get(name, 'unknown')} instead of {present}"
        for name, present in software().items()
        if recorded.get(name) != present and (name in recorded or name not in FUNCTIONS)
    ]
    return "it was made with " + ", ".join(differing) if differing else ""
