"""The trend of the shipped detector's severity for defects that grow, and for defects that do not: direction and doubling time.

    python benchmarks/growth.py --seeds 1
    python benchmarks/growth.py --widths

A spall grows exponentially within 14 s, at two speeds, on outer and inner ring, in three stages: below the width at which rollers reach its
floor, across it, and above; as many keep a width. At the end the trend of the severity [dB/min] is compared with that of the width over the
same judgements. A doubling time is 6.02 dB over the trend. ``--widths`` prints the severity of spalls that keep their width.
"""

from __future__ import annotations

import argparse
import json
import math
from typing import Any

import numpy as np

import dcrb_ros

STAGES = {"small": (0.0005, 0.0014), "across": (0.001, 0.004), "large": (0.0028, 0.008)}
"""Widths of a growing spall at its beginning and end, by the stage [m]; a roller reaches the floor of 60 um at 2.2 to 2.9 mm."""
STEADY = (0.001, 0.002, 0.004)
"""Widths of spalls that do not grow [m]."""
KEPT = (0.0005, 0.001, 0.0014, 0.002, 0.0028, 0.004, 0.0056, 0.008)
"""Widths of the spalls whose severity is printed [m]."""
STEPS = 14
"""Straight pieces of the exponential growth [-]."""
ONSET, DURATION = 1.0, 15.0
"""Beginning of the growth and end of the run [s]."""
NOTICED, LEAST_TREND = 3.0, 1.0
"""Trend up to which a defect counts as steady: in standard errors [-], and at least [dB/min]."""


def scenario(ring: str, widths: tuple[float, float]) -> dict[str, Any]:
    """Return the timeline of a spall that grows from the first width to the last one [m], or keeps it."""
    key, (first, last) = f"faults.{ring}_1", widths
    start = {f"{key}.row": 1, f"{key}.width": first, f"{key}.kind": "spall", f"{key}.depth": 6e-5, f"{key}.share": 0.35}
    piece = (DURATION - ONSET) / STEPS
    more = [
        {"at": ONSET + k * piece, "over": piece, "set": {f"{key}.width": first * (last / first) ** ((k + 1) / STEPS)}}
        for k in range(STEPS if first < last else 0)
    ]
    return {"start": start, "timeline": more}


def slope(time: np.ndarray, level: np.ndarray) -> tuple[float, float]:
    """Return the slope of a line through levels [dB] and its standard error [dB/min], with half of the points independent."""
    centred = time - time.mean()
    spread = float(centred @ centred)
    found = float(centred @ level) / spread
    rest = level - level.mean() - found * centred
    return 60.0 * found, 60.0 * math.sqrt(float(rest @ rest) / max(len(time) / 2.0 - 2.0, 1.0) / (0.5 * spread))


def trial(ring: str, speed: float, stage: str, widths: tuple[float, float], seed: int) -> dict[str, Any]:
    """Return the trends of one run."""
    run = dcrb_ros.simulate("healthy", DURATION, settings={"operating.speed": speed}, scenario=scenario(ring, widths), seed=seed)
    found = dcrb_ros.detect(run)
    judged = [one for one in found.history if one.severity > 0.0 and one.verdict == found.verdict]
    about: dict[str, Any] = {"ring": ring, "speed": speed, "stage": stage, "widths": widths, "seed": seed, "verdict": found.verdict}
    if len(judged) < 8:
        return {**about, "trend": None}
    time = np.array([one.time for one in judged])
    _, error = slope(time, 20.0 * np.log10([one.severity for one in judged]))
    true = 60.0 * 20.0 * math.log10(widths[1] / widths[0]) / (DURATION - ONSET)
    return {**about, "trend": judged[-1].trend, "error": error, "true": true}


def kept(ring: str, speed: float, width: float, seed: int) -> dict[str, Any]:
    """Return the median severity of a spall that keeps its width [m]."""
    settings = {"operating.speed": speed, **scenario(ring, (width, width))["start"]}
    found = dcrb_ros.detect(dcrb_ros.simulate("healthy", 6.0, settings=settings, seed=seed))
    severities = [one.severity for one in found.history if one.severity > 0.0]
    return {"ring": ring, "speed": speed, "width": width, "severity": float(np.median(severities)) if severities else None}


def main() -> None:
    """Run all trials, print the figures as JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=1, help="runs of each kind")
    parser.add_argument("--widths", action="store_true", help="print the severity over the width instead")
    given = parser.parse_args()
    kinds = [(ring, speed, seed) for seed in range(1, given.seeds + 1) for ring in ("outer", "inner") for speed in (75.0, 125.664)]
    if given.widths:
        print(json.dumps([kept(ring, speed, width, seed) for ring, speed, seed in kinds for width in KEPT], indent=2))
        return
    stages = {**STAGES, **{f"steady {1e3 * width:g} mm": (width, width) for width in STEADY}}
    found = [trial(ring, speed, stage, widths, seed) for stage, widths in stages.items() for ring, speed, seed in kinds]
    print(
        json.dumps(
            {"runs": found, "stages": {stage: summary([one for one in found if one["stage"] == stage]) for stage in stages}}, indent=2
        )
    )


def summary(runs: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the figures of a stage."""
    known = [one for one in runs if one["trend"] is not None]
    return {
        "runs": len(runs),
        "judged": len(known),
        "taken_for_growing": sum(one["trend"] > max(LEAST_TREND, NOTICED * one["error"]) for one in known),
        "trends": [one["trend"] for one in known],
        "doubling_time_over_true": [one["true"] / one["trend"] if one["trend"] > 0.0 else None for one in known if one["true"] > 0.0],
    }


if __name__ == "__main__":
    main()
