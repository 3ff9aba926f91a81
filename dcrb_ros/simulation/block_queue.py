"""What has been simulated but is not part of a block yet, and how blocks are cut from it."""

from __future__ import annotations

import dataclasses
import math
from collections import deque
from collections.abc import Callable
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from dcrb_ros.measurement.decimation import Cascade
from dcrb_ros.measurement.sensor import Measurement
from dcrb_ros.schema.arrays import Floats, Integers
from dcrb_ros.schema.simulated_time import nanoseconds
from dcrb_ros.stream.block import Block, Truth
from dcrb_ros.stream.states import States, TemperatureReading

Item = TypeVar("Item")


class BlockQueue:
    """Keeps what the model appends as it advances, and cuts it into consecutive blocks."""

    def __init__(self, rate: int, preview_rate: int, *, preview: bool) -> None:
        """Begin with sample 0 at the sampling ``rate`` [Hz]; without ``preview`` the blocks have no preview."""
        self.samples = 0
        """Samples in the blocks so far."""
        self._rate, self._preview_rate = rate, preview_rate
        self._preview = Cascade(rate // preview_rate) if preview else None
        self.measured: deque[Measurement] = deque()
        """Samples; like the following, in the order of time."""
        self.states: deque[States] = deque()
        """States of the bodies."""
        self.truths: deque[Truth] = deque()
        """Ground truth."""
        self.temperatures: deque[TemperatureReading] = deque()
        """Readings of the temperature sensors."""
        self._pulses = np.zeros(0, np.int64)
        self._first_pulse = 0
        self._previews: deque[tuple[int, npt.NDArray[np.float64]]] = deque()
        self._preview_count = 0

    def add_pulses(self, time_ns: Integers) -> None:
        """Append pulses of the tacho at some times [ns]."""
        self._pulses = np.concatenate([self._pulses, time_ns])

    def cut(self, size: int, *, lost: bool, sensor_range: float) -> Block:
        """Remove the next ``size`` samples and everything of their time, and return them without energy.

        ``lost`` says that the waveform is not published, ``sensor_range`` [m/s^2] is the sensor's range at the end of the block.
        """
        measured = self._take(size)
        first, self.samples = self.samples, self.samples + size
        end_ns = nanoseconds(self.samples, self._rate)
        self._feed_preview(measured.clean)
        previews = _before(self._previews, end_ns, lambda item: item[0])
        first_pulse, pulses = self._take_pulses(end_ns)
        return Block(
            index=first,
            rate=self._rate,
            acceleration=measured.measured.astype(np.float32),
            shaft_angle=wrapped(measured.angle),
            clean=measured.clean.astype(np.float32),
            clipped=int(measured.clipped.sum()),
            range=sensor_range,
            lost=lost,
            preview=np.array([sample for _, sample in previews], np.float32).reshape(-1, 2),
            preview_ns=tuple(time for time, _ in previews),
            states=tuple(_before(self.states, end_ns, lambda states: states.time_ns)),
            truths=tuple(_before(self.truths, end_ns, lambda truth: truth.time_ns)),
            temperatures=tuple(_before(self.temperatures, end_ns, lambda reading: reading.time_ns)),
            pulse_ns=pulses,
            pulse_number=first_pulse + np.arange(len(pulses), dtype=np.int64),
        )

    def _take_pulses(self, end_ns: int) -> tuple[int, Integers]:
        """Remove the pulses before ``end_ns`` [ns]; return the number of the first of them since the start, and their times."""
        count, first = int(np.searchsorted(self._pulses, end_ns)), self._first_pulse
        taken, self._pulses = self._pulses[:count], self._pulses[count:]
        self._first_pulse += count
        return first, taken

    def _take(self, size: int) -> Measurement:
        """Remove the next ``size`` samples and return them."""
        joined = [np.concatenate([getattr(part, field.name) for part in self.measured]) for field in dataclasses.fields(Measurement)]
        self.measured = deque([Measurement(*(samples[size:] for samples in joined))])
        return Measurement(*(samples[:size] for samples in joined))

    def _feed_preview(self, clean: npt.NDArray[np.float64]) -> None:
        if self._preview is None:
            return
        for sample in self._preview.process(clean):
            self._previews.append((nanoseconds(self._preview_count, self._preview_rate), sample))
            self._preview_count += 1


def wrapped(angle: Floats) -> npt.NDArray[np.float32]:
    """Return angles wrapped to [0, 2 pi) in single precision, where an angle below 2 pi may be rounded up to it."""
    turned = np.mod(angle, 2.0 * math.pi).astype(np.float32)
    turned[turned >= np.float32(2.0 * math.pi)] = 0.0
    return turned


def _before(items: deque[Item], end_ns: int, time_of: Callable[[Item], int]) -> list[Item]:
    """Remove the items with a time before ``end_ns`` [ns] from the queue and return them."""
    taken = []
    while items and time_of(items[0]) < end_ns:
        taken.append(items.popleft())
    return taken
