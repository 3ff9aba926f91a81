"""The waveform as it is measured, and before the measurement chain: a message per block."""

from __future__ import annotations

from dcrb_ros.messages.cdr import POINT_CLOUD
from dcrb_ros.messages.points import decode_vibration, encode_vibration
from dcrb_ros.messages.topic import SimulatedTopic, per_block

VIBRATION = SimulatedTopic(
    "outer_ring/vibration",
    POINT_CLOUD,
    "the measured waveform in blocks of 1024 samples at 51.2 kHz: `t` [ns] after the stamp, `ax`, `ay` [m/s²], `shaft_angle` [rad]",
    decode=decode_vibration,
    encode=per_block(lambda block, frame: encode_vibration(block, block.acceleration, frame)),
)
VIBRATION_CLEAN = SimulatedTopic(
    "outer_ring/vibration_clean",
    POINT_CLOUD,
    "the acceleration of the outer ring after the anti-alias filter, without the other stages of the sensor; off by default "
    "(`publishing.clean`)",
    decode=decode_vibration,
    encode=per_block(lambda block, frame: encode_vibration(block, block.clean, frame)),
    enabled=lambda configuration: configuration.publishing.clean,
)
