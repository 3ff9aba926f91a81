"""The shipped detector beside wayside hot-box detectors: false alarms in healthy days of axles, and lead times before hot boxes.

    python benchmarks/hot_boxes.py --healthy 40 --faulty 200 --figure hot-boxes.png

Nothing vibrates: temperatures come from the thermal network between tables of quasi-steady heat (`hot_box_heat.py`). A thousand
healthy axle-days take two minutes of one core. Seeds from 1000 on chose the thresholds; the figures are of seeds from 1 on.
"""

from __future__ import annotations

import argparse
import json
import math
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from hot_box_fleet import DAY, STEP, Fleet, Growth, Temperatures
from hot_box_heat import Fault, HeatTable, heat_table
from scipy.stats import quantile_test

import dcrb_ros
from dcrb_ros.diagnosis.heat_monitor import HeatMonitor
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.registry import HEAT_RULES
from dcrb_ros.diagnosis.wayside import AxleBoxes, Wayside, WaysideParameters
from dcrb_ros.exam.statistics import rate
from dcrb_ros.schema.arrays import Floats

AXLES, DAYS = 20, 5
"""Axles of a healthy fleet and the days that they run."""
LAST: dict[Fault, float] = {"loss": 1.0, "clearance": 1.5e-4}
"""Last size of each fault."""
SHORTEST, LONGEST = 3600.0, 8.0 * 3600.0
"""Of the growth of a fault [s]."""
TITLES: dict[Fault, str] = {"loss": "loss of lubricant", "clearance": "loss of clearance"}


class Alarm(NamedTuple):
    """An alarm of the detector of one box."""

    time: float
    """[s]"""
    verdict: str


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
        return self.wayside - self.detector.time if self.detector is not None else -math.inf


def watched(parameters: DetectorParameters, speed: Floats, ring: Floats, air: Floats) -> list[Alarm]:
    """Return the alarms of the detector of a box for readings of shape (steps,) [rad/s], [deg C]."""
    p: Any = parameters
    monitor, alarms, current = HeatMonitor(p, [rule(p) for rule in HEAT_RULES], p.release_margin), [], ""
    rows = zip((speed / (2.0 * math.pi)).tolist(), ring.tolist(), air.tolist(), strict=True)
    for k, (frequency, outer_ring, ambient) in enumerate(rows):
        heat = monitor.update(k * STEP, frequency, outer_ring, ambient)
        if heat is None:
            continue
        verdict = next(iter(heat.confirmed), "")
        if verdict and not current:
            alarms.append(Alarm(k * STEP, verdict))
        current = verdict
    return alarms


def healthy_days(fleet: Fleet, table: HeatTable, parameters: DetectorParameters) -> tuple[list[list[Alarm]], int]:
    """Return the alarms of each box, of one axle after the other, and the number of axles whose first box a wayside detector finds hot."""
    truth = fleet.temperatures(table)
    ring, air = fleet.readings(truth)
    boxes = [watched(parameters, fleet.duty.speed[:, k], ring[:, k, side], air[:, k]) for k in range(fleet.axles) for side in (0, 1)]
    return boxes, sum(wayside_alarm(fleet, truth, k, 0.0) < math.inf for k in range(fleet.axles))


def drawn_growth(fleet: Fleet, last: float, shortest: float, longest: float) -> Growth:
    """Return growths that begin on the second day, with durations between two [s], evenly by their logarithm."""
    random = np.random.default_rng(fleet.seed)
    onset = DAY * (1.0 + random.random(fleet.axles))
    return Growth(onset, np.exp(random.uniform(math.log(shortest), math.log(longest), fleet.axles)), last)


def faulty_days(fleet: Fleet, table: HeatTable, growth: Growth, parameters: DetectorParameters) -> list[Outcome]:
    """Return the outcomes of all axles whose first box gets a fault."""
    truth = fleet.temperatures(table, growth)
    ring, air = fleet.readings(truth)
    outcomes = []
    for k in range(fleet.axles):
        onset = float(growth.onset[k])
        alarms = watched(parameters, fleet.duty.speed[:, k], ring[:, k, 0], air[:, k])
        early = any(alarm.time < onset for alarm in alarms)
        first = next((alarm for alarm in alarms if alarm.time >= onset), None)
        outcomes.append(Outcome(early, first, wayside_alarm(fleet, truth, k, onset)))
    return outcomes


def wayside_alarm(fleet: Fleet, truth: Temperatures, axle: int, onset: float) -> float:
    """Return when a wayside detector first finds the first box of an axle hot after an onset [s]; infinite if none does."""
    wayside = Wayside(WaysideParameters(seed=(fleet.seed * 100_003 + axle) % 2**31))
    boxes, rings, air = truth.box[:, axle].tolist(), truth.outer_ring[:, axle].tolist(), fleet.duty.ambient[:, axle].tolist()
    for k, speed in enumerate(fleet.duty.speed[:, axle].tolist()):
        axle_boxes = AxleBoxes(boxes[k][0], rings[k][0], boxes[k][1], rings[k][1], air[k])
        passage = wayside.follow(round(k * STEP * 1e9), speed, axle_boxes)
        if passage is not None and passage.alarm and k * STEP >= onset:
            return k * STEP
    return math.inf


def configuration() -> dcrb_ros.Configuration:
    """Return the greased bench with a thermal network."""
    return dcrb_ros.load_configuration("healthy", {"thermal.law": "network"})


def healthy_fleet(seed: int) -> dict[str, Any]:
    """Return the alarms of a healthy fleet."""
    boxes, hot = healthy_days(Fleet(AXLES, DAYS, seed), heat_table(configuration(), "loss"), DetectorParameters())
    return {"alarms": [(k, *alarm) for k, alarms in enumerate(boxes) for alarm in alarms], "wayside": hot}


def faulty_fleet(fault: Fault, axles: int, seed: int) -> list[Outcome]:
    """Return what happened to axles with a fault that grows on their second day."""
    fleet = Fleet(axles, 4, seed)
    growth = drawn_growth(fleet, LAST[fault], SHORTEST, LONGEST)
    return faulty_days(fleet, heat_table(configuration(), fault), growth, DetectorParameters())


def summary(outcomes: list[Outcome]) -> dict[str, Any]:
    """Return the figures of one kind of fault."""
    hot = [outcome for outcome in outcomes if outcome.wayside < math.inf]
    lead = np.array([outcome.lead for outcome in hot]) / 60.0
    bounds: Any = quantile_test(lead, p=0.5).confidence_interval(0.95)
    names = [outcome.detector.verdict for outcome in outcomes if outcome.detector is not None]
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
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(8.0, 4.0), layout="constrained")
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
        kinds: list[Fault] = ["loss", "clearance"]
        fates = pool.map(partial(faulty_fleet, axles=given.faulty, seed=given.seed + 500), kinds)
        faulty: dict[Fault, list[Outcome]] = dict(zip(kinds, fates, strict=True))
    days, alarms = len(fleets) * AXLES * DAYS, [alarm for fleet in fleets for alarm in fleet["alarms"]]
    about: dict[str, Any] = {
        "healthy": {
            "axle_days": days,
            "false_alarms": len(alarms),
            "per_1000_axle_days": list(rate(len(alarms), days / 1000.0)),
            "alarms": alarms,
            "wayside_alarms": sum(fleet["wayside"] for fleet in fleets),
        },
    }
    about |= {str(fault): summary(outcomes) for fault, outcomes in faulty.items()}
    print(json.dumps(about, indent=2))
    if given.figure is not None:
        picture(faulty, given.figure)


if __name__ == "__main__":
    main()
