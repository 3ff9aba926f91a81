"""The answers of a user's detector, and when the signal was sent to which they are the answer."""

from __future__ import annotations

import math
import time
from abc import ABC, abstractmethod
from bisect import bisect_left
from dataclasses import dataclass, field, replace

from dcrb_ros.exam.evaluation import Outcome
from dcrb_ros.messages.received_diagnosis import decode_diagnosis
from dcrb_ros.schema.refusal import Refusal

PROMPT = 2.0
"""Longest time from its signal to a diagnosis that counts as issued at its stamp: wall time, and signal sent at the recorded pace [s]."""
MAX_STAMP_LEAD = 1.0
"""Signal by which a stamp may be ahead of the signal sent [s], for a detector that counts samples itself."""


@dataclass
class Answers(ABC):
    """The messages of a detector in a scenario, and when the signal was sent to which they are the answer."""

    refused: list[str] = field(default_factory=list)
    """Why messages are invalid."""
    begin: float = 0.0
    """Time of the first sample [s]."""
    received_at: float = 0.0
    """Wall time of the last message [s]."""
    rate: float = 0.0
    """Recorded over wall time; with 0 the signal is sent as fast as its diagnoses arrive [-]."""
    valid: int = 0
    """Valid messages [-]."""
    period: float = 0.0
    """Longest time between the stamps of two consecutive messages, and before the first one [s]."""
    _latest: float = -math.inf
    """Latest stamp [s]."""
    _ends: list[float] = field(default_factory=list)
    """Time up to which the signal had been sent after each bundle [s]."""
    _sent_at: list[float] = field(default_factory=list)
    """Wall time at which each bundle was sent [s]."""

    def signal_sent(self, end: float) -> None:
        """Note that the signal has been sent up to the time ``end`` [s]."""
        self._ends.append(end)
        self._sent_at.append(time.monotonic())

    def receive(self, data: bytes) -> None:
        """Take a message of the detector."""
        self.received_at = time.monotonic()
        try:
            stamp = self._taken(data)
        except Refusal as refusal:
            self.refused.append(str(refusal))
            return
        self.valid += 1
        self.period = max(self.period, stamp - self.latest)
        self._latest = max(self._latest, stamp)

    @abstractmethod
    def _taken(self, data: bytes) -> float:
        """Take a message and return its stamp [s].

        Raises:
            Refusal: it is invalid.
        """

    @abstractmethod
    def forget(self) -> None:
        """Drop the messages, some of which may be of another program."""

    def _signal_received(self, stamp: float) -> float:
        """Return the signal time at which a message counts as issued [s].

        This is its stamp, unless it arrived after one with a later stamp or more than `PROMPT` after its signal, in wall time or in signal
        that was sent. The latter counts where the signal is sent faster than recorded because the detector answers.

        Raises:
            Refusal: the stamp is later than the signal sent.
        """
        sent = self._ends[-1] if self._ends else self.begin
        if stamp > sent + MAX_STAMP_LEAD:
            raise Refusal(
                f"a diagnosis is stamped {stamp:.2f} s when the signal had been sent up to {sent:.2f} s: the stamp must be the simulated "
                "time of the judged samples, from the block's header"
            )
        index = bisect_left(self._ends, stamp)
        late = index < len(self._sent_at) and self.received_at - self._sent_at[index] > PROMPT
        late = late or sent - stamp > PROMPT * max(1.0, self.rate)
        return max(stamp, self.latest, sent if late else stamp)

    @property
    def latest(self) -> float:
        """Latest stamp, or the time of the first sample [s]."""
        return max(self.begin, self._latest)


@dataclass
class Diagnoses(Answers, Outcome):
    """The diagnoses that a detector published in a scenario."""

    def forget(self) -> None:
        self.received.clear()

    def _taken(self, data: bytes) -> float:
        diagnosis = decode_diagnosis(data)
        self.received.append(replace(diagnosis, signal_received=self._signal_received(diagnosis.time)))
        return diagnosis.time
