"""Reproduction of a recorded run: the same configuration, seed and commands must produce the same samples."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass

from dcrb_ros.messages.points import packed
from dcrb_ros.recordings.manifest import model_fingerprint, software
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.runtime.version import __version__
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.stream.block import Block
from dcrb_ros.stream.events import CommandSchedule


class NotReproduced(RuntimeError):
    """The samples differ from the recorded ones."""


@dataclass(frozen=True)
class RecordedSamples:
    """Range and hash of the samples in a recording."""

    first_index: int
    """Index of the first sample."""
    count: int
    sha256: str
    end: int
    """Index after the last sample."""


def recorded_samples(recording: Recording) -> RecordedSamples:
    """Return range and hash of the recorded samples, from the outcome record or else from the waveform.

    Raises:
        Refusal: there is no outcome record, and the waveform has a gap.
    """
    outcome = recording.outcome
    try:
        if outcome is not None:
            first, count = int(outcome["first_index"]), int(outcome["samples"])
            return RecordedSamples(first, count, str(outcome["sha256"]), int(outcome.get("end_index", first + count)))
    except (KeyError, TypeError, ValueError):
        pass  # damaged, therefore treated as missing
    digest, rate = hashlib.sha256(), recording.sampling_rate
    begin: int | None = None
    reached = count = 0
    publishing = recording.configuration.publishing
    contiguous = not (publishing.loss_probability or publishing.burst_period)
    for block in recording.vibrations():
        index = block.first_index(rate)
        begin = index if begin is None else begin
        if contiguous and reached and index != reached:
            raise Refusal(f"{recording.path} is damaged: the samples {reached} .. {index - 1} are missing, so it cannot be checked")
        digest.update(block.packed())
        reached, count = index + len(block.shaft_angle), count + len(block.shaft_angle)
    return RecordedSamples(begin or 0, count, digest.hexdigest(), reached)


class Reproduction:
    """Reproduces the run in a recording."""

    def __init__(self, recording: Recording) -> None:
        """Prepare the run of a recording.

        Raises:
            Refusal: it contains imported data or no samples.
        """
        self.recording = recording
        self.samples = recorded_samples(recording)
        if self.samples.count == 0:
            raise Refusal(f"{recording.path} contains no samples to reproduce")
        self._digest = hashlib.sha256()
        self.configuration = recording.configuration
        self.duration = self.samples.end / self.configuration.sensor.sampling_rate

    def blocks(self, simulation: Simulation) -> Iterator[Block]:
        """Yield the blocks of the run, with the commands applied at their times."""
        schedule = CommandSchedule(self.recording.commands())
        schedule.apply_due(simulation)
        for block in simulation.blocks(self.duration):
            skipped = max(0, self.samples.first_index - block.index)
            if skipped < len(block.shaft_angle) and not block.lost:
                self._digest.update(packed(block.acceleration[skipped:], block.shaft_angle[skipped:]))
            yield block
            schedule.apply_due(simulation)

    def check(self) -> None:
        """Compare the samples with the recorded ones.

        Raises:
            NotReproduced: they differ.
        """
        found = self._digest.hexdigest()
        if found != self.samples.sha256:
            raise NotReproduced(
                f"the samples differ from those of {self.recording.path} (sha256 {found[:12]} instead of {self.samples.sha256[:12]}): "
                f"{self.difference() or 'although model and software are the same: the recording or the model is faulty'}"
            )

    def difference(self) -> str:
        """Return how model or software differ from those that made the recording; the empty string if they do not."""
        manifest = self.recording.manifest
        version, model = manifest.get("dcrb_ros", "of an unknown version"), manifest.get("model", "unknown")
        if version != __version__ or model != model_fingerprint():
            return f"it was made by dcrb_ros {version} with model {model}, this is {__version__} with model {model_fingerprint()}"
        recorded = manifest.get("software", {})
        differing = [
            f"{name} {recorded.get(name, 'unknown')} instead of {present}"
            for name, present in software().items()
            if recorded.get(name) != present
        ]
        return "it was made with " + ", ".join(differing) if differing else ""
