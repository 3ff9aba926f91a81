"""What was imported, in one line, and what in it is implausible."""

from __future__ import annotations

import math

import numpy as np

from dcrb_ros.exchange.importing import WaveformImport
from dcrb_ros.exchange.pieces import pieces
from dcrb_ros.settings.parameters import rpm
from dcrb_ros.text.counts import counted

FASTEST = 500.0
"""Speed of the shaft beyond which rpm were most likely meant [rad/s]."""
LOUDEST, QUIETEST = 2000.0, 1e-4
"""Range of a plausible acceleration [m/s^2 rms]."""


def shaft_frequency(waveform: WaveformImport) -> float:
    """Return the mean shaft frequency [Hz], NaN if the speed is unknown."""
    turned, count = 0.0, 0
    for piece in pieces(len(waveform.index) - 1):
        both = slice(piece.start, piece.stop + 1)
        turns = np.diff(waveform.angle[both].astype(np.float64)) / (2.0 * np.pi)
        steps = (turns - np.rint(turns))[np.diff(waveform.index[both]) == 1]
        turned, count = turned + float(np.nansum(steps)), count + int(np.count_nonzero(np.isfinite(steps)))
    return waveform.measured_rate * turned / count if count else np.nan


def acceleration_rms(waveform: WaveformImport) -> float:
    """Return the root mean square of the acceleration without its mean, over the axes [m/s^2]."""
    mean, squares = waveform.acceleration.mean(axis=0, dtype=np.float64), 0.0
    for piece in pieces(len(waveform.acceleration)):
        squares += float(np.sum((waveform.acceleration[piece] - mean) ** 2))
    return math.sqrt(squares / waveform.acceleration.size)


def summary(waveform: WaveformImport) -> str:
    """Return speed [rpm], fault frequencies [Hz], rms and duration [s] in words."""
    shaft = shaft_frequency(waveform)
    lines = ", ".join(f"{name} {order * abs(shaft):.2f}" for name, order in waveform.orders.as_dict().items())
    speed = f"{60.0 * shaft:.5g} rpm, {lines} Hz" if np.isfinite(shaft) else "speed unknown"
    unit = "(relative)" if waveform.description.unit == "relative" else "m/s^2"
    return f"{speed}, rms {acceleration_rms(waveform):.4g} {unit}, {len(waveform.index) / waveform.measured_rate:.3f} s"


def implausible(waveform: WaveformImport) -> list[str]:
    """Return a sentence for each implausible value."""
    sentences, speed, level = [], waveform.description.speed, acceleration_rms(waveform)
    if speed is not None and abs(speed) > FASTEST:
        sentences.append(f"speed = {speed:g} rad/s is {rpm(speed):.5g} rpm, which is implausible: if rpm were meant, give speed_rpm")
    elif (speed := 2.0 * math.pi * abs(shaft_frequency(waveform))) > FASTEST:
        sentences.append(f"{waveform.shaft_source} gives {speed:.4g} rad/s, {rpm(speed):.4g} rpm, which is implausible: check its unit")
    span = f"{QUIETEST:g} .. {LOUDEST:g} m/s^2"
    if waveform.description.unit != "relative" and not QUIETEST <= level <= LOUDEST:
        sentences.append(f"an acceleration of {level:.3g} m/s^2 rms is outside {span}: check unit and sensitivity")
    if jump := waveform.jump_in_time():
        sentences.append(f"{jump}: if samples are missing there, name a channel index, or import the parts as files with a gap")
    end = (waveform.index[-1] + 1) / waveform.rate
    for channel, (time_ns, _) in waveform.readings.items():
        late = time_ns[time_ns > end * 1e9]
        if not len(time_ns):
            sentences.append(f"{channel} has no reading, because all of its values are NaN: check the channel")
        if len(late):
            sentences.append(
                f"{len(late)} of {counted(len(time_ns), 'reading')} of {channel} are later than the waveform, which ends at {end:g} s, "
                f"up to {late[-1] * 1e-9:g} s: check that temperature_time is in seconds since sample 0"
            )
    return sentences
