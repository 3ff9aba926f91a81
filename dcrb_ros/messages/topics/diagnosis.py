"""The verdict of the fault detector and its evidence."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress

from dcrb_ros.messages.cdr import DIAGNOSTICS, FRAME
from dcrb_ros.messages.description import INDICATORS
from dcrb_ros.messages.statuses import ERROR, OK, WARN, Status, decode_diagnostics, encode_diagnostics
from dcrb_ros.messages.topic import DetectedTopic
from dcrb_ros.schema.verdicts import COMPONENTS, TROUBLES
from dcrb_ros.stream.diagnosis import Diagnosis

LEVELS = {"waiting": OK, "healthy": OK, "sensor": WARN}
"""Status level of each verdict; that of any other verdict is an error."""


def encode_diagnosis(diagnosis: Diagnosis, frame: str = FRAME) -> bytes:
    """Return a diagnosis as a DiagnosticArray with one status."""
    values = {
        "verdict": diagnosis.verdict,
        "confidence": f"{diagnosis.confidence:.3f}",
        "reason": diagnosis.reason,
        "shaft_frequency [Hz]": f"{diagnosis.shaft_frequency:.4f}",
        "gaps": str(diagnosis.gaps),
    }
    values |= {f"{name} [dB]": f"{diagnosis.levels.get(name, 0.0):.2f}" for name in INDICATORS}
    values |= {"severity [m/s^2]": f"{diagnosis.severity:.3f}", "trend [dB/min]": f"{diagnosis.trend:.2f}"}
    values |= {f"score {kind} [dB]": f"{score:.2f}" for kind, score in diagnosis.scores.items()}
    # The exam takes the largest score as the evidence for a fault, and refuses one that is not a number.
    largest = max(diagnosis.scores.values(), key=lambda score: (math.isnan(score), score), default=None)
    values |= {} if largest is None else {"score": f"{largest:.2f}"}
    values |= {"clipped": str(diagnosis.clipped), "remarks": "; ".join(diagnosis.remarks)}
    status = Status("fault_detector", LEVELS.get(diagnosis.verdict, ERROR), diagnosis.verdict, values)
    return encode_diagnostics(diagnosis.time_ns, [status], frame)


def decode_scores(values: Mapping[str, str]) -> dict[str, float]:
    """Return the scores in the values of a diagnosis by component or trouble [dB]; anything that is not a finite number is left out."""
    scores: dict[str, float] = {}
    for component in (*COMPONENTS, *TROUBLES):
        with suppress(ValueError):
            scores[component] = float(values.get(f"score {component} [dB]", ""))
    return {component: score for component, score in scores.items() if math.isfinite(score)}


DIAGNOSIS = DetectedTopic(
    "diagnosis",
    DIAGNOSTICS,
    "verdict and evidence of the detector; the exam scores this topic of any detector",
    decode=decode_diagnostics,
    encode=encode_diagnosis,
)
