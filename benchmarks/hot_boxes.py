"""The shipped detector beside wayside hot-box detectors: false alarms in healthy days of axles, and lead times before hot boxes.

    python benchmarks/hot_boxes.py --healthy 40 --faulty 200 --figure hot-boxes.png

Nothing vibrates: temperatures come from the thermal network between tables of quasi-steady heat (`hot_box_heat.py`). A thousand
healthy axle-days take two minutes of one core. Seeds from 1000 on chose the thresholds; the figures are of seeds from 1 on.
"""

from __future__ import annotations

import argparse
import itertools
import json
import math
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from hot_box_fleet import DAY, STEP, Fleet, Growth, Temperatures
from hot_box_heat import Fault, HeatTable, heat_table
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.stats import quantile_test

from dcrb_ros.diagnosis.heat_monitor import HeatMonitor
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.registry import HEAT_RULES
from dcrb_ros.diagnosis.wayside import AxleBoxes, Wayside, WaysideParameters
from dcrb_ros.exam.statistics import rate
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.files import load_configuration

AXLES, DAYS = 20, 5
"""Axles of a healthy fleet and the days that they run."""
LAST: dict[Fault, float] = {"loss": 1.0, "clearance": 1.5e-4}
"""Last size of each fault."""
SHORTEST, LONGEST = 3600.0, 8.0 * 3600.0
"""Shortest and longest growth of a fault [s]; durations are drawn evenly by their logarithm."""
TITLES: dict[Fault, str] = {"loss": "loss of lubricant", "clearance": "loss of clearance"}

Alarm = tuple[float, str]
"""Time [s] and verdict of an alarm of the detector of one box."""


class Outcome(NamedTuple):
    """An axle with a fault of its first box."""

    early: bool
    """Whether an alarm was raised before the onset."""
    detector: Alarm | None
    """First alarm of the detector after the onset."""
    wayside: float
    """Time of the first alarm of a wayside detector after the onset [s]; infinite without one."""

    @property
    def lead(self) -> float:
        """Time by which the detector was earlier [s]; minus infinity without its alarm."""
        return self.wayside - self.detector[0] if self.detector is not None else -math.inf


def detector_alarms(speed: Floats, ring: Floats, air: Floats) -> list[Alarm]:
    """Return the alarms of the detector of a box for readings of shape (steps,) [rad/s], [deg C]."""
    p: Any = DetectorParameters()
    monitor, alarms, current = HeatMonitor(p, [rule(p) for rule in HEAT_RULES], p.release_margin), list[Alarm](), ""
    readings = zip((speed / (2.0 * math.pi)).tolist(), ring.tolist(), air.tolist(), strict=True)
    for k, reading in enumerate(readings):
        heat = monitor.update(k * STEP, *reading)
        if heat is not None:
            before, current = current, heat.confirmed.trouble if heat.confirmed else ""
            if current and not before:
                alarms.append((k * STEP, current))
    return alarms


def wayside_alarm(fleet: Fleet, truth: Temperatures, axle: int, onset: float, side: int = 0) -> float:
    """Return when a wayside detector first finds the box at a side of an axle hot after an onset [s]; infinite if none does."""
    wayside = Wayside(WaysideParameters(seed=(fleet.seed * 100_003 + axle) % 2**31))
    boxes, rings, air = truth.box[:, axle].tolist(), truth.outer_ring[:, axle].tolist(), fleet.duty.ambient[:, axle].tolist()
    for k, speed in enumerate(fleet.duty.speed[:, axle].tolist()):
        axle_boxes = AxleBoxes(boxes[k][side], rings[k][side], boxes[k][1 - side], rings[k][1 - side], air[k])
        passage = wayside.follow(round(k * STEP * 1e9), speed, axle_boxes)
        if passage is not None and passage.alarm and k * STEP >= onset:
            return k * STEP
    return math.inf


def table_of(fault: Fault) -> HeatTable:
    """Return the heat of the greased bench with a thermal network."""
    return heat_table(load_configuration("healthy", {"thermal.law": "network"}), fault)


def healthy_fleet(seed: int) -> tuple[list[tuple[int, float, str]], int]:
    """Return the alarms of a healthy fleet, each with the number of its box, and how many boxes are hot by the wayside."""
    fleet = Fleet(AXLES, DAYS, seed)
    truth = fleet.temperatures(table_of("loss"))
    ring, air = fleet.readings(truth)
    alarms = [
        (box, *alarm)
        for box, (k, side) in enumerate(itertools.product(range(AXLES), (0, 1)))
        for alarm in detector_alarms(fleet.duty.speed[:, k], ring[:, k, side], air[:, k])
    ]
    return alarms, sum(wayside_alarm(fleet, truth, k, 0.0, side) < math.inf for k in range(AXLES) for side in (0, 1))


