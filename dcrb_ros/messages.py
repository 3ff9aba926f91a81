"""Blocks to ROS messages and back, as pure functions: the only module that knows the fields of messages.

CDR comes from rosbags' type store, so that a machine without ROS encodes the very same bytes.
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from itertools import groupby
from typing import Any

import numpy as np
import numpy.typing as npt
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

from dcrb_ros.block import Block, Floats, Layout, Samples, States, Truth
from dcrb_ros.configuration import Configuration
from dcrb_ros.diagnosis.detector import Diagnosis
from dcrb_ros.kinematics import Orders, characteristic_orders
from dcrb_ros.measurement.features import features
from dcrb_ros.refusal import Refusal
from dcrb_ros.stencil import Stencil, marks
from dcrb_ros.topics import (
    ACCELERATION,
    DIAGNOSIS,
    ENVELOPE_SPECTRUM,
    FAULT_INDICATORS,
    FEATURES,
    GROUND_TRUTH,
    JOINT_STATE,
    POINT_CLOUD,
    ROLLER_CONTACTS,
    ROLLER_STATES,
    SENSOR,
    VIBRATION,
    VIBRATION_CLEAN,
    Message,
    Topic,
)

FRAME = "outer_ring"
SAMPLE = np.dtype([("t", "<u4"), ("ax", "<f4"), ("ay", "<f4"), ("shaft_angle", "<f4")])
UNTRACKED_SAMPLE = np.dtype([("t", "<u4"), ("ax", "<f4"), ("ay", "<f4")])
SPECTRUM = np.dtype([("frequency", "<f4"), ("order", "<f4"), ("amplitude", "<f4")])
UINT32, FLOAT32 = 6, 7  # sensor_msgs/msg/PointField
POINT_KINDS = {"<u4": UINT32, "<f4": FLOAT32}
OK, WARN, ERROR = 0, 1, 2  # diagnostic_msgs/msg/DiagnosticStatus
NO_ESTIMATE = -1.0  # first element of a covariance, sensor_msgs/msg/Imu
MOST_SAMPLES = 1 << 20
STENCILS = 64
"""Kinds of messages that are remembered, so that one that differs in stamp and numbers only is not encoded anew."""
STAMP_END = 12
"""Bytes of a message with a header before its frame."""


@cache
def typestore() -> Typestore:
    """Return the message types of ROS 2 Jazzy."""
    return get_typestore(Stores.ROS2_JAZZY)


def index_at(time_ns: int, rate: int) -> int:
    """Return the index of the sample at a simulated time [ns]: the time times the sampling rate [Hz], rounded."""
    return (time_ns * rate + 500_000_000) // 1_000_000_000


@dataclass(frozen=True)
class Vibration:
    """A block of the waveform as it comes over the wire or from a recording."""

    stamp_ns: int
    """Simulated time of the first sample [ns]."""
    offsets_ns: npt.NDArray[np.uint32]
    """Time of each sample after the stamp [ns]."""
    acceleration: Samples
    """Shape (samples, 2) [m/s^2]."""
    shaft_angle: Samples
    """Wrapped to [0, 2 pi) [rad]."""

    def first_index(self, rate: int) -> int:
        """Return the index of the first sample at a sampling rate [Hz]: its time times the rate, rounded."""
        return index_at(self.stamp_ns, rate)

    def packed(self) -> bytes:
        """Return the samples as `packed` does."""
        return packed(self.acceleration, self.shaft_angle)


@dataclass(frozen=True)
class Joints:
    """A JointState: names with position, velocity and effort."""

    stamp_ns: int
    names: tuple[str, ...]
    position: Floats
    velocity: Floats
    effort: Floats


@dataclass(frozen=True)
class Status:
    """One status of a DiagnosticArray."""

    name: str
    level: int
    """0 OK, 1 warning, 2 error."""
    message: str
    values: Mapping[str, str]


def packed(acceleration: Samples, shaft_angle: Samples) -> bytes:
    """Return ax, ay and shaft angle of every sample as little-endian single floats: what a recording's hash is of."""
    return np.column_stack([acceleration, shaft_angle]).astype("<f4", copy=False).tobytes()


