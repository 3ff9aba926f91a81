"""What the fault detector says, as messages."""

from __future__ import annotations

import numpy as np

from dcrb_ros.diagnosis.detector import Diagnosis
from dcrb_ros.messages.description import INDICATORS
from dcrb_ros.messages.joints import encode_joints
from dcrb_ros.messages.points import encode_spectrum
from dcrb_ros.messages.statuses import ERROR, OK, WARN, Status, encode_diagnostics
from dcrb_ros.messages.topics import DIAGNOSIS, ENVELOPE_SPECTRUM, FAULT_INDICATORS, Message

LEVELS = {"waiting": OK, "healthy": OK, "sensor": WARN}


def encode_diagnosis(diagnosis: Diagnosis) -> bytes:
    """Return the detector's verdict as a DiagnosticArray of one status; every fault is an error."""
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
    values |= {"score": f"{max(diagnosis.scores.values()):.2f}"} if diagnosis.scores else {}  # the exam's evidence for any fault
    values |= {"clipped": str(diagnosis.clipped), "remarks": "; ".join(diagnosis.remarks)}
    status = Status("fault_detector", LEVELS.get(diagnosis.verdict, ERROR), diagnosis.verdict, values)
    return encode_diagnostics(round(diagnosis.time * 1e9), [status])


def encode_indicators(diagnosis: Diagnosis) -> bytes:
    """Return the levels over background [dB] as a JointState."""
    levels, none = np.array([diagnosis.levels.get(name, 0.0) for name in INDICATORS]), np.zeros(0)
    return encode_joints(round(diagnosis.time * 1e9), INDICATORS, levels, none, none)


def diagnosis_messages(diagnosis: Diagnosis) -> list[Message]:
    """Return what the detector publishes of a diagnosis."""
    time_ns, (orders, amplitude) = round(diagnosis.time * 1e9), diagnosis.spectrum
    messages = [
        Message(DIAGNOSIS, time_ns, encode_diagnosis(diagnosis)),
        Message(FAULT_INDICATORS, time_ns, encode_indicators(diagnosis)),
    ]
    if len(orders):
        messages.append(Message(ENVELOPE_SPECTRUM, time_ns, encode_spectrum(time_ns, orders, amplitude, diagnosis.shaft_frequency)))
    return messages
