"""Statistical features of every block."""

from __future__ import annotations

from dcrb_ros.messages.cdr import JOINT_STATE
from dcrb_ros.messages.joints import decode_joints, encode_features
from dcrb_ros.messages.topic import SimulatedTopic, per_block

FEATURES = SimulatedTopic(
    "outer_ring/features",
    JOINT_STATE,
    "per block: rms, peak, crest factor and kurtosis of `ay`, clipped samples of both axes",
    decode=decode_joints,
    encode=per_block(encode_features),
)