def _type(name: str) -> Any:
    return typestore().types[name]


def _encoded(type_name: str, message: Any) -> bytes:
    return bytes(typestore().serialize_cdr(message, type_name))


def _header(time_ns: int, frame: str = FRAME) -> Any:
    stamp = _type("builtin_interfaces/msg/Time")(time_ns // 1_000_000_000, time_ns % 1_000_000_000)
    return _type("std_msgs/msg/Header")(stamp, frame)


def stamp_of(header: Any) -> int:
    """Return the stamp of a decoded header [ns]."""
    return int(header.stamp.sec) * 1_000_000_000 + int(header.stamp.nanosec)


def encode_points(points: npt.NDArray[Any], time_ns: int, frame: str = FRAME) -> bytes:
    """Return a PointCloud2 of structured points, one field per column."""
    return _points_stencil(points.dtype, len(points), frame).filled(time_ns, points.tobytes())


@lru_cache(STENCILS)
def _points_stencil(kind: np.dtype[Any], count: int, frame: str) -> Stencil:
    point_type, mark = _type("sensor_msgs/msg/PointField"), marks(kind.itemsize * count)
    fields = [
        point_type(name, offset, POINT_KINDS[dtype.str], 1)
        for name, (dtype, offset) in ((name, (entry[0], entry[1])) for name, entry in (kind.fields or {}).items())
    ]
    raw = np.frombuffer(mark, np.uint8)
    cloud = _type(POINT_CLOUD)(_header(0, frame), 1, count, fields, False, kind.itemsize, kind.itemsize * count, raw, True)
    return Stencil(_encoded(POINT_CLOUD, cloud), mark)


def encode_vibration(block: Block, acceleration: Samples, frame: str = FRAME) -> bytes:
    """Return the waveform of a block as a PointCloud2 with the fields of `SAMPLE`."""
    points = np.empty(len(acceleration), SAMPLE)
    # What the first sample's time lost by rounding down counts for the others.
    lost = block.index * 1_000_000_000 % block.rate
    points["t"] = (lost + np.arange(len(acceleration), dtype=np.int64) * 1_000_000_000) // block.rate
    points["ax"], points["ay"], points["shaft_angle"] = acceleration[:, 0], acceleration[:, 1], block.shaft_angle
    return encode_points(points, block.stamp_ns, frame)


def encode_joints(time_ns: int, names: Sequence[str], position: Floats, velocity: Floats, effort: Floats) -> bytes:
    """Return a JointState."""
    numbers = [np.asarray(values, "<f8").tobytes() for values in (position, velocity, effort)]
    return _joints_stencil(tuple(names), *map(len, numbers)).filled(time_ns, *numbers)


@lru_cache(STENCILS)
def _joints_stencil(names: tuple[str, ...], *sizes: int) -> Stencil:
    """Return a JointState without its numbers, of which each array takes so many bytes."""
    mark = marks(sum(sizes))
    holes = [mark[sum(sizes[:k]) : sum(sizes[: k + 1])] for k in range(len(sizes))]
    arrays = [np.frombuffer(hole, "<f8") for hole in holes]
    return Stencil(_encoded(JOINT_STATE, _type(JOINT_STATE)(_header(0, ""), list(names), *arrays)), *holes)


def encode_states(states: States, names: Sequence[str]) -> bytes:
    """Return azimuth [rad], spin or rotation [rad/s] and inner normal force [N] of all bodies as a JointState."""
    return encode_joints(states.time_ns, names, states.azimuth, states.speed, states.inner_force)


def encode_contacts(states: States, names: Sequence[str]) -> bytes:
    """Return outer normal force [N], slip [m/s] and friction [N] of all bodies as a JointState."""
    return encode_joints(states.time_ns, names, states.outer_force, states.slip, states.friction)


def encode_features(block: Block) -> bytes:
    """Return the features of a block as a JointState; the values are in position."""
    found, none = features(block), np.zeros(0)
    return encode_joints(block.stamp_ns, list(found), np.array(list(found.values())), none, none)


def encode_preview(time_ns: int, acceleration: npt.NDArray[np.float32], frame: str = FRAME) -> bytes:
    """Return a preview sample as an Imu; orientation and rotation are absent, the covariances unknown."""
    return _preview_stencil(frame).filled(time_ns, acceleration.astype("<f8").tobytes())


@lru_cache(STENCILS)
def _preview_stencil(frame: str) -> Stencil:
    vector, quaternion, mark = _type("geometry_msgs/msg/Vector3"), _type("geometry_msgs/msg/Quaternion"), marks(16)
    unknown = np.zeros(9)
    unknown[0] = NO_ESTIMATE
    linear = vector(*struct.unpack("<dd", mark), 0.0)
    name = "sensor_msgs/msg/Imu"
    imu = _type(name)(_header(0, frame), quaternion(0.0, 0.0, 0.0, 1.0), unknown, vector(0.0, 0.0, 0.0), unknown, linear, unknown)
    return Stencil(_encoded(name, imu), mark)


def encode_text(text: str) -> bytes:
    """Return a String."""
    return _encoded("std_msgs/msg/String", _type("std_msgs/msg/String")(text))


def encode_clock(time_ns: int) -> bytes:
    """Return a Clock."""
    name = "rosgraph_msgs/msg/Clock"
    return _encoded(name, _type(name)(_type("builtin_interfaces/msg/Time")(time_ns // 1_000_000_000, time_ns % 1_000_000_000)))


def encode_diagnostics(time_ns: int, statuses: Iterable[Status]) -> bytes:
    """Return a DiagnosticArray."""
    pair, status_type = _type("diagnostic_msgs/msg/KeyValue"), _type("diagnostic_msgs/msg/DiagnosticStatus")
    found = [status_type(s.level, s.name, s.message, "dcrb", [pair(key, value) for key, value in s.values.items()]) for s in statuses]
    name = "diagnostic_msgs/msg/DiagnosticArray"
    return _encoded(name, _type(name)(_header(time_ns, ""), found))


def encode_truth(truth: Truth) -> bytes:
    """Return the ground truth: a status ``operating`` and one per fault, named by its configuration key."""
    operating = {"speed [rad/s]": repr(truth.speed), "load_x [N]": repr(truth.load[0]), "load_y [N]": repr(truth.load[1])}
    operating |= {f"{name} [Hz]": repr(frequency) for name, frequency in truth.frequencies.items()}
    statuses = [Status("operating", OK, truth.changed, operating)]
    if truth.background:
        statuses.append(Status("background", OK, "no fault", {key: repr(value) for key, value in truth.background.items()}))
    for name, fields in truth.faults.items():
        statuses.append(Status(f"faults.{name}", ERROR, "present", {key: repr(value) for key, value in fields.items()}))
    return encode_diagnostics(truth.time_ns, statuses)


def sensor_text(configuration: Configuration) -> str:
    """Return what a reader must know of the waveform, as JSON: rate, units, axes, geometry, orders, index rule."""
    orders = characteristic_orders(configuration.bearing)
    about = {
        "sampling_rate": configuration.sensor.sampling_rate,
        "sampling_rate_unit": "Hz",
        "acceleration_unit": "m/s^2",
        "axes": {"ax": "X, right", "ay": "Y, up"},
        "shaft_angle_unit": "rad",
        "range": configuration.sensor.range,
        "block_size": configuration.publishing.block_size,
        "frame": configuration.publishing.frame,
        "bearing": configuration.bearing.model_dump(),
        "orders": {"FTF": orders.ftf, "BPFO": orders.bpfo, "BPFI": orders.bpfi, "BSF": orders.bsf},
        "first_sample_index": "round(stamp * sampling_rate); sample k is taken at k / sampling_rate of simulated time",
    }
    publishing = configuration.publishing
    if publishing.burst_period > 0.0:
        about |= {"burst_length": publishing.burst_length, "burst_period": publishing.burst_period, "burst_unit": "s"}
    return json.dumps(about, sort_keys=True)


class BlockEncoder:
    """Blocks to messages, each encoded once."""

    def __init__(self, configuration: Configuration, layout: Layout) -> None:
        self._configuration = configuration
        self._names = tuple(layout.names)
        self._frame = configuration.publishing.frame

    def start(self, time_ns: int = 0) -> list[Message]:
        """Return the messages that come before the first block, which begins at ``time_ns``."""
        return [Message(SENSOR, time_ns, encode_text(sensor_text(self._configuration)))]

    def _described(self, block: Block) -> list[Message]:
        """Return the sensor's description anew where its range has changed."""
        sensor = self._configuration.sensor
        if block.range in (0.0, sensor.range):
            return []
        changed = self._configuration.model_copy(update={"sensor": sensor.model_copy(update={"range": block.range})})
        self._configuration = changed
        return [Message(SENSOR, block.stamp_ns, encode_text(sensor_text(changed)))]

    def encode(self, block: Block) -> list[Message]:
        """Return the messages of a block in the order of their times."""
        messages = self._described(block) + ([] if block.lost else self._waveform(block))
        messages += [Message(ROLLER_STATES, states.time_ns, encode_states(states, self._names)) for states in block.states]
        if self._configuration.publishing.contacts:
            messages += [Message(ROLLER_CONTACTS, states.time_ns, encode_contacts(states, self._names)) for states in block.states]
        messages += [Message(GROUND_TRUTH, truth.time_ns, encode_truth(truth)) for truth in block.truths]
        return sorted(messages, key=lambda message: message.time_ns)

    def _waveform(self, block: Block) -> list[Message]:
        """Return the messages that are made of a block's samples."""
        messages = [Message(VIBRATION, block.stamp_ns, encode_vibration(block, block.acceleration, self._frame))]
        if self._configuration.publishing.clean:
            messages.append(Message(VIBRATION_CLEAN, block.stamp_ns, encode_vibration(block, block.clean, self._frame)))
        messages.append(Message(FEATURES, block.stamp_ns, encode_features(block)))
        previews = zip(block.preview_ns, block.preview, strict=True)
        return messages + [Message(ACCELERATION, time_ns, encode_preview(time_ns, sample, self._frame)) for time_ns, sample in previews]


def _decoded(data: bytes, type_name: str) -> Any:
    try:
        return typestore().deserialize_cdr(data, type_name)
    except Exception as error:  # rosbags raises whatever its generated decoder runs into
        raise Refusal(f"a message of {len(data)} bytes is no valid {type_name}: {type(error).__name__}") from None


def decode_vibration(data: bytes) -> Vibration:
    """Return the waveform of a PointCloud2; without the field ``shaft_angle`` the angles are no numbers.

    Raises:
        Refusal: another layout than `SAMPLE`, or a length that does not fit the fields.
    """
    cloud = _decoded(data, POINT_CLOUD)
    found = [(field.name, field.offset, field.datatype, field.count) for field in cloud.fields]
    layout = next((kind for kind in (SAMPLE, UNTRACKED_SAMPLE) if found == _fields(kind) and cloud.point_step == kind.itemsize), None)
    if layout is None or cloud.is_bigendian or cloud.height != 1:
        raise Refusal(
            f"a PointCloud2 with the fields {[name for name, *_ in found]} is no waveform: it must have t, ax, ay and shaft_angle, "
            f"{SAMPLE.itemsize} bytes a sample, or {UNTRACKED_SAMPLE.itemsize} without shaft_angle, little endian, height 1"
        )
    if not 0 < cloud.width <= MOST_SAMPLES or len(cloud.data) != cloud.width * layout.itemsize:
        raise Refusal(
            f"a waveform block claims {cloud.width} samples in {len(cloud.data)} bytes; "
            f"each takes {layout.itemsize}, and {MOST_SAMPLES} are the most"
        )
    points = np.frombuffer(cloud.data.tobytes(), layout)
    acceleration = np.stack([points["ax"], points["ay"]], axis=1)
    angle = points["shaft_angle"].copy() if layout is SAMPLE else np.full(len(points), np.nan, np.float32)
    return Vibration(stamp_of(cloud.header), points["t"].copy(), acceleration, angle)


def _fields(kind: np.dtype[Any]) -> list[tuple[str, int, int, int]]:
    return [(name, entry[1], POINT_KINDS[entry[0].str], 1) for name, entry in (kind.fields or {}).items()]


def decode_waveform(messages: Sequence[bytes]) -> tuple[npt.NDArray[np.int64], Samples, Samples]:
    """Return the samples of blocks end to end: time [ns], acceleration [m/s^2] of shape (samples, 2), shaft angle [rad].

    Blocks of one length repeat their fields; reading those once is many times as fast.

    Raises:
        Refusal: as `decode_vibration`.
    """
    times, accelerations, angles = zip(*(_stretch(list(run)) for _, run in groupby(messages, len)), strict=True)
    return np.concatenate(times), np.concatenate(accelerations), np.concatenate(angles)


def _stretch(messages: Sequence[bytes]) -> tuple[npt.NDArray[np.int64], Samples, Samples]:
    """Return the samples of blocks whose messages have one length."""
    points = _repeated(messages, decode_vibration(messages[0]))
    if points is not None:
        time_ns = (stamps(messages)[:, None] + points["t"]).reshape(-1)
        acceleration = np.stack([points["ax"].reshape(-1), points["ay"].reshape(-1)], axis=1)
        return time_ns, acceleration, points["shaft_angle"].reshape(-1)
    blocks = [decode_vibration(data) for data in messages]
    found = [(block.stamp_ns + block.offsets_ns.astype(np.int64), block.acceleration, block.shaft_angle) for block in blocks]
    times, accelerations, angles = zip(*found, strict=True)
    return np.concatenate(times), np.concatenate(accelerations), np.concatenate(angles)


def _repeated(messages: Sequence[bytes], first: Vibration) -> npt.NDArray[Any] | None:
    """Return the samples of messages of one length, a row for each, where nothing but stamp and samples differs from the ``first``."""
    size = len(first.shaft_angle) * SAMPLE.itemsize
    rows = np.frombuffer(b"".join(messages), np.uint8).reshape(len(messages), -1)
    # Behind the samples, which begin at a multiple of four, one byte says that none is missing; up to three fill it up.
    begin = (rows.shape[1] - size - 1) // 4 * 4
    if begin < STAMP_END or not (rows[:, STAMP_END:begin] == rows[0, STAMP_END:begin]).all():
        return None
    points = np.ascontiguousarray(rows[:, begin : begin + size]).view(SAMPLE)
    as_read = [points["t"][0], points["ax"][0], points["ay"][0], points["shaft_angle"][0]]
    alike = map(np.array_equal, as_read, [first.offsets_ns, *first.acceleration.T, first.shaft_angle])
    return points if all(alike) else None


def decode_joints(data: bytes) -> Joints:
    """Return a JointState."""
    joints = _decoded(data, JOINT_STATE)
    return Joints(stamp_of(joints.header), tuple(joints.name), joints.position, joints.velocity, joints.effort)


def decode_alike(messages: Sequence[bytes]) -> Joints | None:
    """Return JointStates of one length, names and frame as one: every field has a row for each, ``stamp_ns`` the first stamp.

    A topic repeats its names in every message; reading them once is ten times as fast. None where the messages are not alike.
    """
    if not messages or len({len(data) for data in messages}) > 1:
        return None
    first = decode_joints(messages[0])
    counts = len(first.position), len(first.velocity), len(first.effort)
    rows = np.frombuffer(b"".join(messages), np.uint8).reshape(len(messages), -1)
    numbers: list[Floats] = []
    end = rows.shape[1]
    for count in reversed(counts):
        begin = end - 8 * count
        numbers.insert(0, np.ascontiguousarray(rows[:, begin:end]).view("<f8").reshape(len(messages), count))
        # The length before the numbers, and what aligns them to eight.
        end = begin - (8 if count else 4)
    names_end = rows.shape[1] - sum(8 * count for count in counts) - sum(8 if count else 4 for count in counts[1:])
    same = np.all(rows[:, 12:names_end] == rows[0, 12:names_end])
    found = [np.array_equal(own[0], array) for own, array in zip(numbers, (first.position, first.velocity, first.effort), strict=True)]
    return Joints(first.stamp_ns, first.names, *numbers) if same and all(found) else None


def stamps(messages: Sequence[bytes]) -> npt.NDArray[np.int64]:
    """Return the stamps of messages that begin with a header [ns]."""
    heads = np.frombuffer(b"".join(data[4:12] for data in messages), np.dtype([("sec", "<i4"), ("nanosec", "<u4")]))
    found: npt.NDArray[np.int64] = heads["sec"].astype(np.int64) * 1_000_000_000 + heads["nanosec"]
    return found


def decode_clock(data: bytes) -> int:
    """Return the time of a Clock [ns]."""
    clock = _decoded(data, "rosgraph_msgs/msg/Clock").clock
    return int(clock.sec) * 1_000_000_000 + int(clock.nanosec)


def decode_float(data: bytes) -> float:
    """Return the number of a Float64.

    Raises:
        Refusal: no such message.
    """
    return float(_decoded(data, "std_msgs/msg/Float64").data)


def decode_wrench(data: bytes) -> tuple[float, float]:
    """Return the force of a Wrench in X and Y [N].

    Raises:
        Refusal: no such message.
    """
    force = _decoded(data, "geometry_msgs/msg/Wrench").force
    return float(force.x), float(force.y)


def decode_text(data: bytes) -> str:
    """Return the text of a String."""
    return str(_decoded(data, "std_msgs/msg/String").data)


def decode_diagnostics(data: bytes) -> tuple[int, list[Status]]:
    """Return stamp [ns] and statuses of a DiagnosticArray."""
    array = _decoded(data, "diagnostic_msgs/msg/DiagnosticArray")
    statuses = [Status(s.name, int(s.level), s.message, {pair.key: pair.value for pair in s.values}) for s in array.status]
    return stamp_of(array.header), statuses


def decode_truth(data: bytes) -> Truth:
    """Return the ground truth that `encode_truth` wrote."""
    time_ns, statuses = decode_diagnostics(data)
    if not statuses or statuses[0].name != "operating":
        raise Refusal("a DiagnosticArray without the status 'operating' is no ground truth of the bench")
    operating, faults = statuses[0], [status for status in statuses if status.name.startswith("faults.")]
    background = next((status.values for status in statuses if status.name == "background"), {})

    def number(key: str) -> float:
        return float(operating.values.get(key, "nan"))

    frequencies = {name: number(f"{name} [Hz]") for name in ("FTF", "BPFO", "BPFI", "BSF")}
    found = {s.name.removeprefix("faults."): {key: float(value) for key, value in s.values.items()} for s in faults}
    load, levels = (number("load_x [N]"), number("load_y [N]")), {key: float(level) for key, level in background.items()}
    return Truth(time_ns, number("speed [rad/s]"), load, frequencies, found, operating.message, levels)


def encode_spectrum(time_ns: int, orders: Floats, amplitude: Floats, shaft_frequency: float) -> bytes:
    """Return an envelope spectrum as a PointCloud2 with frequency [Hz], order [-] and amplitude."""
    points = np.empty(len(orders), SPECTRUM)
    points["order"], points["amplitude"] = orders, amplitude
    points["frequency"] = orders * (shaft_frequency if math.isfinite(shaft_frequency) else 0.0)
    return encode_points(points, time_ns)


def decode_spectrum(data: bytes) -> tuple[int, Floats, Floats, float]:
    """Return stamp [ns], orders [-], amplitudes and shaft frequency [Hz] of an envelope spectrum.

    Raises:
        Refusal: another layout than `SPECTRUM`, or a length that does not fit the fields.
    """
    cloud = _decoded(data, POINT_CLOUD)
    names = tuple(field.name for field in cloud.fields)
    if names != SPECTRUM.names or cloud.point_step != SPECTRUM.itemsize or len(cloud.data) != cloud.width * SPECTRUM.itemsize:
        raise Refusal(f"a PointCloud2 with the fields {list(names)} is no envelope spectrum: it must have frequency, order and amplitude")
    points = np.frombuffer(cloud.data.tobytes(), SPECTRUM)
    orders, frequency = points["order"].astype(np.float64), points["frequency"].astype(np.float64)
    shaft_frequency = float(frequency[-1] / orders[-1]) if len(orders) and orders[-1] > 0.0 else 0.0
    return stamp_of(cloud.header), orders, points["amplitude"].astype(np.float64), shaft_frequency


def topic_of(name: str, topics: Iterable[Topic], namespace: str) -> Topic | None:
    """Return the topic that an absolute name belongs to, or none."""
    return next((topic for topic in topics if topic.resolved(namespace) == name), None)


INDICATORS = ("BPFO", "BPFI", "BSF", "FTF")
LEVELS = {"waiting": OK, "healthy": OK, "sensor": WARN}


def encode_diagnosis(diagnosis: Diagnosis) -> bytes:
    """Return the detector's verdict as a DiagnosticArray of one status; every fault is an error."""
    values = {
        "verdict": diagnosis.verdict,
        "confidence": f"{diagnosis.confidence:.3f}",
        "reason": diagnosis.reason,
        "shaft_frequency [Hz]": f"{diagnosis.shaft_frequency:.4f}",
        "gaps": str(diagnosis.gaps),
    }
    values |= {f"{name} [dB]": f"{diagnosis.levels.get(name, 0.0):.2f}" for name in INDICATORS}
    values |= {"severity [m/s^2]": f"{diagnosis.severity:.3f}", "trend [dB/min]": f"{diagnosis.trend:.2f}"}
    values |= {f"score {kind} [dB]": f"{score:.2f}" for kind, score in diagnosis.scores.items()}
    values |= {"score": f"{max(diagnosis.scores.values()):.2f}"} if diagnosis.scores else {}  # the exam's evidence for any fault
    values |= {"clipped": str(diagnosis.clipped), "remarks": "; ".join(diagnosis.remarks)}
    status = Status("fault_detector", LEVELS.get(diagnosis.verdict, ERROR), diagnosis.verdict, values)
    return encode_diagnostics(round(diagnosis.time * 1e9), [status])


def encode_indicators(diagnosis: Diagnosis) -> bytes:
    """Return the levels over background [dB] as a JointState."""
    levels, none = np.array([diagnosis.levels.get(name, 0.0) for name in INDICATORS]), np.zeros(0)
    return encode_joints(round(diagnosis.time * 1e9), INDICATORS, levels, none, none)


def diagnosis_messages(diagnosis: Diagnosis) -> list[Message]:
    """Return what the detector publishes of a diagnosis."""
    time_ns, (orders, amplitude) = round(diagnosis.time * 1e9), diagnosis.spectrum
    messages = [
        Message(DIAGNOSIS, time_ns, encode_diagnosis(diagnosis)),
        Message(FAULT_INDICATORS, time_ns, encode_indicators(diagnosis)),
    ]
    if len(orders):
        messages.append(Message(ENVELOPE_SPECTRUM, time_ns, encode_spectrum(time_ns, orders, amplitude, diagnosis.shaft_frequency)))
    return messages


def decode_sensor(data: bytes) -> tuple[int, Orders]:
    """Return sampling rate [Hz] and characteristic orders from the sensor's description.

    Raises:
        Refusal: no such description.
    """
    try:
        about = json.loads(decode_text(data))
        orders = {name: float(about["orders"][name]) for name in INDICATORS}
        rate = int(about["sampling_rate"])
    except (ValueError, KeyError, TypeError, OverflowError, RecursionError) as error:
        raise Refusal(
            f"the sensor's description is not understood ({type(error).__name__}): it must give sampling_rate and orders as JSON"
        ) from None
    if rate <= 0 or not all(math.isfinite(order) and order > 0.0 for order in orders.values()):
        raise Refusal(f"the sensor's description gives {rate} Hz and orders {orders}: both must be positive")
    return rate, Orders(orders["FTF"], orders["BPFO"], orders["BPFI"], orders["BSF"])


def decode_range(data: bytes) -> float:
    """Return the range from the sensor's description [m/s^2], 0 where it does not say."""
    try:
        found = float(json.loads(decode_text(data)).get("range", 0.0))
    except (ValueError, TypeError, AttributeError, OverflowError, RecursionError):
        return 0.0
    return found if math.isfinite(found) and found > 0.0 else 0.0
