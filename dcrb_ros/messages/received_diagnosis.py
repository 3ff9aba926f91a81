"""A diagnosis received from a detector: the minimum that a message on `diagnosis` must contain to be evaluated."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from dcrb_ros.messages.statuses import decode_diagnostics
from dcrb_ros.schema.refusal import Refusal, nearest
from dcrb_ros.schema.verdicts import BEARING_FAULTS, VERDICTS, is_alarm

LATEST = 1e7
"""Latest time stamp accepted as simulated time [s]; the wall clock is far beyond it."""


@dataclass(frozen=True)
class ReceivedDiagnosis:
    """One diagnosis of a detector."""

    time: float
    """Simulated time of the end of the signal that was judged [s]."""
    verdict: str
    score: float | None = None
    """Evidence for a fault, in any unit; None if the detector publishes none."""
    reason: str = ""
    signal_received: float | None = None
    """Signal time received when the diagnosis arrived [s], if later than `time`; None if it arrived at once."""

    @property
    def issued_at(self) -> float:
        """Signal time at which the diagnosis counts as issued [s]."""
        return self.time if self.signal_received is None else max(self.time, self.signal_received)

    @property
    def alarm(self) -> bool:
        """Whether the verdict is an alarm."""
        return is_alarm(self.verdict)


def evidence(verdict: str, confidence: float) -> float | None:
    """Return the evidence for a bearing fault that follows from a verdict and its confidence (0 to 1); None for other verdicts."""
    if verdict in BEARING_FAULTS:
        return confidence
    return 1.0 - confidence if verdict == "healthy" else None


def decode_diagnosis(data: bytes) -> ReceivedDiagnosis:
    """Return the diagnosis in a message on `diagnosis`.

    Only the first status is read: its value ``verdict`` and, if present, ``score`` (or else ``confidence``) and ``reason``.

    Raises:
        Refusal: the message is not a DiagnosticArray, has no status, no verdict or an unknown one, or its stamp is not a simulated time.
    """
    time_ns, statuses = decode_diagnostics(data)
    if not statuses:
        raise Refusal("a message on diagnosis has no status: publish one status with the value 'verdict'")
    values = statuses[0].values
    verdict = values.get("verdict")
    if verdict is None:
        raise Refusal(f"the status '{statuses[0].name}' on diagnosis has no value 'verdict': give one of {', '.join(VERDICTS)}")
    if verdict not in VERDICTS:
        raise Refusal(f"the verdict '{verdict}' is unknown: give one of {', '.join(VERDICTS)}{nearest(verdict, VERDICTS)}")
    return ReceivedDiagnosis(checked_time(time_ns), verdict, score_of(verdict, values), values.get("reason", ""))


def checked_time(time_ns: int) -> float:
    """Return the stamp of a diagnosis [s].

    Raises:
        Refusal: it is not a simulated time.
    """
    time = time_ns * 1e-9
    if not 0.0 <= time <= LATEST:
        raise Refusal(
            f"a diagnosis is stamped {time:.0f} s: the stamp must be the simulated time of the judged samples, from the block's header"
        )
    return time


def score_of(verdict: str, values: Mapping[str, str]) -> float | None:
    """Return the evidence for a fault in the values of a status: ``score``, or what follows from ``confidence``; None without either.

    Raises:
        Refusal: it is not a finite number.
    """
    score, confidence = values.get("score", values.get("score [dB]")), values.get("confidence")
    given = score if score is not None else confidence
    if given is None:
        return None
    try:
        number = float(given)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise Refusal(f"a diagnosis has {'score' if score is not None else 'confidence'} = '{given[:40]}': it must be a finite number")
    return number if score is not None else evidence(verdict, number)
