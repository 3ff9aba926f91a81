"""A foreign waveform into a recording with the topics of the bench, so that everything downstream takes it."""

from __future__ import annotations

import hashlib
import itertools
import json
import shutil
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from dcrb_ros import __version__
from dcrb_ros.bearing.kinematics import Orders
from dcrb_ros.exchange.description import Description, read_description
from dcrb_ros.exchange.files import Array, Foreign, channel, read_foreign
from dcrb_ros.messages.cdr import FRAME
from dcrb_ros.messages.joints import encode_features
from dcrb_ros.messages.plain import encode_text
from dcrb_ros.messages.points import encode_vibration
from dcrb_ros.messages.topics import FEATURES, MANIFEST, NAMESPACE, SENSOR, VIBRATION, Message
from dcrb_ros.recordings.manifest import FORMAT, UNITS, Outcome, now
from dcrb_ros.recordings.recorder import channel_of
from dcrb_ros.recordings.rosbag2 import Bag, RecordingFailed
from dcrb_ros.runtime.refusal import Refusal
from dcrb_ros.settings.sensor_limits import LONGEST_BLOCK
from dcrb_ros.simulation.block import Block

TURN = 2.0 * np.pi
LATEST = 2**31
"""Time from which on the stamp of a message has no room [s]."""


