"""The digest of the samples that a recording contains, and the one that its outcome record states."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from dcrb_ros.recordings.manifest import DAMAGE, Outcome

SHOWN = 12
"""Digits of a digest in a message."""


@dataclass(frozen=True)
class RecordedSamples:
    """Range and hash of samples."""

    first_index: int
    """Index of the first sample."""
    count: int
    sha256: str
    end: int
    """Index after the last sample."""


@dataclass(frozen=True)
class SampleDigests:
    """The samples that a recording states, and those that it contains."""

    stated: RecordedSamples | None
    """From the outcome record; None if that is damaged or missing."""
    read: RecordedSamples
    """From the messages."""
    later_part: bool = False
    """Whether the files before were left out, as in a later file of a split recording that is read alone."""

    @property
    def comparable(self) -> bool:
        """Whether both describe the same samples.

        A later file of a split recording states those of the earlier files, too, and a recording without the waveform those of the run.
        """
        return self.stated is not None and self.read.count > 0 and not self.later_part

    @property
    def match(self) -> bool | None:
        """Whether the digests agree; None if they are not comparable."""
        return self.stated.sha256 == self.read.sha256 if self.stated is not None and self.comparable else None

    @property
    def mismatch(self) -> str:
        """A sentence on digests that differ; the empty string if they agree or are not comparable."""
        if self.stated is None or self.match is not False:
            return ""
        return (
            f"the recording's samples do not match its own digest: it states {self.stated.count} samples with sha256 "
            f"{self.stated.sha256[:SHOWN]}, and contains {self.read.count} with {self.read.sha256[:SHOWN]}; they were changed or lost "
            "after the recording was made"
        )


def stated_samples(outcome: Mapping[str, Any] | None) -> RecordedSamples | None:
    """Return the samples that an outcome record states; None if it is damaged or missing."""
    if outcome is None:
        return None
    try:
        first, count = int(outcome["first_index"]), int(outcome["samples"])
        return RecordedSamples(first, count, str(outcome["sha256"]), int(outcome.get("end_index", first + count)))
    except DAMAGE:
        return None


def samples_in(outcome: Outcome) -> RecordedSamples:
    """Return the samples that were added to an outcome."""
    return RecordedSamples(outcome.first_index or 0, outcome.samples, outcome.sha256, outcome.end_index)
