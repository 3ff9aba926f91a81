"""Reading of a recording into the arrays that the viewer shows; messages that cannot be decoded are refused."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, MutableMapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Protocol, TypeVar

import numpy as np

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.bearing.tacho_pulses import TachoPulses
from dcrb_ros.bearing.temperature_readings import TemperatureReadings
from dcrb_ros.messages.cdr import stamps
from dcrb_ros.messages.joints import decode_alike, decode_joints
from dcrb_ros.messages.points import decode_waveform
from dcrb_ros.messages.pulses import decode_pulses
from dcrb_ros.messages.statuses import decode_diagnostics
from dcrb_ros.messages.topics import (
    DIAGNOSIS,
    FAULT_INDICATORS,
    FEATURES,
    GROUND_TRUTH,
    LUBRICATION_STATE,
    NAMESPACE,
    ROLLER_STATES,
    TACHO,
    VIBRATION,
    Topic,
)
from dcrb_ros.messages.topics.diagnosis import decode_scores
from dcrb_ros.recordings.arrays import truths_of
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.vehicle_folder import title_of
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.parameters import Bearing
from dcrb_ros.stream.states import BodyNames
from dcrb_ros.viewer.content import BenchInfo, Content, DetectorOutput, Motion, Series, TimedWaveform, Verdict
from dcrb_ros.viewer.spectrum import diagnoses, indicators_of, verdicts_of

SHOWN = (VIBRATION, ROLLER_STATES, GROUND_TRUTH, FEATURES, FAULT_INDICATORS, DIAGNOSIS, LUBRICATION_STATE, TACHO)

Decoded = TypeVar("Decoded")


class Reading(Protocol):
    """Reading of the messages on one topic."""

    def __call__(self, decode: Callable[[Sequence[bytes]], Decoded], messages: Sequence[bytes], /) -> Decoded:
        """Return the decoded messages; a `Refusal` passes, or the messages are left out."""


def decoded(decode: Callable[[Sequence[bytes]], Decoded], messages: Sequence[bytes]) -> Decoded:
    """Return the decoded messages on a topic."""
    return decode(messages)


def read_content(recording: Recording) -> Content:
    """Return the content of a recording, read in one pass; of a truncated recording, its readable part.

    Raises:
        Refusal: it has no waveform, or a message cannot be decoded.
    """
    messages: dict[Topic, list[bytes]] = defaultdict(list)
    for message in recording.messages(SHOWN):
        messages[message.topic].append(message.data)
    if not messages[VIBRATION]:
        topic = VIBRATION.resolved(recording.namespace)
        raise Refusal(f"{recording.path} has no block on {topic}: give a recording that contains the waveform")
    bearing = recording.bearing
    bench = BenchInfo(
        title_of(recording.path),
        bearing or Bearing(),
        recording.orders,
        recording.sampling_rate,
        imported=bearing is None,
        pulses_per_turn=recording.pulses_per_turn,
    )
    temperatures = recording.temperatures()
    return content_of(
        messages,
        bench,
        lambda waveform: _in_background(lambda: detector_output_of(waveform, recording.orders, messages, temperatures, bearing)),
    )


def content_of(
    messages: MutableMapping[Topic, list[bytes]],
    bench: BenchInfo,
    start_detector: Callable[[TimedWaveform], Future[DetectorOutput]],
    read: Reading = decoded,
) -> Content:
    """Return the content of messages by topic, each topic by ``read``; ``start_detector`` starts the detector on the waveform.

    The messages with the waveform, which take as much memory as its samples, are removed from ``messages``.
    """
    waveform = read(lambda blocks: waveform_of(blocks, bench.rate), messages.pop(VIBRATION, ()))
    return Content(
        **vars(bench),
        waveform=waveform,
        pending_output=start_detector(waveform),
        motion=read(lambda states: motion_of(states, bench.bodies), messages.get(ROLLER_STATES, ())),
        truths=read(truths_of, messages.get(GROUND_TRUTH, ())),
        features=read(series_of, messages.get(FEATURES, ())),
        lubrication=read(series_of, messages.get(LUBRICATION_STATE, ())),
        tacho=read(lambda pulses: tacho_of(pulses, bench.pulses_per_turn), messages.get(TACHO, ())),
    )


def waveform_of(messages: Sequence[bytes], rate: int) -> TimedWaveform:
    """Return the concatenated samples of all blocks."""
    if messages:
        return TimedWaveform(*decode_waveform(messages), rate=rate)
    return TimedWaveform(np.zeros(0, np.int64), np.zeros((0, 2), np.float32), np.zeros(0, np.float32), rate)


def detector_output_of(
    waveform: TimedWaveform,
    orders: Orders,
    messages: Mapping[Topic, Sequence[bytes]],
    temperatures: TemperatureReadings,
    bearing: Bearing | None,
) -> DetectorOutput:
    """Return the shipped detector's output for a waveform and temperatures; recorded indicators and verdicts take precedence."""
    judgements = diagnoses(waveform, orders, temperatures, time_lapse(messages.get(GROUND_TRUTH, ())), bearing)
    return DetectorOutput(
        indicators=series_of(messages.get(FAULT_INDICATORS, ())) or indicators_of(judgements),
        verdicts=verdicts_in(messages.get(DIAGNOSIS, ())) or verdicts_of(judgements),
        diagnoses=tuple(judgements),
    )


