"""The description of the sensor: at the start, again every second, and when its range has changed."""

from __future__ import annotations

from dcrb_ros.messages.cdr import TEXT
from dcrb_ros.messages.description import decode_sensor, sensor_text
from dcrb_ros.messages.plain import encode_text
from dcrb_ros.messages.topic import Encoded, EncodedBench, SimulatedTopic
from dcrb_ros.stream.block import Block

REPEAT_NS = 1_000_000_000
"""Simulated time between two descriptions [ns]: whoever reads a part of a recording, or plays it from the middle, loses less than that."""


def _start(source: EncodedBench) -> bytes:
    return encode_text(sensor_text(source.configuration))


def _encode(block: Block, source: EncodedBench) -> Encoded:
    changed = source.after(block)
    return ((block.stamp_ns, _start(changed)),) if changed is not source or repeats_with(block) else ()


def repeats_with(block: Block) -> bool:
    """Return whether the description is repeated with a block: whether a multiple of `REPEAT_NS` after zero falls on it."""
    return block.index > 0 and -(-block.stamp_ns // REPEAT_NS) * REPEAT_NS < block.end_ns


SENSOR = SimulatedTopic(
    "outer_ring/sensor",
    TEXT,
    "JSON: sampling rate, units, axes, range, block size, bearing, fault orders",
    depth=1,
    latched=True,
    decode=decode_sensor,
    encode=_encode,
    start=_start,
)
