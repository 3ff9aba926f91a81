"""A recording as arrays: the waveform, the bodies, the ground truth and the recorded diagnoses."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.bearing.history import StateHistory
from dcrb_ros.bearing.tacho_pulses import TachoPulses
from dcrb_ros.bearing.temperature_readings import TemperatureReadings
from dcrb_ros.bearing.waveform import Piece, Waveform, described_stretch, stretch
from dcrb_ros.messages.cdr import STAMP_END, stamps
from dcrb_ros.messages.joints import Joints, decode_alike, decode_joints
from dcrb_ros.messages.points import check_axes
from dcrb_ros.messages.pulses import decode_pulses
from dcrb_ros.messages.statuses import decode_diagnostics, decode_truth
from dcrb_ros.messages.topics import (
    AMBIENT_TEMPERATURE,
    BOX_TEMPERATURE,
    DIAGNOSIS,
    LUBRICATION_STATE,
    OUTER_RING_TEMPERATURE,
    ROLLER_CONTACTS,
    ROLLER_STATES,
    TACHO,
    Message,
    Topic,
)
from dcrb_ros.messages.topics.lubrication_state import arrays_of
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.stream.block import Truth

READINGS = {"outer_ring": OUTER_RING_TEMPERATURE, "box": BOX_TEMPERATURE, "ambient": AMBIENT_TEMPERATURE}
"""Topics of the temperature sensors by attribute of `TemperatureReadings`."""


Messages = Callable[[Iterable[Topic]], Iterator[Message]]
"""The messages of a recording on some topics, such as `Recording.messages`."""


@dataclass(frozen=True, repr=False)
class RecordedVerdict:
    """A verdict that a detector published during the recording."""

    time: float
    """Simulated time that it judges [s]."""
    verdict: str
    confidence: float
    """From 0 to 1; NaN where the detector publishes none."""
    reason: str
    """The evidence in words."""

    def __repr__(self) -> str:
        return f"<RecordedVerdict: {self.verdict} at {self.time:.2f} s>"


def joined_waveform(blocks: Iterable[Piece], rate: int, orders: Orders, path: Path, start: float | None, stop: float | None) -> Waveform:
    """Return the samples of some blocks, in the order of the recording, with ``start <= time < stop`` [s], all without these.

    Raises:
        Refusal: there is no sample in that time, where the sentence names the ``path``; or blocks differ in their axes.
    """
    first, last = stretch(rate, start, stop)
    pieces, spans = [], []
    for piece in blocks:
        begin, end = piece.first_index, piece.end_index
        spans.append((begin, end))
        if begin < last and end > first:
            pieces.append(piece)
    if not pieces:
        begin, end = min(begin for begin, _ in spans), max(end for _, end in spans)
        raise Refusal(f"{path} has no sample {described_stretch(start, stop)}: it has samples from {begin / rate:g} to {end / rate:g} s")
    check_axes(piece.acceleration for piece in pieces)
    # A block that came twice or too late is kept once, in its place.
    index = np.concatenate([piece.first_index + np.arange(len(piece.shaft_angle), dtype=np.int64) for piece in pieces])
    index, order = np.unique(index, return_index=True)
    return Waveform(
        acceleration=np.concatenate([piece.acceleration for piece in pieces])[order],
        shaft_angle=np.concatenate([piece.shaft_angle for piece in pieces])[order],
        sampling_rate=rate,
        index=index,
        orders=orders,
        sensor_range=pieces[-1].sensor_range,
    ).between(start, stop)


def states_of(messages: Messages) -> StateHistory | None:
    """Return the bodies over time, with the contacts where they were recorded; None without ``roller_states``."""
    times, states = _joints(messages, ROLLER_STATES)
    if states is None:
        return None
    contact_times, contacts = _joints(messages, ROLLER_CONTACTS)
    oil_times, oil = _joints(messages, LUBRICATION_STATE)
    oiled = arrays_of(oil.names, oil.position) if oil is not None and np.array_equal(times, oil_times) else None
    whole = contacts is not None and np.array_equal(times, contact_times)
    return StateHistory(
        time=times,
        names=states.names,
        azimuth=states.position,
        speed=states.velocity,
        inner_force=states.effort,
        outer_force=contacts.position if contacts is not None and whole else None,
        slip=contacts.velocity if contacts is not None and whole else None,
        friction=contacts.effort if contacts is not None and whole else None,
        **(oiled or {}),
    )


def _joints(messages: Messages, topic: Topic) -> tuple[Floats, Joints | None]:
    """Return the times [s] and the values, shape (times, bodies), of a topic of joint states; None where it was not recorded."""
    encoded = [message.data for message in messages((topic,))]
    if not encoded:
        return np.zeros(0), None
    alike = decode_alike(encoded)
    times = np.asarray(stamps(encoded) * 1e-9, np.float64)
    if alike is None:
        joints = [decode_joints(data) for data in encoded]
        if any(joint.names != joints[0].names for joint in joints):
            raise Refusal(f"the messages on {topic.name} name different bodies: give a recording of one bench")
        fields = (np.array([getattr(joint, name) for joint in joints]) for name in ("position", "velocity", "effort"))
        alike = Joints(joints[0].stamp_ns, joints[0].names, *fields)
    return times, alike


def truths_of(messages: Sequence[bytes]) -> tuple[Truth, ...]:
    """Return the ground truth over time; messages that differ in their stamp only are decoded once."""
    known: dict[bytes, Truth] = {}
    truths = []
    for time_ns, data in zip(stamps(messages).tolist() if messages else (), messages, strict=True):
        content = data[STAMP_END:]
        if content not in known:
            known[content] = decode_truth(data)
        truths.append(replace(known[content], time_ns=time_ns))
    return tuple(truths)


def temperatures_of(messages: Messages) -> TemperatureReadings:
    """Return the readings of the temperature sensors [deg C], NaN where one of them has none; empty where none were recorded."""
    by_topic: dict[Topic, dict[int, float]] = {topic: {} for topic in READINGS.values()}
    for message in messages(by_topic):
        by_topic[message.topic][message.time_ns] = float(message.content)
    times = sorted({time_ns for readings in by_topic.values() for time_ns in readings})
    sensors = {sensor: np.array([by_topic[topic].get(time_ns, math.nan) for time_ns in times]) for sensor, topic in READINGS.items()}
    return TemperatureReadings(time=np.array([time_ns * 1e-9 for time_ns in times], np.float64), **sensors)


def tacho_of(messages: Messages, pulses_per_turn: int) -> TachoPulses:
    """Return the pulses of the tacho; empty where none were recorded."""
    blocks = [decode_pulses(message.data) for message in messages((TACHO,))]
    none = np.zeros(0, np.int64)
    time_ns, number = (np.concatenate([none, *(getattr(block, name) for block in blocks)]) for name in ("time_ns", "number"))
    # A block that came twice or too late is kept once, in its place.
    time_ns, order = np.unique(time_ns, return_index=True)
    return TachoPulses(time=time_ns * 1e-9, number=number[order], pulses_per_turn=pulses_per_turn)


def verdicts_of(messages: Messages) -> list[RecordedVerdict]:
    """Return the verdicts that a detector published during the recording."""
    verdicts = []
    for message in messages((DIAGNOSIS,)):
        time_ns, statuses = decode_diagnostics(message.data)
        for status in statuses[:1]:
            values = status.values
            verdict, reason = values.get("verdict", status.message), values.get("reason", "")
            verdicts.append(RecordedVerdict(time_ns * 1e-9, verdict, _number(values.get("confidence")), reason))
    return verdicts


def _number(text: str | None) -> float:
    """Return a number as a detector wrote it; NaN for a missing or invalid one."""
    try:
        return float(text) if text is not None else math.nan
    except ValueError:
        return math.nan
