"""Reproduction of a recorded run: the same configuration, seed and commands must produce the same samples.

That requires the same software, the same results of the mathematical functions of C library and numpy, and processors that all have fused
multiply-add, or all have none.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from typing import Any

from dcrb_ros.messages.points import MOST_SAMPLES as LONGEST_BLOCK
from dcrb_ros.messages.points import SAMPLE, index_at, packed
from dcrb_ros.messages.topics import SIMULATED
from dcrb_ros.recordings.digest import SHOWN, RecordedSamples, SampleDigests, stated_samples
from dcrb_ros.recordings.manifest import model_fingerprint, software
from dcrb_ros.recordings.mathematics import FUNCTIONS
from dcrb_ros.recordings.mcap_reader import MAX_RECORD
from dcrb_ros.recordings.processor import processor, processor_difference
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.runtime.version import __version__
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.schema.simulated_time import MAX_DURATION
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.stream.block import Block
from dcrb_ros.stream.events import CommandSchedule

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


def _check_stated(stated: RecordedSamples, recording: Recording) -> None:
    """Refuse an outcome record that states a longer run than the messages show; a chunk that cannot be read may hold some of them.

    Raises:
        Refusal: the run would not end where the recording does.
    """
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
        self.digests: SampleDigests = recording.digests()
        if self.digests.read.count and not self.digests.comparable:
            self.samples = self.digests.read
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
        sha256 = self._digest.hexdigest()
        if self.digests.mismatch:
            agreeing = {self.samples.sha256: "the stated digest", self.digests.read.sha256: "the samples read"}.get(sha256, "neither")
            raise NotReproduced(f"{self.recording.path}: {self.digests.mismatch}; the simulation agrees with {agreeing}")
        if sha256 != self.samples.sha256:
            digests = f"sha256 {sha256[:SHOWN]} instead of {self.samples.sha256[:SHOWN]}"
            raise NotReproduced(f"the samples differ from those of {self.recording.path} ({digests}): {self.difference() or ALIKE}")

    def difference(self) -> str:
        """Return how model, software or processor differ from those that made the recording; the empty string if they do not."""
        return origin_difference(self.recording)


def origin_difference(recording: Recording) -> str:
    """Return how model, software or processor differ from those that made a recording; the empty string if they do not."""
    manifest = recording.manifest
    reasons = [_model_difference(manifest), _software_difference(manifest)]
    reasons.append(processor_difference(manifest.get("processor"), processor()))
    return "; ".join(reason for reason in reasons if reason)


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
