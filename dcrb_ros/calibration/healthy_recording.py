"""Recordings from which the bench is calibrated: what they must have, checked before anything is estimated."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.bearing.waveform import Signal, Waveform
from dcrb_ros.diagnosis.detection import watch
from dcrb_ros.diagnosis.order_tracking import unwrapped_turns
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.parameters import rpm

LEAST_SECONDS, LEAST_TURNS = 2.0, 20.0
"""Shortest stretch without a gap from which spectra and lines are estimated [s], and its turns of the shaft [-]."""
LARGEST_SPEED_RANGE = 0.05
"""Largest range of the speed over its mean [-]: the source is simulated at one speed, which a spectrum needs."""
CLIPPED_SHARE = 1e-4
"""Share of samples at one extreme value from which a signal counts as clipped [-]."""
FEWEST_CLIPPED = 8
"""Samples at one extreme value that chance or a coarse converter does not give [-]."""
SAME_ORDERS = 0.02
"""Largest relative difference of BPFO and BPFI between recordings of one bearing [-]."""


@dataclass(frozen=True, eq=False)
class HealthyRecording:
    """A checked recording of a healthy machine: its longest stretch without a gap."""

    name: str
    waveform: Waveform
    acceleration: Floats
    """Without its mean, shape (axes, samples) [m/s^2, or relative]; one axis if the second is a copy of the first."""
    axes: tuple[str, ...]
    """``y`` for a single axis, otherwise ``x`` and ``y``."""
    turns: Floats
    """Turns of the shaft since the first sample, shape (samples,) [-]."""
    rate: int
    """Sampling rate [Hz]."""
    unit: str
    """``m/s^2`` or ``relative``."""
    tracked: bool
    """Whether the angle of the shaft was measured; otherwise it follows from a stated speed."""
    configuration: Configuration | None
    """Configuration of the bench if it made the recording."""

    @property
    def orders(self) -> Orders:
        """Characteristic orders of the bearing."""
        return self.waveform.orders

    @property
    def speed(self) -> float:
        """Mean speed of the shaft [rad/s], negative if it turns clockwise."""
        return float(self.turns[-1]) * 2.0 * math.pi * self.rate / (len(self.turns) - 1)


def checked_recording(signal: Signal, name: str, *, trust: bool = False) -> HealthyRecording:
    """Return a recording, called ``name`` in messages, after its checks; with ``trust`` although the detector finds a fault.

    Raises:
        Refusal: it is empty, too short, clipped, without speed, at a varying speed, of an unknown bearing, or faulty.
    """
    if not isinstance(signal, Signal):
        raise Refusal(f"{name} is not a recording: give a Recording, a SimulationResult or a Waveform")
    whole = signal.waveform()
    waveform = longest_stretch(whole)
    acceleration = waveform.acceleration[:, :2].T.astype(np.float64)
    if not len(waveform) or not np.isfinite(acceleration).all():
        raise Refusal(f"{name} is empty or has samples that are not numbers: give a waveform")
    constant = [axis for axis in (0, 1) if float(np.ptp(acceleration[axis])) == 0.0]
    if constant:
        value = float(acceleration[constant[0], 0]) + 0.0  # without the sign of zero
        if len(constant) == 2:
            raise Refusal(f"{name} is empty: every sample is {value:g}; check the channel and the sensor")
        raise Refusal(f"{name} has a dead axis: every sample in {'XY'[constant[0]]} is {value:g}; import it without this channel")
    if not waveform.tracked:
        raise Refusal(f"{name} has no speed: import it with speed_rpm, a channel of speed or a tacho")
    if math.isnan(waveform.orders.bpfo):
        raise Refusal(f"{name} is of an unknown bearing: give its geometry or its orders")
    turns = unwrapped_turns(waveform.shaft_angle)
    turned = abs(float(turns[-1]))
    if waveform.duration < LEAST_SECONDS or turned < LEAST_TURNS:
        gaps = " without a gap" if len(waveform) < len(whole) else ""
        raise Refusal(
            f"{name} is too short: {waveform.duration:.3g} s and {turned:.3g} turns of the shaft{gaps}, and a calibration needs "
            f"{LEAST_SECONDS:g} s and {LEAST_TURNS:g} turns"
        )
    _check_speed(turns, waveform.sampling_rate, name)
    _check_clipping(acceleration, waveform.sensor_range, unit_of(signal), name)
    single = np.array_equal(acceleration[0], acceleration[1])
    if not trust:
        _check_health(waveform, signal, name)
    return HealthyRecording(
        name,
        waveform,
        acceleration[1:] - acceleration[1:].mean() if single else acceleration - acceleration.mean(axis=1, keepdims=True),
        ("y",) if single else ("x", "y"),
        turns - turns[0],
        waveform.sampling_rate,
        unit_of(signal),
        _angle_measured(signal),
        _configuration(signal),
    )


def check_one_machine(recordings: Sequence[HealthyRecording]) -> None:
    """Refuse an empty list, a recording that is given twice, and recordings that do not fit together.

    These are of different machines, or their rates, units, axes or directions of rotation differ.
    """
    if not recordings:
        raise Refusal("no recording is given: give at least one of the healthy machine")
    first = recordings[0]
    for other in recordings[1:]:
        pair = f"{first.name} and {other.name}"
        if other.rate != first.rate:
            raise Refusal(f"{pair} have sampling rates of {first.rate} and {other.rate} Hz: resample one, or calibrate to each alone")
        if other.unit != first.unit:
            raise Refusal(f"{pair} have the units {first.unit} and {other.unit}: import both with the same unit")
        if other.axes != first.axes:
            raise Refusal(f"{pair} have {len(first.axes)} and {len(other.axes)} axes: import both with the same channels")
        if other.speed * first.speed < 0.0:
            speeds = f"{rpm(first.speed):.4g} and {rpm(other.speed):.4g} rpm"
            raise Refusal(f"{pair} have opposite directions of rotation, {speeds}: calibrate to each alone")
        for name in ("bpfo", "bpfi"):
            before, after = getattr(first.orders, name), getattr(other.orders, name)
            if abs(after / before - 1.0) > SAME_ORDERS:
                orders = f"{name.upper()} is {before:.4g} and {after:.4g} orders"
                raise Refusal(f"{pair} are of different machines: {orders}; calibrate to each alone")
    for first, second in combinations(recordings, 2):
        if np.array_equal(first.acceleration, second.acceleration):
            raise Refusal(f"{first.name} and {second.name} have the same samples, which would count twice: give every recording once")


def longest_stretch(waveform: Waveform) -> Waveform:
    """Return the longest part of a waveform without a gap."""
    borders = [0, *(np.flatnonzero(np.diff(waveform.index) != 1) + 1).tolist(), len(waveform)]
    begin, end = max(pairwise(borders), key=lambda piece: piece[1] - piece[0])
    return waveform if (begin, end) == (0, len(waveform)) else waveform._cut(slice(begin, end))


def _check_speed(turns: Floats, rate: int, name: str) -> None:
    hop = max(1, round(0.5 * rate))
    speeds = np.diff(turns[::hop]) * (rate / hop)
    mean = float(speeds.mean())
    if mean == 0.0 or float(np.ptp(speeds)) > LARGEST_SPEED_RANGE * abs(mean):
        raise Refusal(
            f"{name} has a speed between {60.0 * speeds.min():.4g} and {60.0 * speeds.max():.4g} rpm: a calibration needs a steady one, "
            f"within {100.0 * LARGEST_SPEED_RANGE:g} %"
        )


def _check_clipping(acceleration: Floats, sensor_range: float, unit: str, name: str) -> None:
    samples = acceleration.shape[1]
    for axis in acceleration:
        middle = float(np.median(axis))
        far = 4.0 * float(np.median(np.abs(axis - middle)))
        for extreme in (float(axis.max()), float(axis.min())):
            at = int(np.count_nonzero(axis == extreme))
            limited = at >= max(FEWEST_CLIPPED, CLIPPED_SHARE * samples)
            if limited and (abs(extreme - middle) >= far or 0.0 < sensor_range <= abs(extreme)):
                shown = "(relative)" if unit == "relative" else unit
                raise Refusal(f"{name} is clipped: {at} samples are at {extreme:.4g} {shown}; record with a larger range")


def _check_health(waveform: Waveform, signal: Signal, name: str) -> None:
    try:
        diagnosis = watch(waveform)
    except Refusal as refusal:
        reason = str(refusal).partition(":")[0]
        raise Refusal(f"{name} cannot be judged by the detector, {reason}: if the machine is healthy, say so (--trust)") from None
    if diagnosis.verdict not in ("healthy", "waiting"):
        raise Refusal(
            f"{name} does not seem healthy: the detector finds {diagnosis.verdict} ({diagnosis.reason}); give a healthy recording, "
            "or say that it is one (--trust)"
        )


def unit_of(signal: Signal) -> str:
    """Return the unit of the acceleration: ``m/s^2`` or ``relative``."""
    about = signal.manifest.get("units", {}) if isinstance(signal, Recording) else {}
    return "relative" if about.get("acceleration") == "relative" else "m/s^2"


def _angle_measured(signal: Signal) -> bool:
    if isinstance(signal, Recording) and signal.imported:
        return str(signal.manifest.get("sensor", {}).get("shaft_angle", "")) not in ("from the stated speed", "unknown")
    return True


def _configuration(signal: Signal) -> Configuration | None:
    if isinstance(signal, Recording):
        return signal.configuration if signal.configured else None
    configuration = getattr(signal, "configuration", None)
    return configuration if isinstance(configuration, Configuration) else None
