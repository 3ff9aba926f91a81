"""What cannot be measured as asked for: filters beyond the step rate, modes that are no modes, bursts without a period."""

from __future__ import annotations

from collections.abc import Iterator

from dcrb_ros.settings.parameters import Publishing
from dcrb_ros.settings.sensor import Background, SensorParameters, Structure, numbers

LONGEST_BLOCK = 4.29
"""Longest block [s]: messages give the time of a sample after the stamp of its block in nanoseconds of 32 bits."""
HIGHEST_SHARE = 0.45
"""Highest frequency of a filter at the step rate, as a share of it [-]."""
LOWEST_MOUNT, LOWEST_BANDWIDTH = 100.0, 10.0
"""Lowest resonance of a mount and bandwidth of a sensor that are taken for one [Hz]."""
NARROWEST_BAND = 1.2
"""Smallest ratio of the edges of the track noise [-]."""
MODE_RANGE = (50.0, 20000.0)
"""Natural frequencies of given modes [Hz]."""
DAMPING_RANGE = (0.001, 0.5)
"""Damping ratios of given modes [-]."""
MOST_MODES = 24


def filters_beyond(sensor: SensorParameters, background: Background, step_rate: int) -> Iterator[str]:
    """Yield a sentence for every filter that cannot run at the step rate [Hz]."""
    highest = HIGHEST_SHARE * step_rate
    filters = {
        "sensor.mount_frequency": sensor.mount_frequency,
        "sensor.bandwidth": sensor.bandwidth,
        "background.track_high": background.track_high,
    }
    for key, frequency in filters.items():
        if frequency > highest:
            yield f"{key} = {frequency:g} Hz is above {highest:g} Hz, {HIGHEST_SHARE:g} of the step rate: give less or a shorter step"
    if 0.0 < sensor.mount_frequency < LOWEST_MOUNT:
        yield (
            f"sensor.mount_frequency = {sensor.mount_frequency:g} Hz is below {LOWEST_MOUNT:g} Hz: "
            "give 0.0 for a rigid mount or more, it is in Hz"
        )
    if 0.0 < sensor.bandwidth < LOWEST_BANDWIDTH:
        yield f"sensor.bandwidth = {sensor.bandwidth:g} Hz is below {LOWEST_BANDWIDTH:g} Hz: give 0.0 for no low-pass or more, it is in Hz"
    if background.track_high < NARROWEST_BAND * background.track_low:
        yield (
            f"background.track_high = {background.track_high:g} Hz is not {NARROWEST_BAND:g} times "
            f"background.track_low = {background.track_low:g} Hz: make the band wider"
        )


def impossible_modes(structure: Structure) -> Iterator[str]:
    """Yield a sentence for everything wrong with given modes of the axle box."""
    try:
        frequencies = numbers(structure.frequencies, "structure.frequencies")
        dampings = numbers(structure.dampings, "structure.dampings")
    except ValueError as error:
        yield str(error)
        return
    yield from _outside("structure.frequencies", frequencies, MODE_RANGE, " Hz")
    yield from _outside("structure.dampings", dampings, DAMPING_RANGE, "")
    if dampings and len(dampings) != len(frequencies):
        yield f"structure.dampings has {len(dampings)} numbers for {len(frequencies)} structure.frequencies: give one each, or none"


def _outside(key: str, found: list[float], span: tuple[float, float], unit: str) -> Iterator[str]:
    low, high = span
    for value in found:
        if not low <= value <= high:
            yield f"{key}: {value:g}{unit} is outside {low:g} .. {high:g}{unit}"
    if len(found) > MOST_MODES:
        yield f"{key} has {len(found)} numbers; {MOST_MODES} are the most"


def endless_blocks(publishing: Publishing, rate: int) -> Iterator[str]:
    """Yield a sentence for blocks in which a sample's time after the stamp finds no room, at a sampling rate [Hz]."""
    most = int(LONGEST_BLOCK * rate)
    if publishing.block_size > most:
        yield (
            f"publishing.block_size = {publishing.block_size} lasts {publishing.block_size / rate:.4g} s at sensor.sampling_rate = "
            f"{rate} Hz: the time of a sample within its block is told in nanoseconds up to {LONGEST_BLOCK:g} s; give {most} or fewer"
        )


def impossible_bursts(publishing: Publishing, rate: int) -> Iterator[str]:
    """Yield a sentence for bursts that have no length or no period, at a sampling rate [Hz]."""
    length, period, block = publishing.burst_length, publishing.burst_period, publishing.block_size / rate
    if period and not block <= length <= period:
        yield (
            f"publishing.burst_length = {length:g} s is outside {block:.4g} .. {period:g} s, a block and publishing.burst_period: "
            "give a length between them, or a period of 0.0 for no pauses"
        )
    if length and not period:
        yield f"publishing.burst_length = {length:g} s has no publishing.burst_period: give the period too, or a length of 0.0"
