"""What a detector said, as the exam understands it: the least that a message on `diagnosis` must hold."""

from __future__ import annotations

import math
from dataclasses import dataclass

from dcrb_ros.messages.statuses import decode_diagnostics
from dcrb_ros.runtime.refusal import Refusal, nearest

BEARING = ("outer_ring", "inner_ring", "roller", "cage", "compound")
"""Verdicts that name a fault of the bearing."""
VERDICTS = ("healthy", *BEARING, "sensor")
"""Verdicts that a scenario may expect."""
WAITING = "waiting"
"""No verdict yet, said aloud."""
LATEST = 1e7
"""Latest stamp that is believed [s]; a wall clock is far beyond it."""


@dataclass(frozen=True)
class Opinion:
    """One diagnosis."""

    time: float
    """Simulated time that it judges, the end of its signal [s]."""
    verdict: str
    score: float | None = None
    """Evidence for a fault, of any unit; none where the detector publishes none."""
    reason: str = ""
    known: float | None = None
    """What had been heard of the signal when it came, where that is more than it judges [s]; none where it came at once."""

    @property
    def given(self) -> float:
        """When it counts as given [s]."""
        return self.time if self.known is None else max(self.time, self.known)

    @property
    def alarm(self) -> bool:
        """Whether it would bring somebody to the bearing."""
        return self.verdict not in ("healthy", WAITING)


def evidence(verdict: str, confidence: float) -> float | None:
    """Return the evidence for a fault in a confidence of 0 to 1 in a verdict; none where the verdict is not on the bearing."""
    if verdict in BEARING:
        return confidence
    return 1.0 - confidence if verdict == "healthy" else None


def opinion_of(data: bytes) -> Opinion:
    """Return the opinion in a message on `diagnosis`.

    The first status counts: its value ``verdict``, and where there are any ``score`` or else ``confidence``, and ``reason``.

    Raises:
        Refusal: no DiagnosticArray, no status, no verdict or an unknown one, or a stamp that is no simulated time.
    """
    time_ns, statuses = decode_diagnostics(data)
    if not statuses:
        raise Refusal("a diagnosis without a status is no verdict: give one status with the value 'verdict'")
    values, known = statuses[0].values, (*VERDICTS, WAITING)
    verdict = values.get("verdict")
    if verdict is None:
        raise Refusal(f"the status '{statuses[0].name}' on diagnosis has no value 'verdict': give one of {', '.join(known)}")
    if verdict not in known:
        raise Refusal(f"the verdict '{verdict}' is none of {', '.join(known)}{nearest(verdict, known)}")
    time = time_ns * 1e-9
    if not 0.0 <= time <= LATEST:
        raise Refusal(
            f"a diagnosis is stamped {time:.0f} s: the stamp must be the simulated time that it judges, taken from the block's header"
        )
    return Opinion(time, verdict, _score(verdict, values.get("score"), values.get("confidence")), values.get("reason", ""))


def _score(verdict: str, score: str | None, confidence: str | None) -> float | None:
    given = score if score is not None else confidence
    if given is None:
        return None
    try:
        number = float(given)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise Refusal(f"a diagnosis gives {'score' if score is not None else 'confidence'} = '{given[:40]}': it must be a finite number")
    return number if score is not None else evidence(verdict, number)
