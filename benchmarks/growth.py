"""The trend of the shipped detector's severity for defects that grow, and for defects that do not: direction and doubling time.

    python benchmarks/growth.py --seeds 1
    python benchmarks/growth.py --widths

A spall grows evenly from 1 to 4 mm within 14 s, at two speeds, on outer and inner ring; as many keep 2 mm. At the end the trend of the
severity [dB/min] is compared with that of the width over the same judgements. A doubling time is 6.02 dB over the trend. With ``--widths``
the severity of spalls that keep their width is printed instead.
"""

from __future__ import annotations

import argparse
import json
import math
from typing import Any

import numpy as np
from scipy.stats import linregress

from dcrb_ros.diagnosis.detection import detect
from dcrb_ros.simulation.run import simulate

FIRST, LAST, STEADY = 0.001, 0.004, 0.002
"""Widths of a growing spall at its beginning and end, and of a steady one [m]."""
KEPT = (0.0005, 0.001, 0.0014, 0.002, 0.0028, 0.004, 0.0056, 0.008)
"""Widths of the spalls whose severity is printed [m]."""
KEPT_DURATION = 6.0
"""Time for which each of them is watched [s]."""
ONSET, DURATION = 1.0, 15.0
"""Beginning of the growth and end of the run [s]."""


def scenario(ring: str, growing: bool) -> dict[str, Any]:
    """Return the timeline of a spall."""
    key = f"faults.{ring}_1"
    first = {
        f"{key}.row": 1,
        f"{key}.width": FIRST if growing else STEADY,
        f"{key}.kind": "spall",
        f"{key}.depth": 6e-5,
        f"{key}.share": 0.35,
    }
    more = [{"at": ONSET, "over": DURATION - ONSET, "set": {f"{key}.width": LAST}}] if growing else []
    return {"start": first, "timeline": more}


def width(time: np.ndarray) -> np.ndarray:
    """Return the width of a growing spall at times [s], [m]."""
    return FIRST + (LAST - FIRST) * np.clip((time - ONSET) / (DURATION - ONSET), 0.0, 1.0)


def slope(time: np.ndarray, level: np.ndarray) -> tuple[float, float]:
    """Return the slope of a line through levels [dB] and its standard error [dB/min], with half of the points independent."""
    line, count = linregress(time, level), len(time)
    return 60.0 * line.slope, 60.0 * line.stderr * math.sqrt((count - 2.0) / max(count / 2.0 - 2.0, 1.0) / 0.5)


def trial(ring: str, speed: float, growing: bool, seed: int) -> dict[str, Any]:
    """Return the trends of one run."""
    run = simulate("healthy", DURATION, settings={"operating.speed": speed}, scenario=scenario(ring, growing), seed=seed)
    detection = detect(run)
    judged = [diagnosis for diagnosis in detection.history if diagnosis.severity > 0.0 and diagnosis.verdict == detection.verdict]
    about: dict[str, Any] = {"ring": ring, "speed": speed, "growing": growing, "seed": seed, "verdict": detection.verdict}
    if len(judged) < 8:
        return {**about, "trend": None}
    time = np.array([diagnosis.time for diagnosis in judged])
    fitted, error = slope(time, 20.0 * np.log10([diagnosis.severity for diagnosis in judged]))
    # A judgement is of the four seconds before it.
    true, _ = slope(time, 20.0 * np.log10(width(time - 2.0)))
    return {**about, "trend": judged[-1].trend, "fitted": fitted, "error": error, "true": true if growing else 0.0}


def kept(ring: str, speed: float, width: float, seed: int) -> dict[str, Any]:
    """Return the median severity of a spall that keeps its width [m]."""
    settings = {"operating.speed": speed, **scenario(ring, growing=False)["start"], f"faults.{ring}_1.width": width}
    detection = detect(simulate("healthy", KEPT_DURATION, settings=settings, seed=seed))
    severities = [diagnosis.severity for diagnosis in detection.history if diagnosis.severity > 0.0]
    return {"ring": ring, "speed": speed, "seed": seed, "width": width, "severity": float(np.median(severities)) if severities else None}


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
    trials = [trial(ring, speed, growing, seed) for ring, speed, seed in kinds for growing in (True, False)]
    print(json.dumps(trials, indent=2))


if __name__ == "__main__":
    main()
