"""The waveform before the measurement chain."""

from __future__ import annotations

from dcrb_ros.messages.cdr import POINT_CLOUD
from dcrb_ros.messages.points import decode_vibration, encode_vibration
from dcrb_ros.messages.topic import Encoded, EncodedBench, SimulatedTopic
from dcrb_ros.stream.block import Block


def _encode(block: Block, source: EncodedBench) -> Encoded:
    return () if block.lost else ((block.stamp_ns, encode_vibration(block, block.clean, source.frame)),)


VIBRATION_CLEAN = SimulatedTopic(
    "outer_ring/vibration_clean",
    POINT_CLOUD,
    "the acceleration of the outer ring after the anti-alias filter, without the other stages of the sensor; off by default "
    "(`publishing.clean`)",
    decode=decode_vibration,
    encode=_encode,
    enabled=lambda configuration: configuration.publishing.clean,
)
