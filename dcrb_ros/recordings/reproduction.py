"""A recorded run once more: the same configuration, seed and commands, and whether the same samples come out."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass

from dcrb_ros import __version__
from dcrb_ros.messages.points import packed
from dcrb_ros.recordings.manifest import model_fingerprint, software
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.runtime.refusal import Refusal
from dcrb_ros.simulation.block import Block
from dcrb_ros.simulation.events import CommandSchedule
from dcrb_ros.simulation.loop import Simulation


class NotReproduced(RuntimeError):
    """Other samples came out."""


@dataclass(frozen=True)
class Samples:
    """What a recording says of its samples."""

    first_index: int
    count: int
    sha256: str
    end: int
    """Index after the last sample."""


def recorded_samples(recording: Recording) -> Samples:
    """Return what the end of a recording says of its samples; of one that was cut off, what its waveform says.

    Raises:
        Refusal: a waveform that was cut off has a gap.
    """
    told = recording.outcome
    try:
        if told is not None:
            first, count = int(told["first_index"]), int(told["samples"])
            return Samples(first, count, str(told["sha256"]), int(told.get("end_index", first + count)))
    except (KeyError, TypeError, ValueError):
        pass  # damaged, so it is read from the waveform as if there were none
    digest, rate = hashlib.sha256(), recording.sampling_rate
    begin: int | None = None
    reached = count = 0
    publishing = recording.configuration.publishing
    whole = not (publishing.loss_probability or publishing.burst_period)
    for block in recording.vibrations():
        index = block.first_index(rate)
        begin = index if begin is None else begin
        if whole and reached and index != reached:
            raise Refusal(f"{recording.path} is damaged: the samples {reached} .. {index - 1} are missing, so it cannot be checked")
        digest.update(block.packed())
        reached, count = index + len(block.shaft_angle), count + len(block.shaft_angle)
    return Samples(begin or 0, count, digest.hexdigest(), reached)


class Reproduction:
    """A run as a recording tells it."""

    def __init__(self, recording: Recording) -> None:
        """Prepare the run of a recording.

        Raises:
            Refusal: it holds imported data, or commands that cannot be repeated.
        """
        self.recording = recording
        self.samples = recorded_samples(recording)
        if self.samples.count == 0:
            raise Refusal(f"{recording.path} holds no sample to make again")
        self._digest = hashlib.sha256()
        self.configuration = recording.configuration
        self.duration = self.samples.end / self.configuration.sensor.sampling_rate

    def blocks(self, simulation: Simulation) -> Iterator[Block]:
        """Yield the blocks of the run; the commands come at their times."""
        schedule = CommandSchedule(self.recording.commands())
        schedule.apply_due(simulation)
        for block in simulation.blocks(self.duration):
            skipped = max(0, self.samples.first_index - block.index)
            if skipped < len(block.shaft_angle) and not block.lost:
                self._digest.update(packed(block.acceleration[skipped:], block.shaft_angle[skipped:]))
            yield block
            schedule.apply_due(simulation)

    def check(self) -> None:
        """Compare what came out with what was recorded.

        Raises:
            NotReproduced: they differ.
        """
        found = self._digest.hexdigest()
        if found != self.samples.sha256:
            raise NotReproduced(
                f"the samples differ from those of {self.recording.path} (sha256 {found[:12]} instead of {self.samples.sha256[:12]}): "
                f"{self.difference() or 'the same model and software made others, so the recording or the model is at fault'}"
            )

    def difference(self) -> str:
        """Return what is not as it was when the recording was made, or nothing."""
        about = self.recording.manifest
        version, model = about.get("dcrb_ros", "of an unknown version"), about.get("model", "unknown")
        if version != __version__ or model != model_fingerprint():
            return f"it was made by dcrb_ros {version} with model {model}, this is {__version__} with model {model_fingerprint()}"
        was = about.get("software", {})
        other = {name: (was.get(name, "unknown"), here) for name, here in software().items() if was.get(name) != here}
        return (
            "it was made with " + ", ".join(f"{name} {then} where this is {here}" for name, (then, here) in other.items()) if other else ""
        )
