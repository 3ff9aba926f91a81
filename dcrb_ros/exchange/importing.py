"""Import of an external waveform into a recording with the topics of the bench, which all other commands can read."""

from __future__ import annotations

import dataclasses
import hashlib
import itertools
import json
import math
from collections import deque
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.exchange.description import COPY, LOWEST_RATE, RELATIVE, Description, read_description
from dcrb_ros.exchange.joining import JoinedFiles
from dcrb_ros.exchange.pieces import Show, pieces, unseen
from dcrb_ros.exchange.pulse_train import PulseTrain, counted_pulses, joined_turns, pulse_train, turns_at_speed, wrapped, wrapped_angle
from dcrb_ros.exchange.temperatures import CHANNELS, LATEST_STAMP, checked_channels, readings_of
from dcrb_ros.exchange.text_table import Array
from dcrb_ros.messages.cdr import FRAME
from dcrb_ros.messages.description import PULSES_PER_TURN
from dcrb_ros.messages.joints import encode_features
from dcrb_ros.messages.plain import encode_temperature, encode_text
from dcrb_ros.messages.points import encode_vibration
from dcrb_ros.messages.pulses import encode_pulses
from dcrb_ros.messages.topics import FEATURES, MANIFEST, NAMESPACE, SENSOR, TACHO, VIBRATION, Message, Topic
from dcrb_ros.messages.topics.sensor import repeats_with
from dcrb_ros.recordings.arrays import READINGS
from dcrb_ros.recordings.manifest import FORMAT, MEASURED_UNITS, Outcome, now, record_text
from dcrb_ros.recordings.recorder import channel_of
from dcrb_ros.recordings.splitting import Bag
from dcrb_ros.runtime.version import __version__
from dcrb_ros.schema.arrays import Floats, Samples
from dcrb_ros.schema.numbers import HIGHEST_RATE
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.schema.simulated_time import nanoseconds
from dcrb_ros.settings.sensor_limits import LONGEST_BLOCK
from dcrb_ros.stream.block import Block
from dcrb_ros.text.files import open_regular

MOST_ROUNDED = 1e-4
"""Largest relative change of a sampling rate by rounding [-]: the clocks of data acquisition are as accurate, and lines are as wide."""