def time_lapse(truths: Sequence[bytes]) -> float:
    """Return the time lapse of the heat in messages of the ground truth [-]; 1 where it is not stated."""
    return max((truth.thermal.get("acceleration", 1.0) for truth in truths_of(truths[-1:])), default=1.0)


def _in_background(work: Callable[[], DetectorOutput]) -> Future[DetectorOutput]:
    pool = ThreadPoolExecutor(1, "judgement")
    future = pool.submit(work)
    pool.shutdown(wait=False)
    return future


def motion_of(messages: Sequence[bytes], bodies: BodyNames) -> Motion | None:
    """Return the motion of the bodies; ``None`` if there are no messages.

    Raises:
        Refusal: the messages contain other bodies than the bearing has.
    """
    if not messages:
        return None
    names, alike = tuple(bodies.names), decode_alike(messages)
    each = [decode_joints(data) for data in messages] if alike is None else [alike]
    for joints in each:
        counts = {joints.position.shape[-1], joints.velocity.shape[-1], joints.effort.shape[-1]}
        if joints.names != names or counts != {len(names)}:
            raise Refusal(
                f"a message on {ROLLER_STATES.resolved(NAMESPACE)} has {sorted(counts)} values for {len(joints.names)} bodies, but the "
                f"bearing of the manifest has {len(names)}, from {names[0]} to {names[-1]}: give a recording of a single bench"
            )
    fields = [np.concatenate([np.atleast_2d(getattr(joints, name)) for joints in each]) for name in ("position", "velocity", "effort")]
    return Motion(stamps(messages), *fields)


def series_of(messages: Sequence[bytes]) -> Series | None:
    """Return the positions in the messages that have the names of the first one; ``None`` if none has one position for each name."""
    joined = decode_alike(messages)
    if joined is not None and len(joined.names) == joined.position.shape[1] > 0:
        return Series(stamps(messages), joined.names, joined.position)
    whole = [joints for joints in map(decode_joints, messages) if len(joints.names) == len(joints.position) > 0]
    alike = [joints for joints in whole if joints.names == whole[0].names]
    if not alike:
        return None
    return Series(
        np.array([joints.stamp_ns for joints in alike], np.int64), alike[0].names, np.array([joints.position for joints in alike])
    )


def tacho_of(messages: Sequence[bytes], pulses_per_turn: int) -> Series | None:
    """Return the speed of the shaft from the pulses of its tacho [rad/s], each at the later of two pulses; ``None`` if it is unknown."""
    blocks = [decode_pulses(data) for data in messages]
    if not blocks or not pulses_per_turn:
        return None
    time_ns, number = (np.concatenate([getattr(block, name) for block in blocks]) for name in ("time_ns", "number"))
    speed = TachoPulses(time=time_ns * 1e-9, number=number, pulses_per_turn=pulses_per_turn).speed
    return Series(time_ns[1:], ("tacho [rad/s]",), speed[:, None]) if len(speed) else None


def verdicts_in(messages: Sequence[bytes]) -> tuple[Verdict, ...]:
    """Return the verdicts in messages on ``diagnosis``."""
    received = [decode_diagnostics(data) for data in messages]
    return tuple(
        Verdict(time_ns, status.values.get("verdict", status.message), status.level, status.values, decode_scores(status.values))
        for time_ns, statuses in received
        for status in statuses[:1]
    )
