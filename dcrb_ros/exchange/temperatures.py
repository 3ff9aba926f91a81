"""Readings of temperature sensors in files of other tools: beside the waveform with their own times, or in columns of its length."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from dcrb_ros.bearing.temperature_readings import TemperatureReadings
from dcrb_ros.messages.points import index_at
from dcrb_ros.recordings.arrays import READINGS
from dcrb_ros.schema.arrays import Floats, Integers
from dcrb_ros.schema.refusal import Refusal

CHANNELS: Mapping[str, str] = {f"{sensor}_temperature": sensor for sensor in READINGS}
"""Channels of temperatures [deg C], and the places of the sensors."""
TIME = "temperature_time"
"""Channel with the times of the readings [s]."""
LEAST_INTERVAL_NS = 100_000_000
"""Time from a reading to the next that is kept [ns]: a channel may have one at every sample."""
LATEST_STAMP = 2**31
"""Time from which on a ROS time stamp overflows [s]."""
COLDEST, HOTTEST = -273.15, 2000.0
"""Absolute zero, and a temperature above the melting point of steel [deg C]."""


def own_arrays(readings: TemperatureReadings, stretch: float) -> dict[str, Floats]:
    """Return the readings as arrays of their own length, with their times, multiplied by ``stretch``."""
    if not len(readings):
        return {}
    return {TIME: readings.time * stretch, **{channel: getattr(readings, sensor) for channel, sensor in CHANNELS.items()}}


def columns(readings: TemperatureReadings, index: Integers, rate: int) -> dict[str, Floats]:
    """Return the readings as columns beside the samples ``index``: each at the sample of its time, NaN elsewhere.

    A reading at the time of a missing sample is left out.
    """
    if not len(readings):
        return {}
    wanted = [index_at(round(time * 1e9), rate) for time in readings.time]
    samples, rows, before = np.intersect1d(index, wanted, return_indices=True)
    table = {channel: np.full(len(index), np.nan) for channel in CHANNELS}
    for channel, sensor in CHANNELS.items():
        table[channel][rows] = getattr(readings, sensor)[before]
    return table if len(samples) else {}


def readings_of(
    parts: Sequence[Floats], indices: Sequence[npt.NDArray[np.int64]], times: Floats | None, rate: float, source: str
) -> tuple[Integers, Floats]:
    """Return times [ns] and values [deg C] of a channel of one or more files, without NaN, at most one in `LEAST_INTERVAL_NS`.

    Args:
        parts: the channel in each file, shape (files,) of (readings,).
        indices: the samples of each file, shape (files,) of (samples,). Fewer readings than samples are spread evenly over the file.
        times: times of the readings of all files [s], shape (readings,); None if they follow from the samples.
        rate: sampling rate of the recording [Hz].
        source: name of the channel in error messages.

    Raises:
        Refusal: there are no readings, more than samples or another number than times, a time is negative or beyond the range of time
            stamps, or a reading is below absolute zero or above `HOTTEST`.
    """
    values = np.concatenate(parts)
    if not all(len(part) for part in (parts if times is None else [values])):
        raise Refusal(f"{source} has no readings: give at least one, NaN where unknown, or leave the channel out")
    if times is None:
        time_ns = np.concatenate([_spread(len(part), index, rate, source) for part, index in zip(parts, indices, strict=True)])
    elif len(times) == len(values):
        wrong = times[(times < 0.0) | (times >= LATEST_STAMP)]
        if len(wrong):
            raise Refusal(
                f"{source}: {TIME} has {wrong[0]:g} s, outside 0 .. {LATEST_STAMP} s: give the times in seconds since the first sample"
            )
        time_ns = np.rint(times * 1e9).astype(np.int64)
    else:
        raise Refusal(f"{source} has {len(values)} readings for {len(times)} times in {TIME}: give a time for each reading")
    known = np.isfinite(values)
    time_ns, values = time_ns[known], values[known]
    outside = values[(values < COLDEST) | (values > HOTTEST)]
    if len(outside):
        raise Refusal(
            f"{source} has a temperature of {outside[0]:g} deg C, outside {COLDEST:g} .. {HOTTEST:g} deg C: give degrees Celsius, NaN "
            "where unknown"
        )
    if len(back := np.flatnonzero(np.diff(time_ns) <= 0)):
        first, second = time_ns[back[0] : back[0] + 2] * 1e-9
        raise Refusal(
            f"{source}: the times in {TIME} must increase, but {second:g} s follows {first:g} s: sort the readings; in several files the "
            "times count from sample 0 of the first one"
        )
    kept, last = [], -LEAST_INTERVAL_NS
    for number, reading_ns in enumerate(time_ns.tolist()):
        if reading_ns - last >= LEAST_INTERVAL_NS:
            kept.append(number)
            last = reading_ns
    return time_ns[kept], values[kept]


def _spread(count: int, index: npt.NDArray[np.int64], rate: float, source: str) -> Integers:
    """Return the times [ns] of readings that are spread evenly over the samples of a file."""
    if count > len(index):
        raise Refusal(f"{source} has {count} readings for {len(index)} samples: give at most one per sample, or their times in {TIME}")
    positions = index if count == len(index) else index[0] + np.arange(count) * ((index[-1] - index[0] + 1) / count)
    return np.floor(np.asarray(positions, np.float64) * 1e9 / rate + 1e-3).astype(np.int64)


def checked_channels(given: Mapping[str, object], deviation: float, source: Path) -> list[str]:
    """Return the channels of temperatures that a description gives.

    Raises:
        Refusal: it gives the times of readings or a standard ``deviation`` of them [K], but no readings.
    """
    channels = [channel for channel in CHANNELS if given.get(channel) is not None]
    useless = TIME if given.get(TIME) is not None else "temperature_deviation" if deviation else ""
    if useless and not channels:
        raise Refusal(f"{source} gives {useless}, but no temperature: name a channel of {', '.join(CHANNELS)}, or leave it out")
    return channels
