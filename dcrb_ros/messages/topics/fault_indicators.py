"""The levels of the characteristic lines."""

from __future__ import annotations

from dcrb_ros.messages.cdr import FRAME, JOINT_STATE
from dcrb_ros.messages.description import INDICATORS
from dcrb_ros.messages.joints import decode_joints, encode_joints
from dcrb_ros.messages.topic import DetectedTopic
from dcrb_ros.stream.diagnosis import Diagnosis


def encode_indicators(diagnosis: Diagnosis, frame: str = FRAME) -> bytes:
    """Return the levels over background [dB] as a JointState; the values are in ``position``."""
    return encode_joints(diagnosis.time_ns, INDICATORS, [diagnosis.levels.get(name, 0.0) for name in INDICATORS], frame=frame)


FAULT_INDICATORS = DetectedTopic(
    "fault_indicators", JOINT_STATE, "levels of the detector over background [dB]", decode=decode_joints, encode=encode_indicators
)
