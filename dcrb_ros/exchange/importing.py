"""Import of an external waveform into a recording with the topics of the bench, which all other commands can read."""

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

from dcrb_ros.bearing.kinematics import Orders
from dcrb_ros.exchange.description import Description, read_description
from dcrb_ros.exchange.files import Array, ExternalFile, channel, read_external
from dcrb_ros.messages.cdr import FRAME
from dcrb_ros.messages.joints import encode_features
from dcrb_ros.messages.plain import encode_text
from dcrb_ros.messages.points import encode_vibration
from dcrb_ros.messages.topics import FEATURES, MANIFEST, NAMESPACE, SENSOR, VIBRATION, Message
from dcrb_ros.messages.topics.sensor import repeats_with
from dcrb_ros.recordings.manifest import FORMAT, MEASURED_UNITS, Outcome, now
from dcrb_ros.recordings.recorder import channel_of
from dcrb_ros.recordings.rosbag2 import Bag, RecordingFailed
from dcrb_ros.runtime.version import __version__
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.sensor_limits import LONGEST_BLOCK
from dcrb_ros.stream.block import Block
from dcrb_ros.text.files import open_regular

FULL_TURN = 2.0 * np.pi
LATEST_STAMP = 2**31
"""Time from which on a ROS time stamp overflows [s]."""


