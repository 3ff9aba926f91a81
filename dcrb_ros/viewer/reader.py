"""From a recording to the arrays that the viewer shows."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from dcrb_ros.bearing.kinematics import Orders
from dcrb_ros.bearing.states import BodyNames
from dcrb_ros.messages.cdr import STAMP_END, stamps
from dcrb_ros.messages.joints import decode_alike, decode_joints
from dcrb_ros.messages.points import decode_waveform
from dcrb_ros.messages.statuses import decode_diagnostics, decode_truth
from dcrb_ros.messages.topics import DIAGNOSIS, FAULT_INDICATORS, FEATURES, GROUND_TRUTH, NAMESPACE, ROLLER_STATES, VIBRATION, Topic
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.runtime.refusal import Refusal
from dcrb_ros.settings.parameters import Bearing
from dcrb_ros.simulation.block import Truth
from dcrb_ros.viewer.content import Content, Judgement, Motion, Series, Subject, Verdict, Waveform
from dcrb_ros.viewer.spectrum import diagnoses, indicators_of, verdicts_of

SHOWN = (VIBRATION, ROLLER_STATES, GROUND_TRUTH, FEATURES, FAULT_INDICATORS, DIAGNOSIS)


def read_content(recording: Recording) -> Content:
    """Return what is shown of a recording, read in one pass; a cut-off one as far as it goes.

    Raises:
        Refusal: it has no waveform, or a message that cannot be decoded.
    """
    found: dict[Topic, list[bytes]] = defaultdict(list)
    for message in recording.messages(SHOWN):
        found[message.topic].append(message.data)
    if not found[VIBRATION]:
        topic = VIBRATION.resolved(recording.namespace)
        raise Refusal(f"{recording.path} has no block on {topic} to show: give a recording of the bench with its waveform")
    bearing = Bearing() if recording.imported else recording.configuration.bearing
    subject = Subject(recording.path.stem, bearing, recording.orders, recording.sampling_rate, recording.imported)
    return content_of(found, subject, lambda waveform: _in_background(lambda: judgement_of(waveform, recording.orders, found)))


def content_of(found: Mapping[Topic, Sequence[bytes]], subject: Subject, judge: Callable[[Waveform], Future[Judgement]]) -> Content:
    """Return what some messages show.

    Raises:
        Refusal: one cannot be decoded.
    """
    waveform = waveform_of(found.get(VIBRATION, ()), subject.rate)
    return Content(
        title=subject.title,
        bearing=subject.bearing,
        orders=subject.orders,
        imported=subject.imported,
        bodies=subject.bodies,
        waveform=waveform,
        judging=judge(waveform),
        motion=motion_of(found.get(ROLLER_STATES, ()), subject.bodies),
        truths=truths_of(found.get(GROUND_TRUTH, ())),
        features=series_of(found.get(FEATURES, ())),
    )


def waveform_of(messages: Sequence[bytes], rate: int) -> Waveform:
    """Return the samples of all blocks end to end."""
    if messages:
        return Waveform(*decode_waveform(messages), rate=rate)
    return Waveform(np.zeros(0, np.int64), np.zeros((0, 2), np.float32), np.zeros(0, np.float32), rate)


def judgement_of(waveform: Waveform, orders: Orders, found: Mapping[Topic, Sequence[bytes]]) -> Judgement:
    """Return what the detector says of a waveform, and what one said while it was recorded."""
    judged = diagnoses(waveform, orders)
    return Judgement(
        indicators=series_of(found.get(FAULT_INDICATORS, ())) or indicators_of(judged),
        verdicts=verdicts_in(found.get(DIAGNOSIS, ())) or verdicts_of(judged),
        diagnoses=tuple(judged),
    )


def _in_background(work: Callable[[], Judgement]) -> Future[Judgement]:
    pool = ThreadPoolExecutor(1, "judgement")
    future = pool.submit(work)
    pool.shutdown(wait=False)
    return future


def truths_of(messages: Sequence[bytes]) -> tuple[Truth, ...]:
    """Return the ground truth over time; what repeats itself but for the stamp is decoded once."""
    known: dict[bytes, Truth] = {}
    found = []
    for time_ns, data in zip(stamps(messages).tolist(), messages, strict=True):
        said = data[STAMP_END:]
        if said not in known:
            known[said] = decode_truth(data)
        found.append(replace(known[said], time_ns=time_ns))
    return tuple(found)


def motion_of(messages: Sequence[bytes], bodies: BodyNames) -> Motion | None:
    """Return the bodies over time; ``None`` without states.

    Raises:
        Refusal: the states are of other bodies than the bearing has.
    """
    if not messages:
        return None
    names, alike = tuple(bodies.names), decode_alike(messages)
    for joints in [decode_joints(data) for data in messages] if alike is None else [alike]:
        counts = {joints.position.shape[-1], joints.velocity.shape[-1], joints.effort.shape[-1]}
        if joints.names != names or counts != {len(names)}:
            raise Refusal(
                f"a message on {ROLLER_STATES.resolved(NAMESPACE)} has {sorted(counts)} values for {len(joints.names)} bodies where the "
                f"bearing of the manifest has {len(names)}, from {names[0]} to {names[-1]}: give a recording of one bench"
            )
    if alike is None:
        each = [decode_joints(data) for data in messages]
        fields = [np.array([getattr(joints, name) for joints in each]) for name in ("position", "velocity", "effort")]
    else:
        fields = [alike.position, alike.velocity, alike.effort]
    return Motion(stamps(messages), *fields)


def series_of(messages: Sequence[bytes]) -> Series | None:
    """Return the positions of messages with the names of the first; ``None`` without messages."""
    if not messages:
        return None
    joined = decode_alike(messages)
    if joined is not None:
        return Series(stamps(messages), joined.names, joined.position)
    decoded = [decode_joints(data) for data in messages]
    alike = [joints for joints in decoded if joints.names == decoded[0].names]
    return Series(
        np.array([joints.stamp_ns for joints in alike], np.int64), decoded[0].names, np.array([joints.position for joints in alike])
    )


def verdicts_in(messages: Sequence[bytes]) -> tuple[Verdict, ...]:
    """Return what the detector said in its messages on ``diagnosis``."""
    decoded = [decode_diagnostics(data) for data in messages]
    return tuple(
        Verdict(time_ns, status.values.get("verdict", status.message), status.level, status.values)
        for time_ns, statuses in decoded
        for status in statuses[:1]
    )
