"""The pulses of the tacho, a message per block of the waveform."""

from __future__ import annotations

from dcrb_ros.messages.cdr import POINT_CLOUD
from dcrb_ros.messages.pulses import decode_pulses, encode_pulses
from dcrb_ros.messages.topic import SimulatedTopic, per_block

TACHO = SimulatedTopic(
    "shaft/tacho",
    POINT_CLOUD,
    "the pulses of a tacho during each block of the waveform: `t` [ns] after the stamp, `pulse`, its number; off by default "
    "(`tacho.pulses_per_turn`)",
    decode=decode_pulses,
    encode=per_block(encode_pulses),
    enabled=lambda configuration: configuration.tacho.pulses_per_turn > 0,
)
