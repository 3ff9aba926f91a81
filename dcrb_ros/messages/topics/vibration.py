"""The measured waveform, a message per block."""

from __future__ import annotations

from dcrb_ros.messages.cdr import POINT_CLOUD
from dcrb_ros.messages.points import decode_vibration, encode_vibration
from dcrb_ros.messages.topic import Encoded, EncodedBench, SimulatedTopic
from dcrb_ros.stream.block import Block


def _encode(block: Block, source: EncodedBench) -> Encoded:
    return () if block.lost else ((block.stamp_ns, encode_vibration(block, block.acceleration, source.frame)),)


VIBRATION = SimulatedTopic(
    "outer_ring/vibration",
    POINT_CLOUD,
    "the measured waveform in blocks of 1024 samples at 51.2 kHz: `t` [ns] after the stamp, `ax`, `ay` [m/s²], `shaft_angle` [rad]",
    decode=decode_vibration,
    encode=_encode,
)
