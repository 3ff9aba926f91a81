"""The pulses of a tacho as a PointCloud2, one point per pulse."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dcrb_ros.messages.cdr import FRAME
from dcrb_ros.messages.points import decode_cloud, encode_points
from dcrb_ros.schema.arrays import Integers
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
    wanted = f"has no pulses of a tacho: it must have t and pulse, {PULSE.itemsize} bytes a pulse"
    stamp_ns, points = decode_cloud(data, [PULSE], wanted, "a block of a tacho", "pulses")
    return PulseBlock(stamp_ns, stamp_ns + points["t"].astype(np.int64), points["pulse"].astype(np.int64))
