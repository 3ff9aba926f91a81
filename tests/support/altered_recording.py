"""A recording whose samples were changed after it was made."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from dcrb_ros.messages.points import decode_vibration
from dcrb_ros.messages.topics import VIBRATION
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recovery import described_channel
from dcrb_ros.recordings.splitting import Bag


def with_flipped_bit(data: bytes) -> bytes:
    """Return a block with one bit of a sample flipped, the first one from its middle on; the time of a point is no part of a sample."""
    before = decode_vibration(data).packed()
    for at in range(len(data) // 2, len(data)):
        changed = bytearray(data)
        changed[at] ^= 0x01
        if decode_vibration(bytes(changed)).packed() != before:
            return bytes(changed)
    raise ValueError("the block has no sample in its second half")


def altered(source: Path, target: Path, change: Callable[[bytes], bytes | None] = with_flipped_bit) -> Path:
    """Copy a recording with a ``change`` of each block of samples, None for its removal; checksums and records of the file are right."""
    recording = Recording(source)
    records = {r.name: dict(r.metadata) for file in recording.stored for r in file.metadata() if r.name != "rosbag2"}
    bag = Bag(target, opening={}, closing=lambda: records)
    for stored in recording.stored[0].messages([]):
        assert stored.schema is not None
        waveform = stored.channel.topic.endswith(f"/{VIBRATION.name}")
        data = change(stored.message.data) if waveform else stored.message.data
        if data is not None:
            bag.write([(described_channel(stored.channel, stored.schema), stored.message.log_time, data)])
    bag.close()
    return target
