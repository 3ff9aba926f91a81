"""A low-passed preview of the waveform for viewers."""

from __future__ import annotations

from dcrb_ros.messages.cdr import IMU
from dcrb_ros.messages.plain import encode_preview
from dcrb_ros.messages.topic import Encoded, EncodedBench, SimulatedTopic
from dcrb_ros.stream.block import Block


def _encode(block: Block, source: EncodedBench) -> Encoded:
    if block.lost:
        return
    for time_ns, sample in zip(block.preview_ns, block.preview, strict=True):
        yield time_ns, encode_preview(time_ns, sample, source.frame)


ACCELERATION = SimulatedTopic("outer_ring/acceleration", IMU, "low-passed preview for viewers, 200 Hz", depth=500, encode=_encode)
