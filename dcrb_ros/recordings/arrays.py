"""A recording as arrays: the waveform, the bodies, the ground truth and the recorded diagnoses."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

import numpy as np

from dcrb_ros.bearing.history import StateHistory
from dcrb_ros.bearing.kinematics import Orders
from dcrb_ros.bearing.tacho import TachoPulses
from dcrb_ros.bearing.temperature_readings import TemperatureReadings
from dcrb_ros.bearing.waveform import Piece, Waveform, described_stretch, stretch
from dcrb_ros.messages.cdr import STAMP_END, stamps
from dcrb_ros.messages.joints import Joints, decode_alike, decode_joints
from dcrb_ros.messages.points import Vibration
from dcrb_ros.messages.pulses import decode_pulses
from dcrb_ros.messages.statuses import decode_diagnostics, decode_truth
from dcrb_ros.messages.topics import (
    AMBIENT_TEMPERATURE,
    BOX_TEMPERATURE,
    DIAGNOSIS,
    GROUND_TRUTH,
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
from dcrb_ros.simulation.ground_truth import GroundTruth
from dcrb_ros.stream.block import Truth

READINGS = {"outer_ring": OUTER_RING_TEMPERATURE, "box": BOX_TEMPERATURE, "ambient": AMBIENT_TEMPERATURE}
"""Topics of the temperature sensors by attribute of `TemperatureReadings`."""


class RecordedTopics(Protocol):
    """The part of a recording that is read here; `dcrb_ros.recordings.reader.Recording` has it."""

    path: Path

    @property
    def sampling_rate(self) -> int:
        """Sampling rate [Hz]."""

    @property
    def orders(self) -> Orders:
        """Characteristic orders of the bearing."""

    def ranged_vibrations(self) -> Iterator[tuple[Vibration, float]]:
        """Yield the blocks of the waveform, each with the range of the sensor [m/s^2]."""

    def messages(self, topics: Iterable[Topic] | None = None) -> Iterator[Message]:
        """Yield the messages on some topics."""


@dataclass(frozen=True, repr=False)
class RecordedVerdict:
    """A verdict that a detector published while the recording was made."""

    time: float
    """Simulated time that it judges [s]."""
    verdict: str
    confidence: float
    """From 0 to 1; NaN where the detector publishes none."""
    reason: str
    """The evidence in words."""

    def __repr__(self) -> str:
        return f"<RecordedVerdict: {self.verdict} at {self.time:.2f} s>"


def pieces_of(recording: RecordedTopics) -> Iterator[Piece]:
    """Yield the blocks of the waveform in the order in which they were recorded."""
    rate = recording.sampling_rate
    for block, sensor_range in recording.ranged_vibrations():
        yield Piece(block.first_index(rate), block.acceleration, block.shaft_angle, sensor_range)


def waveform_of(recording: RecordedTopics, start: float | None, stop: float | None) -> Waveform:
    """Return the samples with ``start <= time < stop`` [s], all without these; see `Recording.waveform`."""
    rate = recording.sampling_rate
    first, last = stretch(rate, start, stop)
    pieces, spans = [], []
    for piece in pieces_of(recording):
        begin, end = piece.first_index, piece.first_index + len(piece.shaft_angle)
        spans.append((begin, end))
        if begin < last and end > first:
            pieces.append(piece)
    if not pieces:
        begin, end = min(begin for begin, _ in spans), max(end for _, end in spans)
        raise Refusal(
            f"{recording.path} has no sample {described_stretch(start, stop)}: it has samples from {begin / rate:g} to {end / rate:g} s"
        )
    # A block that came twice or too late is kept once, in its place.
    index = np.concatenate([piece.first_index + np.arange(len(piece.shaft_angle), dtype=np.int64) for piece in pieces])
    index, order = np.unique(index, return_index=True)
    return Waveform(
        acceleration=np.concatenate([piece.acceleration for piece in pieces])[order],
        shaft_angle=np.concatenate([piece.shaft_angle for piece in pieces])[order],
        sampling_rate=rate,
        index=index,
        orders=recording.orders,
        sensor_range=pieces[-1].sensor_range,
    ).between(start, stop)


def states_of(recording: RecordedTopics) -> StateHistory:
    """Return the bodies over time; see `Recording.states`."""
    times, states = _joints(recording, ROLLER_STATES)
    if states is None:
        raise Refusal(f"{recording!r} has no messages on {ROLLER_STATES.name}: record this topic too, or simulate it again")
    contact_times, contacts = _joints(recording, ROLLER_CONTACTS)
    oil_times, oil = _joints(recording, LUBRICATION_STATE)
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


def _joints(recording: RecordedTopics, topic: Topic) -> tuple[Floats, Joints | None]:
    """Return the times [s] and the values, shape (times, bodies), of a topic of joint states; none where it was not recorded."""
    messages = [message.data for message in recording.messages((topic,))]
    if not messages:
        return np.zeros(0), None
    alike = decode_alike(messages)
    times = np.asarray(stamps(messages) * 1e-9, np.float64)
    return times, _stacked([decode_joints(data) for data in messages], topic) if alike is None else alike


def _stacked(joints: Sequence[Joints], topic: Topic) -> Joints:
    """Return joint states of the same bodies as one with a row for each."""
    first = joints[0]
    if any(joint.names != first.names for joint in joints):
        raise Refusal(f"the messages on {topic.name} name different bodies: give a recording of one bench")
    fields = (np.array([getattr(joint, name) for joint in joints]) for name in ("position", "velocity", "effort"))
    return Joints(first.stamp_ns, first.names, *fields)


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


def truth_of(recording: RecordedTopics) -> GroundTruth:
    """Return the ground truth over time; see `Recording.truth`."""
    return GroundTruth(truths_of([message.data for message in recording.messages((GROUND_TRUTH,))]))


def temperatures_of(recording: RecordedTopics) -> TemperatureReadings:
    """Return what the temperature sensors read; see `Recording.temperatures`."""
    by_topic: dict[Topic, dict[int, float]] = {topic: {} for topic in READINGS.values()}
    for message in recording.messages(by_topic):
        by_topic[message.topic][message.time_ns] = float(message.content)
    times = sorted({time_ns for readings in by_topic.values() for time_ns in readings})
    sensors = {sensor: np.array([by_topic[topic].get(time_ns, math.nan) for time_ns in times]) for sensor, topic in READINGS.items()}
    return TemperatureReadings(time=np.array([time_ns * 1e-9 for time_ns in times], np.float64), **sensors)


def tacho_of(recording: RecordedTopics, pulses_per_turn: int) -> TachoPulses:
    """Return the pulses of the tacho; see `Recording.tacho`."""
    blocks = [decode_pulses(message.data) for message in recording.messages((TACHO,))]
    none = np.zeros(0, np.int64)
    time_ns, number = (np.concatenate([none, *(getattr(block, name) for block in blocks)]) for name in ("time_ns", "number"))
    # A block that came twice or too late is kept once, in its place.
    time_ns, order = np.unique(time_ns, return_index=True)
    return TachoPulses(time=time_ns * 1e-9, number=number[order], pulses_per_turn=pulses_per_turn)


def verdicts_of(recording: RecordedTopics) -> list[RecordedVerdict]:
    """Return the recorded verdicts; see `Recording.verdicts`."""
    verdicts = []
    for message in recording.messages((DIAGNOSIS,)):
        time_ns, statuses = decode_diagnostics(message.data)
        for status in statuses[:1]:
            values = status.values
            verdict, reason = values.get("verdict", status.message), values.get("reason", "")
            verdicts.append(RecordedVerdict(time_ns * 1e-9, verdict, _number(values.get("confidence")), reason))
    return verdicts


def _number(text: str | None) -> float:
    """Return a number as a detector wrote it; NaN where there is none."""
    try:
        return float(text) if text is not None else math.nan
    except ValueError:
        return math.nan