class Import:
    """A file and its description, checked against each other.

    Raises:
        Refusal: rate, unit, speed, channels or orders are missing or contradict each other.
    """

    def __init__(self, file: Path, about: Path) -> None:
        self._file, self._about = file, about
        self.description: Description = read_description(about)
        foreign = read_foreign(file)
        self.rate = self._rate(foreign)
        self.orders: Orders = self.description.fault_orders(about)
        factor = self._factor(foreign)
        channels = self.description.channels
        ax = self._axis(foreign, channels.ax, factor)
        ay = ax if channels.ay is None else self._axis(foreign, channels.ay, factor)
        self.index = self._index(foreign, len(ax))
        angle = self._angle(foreign, self.index)
        lengths = {"ax": len(ax), "ay": len(ay), "shaft_angle": len(angle), "index": len(self.index)}
        if len(set(lengths.values())) > 1 or not len(ax):
            raise Refusal(f"{file}: the channels must be of one length and not empty: {lengths}")
        self.acceleration = np.column_stack([ax, ay])
        self.angle = angle

    def _rate(self, foreign: Foreign) -> int:
        given = self.description.sampling_rate
        if given is None and foreign.rate is None:
            raise Refusal(f"{self._about} gives no sampling_rate, and {self._file} has none of its own: add it in Hz; it is never guessed")
        if given is not None and foreign.rate is not None and given != foreign.rate:
            raise Refusal(f"{self._about} gives sampling_rate = {given} Hz and {self._file} itself {foreign.rate} Hz: one of them is wrong")
        return int(given or foreign.rate or 0)

    def _factor(self, foreign: Foreign) -> float:
        """Return a number of the file in m/s^2."""
        factor = self.description.factor(self._about)
        if foreign.full_scale is None:
            return factor
        if self.description.full_scale is None:
            unit = self.description.unit
            raise Refusal(f"{self._file} holds whole numbers: {self._about} must give full_scale, what their largest stands for in {unit}")
        return factor * self.description.full_scale / foreign.full_scale

    def _finite(self, foreign: Foreign, name: str | int) -> Array:
        values = channel(foreign, self._file, name)
        bad = int(np.count_nonzero(~np.isfinite(values)))
        if bad:
            raise Refusal(f"{self._file}: {bad} of {len(values)} samples of '{name}' are not finite numbers: cut them out first")
        return values.astype(np.float64)

    def _axis(self, foreign: Foreign, name: str | int, factor: float) -> npt.NDArray[np.float32]:
        """Return the acceleration of a channel [m/s^2]."""
        with np.errstate(over="ignore"):
            values = (self._finite(foreign, name) * factor).astype(np.float32)
        bad = np.flatnonzero(~np.isfinite(values))
        if len(bad):
            raise Refusal(
                f"{self._file}: sample {bad[0]} of '{name}' is {float(channel(foreign, self._file, name)[bad[0]]):g}, more than "
                f"{np.finfo(np.float32).max:.1g} m/s^2, what a message holds: cut it out, or check the unit"
            )
        return values

    def _index(self, foreign: Foreign, count: int) -> npt.NDArray[np.int64]:
        name, first = self.description.channels.index, self.description.first_index
        if name is None:
            self._in_time(first + count - 1, f"{self._about}: first_index = {first}")
            return first + np.arange(count, dtype=np.int64)
        found = self._finite(foreign, name)
        broken = found[found != np.rint(found)]
        if len(broken):
            raise Refusal(
                f"{self._file}: '{name}' is no index: {broken[0]:g} is not a whole number; an index counts samples, gaps included"
            )
        if len(found) and (found[0] < 0 or np.any(np.diff(found) <= 0)):
            raise Refusal(f"{self._file}: '{name}' must be an index that begins at 0 or later and rises")
        self._in_time(float(found[-1]) if len(found) else 0.0, f"{self._file}: '{name}'")
        return found.astype(np.int64)

    def _in_time(self, last: float, source: str) -> None:
        """Refuse an index whose time a message cannot tell."""
        if last >= LATEST * self.rate:
            raise Refusal(f"{source} leads to sample {last:.3g}, beyond {LATEST} s at {self.rate} Hz, where stamps end: begin at 0")

    def _angle(self, foreign: Foreign, index: npt.NDArray[np.int64]) -> npt.NDArray[np.float32]:
        """Return the shaft's angle within [0, 2 pi), as it is in the file or as it follows from the speed."""
        name = self.description.channels.shaft_angle
        turned = (
            self.description.shaft_speed(self._about) * index.astype(np.float64) / self.rate
            if name is None
            else self._finite(foreign, name)
        )
        within = np.mod(turned, TURN).astype(np.float32)
        within[within >= np.float32(TURN)] = 0.0
        return within

    @property
    def block_size(self) -> int:
        """Samples in a block: those asked for, but no more than fit into `LONGEST_BLOCK`."""
        return max(1, min(self.description.block_size, int(LONGEST_BLOCK * self.rate)))

    def blocks(self) -> Iterator[Block]:
        """Yield the waveform; a block ends where samples are missing."""
        size, count = self.block_size, len(self.index)
        breaks = [0, *(np.flatnonzero(np.diff(self.index) != 1) + 1), count]
        for begin, end in itertools.pairwise(breaks):
            for at in range(int(begin), int(end), size):
                part = slice(at, min(at + size, int(end)))
                acceleration = self.acceleration[part]
                yield Block(int(self.index[at]), self.rate, acceleration, self.angle[part], acceleration)

    def sensor(self) -> dict[str, Any]:
        """Return what a listener must know of the waveform."""
        channels, d = self.description.channels, self.description
        return {
            "sampling_rate": self.rate,
            "sampling_rate_unit": "Hz",
            "acceleration_unit": "m/s^2",
            "axes": {"ax": str(channels.ax), "ay": "a copy of ax" if channels.ay is None else str(channels.ay)},
            "shaft_angle_unit": "rad",
            "shaft_angle": "measured" if channels.shaft_angle is not None else "from the stated speed",
            "block_size": self.block_size,
            "frame": FRAME,
            "bearing": d.bearing.model_dump() if d.bearing else None,
            "orders": self.orders.as_dict(),
            "first_sample_index": "round(stamp * sampling_rate); sample k is taken at k / sampling_rate",
        }

    def manifest(self) -> dict[str, Any]:
        """Return what makes the recording explain itself."""
        digest = hashlib.sha256(self._file.read_bytes()).hexdigest()
        return {
            "format": FORMAT,
            "dcrb_ros": __version__,
            "imported": {"file": self._file.name, "sha256": digest, **self.description.model_dump(exclude_none=True)},
            "namespace": NAMESPACE,
            "sampling_rate": self.rate,
            "orders": self.sensor()["orders"],
            "sensor": self.sensor(),
            "units": UNITS,
            "recorded": now(),
        }

    def write(self, path: Path) -> int:
        """Write the recording; return the number of its samples."""
        outcome = Outcome(self.rate)
        about = {MANIFEST: {"manifest": json.dumps(self.manifest(), default=str)}}
        bag = Bag(path, opening=about, closing=outcome.records)
        channels = {topic: channel_of(topic, NAMESPACE) for topic in (SENSOR, VIBRATION, FEATURES)}
        try:
            bag.write([(channels[SENSOR], 0, encode_text(json.dumps(self.sensor(), sort_keys=True)))])
            for block in self.blocks():
                waveform = Message(VIBRATION, block.stamp_ns, encode_vibration(block, block.acceleration))
                outcome.note(waveform)
                features = (channels[FEATURES], block.stamp_ns, encode_features(block))
                bag.write([(channels[VIBRATION], block.stamp_ns, waveform.data), features])
            bag.close()
        except BaseException:
            with suppress(RecordingFailed):
                bag.close()
            shutil.rmtree(bag.path, ignore_errors=True)
            raise
        return outcome.samples
