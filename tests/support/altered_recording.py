"""A recording whose samples were changed after it was made."""

from __future__ import annotations

from pathlib import Path

from dcrb_ros.messages.topics import VIBRATION
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recovery import described_channel
from dcrb_ros.recordings.splitting import Bag


def altered(source: Path, target: Path) -> Path:
    """Copy a recording with one bit of each block of samples flipped; checksums and records of the file are right."""
    recording = Recording(source)
    records = {r.name: dict(r.metadata) for file in recording.stored for r in file.metadata() if r.name != "rosbag2"}
    bag = Bag(target, opening={}, closing=lambda: records)
    for stored in recording.stored[0].messages([]):
        assert stored.schema is not None
        data = bytearray(stored.message.data)
        if stored.channel.topic.endswith(f"/{VIBRATION.name}"):
            data[len(data) // 2] ^= 0x01
        bag.write([(described_channel(stored.channel, stored.schema), stored.message.log_time, bytes(data))])
    bag.close()
    return target
