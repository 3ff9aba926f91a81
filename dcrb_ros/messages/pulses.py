"""The pulses of a tacho as a PointCloud2, one point per pulse."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dcrb_ros.messages.cdr import FRAME, stamp_of
from dcrb_ros.messages.points import MOST_SAMPLES, decode_cloud, encode_points, fields_of
from dcrb_ros.schema.arrays import Integers
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.stream.block import Block

PULSE = np.dtype([("t", "<u4"), ("pulse", "<u4")])
NUMBERS = 1 << 32
"""Number of pulses after which they are counted from zero again."""


@dataclass(frozen=True)
class PulseBlock:
    """The pulses during a block of the waveform, decoded from a message."""

    stamp_ns: int
    """Time of the first sample of the block [ns]."""
    time_ns: Integers
    """Time of each pulse, shape (pulses,) [ns]."""
    number: Integers
    """Number of each pulse since the start, modulo `NUMBERS`, shape (pulses,)."""


def encode_pulses(block: Block, frame: str = FRAME) -> bytes:
    """Return the pulses of a block as a PointCloud2 with the fields of `PULSE`, stamped with the first sample."""
    points = np.empty(len(block.pulse_ns), PULSE)
    points["t"], points["pulse"] = block.pulse_ns - block.stamp_ns, block.pulse_number % NUMBERS
    return encode_points(points, block.stamp_ns, frame)


def decode_pulses(data: bytes) -> PulseBlock:
    """Return the pulses in a PointCloud2.

    Raises:
        Refusal: the fields are not those of `PULSE`, or the length does not fit them.
    """
    cloud, fields = decode_cloud(data)
    if fields != fields_of(PULSE) or cloud.point_step != PULSE.itemsize or cloud.is_bigendian or cloud.height != 1:
        raise Refusal(
            f"a PointCloud2 with the fields {[name for name, *_ in fields]} has no pulses of a tacho: it must have t and pulse, "
            f"{PULSE.itemsize} bytes a pulse, little endian, height 1"
        )
    if cloud.width > MOST_SAMPLES or len(cloud.data) != cloud.width * PULSE.itemsize:
        raise Refusal(
            f"a block of a tacho declares {cloud.width} pulses in {len(cloud.data)} bytes: it must have {PULSE.itemsize} bytes per pulse "
            f"and at most {MOST_SAMPLES} pulses"
        )
    points, stamp_ns = np.frombuffer(cloud.data.tobytes(), PULSE), stamp_of(cloud.header)
    return PulseBlock(stamp_ns, stamp_ns + points["t"].astype(np.int64), points["pulse"].astype(np.int64))
