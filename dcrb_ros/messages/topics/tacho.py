"""The pulses of the tacho, a message per block of the waveform."""

from __future__ import annotations

from dcrb_ros.messages.cdr import POINT_CLOUD
from dcrb_ros.messages.pulses import decode_pulses, encode_pulses
from dcrb_ros.messages.topic import Encoded, EncodedBench, SimulatedTopic
from dcrb_ros.stream.block import Block


def _encode(block: Block, source: EncodedBench) -> Encoded:
    return () if block.lost else ((block.stamp_ns, encode_pulses(block, source.frame)),)


TACHO = SimulatedTopic(
    "shaft/tacho",
    POINT_CLOUD,
    "the pulses of a tacho during each block of the waveform: `t` [ns] after the stamp, `pulse`, its number; off by default "
    "(`tacho.pulses_per_turn`)",
    decode=decode_pulses,
    encode=_encode,
    enabled=lambda configuration: configuration.tacho.pulses_per_turn > 0,
)
