"""PointCloud2 messages: the waveform and the squared envelope spectrum, one field per quantity."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from dcrb_ros.messages.cdr import FRAME, POINT_CLOUD, TEMPLATES, decoded, encoded, header, ros_type, stamp_of
from dcrb_ros.messages.message_template import MessageTemplate, placeholder_bytes
from dcrb_ros.schema.arrays import Floats, Samples
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.stream.axes import AXES
from dcrb_ros.stream.block import Block


def sample_type(axes: int, *, tracked: bool = True) -> np.dtype[Any]:
    """Return the fields of a sample with two or three axes, with or without a shaft angle."""
    angle = [("shaft_angle", "<f4")] if tracked else []
    return np.dtype([("t", "<u4"), *((name, "<f4") for name in AXES[:axes]), *angle])


SAMPLE, UNTRACKED_SAMPLE = sample_type(2), sample_type(2, tracked=False)
LAYOUTS = (SAMPLE, UNTRACKED_SAMPLE, sample_type(3), sample_type(3, tracked=False))
SPECTRUM = np.dtype([("frequency", "<f4"), ("order", "<f4"), ("amplitude", "<f4")])
UINT32, FLOAT32 = 6, 7  # sensor_msgs/msg/PointField
POINT_KINDS = {"<u4": UINT32, "<f4": FLOAT32}
MOST_SAMPLES = 1 << 20
"""Most samples accepted in a message."""
WAVEFORM = (
    f"is not a waveform: it must have t, ax, ay and shaft_angle, {SAMPLE.itemsize} bytes a sample, or {UNTRACKED_SAMPLE.itemsize} without "
    "shaft_angle, with az after ay four more"
)
LINES = f"is not a squared envelope spectrum: it must have frequency, order and amplitude as float32, {SPECTRUM.itemsize} bytes a line"
"""Fields of the two kinds of messages, in the words of a refusal."""


def index_at(time_ns: int, rate: int) -> int:
    """Return the index of the sample at a simulated time [ns]: the time times the sampling rate [Hz], rounded."""
    return (time_ns * rate + 500_000_000) // 1_000_000_000


@dataclass(frozen=True)
class Vibration:
    """A block of the waveform, decoded from a message."""

    stamp_ns: int
    """Simulated time of the first sample [ns]."""
    offsets_ns: npt.NDArray[np.uint32]
    """Time of each sample after the stamp [ns]."""
    acceleration: Samples
    """Shape (samples, axes) [m/s^2]."""
    shaft_angle: Samples
    """Wrapped to [0, 2 pi) [rad]."""

    def first_index(self, rate: int) -> int:
        """Return the index of the first sample at a sampling rate [Hz]: its time times the rate, rounded."""
        return index_at(self.stamp_ns, rate)

    def packed(self) -> bytes:
        """Return the samples as `packed` does."""
        return packed(self.acceleration, self.shaft_angle)


def packed(acceleration: Samples, shaft_angle: Samples) -> bytes:
    """Return ax, ay, az if there is one, and shaft angle of every sample as little-endian float32; a recording states their hash."""
    return np.column_stack([acceleration, shaft_angle]).astype("<f4", copy=False).tobytes()


def encode_points(points: npt.NDArray[Any], time_ns: int, frame: str = FRAME) -> bytes:
    """Return structured points, shape (points,), as a PointCloud2."""
    return _points_template(points.dtype, len(points), frame).filled(time_ns, points.tobytes())


@lru_cache(TEMPLATES)
def _points_template(kind: np.dtype[Any], count: int, frame: str) -> MessageTemplate:
    point_type, placeholder = ros_type("sensor_msgs/msg/PointField"), placeholder_bytes(kind.itemsize * count)
    fields = [point_type(*field) for field in fields_of(kind)]
    raw = np.frombuffer(placeholder, np.uint8)
    cloud = ros_type(POINT_CLOUD)(header(0, frame), 1, count, fields, False, kind.itemsize, kind.itemsize * count, raw, True)
    return MessageTemplate(encoded(POINT_CLOUD, cloud), placeholder)


def encode_vibration(block: Block, acceleration: Samples, frame: str = FRAME) -> bytes:
    """Return the waveform of a block of two or three axes as a PointCloud2 with the fields of `sample_type`."""
    return encode_waveform(block.index, block.rate, acceleration, block.shaft_angle, frame)


def encode_waveform(index: int, rate: int, acceleration: Samples, shaft_angle: npt.NDArray[Any], frame: str = FRAME) -> bytes:
    """Return samples from an ``index`` on at a ``rate`` [Hz] as a PointCloud2 with the fields of `sample_type`."""
    points = np.empty(len(acceleration), sample_type(acceleration.shape[1]))
    # The stamp is rounded down to nanoseconds; the times of the other samples include the remainder.
    stamp_ns, lost = divmod(index * 1_000_000_000, rate)
    points["t"] = (lost + np.arange(len(acceleration), dtype=np.int64) * 1_000_000_000) // rate
    for name, column in zip(AXES, acceleration.T, strict=False):
        points[name] = column
    points["shaft_angle"] = shaft_angle
    return encode_points(points, stamp_ns, frame)


def decode_cloud(
    data: bytes, layouts: Sequence[np.dtype[Any]], wanted: str, block: str, points: str, least: int = 0
) -> tuple[int, npt.NDArray[Any]]:
    """Return stamp [ns] and points, shape (points,), of a PointCloud2 that has the fields of one of ``layouts``.

    Raises:
        Refusal: no such message, one with other fields than ``wanted``, or a ``block`` without ``least`` to `MOST_SAMPLES` ``points``.
    """
    cloud = decoded(data, POINT_CLOUD)
    fields = [(field.name, field.offset, field.datatype, field.count) for field in cloud.fields]
    layout = next((kind for kind in layouts if fields == fields_of(kind) and cloud.point_step == kind.itemsize), None)
    if layout is None or cloud.is_bigendian or cloud.height != 1:
        raise Refusal(f"a PointCloud2 with the fields {[name for name, *_ in fields]} {wanted}; little endian, height 1")
    if not least <= cloud.width <= MOST_SAMPLES or len(cloud.data) != cloud.width * layout.itemsize:
        raise Refusal(
            f"{block} declares {cloud.width} {points} in {len(cloud.data)} bytes: it must have {layout.itemsize} bytes per "
            f"{points.removesuffix('s')} and {least} to {MOST_SAMPLES} {points}"
        )
    return stamp_of(cloud.header), np.frombuffer(cloud.data.tobytes(), layout)


def decode_vibration(data: bytes) -> Vibration:
    """Return the waveform of a PointCloud2; without the field ``shaft_angle`` the angles are NaN.

    Raises:
        Refusal: the fields are not those of `sample_type`, or the length does not fit them.
    """
    stamp_ns, points = decode_cloud(data, LAYOUTS, WAVEFORM, "a waveform block", "samples", 1)
    names = points.dtype.names or ()
    angle = points["shaft_angle"].copy() if "shaft_angle" in names else np.full(len(points), np.nan, np.float32)
    return Vibration(stamp_ns, points["t"].copy(), np.stack([points[name] for name in AXES if name in names], axis=1), angle)


def fields_of(kind: np.dtype[Any]) -> list[tuple[str, int, int, int]]:
    """Return name, offset, kind and count of each field of structured points, as in a PointField."""
    return [(name, entry[1], POINT_KINDS[entry[0].str], 1) for name, entry in (kind.fields or {}).items()]


def decode_waveform(messages: Sequence[bytes]) -> tuple[npt.NDArray[np.int64], Samples, Samples]:
    """Return the samples of consecutive blocks: time [ns], acceleration [m/s^2] of shape (samples, axes), shaft angle [rad].

    Raises:
        Refusal: as `decode_vibration`, or blocks differ in their axes.
    """
    blocks = [decode_vibration(data) for data in messages]
    check_axes(block.acceleration for block in blocks)
    times = np.concatenate([block.stamp_ns + block.offsets_ns.astype(np.int64) for block in blocks])
    return times, np.concatenate([block.acceleration for block in blocks]), np.concatenate([block.shaft_angle for block in blocks])


def check_axes(accelerations: Iterable[Samples]) -> None:
    """Refuse the accelerations of blocks, each of shape (samples, axes), that differ in their axes."""
    if len({acceleration.shape[1] for acceleration in accelerations}) > 1:
        raise Refusal("blocks of a waveform have two and three axes: publish the same fields in all of them")


def encode_spectrum(time_ns: int, orders: Floats, amplitude: Floats, shaft_frequency: float, frame: str = FRAME) -> bytes:
    """Return a PointCloud2 with frequency [Hz], order [-] and the square root of the squared envelope spectrum's amplitudes [m/s^2]."""
    points = np.empty(len(orders), SPECTRUM)
    points["order"], points["amplitude"] = orders, amplitude
    points["frequency"] = orders * (shaft_frequency if math.isfinite(shaft_frequency) else 0.0)
    return encode_points(points, time_ns, frame)


def decode_spectrum(data: bytes) -> tuple[int, Floats, Floats, float]:
    """Return stamp [ns], orders [-], square roots of the amplitudes [m/s^2] and shaft frequency [Hz] of a squared envelope spectrum.

    Raises:
        Refusal: the fields are not those of `SPECTRUM`, the length does not fit them, or the orders are not finite and increasing.
    """
    stamp_ns, points = decode_cloud(data, [SPECTRUM], LINES, "a squared envelope spectrum", "lines")
    orders, frequency = points["order"].astype(np.float64), points["frequency"].astype(np.float64)
    if not (np.isfinite(orders).all() and (np.diff(orders) >= 0.0).all()):
        raise Refusal("the orders of a squared envelope spectrum are not finite and increasing: publish its lines sorted by order")
    shaft_frequency = float(frequency[-1] / orders[-1]) if len(orders) and orders[-1] > 0.0 else 0.0
    return stamp_ns, orders, points["amplitude"].astype(np.float64), shaft_frequency