class WaveformImport:
    """A waveform read from one or more files and their description, checked for consistency.

    Raises:
        Refusal: rate, unit, speed, channels or orders are missing or contradict each other.
    """

    def __init__(self, files: Path | Sequence[Path], about: Path, settings: Sequence[str] = ()) -> None:
        """Read ``files`` as the YAML file ``about`` describes them, changed by ``settings``; see `read_description`."""
        self._about = about
        self.description: Description = read_description(about, settings)
        self.shaft_source = self.description.shaft_source(about)
        """Origin of the angle of the shaft, as in `Description.shaft_source`."""
        self._files = JoinedFiles([files] if isinstance(files, Path) else files)
        self.measured_rate = self._rate(self._files.rate)
        """Sampling rate as it is given [Hz]."""
        self.rate = self._whole_rate()
        """Sampling rate of the recording, an integer [Hz]."""
        self._check_speed()
        self.orders: Orders = self.description.fault_orders(about)
        channels, factor = self.description.channels, self._factor()
        parts = {name: self._files.parts(channel) for name, channel in channels.axes.items()}
        self._lengths = [len(part) for part in parts["ax"]]
        self.index = self._index()
        self._check_lengths({**{name: sum(map(len, numbers)) for name, numbers in parts.items()}, "index": len(self.index)})
        self.acceleration: Samples = np.empty((len(self.index), max(2, len(parts))), np.float32)
        for axis, name in enumerate(parts):
            self._fill_axis(axis, channels.axes[name], parts[name], factor)
        if len(parts) == 1:
            self.acceleration[:, 1] = self.acceleration[:, 0]
        parts.clear()
        self._train = self._tacho()
        self.angle = self._angle()
        self.readings = self._readings()
        """Times [ns] and values [deg C] of the readings of temperature by channel."""
        self._check_lengths({"ax": len(self.index), "shaft_angle": len(self.angle)})

    def _check_lengths(self, lengths: dict[str, int]) -> None:
        if len(set(lengths.values())) > 1 or not lengths["ax"]:
            raise Refusal(f"{self._files}: the channels must have the same length and not be empty: {lengths}")

    def _rate(self, stated: float | None) -> float:
        given = self.description.sampling_rate
        if given is None and stated is None:
            raise Refusal(f"{self._about} has no sampling_rate, and {self._files} contains none: add it in Hz; it is never guessed")
        if given is not None and stated is not None and given != stated:
            raise Refusal(f"{self._about} gives sampling_rate = {given:g} Hz, but {self._files} contains {stated:g} Hz: correct the former")
        rate = float(given or stated or 0.0)
        if not LOWEST_RATE <= rate <= HIGHEST_RATE:
            raise Refusal(f"{self._files} states a sampling rate of {rate:g} Hz, outside {LOWEST_RATE} .. {HIGHEST_RATE} Hz: correct it")
        channels = self.description.channels
        others = [name for name in channels.model_dump(exclude={"temperature_time"}).values() if name is not None]
        if contradiction := self._files.contradiction(rate, channels.ax, others):
            raise Refusal(
                f"{self._about} gives sampling_rate = {rate:g} Hz, but {contradiction}: correct one of them, or rename what is no time"
            )
        return rate

    def _check_speed(self) -> None:
        """Refuse a stated speed of half a turn or more per sample, whose direction and size an angle cannot represent."""
        if abs(self.description.shaft_speed) / self.measured_rate >= math.pi:
            given = f"{self.shaft_source} = {getattr(self.description, self.shaft_source):g}"
            raise Refusal(f"{self._about}: {given} is half a turn or more per sample at {self.measured_rate:g} Hz: correct one of them")

    def _whole_rate(self) -> int:
        """Return the integer next to the sampling rate, on which the index and the stamps of a recording are based [Hz]."""
        if abs(round(self.measured_rate) / self.measured_rate - 1.0) > MOST_ROUNDED:
            raise Refusal(
                f"{self._about}: sampling_rate = {self.measured_rate:g} Hz is refused: a recording has an integer rate, and rounding would "
                f"change this one by more than {MOST_ROUNDED:g} of it; resample the signal"
            )
        return round(self.measured_rate)

    def _factor(self) -> float:
        """Return the factor from a number in the file to m/s^2."""
        factor = self.description.factor(self._about)
        if self._files.full_scale is None:
            if self.description.full_scale is not None:
                raise Refusal(f"{self._about} gives full_scale, but {self._files} has no integer samples of a WAV file: leave it out")
            return factor
        if self.description.full_scale is None:
            unit = self.description.unit
            raise Refusal(f"{self._files} has integer samples: add full_scale to {self._about}, the value at full scale in {unit}")
        return factor * self.description.full_scale / self._files.full_scale

    def _fill_axis(self, axis: int, name: str | int, parts: Sequence[Array], factor: float) -> None:
        """Write the channel ``name`` of each file to an axis of the acceleration [m/s^2]."""
        begin = 0
        for part in parts:
            for piece in pieces(len(part)):
                numbers = part[piece].astype(np.float64)
                with np.errstate(over="ignore"):
                    values = (numbers * factor).astype(np.float32)
                bad = np.flatnonzero(~np.isfinite(values))
                if len(bad):
                    raise Refusal(
                        f"{self._files}: sample {begin + bad[0]} of '{name}' is {float(numbers[bad[0]]):g}, above "
                        f"{np.finfo(np.float32).max:.1g} m/s^2, the range of a message: remove it, or check the unit"
                    )
                self.acceleration[begin : begin + len(values), axis] = values
                begin += len(values)

    def _consecutive_index(self) -> npt.NDArray[np.int64]:
        """Return the index of each sample of files with the described gap between them, shape (samples,)."""
        first, gap, lengths = self.description.first_index, self.description.gap, self._lengths
        # A long gap must not overflow the index before it is checked.
        last = first + sum(lengths) + (gap or 0.0) * self.rate * (len(lengths) - 1) - 1
        self._check_stamp(last, f"{self._about}: first_index = {first}" + (f" and gap = {gap:g} s" if gap else ""))
        if gap is None and len(lengths) > 1:
            raise Refusal(f"{self._about} has no gap between {len(lengths)} files: add gap [s], 0 if each continues the one before it")
        if gap is not None and len(lengths) == 1:
            raise Refusal(f"{self._about} gives gap = {gap:g} s, but there is one file: give the others, too, or leave it out")
        between = round((gap or 0.0) * self.measured_rate)
        begins = first + np.concatenate([[0], np.cumsum(np.asarray(lengths[:-1], np.int64) + between)]).astype(np.int64)
        return np.concatenate([begin + np.arange(length, dtype=np.int64) for begin, length in zip(begins, lengths, strict=True)])

    def _index(self) -> npt.NDArray[np.int64]:
        d = self.description
        name, first = d.channels.index, d.first_index
        if name is None:
            return self._consecutive_index()
        if d.gap is not None:
            raise Refusal(f"{self._about} gives gap and the channel index, which contains the gaps: leave out gap")
        index = np.concatenate(self._files.numbers(name))
        broken = index[index != np.rint(index)]
        if len(broken):
            raise Refusal(
                f"{self._files}: '{name}' is not an index: {broken[0]:g} is not an integer; an index counts samples, gaps included"
            )
        if len(index) and (index[0] < 0 or np.any(np.diff(index) <= 0)):
            raise Refusal(f"{self._files}: '{name}' is not an index: it must start at 0 or later and increase")
        if first and len(index) and index[0] != first:
            raise Refusal(f"{self._about} gives first_index = {first}, but '{name}' begins with {index[0]:g}: leave out first_index")
        self._check_stamp(float(index[-1]) if len(index) else 0.0, f"{self._files}: '{name}'")
        return index.astype(np.int64)

    def _check_stamp(self, last: float, source: str) -> None:
        """Refuse an index whose time exceeds the range of a time stamp."""
        if last >= LATEST_STAMP * self.rate:
            raise Refusal(
                f"{source} gives sample {last:.3g}, after {LATEST_STAMP} s at {self.rate} Hz, the range of time stamps: start at 0, "
                "with shorter gaps"
            )

    def _angle(self) -> npt.NDArray[np.float32]:
        """Return the angle of the shaft within [0, 2 pi), NaN where it is unknown, shape (samples,) [rad]."""
        d, source = self.description, self.shaft_source
        if source == "rpm" and d.channels.rpm is not None:
            return wrapped(self._turns_at_speed(d.channels.rpm))
        if source == "shaft_angle" and d.channels.shaft_angle is not None:
            return wrapped_angle(np.concatenate(self._files.numbers(d.channels.shaft_angle, nan=True)))
        angle, train = np.empty(len(self.index), np.float32), self._train if source == "tacho" else None
        for piece in pieces(len(self.index)):
            index = self.index[piece]
            angle[piece] = (
                wrapped(train.at(index)) if train else wrapped_angle(d.shaft_speed * index.astype(np.float64) / self.measured_rate)
            )
        return angle

    def _tacho(self) -> PulseTrain | None:
        """Return the turns at the pulses of the tacho; None without one."""
        d = self.description
        if d.channels.tacho is None:
            return None
        pulses = np.concatenate(self._files.numbers(d.channels.tacho))
        self._check_lengths({"ax": len(self.index), "tacho": len(pulses)})
        if self.shaft_source != "tacho":
            return counted_pulses(pulses, self.index, self.pulses_per_turn, d.tacho_levels)
        return pulse_train(pulses, self.index, self.pulses_per_turn, d.tacho_levels, f"{self._files}: '{d.channels.tacho}'")

    @property
    def pulses_per_turn(self) -> int:
        """Pulses of the tacho per turn of the shaft; 0 without one."""
        return 0 if self.description.channels.tacho is None else self.description.pulses_per_turn or 1

    @property
    def irregular_pulses(self) -> int:
        """Intervals of the tacho in which pulses were missing or too many [-]."""
        return 0 if self._train is None else self._train.irregular

    def _readings(self) -> dict[str, tuple[npt.NDArray[np.int64], Floats]]:
        channels = self.description.channels
        given = checked_channels(channels.model_dump(), self.description.temperature_deviation, self._about)
        times = None if channels.temperature_time is None else np.concatenate(self._files.numbers(channels.temperature_time))
        # All stamps of a recording count at its integer rate.
        times = None if times is None else times * (self.measured_rate / self.rate)
        indices = self._by_file() if given else []
        return {
            channel: readings_of(
                self._files.numbers(getattr(channels, channel), nan=True), indices, times, self.rate, f"{self._files}: '{channel}'"
            )
            for channel in given
        }

    def _by_file(self) -> list[npt.NDArray[np.int64]]:
        """Return the index of the samples of each file."""
        return np.split(self.index, np.cumsum(self._lengths)[:-1])

    def _turns_at_speed(self, name: str | int) -> Floats:
        """Return the turns of the shaft, file by file, whose channels of speed may have other lengths than the waveform [-]."""
        parts = self._files.numbers(name, nan=True)
        indices = self._by_file()
        turns = [
            turns_at_speed(part, index, self.measured_rate, f"{file}: '{name}'")
            for part, index, file in zip(parts, indices, self._files.files, strict=True)
        ]
        return joined_turns(turns, indices)

    @property
    def block_size(self) -> int:
        """Samples in a block [-]: as given by the description, limited by `LONGEST_BLOCK`."""
        return max(1, min(self.description.block_size, int(LONGEST_BLOCK * self.rate)))

    def blocks(self) -> Iterator[Block]:
        """Yield the waveform in blocks, with the pulses of a tacho; a block ends at every gap."""
        return self._blocks() if self._train is None else self._with_pulses(self._blocks(), self._train)

    def _blocks(self) -> Iterator[Block]:
        size, count = self.block_size, len(self.index)
        breaks = [0, *(np.flatnonzero(np.diff(self.index) != 1) + 1), count]
        for begin, end in itertools.pairwise(breaks):
            for first in range(int(begin), int(end), size):
                part = slice(first, min(first + size, int(end)))
                acceleration = self.acceleration[part]
                yield Block(int(self.index[first]), self.rate, acceleration, self.angle[part], acceleration)

    def _with_pulses(self, blocks: Iterator[Block], train: PulseTrain) -> Iterator[Block]:
        """Yield blocks with the pulses of their time."""
        time_ns = np.rint(train.edges * (1e9 / self.rate)).astype(np.int64)
        for block in blocks:
            first, last = np.searchsorted(time_ns, [block.stamp_ns, block.end_ns]).tolist()
            number = np.rint(train.turns[first:last] * self.pulses_per_turn).astype(np.int64)
            yield dataclasses.replace(block, pulse_ns=time_ns[first:last], pulse_number=number)

    def _temperatures(self) -> list[Message]:
        """Return the messages with the readings of temperature in the order of time."""
        deviation = self.description.temperature_deviation
        messages = [
            Message(READINGS[CHANNELS[channel]], time_ns, encode_temperature(time_ns, value, deviation))
            for channel, (times, values) in self.readings.items()
            for time_ns, value in zip(times.tolist(), values.tolist(), strict=True)
        ]
        return sorted(messages, key=lambda message: message.time_ns)

    def sensor(self) -> dict[str, Any]:
        """Return the description of the sensor that is published with the waveform."""
        channels, d = self.description.channels, self.description
        return {
            "sampling_rate": self.rate,
            "sampling_rate_unit": "Hz",
            **({} if self.measured_rate == self.rate else {"measured_sampling_rate": self.measured_rate}),
            "acceleration_unit": self._unit,
            "axes": {"ay": COPY, **{name: str(channel) for name, channel in channels.axes.items()}},
            "shaft_angle_unit": "rad",
            "shaft_angle": self._angle_words(),
            **({PULSES_PER_TURN: self.pulses_per_turn} if self.pulses_per_turn else {}),
            "block_size": self.block_size,
            "frame": FRAME,
            "bearing": d.bearing.model_dump(exclude_none=True) if d.bearing else None,
            "orders": self.orders.as_dict(),
            "first_sample_index": "round(stamp * sampling_rate); sample k is taken at k / sampling_rate",
        }

    @property
    def _unit(self) -> str:
        return RELATIVE if self.description.unit == RELATIVE else "m/s^2"

    def _angle_words(self) -> str:
        """Return how the angle of the shaft was found."""
        if not np.isfinite(self.angle).any():
            return "unknown"
        if self.shaft_source == "tacho":
            irregular = f", irregular in {self.irregular_pulses} intervals" if self.irregular_pulses else ""
            return f"from pulses of a tacho, {self.description.pulses_per_turn or 1} per turn{irregular}"
        return {"shaft_angle": "measured", "rpm": "from the measured speed"}.get(self.shaft_source, "from the stated speed")

    def jump_in_time(self) -> str:
        """Return a sentence on a jump of the time of the samples, or the empty string; a channel ``index`` contains the gaps."""
        channels = self.description.channels
        return self._files.jump(channels.ax) if channels.index is None else ""

    def remarks(self) -> list[str]:
        """Return sentences about the differences between the recording and the measurement."""
        notes = []
        if self.measured_rate != self.rate:
            notes.append(
                f"the sampling rate of {self.measured_rate:.12g} Hz is recorded as {self.rate} Hz, since stamps count whole samples"
            )
        gaps = int(np.count_nonzero(np.diff(self.index) != 1))
        if gaps:
            notes.append(f"the waveform has {gaps} gap{'s' * (gaps > 1)}")
        if self.irregular_pulses:
            notes.append(
                f"pulses of the tacho are missing or too many in {self.irregular_pulses} intervals, which were counted as whole pulses"
            )
        if self._unit == RELATIVE:
            notes.append("the unit is unknown: what is given in m/s^2 is relative")
        return notes

    def sha256(self) -> str:
        """Return the SHA-256 of the files, one after the other, as hexadecimal digits."""
        digest = hashlib.sha256()
        for file in self._files.files:
            with open_regular(file) as stream:
                for part in iter(lambda stream=stream: stream.read(1 << 20), b""):  # type: ignore[misc]
                    digest.update(part)
        return digest.hexdigest()

    def manifest(self) -> dict[str, Any]:
        """Return the manifest of the recording: its origin, orders, sensor and units."""
        names = [file.name for file in self._files.files]
        origin = {"file": names[0]} if len(names) == 1 else {"files": names}
        return {
            "format": FORMAT,
            "dcrb_ros": __version__,
            "imported": {**origin, "sha256": self.sha256(), **self.description.model_dump(exclude_none=True)},
            "namespace": NAMESPACE,
            "sampling_rate": self.rate,
            "orders": self.sensor()["orders"],
            "sensor": self.sensor(),
            "units": MEASURED_UNITS | {"acceleration": self._unit},
            "recorded": now(),
        }

    def write(self, path: Path, show: Show = unseen) -> int:
        """Write the recording to a new folder; return its number of samples. Nothing is left behind if it fails."""
        outcome = Outcome(self.rate)
        about = {MANIFEST: {"manifest": record_text(self.manifest())}}
        bag = Bag(path, opening=about, closing=outcome.records)
        topics: list[Topic] = [SENSOR, VIBRATION, FEATURES, TACHO, *READINGS.values()]
        channels = {topic: channel_of(topic, NAMESPACE) for topic in topics}
        with bag.removed_on_failure():
            description, read = encode_text(json.dumps(self.sensor(), sort_keys=True)), deque(self._temperatures())
            start_ns = min([nanoseconds(int(self.index[0]), self.rate), *(message.time_ns for message in list(read)[:1])])
            bag.write([(channels[SENSOR], start_ns, description)])
            for block in self.blocks():
                messages = [Message(SENSOR, block.stamp_ns, description)] if repeats_with(block) else []
                messages.append(Message(VIBRATION, block.stamp_ns, encode_vibration(block, block.acceleration)))
                outcome.add(messages[-1])
                messages += [Message(TACHO, block.stamp_ns, encode_pulses(block))] if self._train is not None else []
                messages.append(Message(FEATURES, block.stamp_ns, encode_features(block)))
                while read and read[0].time_ns < block.end_ns:
                    messages.append(read.popleft())
                messages.sort(key=lambda message: message.time_ns)
                bag.write([(channels[message.topic], message.time_ns, message.data) for message in messages])
                show(f"writing {path.name}", outcome.samples, len(self.index))
            bag.write([(channels[message.topic], message.time_ns, message.data) for message in read])
        return outcome.samples
