"""The squared envelope spectrum over orders of the shaft."""

from __future__ import annotations

from dcrb_ros.messages.cdr import POINT_CLOUD
from dcrb_ros.messages.points import decode_spectrum, encode_spectrum
from dcrb_ros.messages.topic import DetectedTopic
from dcrb_ros.stream.diagnosis import Diagnosis


def _encode(diagnosis: Diagnosis, frame: str) -> bytes | None:
    orders, amplitude = diagnosis.spectrum
    return encode_spectrum(diagnosis.time_ns, orders, amplitude, diagnosis.shaft_frequency, frame) if len(orders) else None


ENVELOPE_SPECTRUM = DetectedTopic(
    "envelope_spectrum",
    POINT_CLOUD,
    "squared envelope spectrum of the detector: `frequency` [Hz], `order` [-], `amplitude` [m/s²], the square root of its amplitudes",
    decode=decode_spectrum,
    encode=_encode,
    recorded=False,
)
