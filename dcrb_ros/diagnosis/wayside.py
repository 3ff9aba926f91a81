"""A wayside hot-box detector: it reads passing axle boxes every few kilometres and judges by two fixed rules.

It measures the box with a part of the bearing behind it, reads T_BOX + 0.15 (T_OR - T_BOX) with an error of emissivity over the ambient
temperature, and noise. It alarms where a box is 94.4 K (170 F) above ambient, or 52.8 K (95 F) above the other box of the axle: the
conventional North American settings (University of Texas Rio Grande Valley, scholarworks.utrgv.edu/me_fac/185). Of a train it reads all
boxes, and judges by the rules of `dcrb_ros.diagnosis.hot_boxes`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from dcrb_ros.diagnosis.hot_boxes import HotBox, HotBoxParameters, hot_boxes
from dcrb_ros.measurement.random_streams import random_stream
from dcrb_ros.schema.fields import Group, quantity

RING_SHARE = 0.15
"""Share of the outer ring's excess over the box that the detector measures [-] (a choice)."""
KILOMETRE = 1e3
"""[m]"""


class WaysideParameters(Group):
    """A line of wayside detectors and their rules."""

    spacing: float = quantity(30.0, "km", "Distance between two detectors; lines have one every 20 to 40 km", 0.01, 1000.0)
    first: float = quantity(0.0, "km", "Distance to the first detector; 0 for the spacing", 0.0, 1000.0)
    noise: float = quantity(3.0, "K", "Standard deviation of a reading", 0.0, 100.0)
    emissivity_error: float = quantity(
        0.0, "-", "Relative error of a reading above ambient; below zero where the box radiates less than assumed", -0.9, 1.0
    )
    above_ambient: float = quantity(94.4, "K", "Excess over ambient that is a hot box", 1.0, 500.0)
    above_opposite: float = quantity(52.8, "K", "Excess over the other box of the axle that is a hot box", 1.0, 500.0)
    wheel_diameter: float = quantity(0.92, "m", "Diameter of the wheels on the shaft", 0.05, 5.0, symbol="D")
    seed: int = quantity(1, "-", "Seed of the noise", 0, 2**31 - 1)


@dataclass(frozen=True)
class AxleBoxes:
    """What a detector looks at: a box with its bearing, and the healthy one across the axle [deg C]."""

    box: float
    outer_ring: float
    opposite_box: float
    opposite_outer_ring: float
    ambient: float


@dataclass(frozen=True)
class Passage:
    """A reading of a detector."""

    time_ns: int
    """Simulated time [ns]."""
    distance: float
    """Since the start [km]."""
    reading: float
    """[deg C]"""
    opposite: float
    """Of the other box of the axle [deg C]."""
    ambient: float
    """[deg C]"""
    over_ambient: bool
    """Whether the box is hot by the first rule."""
    over_opposite: bool
    """Whether it is hot by the second one."""

    @property
    def alarm(self) -> bool:
        """Whether the box is hot."""
        return self.over_ambient or self.over_opposite

    @property
    def reason(self) -> str:
        """The reading in words."""
        above, across = self.reading - self.ambient, self.reading - self.opposite
        return f"{self.reading:.0f} deg C, {above:.0f} K above ambient, {across:.0f} K above the other box"


class Box(NamedTuple):
    """A box of a train with its bearing [deg C]."""

    box: float
    outer_ring: float


@dataclass(frozen=True)
class TrainPassage:
    """The readings of all boxes of a train at a detector."""

    time_ns: int
    """Simulated time [ns]."""
    distance: float
    """Since the start [km]."""
    readings: Mapping[str, float]
    """Of each box [deg C]."""
    ambient: float
    """[deg C]"""
    hot: tuple[HotBox, ...]
    """Boxes that break a rule."""


class Wayside:
    """Follows a vehicle, and reads its axle box wherever it passes a detector."""

    def __init__(self, parameters: WaysideParameters, box: str = "") -> None:
        """Begin a run; the noise depends on the seed and on ``box``, the name of the axle box where there are several."""
        self._p = parameters
        self._random = random_stream(parameters.seed, f"wayside detector{box}")
        self._distance, self._passed = 0.0, 0
        self._before_ns: int | None = None

    def follow(self, time_ns: int, speed: float, boxes: AxleBoxes, acceleration: float = 1.0) -> Passage | None:
        """Return the reading at a detector that was passed since the call before, None where there was none.

        ``speed`` is that of the shaft [rad/s] since then. With a time lapse the vehicle covers more distance in the time of the heat, which
        ``acceleration`` multiplies. A vehicle that passes several at once is read once, by the last.
        """
        p = self._p
        if not self._passes(time_ns, 0.5 * p.wheel_diameter * speed, acceleration):
            return None
        reading, opposite = (
            self._read(box, ring, boxes.ambient)
            for box, ring in ((boxes.box, boxes.outer_ring), (boxes.opposite_box, boxes.opposite_outer_ring))
        )
        hot = reading - boxes.ambient > p.above_ambient, reading - opposite > p.above_opposite
        return Passage(time_ns, self._distance, reading, opposite, boxes.ambient, *hot)

    def follow_train(
        self, time_ns: int, speed: float, boxes: Mapping[str, Box], ambient: float, rules: HotBoxParameters, acceleration: float = 1.0
    ) -> TrainPassage | None:
        """Return the readings of all ``boxes`` by name at a detector that was passed, as `follow`, at a speed of the vehicle [m/s]."""
        if not self._passes(time_ns, speed, acceleration):
            return None
        readings = {name: self._read(box.box, box.outer_ring, ambient) for name, box in boxes.items()}
        return TrainPassage(time_ns, self._distance, readings, ambient, tuple(hot_boxes(readings, ambient, speed, rules)))

    def _passes(self, time_ns: int, speed: float, acceleration: float) -> bool:
        """Return whether a vehicle at a speed [m/s] passed a detector since the call before."""
        p, passed_s = self._p, 0.0 if self._before_ns is None else 1e-9 * (time_ns - self._before_ns)
        self._before_ns = time_ns
        self._distance += abs(speed) * max(passed_s, 0.0) * acceleration / KILOMETRE
        before_first = self._distance - (p.first or p.spacing)
        passed = 0 if before_first < 0.0 else 1 + int(before_first / p.spacing)
        before, self._passed = self._passed, passed
        return passed != before

    def _read(self, box: float, ring: float, ambient: float) -> float:
        """Return the reading of a box [deg C]."""
        seen = box + RING_SHARE * (ring - box)
        return float(seen + self._p.emissivity_error * (seen - ambient) + self._p.noise * self._random.standard_normal())