def faulty_fleet(fault: Fault, axles: int, seed: int) -> list[Outcome]:
    """Return what happened to axles with a fault of their first box that begins on the second day."""
    fleet, random = Fleet(axles, 4, seed), np.random.default_rng(seed)
    onset = DAY * (1.0 + random.random(axles))
    duration = np.exp(random.uniform(math.log(SHORTEST), math.log(LONGEST), axles))
    truth = fleet.temperatures(table_of(fault), Growth(onset, duration, LAST[fault]))
    ring, air = fleet.readings(truth)
    outcomes = []
    for k, begin in enumerate(onset.tolist()):
        alarms = detector_alarms(fleet.duty.speed[:, k], ring[:, k, 0], air[:, k])
        first = next((alarm for alarm in alarms if alarm[0] >= begin), None)
        outcomes.append(Outcome(any(time < begin for time, _ in alarms), first, wayside_alarm(fleet, truth, k, begin)))
    return outcomes


def summary(outcomes: list[Outcome]) -> dict[str, Any]:
    """Return the figures of one kind of fault."""
    hot = [outcome for outcome in outcomes if outcome.wayside < math.inf]
    lead = np.array([outcome.lead for outcome in hot]) / 60.0
    bounds: Any = quantile_test(lead, p=0.5).confidence_interval(0.95)
    names = [outcome.detector[1] for outcome in outcomes if outcome.detector is not None]
    return {
        "axles": len(outcomes),
        "found": len(names),
        "found_by_wayside": len(hot),
        "earlier": int((lead > 0.0).sum()),
        "lead_median": float(np.median(lead)),
        "lead_median_interval": [float(bounds.low), float(bounds.high)],
        "lead_percentiles": {str(p): float(np.percentile(lead, p, method="lower")) for p in (5, 95)},
        "names": {name: names.count(name) for name in ("lubrication", "overheating")},
        "alarm_before_onset": sum(outcome.early for outcome in outcomes),
    }


def picture(outcomes: dict[Fault, list[Outcome]], file: Path) -> None:
    """Plot the share of hot boxes over the lead time."""
    figure = Figure(figsize=(8.0, 4.0), layout="constrained")
    axes: Axes = figure.subplots()
    for fault, colour in zip(outcomes, ("tab:blue", "tab:red"), strict=True):
        lead = np.sort([outcome.lead / 60.0 for outcome in outcomes[fault] if outcome.wayside < math.inf])
        share = 1.0 - np.arange(len(lead)) / len(lead)
        band = math.sqrt(math.log(2.0 / 0.05) / (2.0 * len(lead)))
        axes.step(lead, share, where="post", color=colour, label=f"{TITLES[fault]}, {len(lead)} axles")
        axes.fill_between(lead, np.clip(share - band, 0, 1), np.clip(share + band, 0, 1), step="post", color=colour, alpha=0.15, lw=0)
    axes.set_xscale("symlog", linthresh=10.0, linscale=0.5)
    ticks = [-10, 0, 10, 30, 60, 120, 240, 480, 960]
    axes.set_xticks(ticks, labels=[str(tick) for tick in ticks])
    axes.minorticks_off()
    axes.axvline(0.0, color="black", lw=0.8)
    axes.set(xlabel="lead of the detector over the wayside rule [min]", ylabel="share of hot boxes with that lead or more", ylim=(0, 1.02))
    axes.set_title("Hot boxes that a wayside detector finds; 95 % bands (Dvoretzky, Kiefer and Wolfowitz)")
    axes.grid(alpha=0.3)
    axes.legend()
    figure.savefig(file, dpi=100)


def main() -> None:
    """Run both trials, print the figures as JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--healthy", type=int, default=40, help=f"healthy fleets of {AXLES * DAYS} axle-days")
    parser.add_argument("--faulty", type=int, default=200, help="axles with each kind of fault")
    parser.add_argument("--seed", type=int, default=1, help="first seed")
    parser.add_argument("--workers", type=int, default=1, help="processes")
    parser.add_argument("--figure", type=Path, help="file for the picture")
    given = parser.parse_args()
    with ProcessPoolExecutor(given.workers) as pool:
        fleets = list(pool.map(healthy_fleet, range(given.seed, given.seed + given.healthy)))
        outcomes = pool.map(partial(faulty_fleet, axles=given.faulty, seed=given.seed + 500), TITLES)
        faulty = dict(zip(TITLES, outcomes, strict=True))
    days, alarms = len(fleets) * AXLES * DAYS, [alarm for alarms, _ in fleets for alarm in alarms]
    healthy = {
        "axle_days": days,
        "false_alarms": len(alarms),
        "per_1000_axle_days": list(rate(len(alarms), days / 1000.0)),
        "alarms": alarms,
        "wayside_alarms": sum(hot for _, hot in fleets),
    }
    print(json.dumps({"healthy": healthy, **{fault: summary(outcomes) for fault, outcomes in faulty.items()}}, indent=2))
    if given.figure is not None:
        picture(faulty, given.figure)


if __name__ == "__main__":
    main()
