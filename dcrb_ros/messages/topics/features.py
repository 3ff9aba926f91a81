"""Statistical features of every block."""

from __future__ import annotations

from dcrb_ros.messages.cdr import JOINT_STATE
from dcrb_ros.messages.joints import decode_joints, encode_features
from dcrb_ros.messages.topic import Encoded, EncodedBench, SimulatedTopic
from dcrb_ros.stream.block import Block


def _encode(block: Block, source: EncodedBench) -> Encoded:
    return () if block.lost else ((block.stamp_ns, encode_features(block, source.frame)),)


FEATURES = SimulatedTopic(
    "outer_ring/features",
    JOINT_STATE,
    "per block: rms, peak, crest factor and kurtosis of `ay`, clipped samples of both axes",
    decode=decode_joints,
    encode=_encode,
)