class WaveformImport:
    """A waveform read from a file and its description, with both checked for consistency.

    Raises:
        Refusal: rate, unit, speed, channels or orders are missing or contradict each other.
    """

    def __init__(self, file: Path, about: Path) -> None:
        self._file, self._about = file, about
        self.description: Description = read_description(about)
        external = read_external(file)
        self.rate = self._rate(external)
        self.orders: Orders = self.description.fault_orders(about)
        factor = self._factor(external)
        channels = self.description.channels
        ax = self._axis(external, channels.ax, factor)
        ay = ax if channels.ay is None else self._axis(external, channels.ay, factor)
        self.index = self._index(external, len(ax))
        angle = self._angle(external, self.index)
        lengths = {"ax": len(ax), "ay": len(ay), "shaft_angle": len(angle), "index": len(self.index)}
        if len(set(lengths.values())) > 1 or not len(ax):
            raise Refusal(f"{file}: the channels must have the same length and not be empty: {lengths}")
        self.acceleration = np.column_stack([ax, ay])
        self.angle = angle

    def _rate(self, external: ExternalFile) -> int:
        given = self.description.sampling_rate
        if given is None and external.rate is None:
            raise Refusal(f"{self._about} has no sampling_rate, and {self._file} contains none: add it in Hz; it is never guessed")
        if given is not None and external.rate is not None and given != external.rate:
            raise Refusal(
                f"{self._about} gives sampling_rate = {given} Hz, but {self._file} contains {external.rate} Hz: correct the former"
            )
        return int(given or external.rate or 0)

    def _factor(self, external: ExternalFile) -> float:
        """Return the factor from a number in the file to m/s^2."""
        factor = self.description.factor(self._about)
        if external.full_scale is None:
            return factor
        if self.description.full_scale is None:
            unit = self.description.unit
            raise Refusal(f"{self._file} has integer samples: add full_scale to {self._about}, the acceleration at full scale in {unit}")
        return factor * self.description.full_scale / external.full_scale

    def _finite(self, external: ExternalFile, name: str | int) -> Array:
        values = channel(external, self._file, name)
        bad = int(np.count_nonzero(~np.isfinite(values)))
        if bad:
            raise Refusal(f"{self._file}: {bad} of {len(values)} samples of '{name}' are not finite numbers: remove them first")
        return values.astype(np.float64)

    def _axis(self, external: ExternalFile, name: str | int, factor: float) -> npt.NDArray[np.float32]:
        """Return the acceleration of a channel, shape (samples,) [m/s^2]."""
        with np.errstate(over="ignore"):
            values = (self._finite(external, name) * factor).astype(np.float32)
        bad = np.flatnonzero(~np.isfinite(values))
        if len(bad):
            raise Refusal(
                f"{self._file}: sample {bad[0]} of '{name}' is {float(channel(external, self._file, name)[bad[0]]):g}, above "
                f"{np.finfo(np.float32).max:.1g} m/s^2, the range of a message: remove it, or check the unit"
            )
        return values

    def _index(self, external: ExternalFile, count: int) -> npt.NDArray[np.int64]:
        name, first = self.description.channels.index, self.description.first_index
        if name is None:
            self._check_stamp(first + count - 1, f"{self._about}: first_index = {first}")
            return first + np.arange(count, dtype=np.int64)
        found = self._finite(external, name)
        broken = found[found != np.rint(found)]
        if len(broken):
            raise Refusal(
                f"{self._file}: '{name}' is not an index: {broken[0]:g} is not an integer; an index counts samples, gaps included"
            )
        if len(found) and (found[0] < 0 or np.any(np.diff(found) <= 0)):
            raise Refusal(f"{self._file}: '{name}' is not an index: it must start at 0 or later and increase")
        self._check_stamp(float(found[-1]) if len(found) else 0.0, f"{self._file}: '{name}'")
        return found.astype(np.int64)

    def _check_stamp(self, last: float, source: str) -> None:
        """Refuse an index whose time exceeds the range of a time stamp."""
        if last >= LATEST_STAMP * self.rate:
            raise Refusal(
                f"{source} gives sample {last:.3g}, after {LATEST_STAMP} s at {self.rate} Hz, the range of time stamps: start at 0"
            )

    def _angle(self, external: ExternalFile, index: npt.NDArray[np.int64]) -> npt.NDArray[np.float32]:
        """Return the shaft angle from the file or from the speed, within [0, 2 pi), NaN if neither is given, shape (samples,) [rad]."""
        name = self.description.channels.shaft_angle
        turned = (
            self.description.shaft_speed(self._about) * index.astype(np.float64) / self.rate
            if name is None
            else self._finite(external, name)
        )
        within = np.mod(turned, FULL_TURN).astype(np.float32)
        within[within >= np.float32(FULL_TURN)] = 0.0
        return within

    @property
    def block_size(self) -> int:
        """Samples in a block [-]: as given by the description, limited by `LONGEST_BLOCK`."""
        return max(1, min(self.description.block_size, int(LONGEST_BLOCK * self.rate)))

    def blocks(self) -> Iterator[Block]:
        """Yield the waveform in blocks; a block ends at every gap."""
        size, count = self.block_size, len(self.index)
        breaks = [0, *(np.flatnonzero(np.diff(self.index) != 1) + 1), count]
        for begin, end in itertools.pairwise(breaks):
            for at in range(int(begin), int(end), size):
                part = slice(at, min(at + size, int(end)))
                acceleration = self.acceleration[part]
                yield Block(int(self.index[at]), self.rate, acceleration, self.angle[part], acceleration)

    def sensor(self) -> dict[str, Any]:
        """Return the description of the sensor that is published with the waveform."""
        channels, d = self.description.channels, self.description
        return {
            "sampling_rate": self.rate,
            "sampling_rate_unit": "Hz",
            "acceleration_unit": "m/s^2",
            "axes": {"ax": str(channels.ax), "ay": "a copy of ax" if channels.ay is None else str(channels.ay)},
            "shaft_angle_unit": "rad",
            "shaft_angle": "measured" if channels.shaft_angle is not None else "unknown" if d.speedless else "from the stated speed",
            "block_size": self.block_size,
            "frame": FRAME,
            "bearing": d.bearing.model_dump() if d.bearing else None,
            "orders": self.orders.as_dict(),
            "first_sample_index": "round(stamp * sampling_rate); sample k is taken at k / sampling_rate",
        }

    def manifest(self) -> dict[str, Any]:
        """Return the manifest of the recording: its origin, orders, sensor and units."""
        digest = hashlib.sha256()
        with open_regular(self._file) as stream:
            for part in iter(lambda: stream.read(1 << 20), b""):
                digest.update(part)
        return {
            "format": FORMAT,
            "dcrb_ros": __version__,
            "imported": {"file": self._file.name, "sha256": digest.hexdigest(), **self.description.model_dump(exclude_none=True)},
            "namespace": NAMESPACE,
            "sampling_rate": self.rate,
            "orders": self.sensor()["orders"],
            "sensor": self.sensor(),
            "units": MEASURED_UNITS,
            "recorded": now(),
        }

    def write(self, path: Path) -> int:
        """Write the recording to a new folder; return its number of samples. Nothing is left behind if it fails."""
        outcome = Outcome(self.rate)
        about = {MANIFEST: {"manifest": json.dumps(self.manifest(), default=str)}}
        bag = Bag(path, opening=about, closing=outcome.records)
        channels = {topic: channel_of(topic, NAMESPACE) for topic in (SENSOR, VIBRATION, FEATURES)}
        try:
            description = encode_text(json.dumps(self.sensor(), sort_keys=True))
            bag.write([(channels[SENSOR], 0, description)])
            for block in self.blocks():
                if repeats_with(block):
                    bag.write([(channels[SENSOR], block.stamp_ns, description)])
                waveform = Message(VIBRATION, block.stamp_ns, encode_vibration(block, block.acceleration))
                outcome.add(waveform)
                features = (channels[FEATURES], block.stamp_ns, encode_features(block))
                bag.write([(channels[VIBRATION], block.stamp_ns, waveform.data), features])
            bag.close()
        except BaseException:
            with suppress(RecordingFailed):
                bag.close()
            shutil.rmtree(bag.path, ignore_errors=True)
            raise
        return outcome.samples
