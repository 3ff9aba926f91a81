"""The shipped detector beside wayside detectors on the same axles: alarms in healthy days, and lead times before hot boxes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from dcrb_ros.diagnosis.heat_monitor import HeatMonitor
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.registry import HEAT_RULES
from dcrb_ros.diagnosis.wayside import AxleBoxes, Wayside, WaysideParameters
from dcrb_ros.exam.hot_boxes.fleet import DAY, STEP, Fleet, Growth, Temperatures
from dcrb_ros.exam.hot_boxes.heat_table import HeatTable
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.verdicts import Trouble


@dataclass(frozen=True)
class Alarm:
    """The first alarm of a detector of one box, or one of several."""

    time: float
    """[s]"""
    verdict: Trouble
    residual: float
    """Excess over the expected temperature [K]."""


@dataclass(frozen=True)
class Watched:
    """What the detector of one box said."""

    alarms: list[Alarm]
    """Each when it was raised."""
    most: float
    """Largest departure above the expected temperature, in standard deviations [-]."""
    least: float
    """The same below it."""


@dataclass(frozen=True)
class Outcome:
    """An axle with a fault of its first box."""

    onset: float
    """[s]"""
    early: bool
    """Whether an alarm stood or was raised before the onset."""
    detector: Alarm | None
    """First alarm of the detector after the onset."""
    wayside: float
    """Time of the first alarm of a wayside detector after the onset [s]; infinite without one."""
    hottest: float
    """Largest rise of the box above ambient [K]."""

    @property
    def lead(self) -> float:
        """Time by which the detector was earlier [s]; minus infinity without its alarm."""
        return self.wayside - self.detector.time if self.detector is not None else -math.inf


def monitor(parameters: DetectorParameters) -> HeatMonitor:
    """Return the part of the shipped detector that judges temperatures."""
    p: Any = parameters
    return HeatMonitor(p, [rule(p) for rule in HEAT_RULES], p.release_margin)


def watched(parameters: DetectorParameters, speed: Floats, ring: Floats, air: Floats) -> Watched:
    """Return what the detector of a box says about readings, shape (steps,) [rad/s], [deg C]."""
    judge, alarms, standing = monitor(parameters), [], ""
    most = least = 0.0
    rows = zip((speed / (2.0 * math.pi)).tolist(), ring.tolist(), air.tolist(), strict=True)
    for k, (frequency, one, ambient) in enumerate(rows):
        found = judge.update(k * STEP, frequency, one, ambient)
        if found is None:
            continue
        departure = found.evidence.residual / found.evidence.deviation
        most, least = max(most, departure), min(least, departure)
        verdict = next(iter(found.confirmed), None)
        if verdict is not None and not standing:
            alarms.append(Alarm(k * STEP, verdict, found.evidence.residual))
        standing = verdict or ""
    return Watched(alarms, most, least)


def healthy_days(fleet: Fleet, table: HeatTable, parameters: DetectorParameters) -> tuple[list[Watched], int]:
    """Return what the detectors of both boxes of each axle say about healthy days, two in turn for each axle.

    The second value is the number of axles whose first box a wayside detector finds hot.
    """
    truth = fleet.temperatures(table)
    ring, air = fleet.readings(truth)
    found = [watched(parameters, fleet.duty.speed[:, k], ring[:, k, side], air[:, k]) for k in range(fleet.axles) for side in (0, 1)]
    return found, sum(wayside_alarm(fleet, truth, k, 0.0, WaysideParameters()) < math.inf for k in range(fleet.axles))


def drawn_growth(fleet: Fleet, last: float, shortest: float, longest: float) -> Growth:
    """Return growths that begin on the second day, with durations between two [s], evenly by their logarithm."""
    random = np.random.default_rng(fleet.seed)
    onset = DAY * (1.0 + random.random(fleet.axles))
    return Growth(onset, np.exp(random.uniform(math.log(shortest), math.log(longest), fleet.axles)), last)


def faulty_days(
    fleet: Fleet, table: HeatTable, growth: Growth, parameters: DetectorParameters, line: WaysideParameters | None = None
) -> list[Outcome]:
    """Return the outcomes of all axles whose first box gets a fault."""
    truth = fleet.temperatures(table, growth)
    ring, air = fleet.readings(truth)
    found = []
    for k in range(fleet.axles):
        onset = float(growth.onset[k])
        alarms = watched(parameters, fleet.duty.speed[:, k], ring[:, k, 0], air[:, k]).alarms
        early = any(alarm.time < onset for alarm in alarms)
        first = next((alarm for alarm in alarms if alarm.time >= onset), None)
        rise = float((truth.box[:, k, 0] - fleet.duty.ambient[:, k]).max())
        found.append(Outcome(onset, early, first, wayside_alarm(fleet, truth, k, onset, line or WaysideParameters()), rise))
    return found


def wayside_alarm(fleet: Fleet, truth: Temperatures, axle: int, onset: float, line: WaysideParameters) -> float:
    """Return when a wayside detector first finds the first box of an axle hot after an onset [s]; infinite if none does."""
    chosen = line.model_copy(update={"seed": (fleet.seed * 100_003 + axle) % 2**31})
    along = Wayside(chosen)
    boxes, rings, air = truth.box[:, axle].tolist(), truth.outer_ring[:, axle].tolist(), fleet.duty.ambient[:, axle].tolist()
    for k, speed in enumerate(fleet.duty.speed[:, axle].tolist()):
        seen = AxleBoxes(boxes[k][0], rings[k][0], boxes[k][1], rings[k][1], air[k])
        passage = along.follow(round(k * STEP * 1e9), speed, seen)
        if passage is not None and passage.alarm and k * STEP >= onset:
            return k * STEP
    return math.inf
