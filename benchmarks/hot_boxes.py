"""The shipped detector beside wayside hot-box detectors: false alarms in healthy days of axles, and lead times before hot boxes.

    python benchmarks/hot_boxes.py --healthy 40 --faulty 200 --figure hot-boxes.png

Nothing vibrates: temperatures come from the thermal network between tables of quasi-steady heat (`dcrb_ros.exam.hot_boxes`). A thousand
healthy axle-days take two minutes of one core. Seeds from 1000 on chose the thresholds; the figures are of seeds from 1 on.
"""

from __future__ import annotations

import argparse
import json
import math
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import dcrb_ros
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.exam.hot_boxes.fleet import Fleet
from dcrb_ros.exam.hot_boxes.heat_table import Fault, heat_table
from dcrb_ros.exam.hot_boxes.trial import Outcome, drawn_growth, faulty_days, healthy_days
from dcrb_ros.exam.statistics import rate

AXLES, DAYS = 20, 5
"""Axles of a healthy fleet and the days that they run."""
LAST: dict[Fault, float] = {"loss": 1.0, "clearance": 1.5e-4}
"""Last size of each fault."""
SHORTEST, LONGEST = 3600.0, 8.0 * 3600.0
"""Of the growth of a fault [s]."""
TITLES: dict[Fault, str] = {"loss": "loss of lubricant", "clearance": "loss of clearance"}


def configuration() -> dcrb_ros.Configuration:
    """Return the greased bench with a thermal network."""
    return dcrb_ros.load_configuration("healthy", {"thermal.law": "network"})


def healthy_fleet(seed: int) -> dict[str, Any]:
    """Return the alarms of a healthy fleet."""
    found, hot = healthy_days(Fleet(AXLES, DAYS, seed), heat_table(configuration(), "loss"), DetectorParameters())
    alarms = [(box, alarm.time / 3600.0, alarm.verdict, alarm.residual) for box, one in enumerate(found) for alarm in one.alarms]
    return {
        "axle_days": AXLES * DAYS,
        "alarms": alarms,
        "wayside": hot,
        "most": max(one.most for one in found),
        "least": min(one.least for one in found),
    }


def faulty_fleet(fault: Fault, axles: int, seed: int) -> list[Outcome]:
    """Return what happened to axles with a fault that grows on their second day."""
    fleet = Fleet(axles, 4, seed)
    growth = drawn_growth(fleet, LAST[fault], SHORTEST, LONGEST)
    return faulty_days(fleet, heat_table(configuration(), fault), growth, DetectorParameters())


def median_bounds(values: np.ndarray) -> tuple[float, float, float]:
    """Return the median with its 95 % interval from the order of the values (binomial)."""
    from scipy.stats import binom

    ordered, count = np.sort(values), len(values)
    low = int(binom.ppf(0.025, count, 0.5))
    return float(np.median(ordered)), float(ordered[max(low - 1, 0)]), float(ordered[min(count - low, count - 1)])


def summary(outcomes: list[Outcome]) -> dict[str, Any]:
    """Return the figures of one kind of fault."""
    hot = [one for one in outcomes if one.wayside < math.inf]
    lead = np.array([one.lead for one in hot]) / 60.0
    names = [one.detector.verdict for one in outcomes if one.detector is not None]
    return {
        "axles": len(outcomes),
        "found": len(names),
        "found_by_wayside": len(hot),
        "found_by_wayside_only": int(np.isneginf(lead).sum()),
        "earlier": int((lead > 0.0).sum()),
        "lead_median": median_bounds(lead),
        "lead_percentiles": {str(p): float(np.percentile(lead, p, method="lower")) for p in (5, 25, 75, 95)},
        "names": {name: names.count(name) for name in ("lubrication", "overheating")},
        "alarm_before_onset": sum(one.early for one in outcomes),
    }


def picture(found: dict[Fault, list[Outcome]], file: Path) -> None:
    """Plot the share of hot boxes over the lead time."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(8.0, 4.0), layout="constrained")
    for fault, colour in zip(found, ("tab:blue", "tab:red"), strict=True):
        lead = np.sort([one.lead / 60.0 for one in found[fault] if one.wayside < math.inf])
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
        outcomes = pool.map(partial(faulty_fleet, axles=given.faulty, seed=given.seed + 500), kinds)
        faulty: dict[Fault, list[Outcome]] = dict(zip(kinds, outcomes, strict=True))
    days, alarms = sum(one["axle_days"] for one in fleets), [alarm for one in fleets for alarm in one["alarms"]]
    often = rate(len(alarms), days / 1000.0)
    about: dict[str, Any] = {
        "healthy": {
            "axle_days": days,
            "false_alarms": len(alarms),
            "per_1000_axle_days": list(often),
            "alarms": alarms,
            "wayside_alarms": sum(one["wayside"] for one in fleets),
            "largest_departures": [min(one["least"] for one in fleets), max(one["most"] for one in fleets)],
        },
    }
    about |= {str(fault): summary(one) for fault, one in faulty.items()}
    print(json.dumps(about, indent=2))
    if given.figure is not None:
        picture(faulty, given.figure)


if __name__ == "__main__":
    main()
