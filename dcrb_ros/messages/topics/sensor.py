"""The description of the sensor: at the start, and again when its range has changed."""

from __future__ import annotations

from dcrb_ros.messages.cdr import TEXT
from dcrb_ros.messages.description import decode_sensor, sensor_text
from dcrb_ros.messages.plain import encode_text
from dcrb_ros.messages.topic import Encoded, SimulatedTopic, Source
from dcrb_ros.stream.block import Block


def _start(source: Source) -> bytes:
    return encode_text(sensor_text(source.configuration))


def _encode(block: Block, source: Source) -> Encoded:
    changed = source.after(block)
    return () if changed is source else ((block.stamp_ns, _start(changed)),)


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
