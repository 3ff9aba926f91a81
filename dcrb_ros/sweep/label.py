"""The label of a run: what it is, what is wrong in it, and what became of it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from dcrb_ros import __version__
from dcrb_ros.faults.ground_truth import class_of
from dcrb_ros.recordings.manifest import model_fingerprint
from dcrb_ros.settings.files import overlaid
from dcrb_ros.simulation.block import Truth
from dcrb_ros.sweep.plan import Run

DONE, REFUSED, FAILED, ERROR = "done", "refused", "failed", "error"
"""What becomes of a run. A refused or failed one would fail again; after an error it is tried again by the next call."""


def base_label(run: Run, base: Mapping[str, Any]) -> dict[str, Any]:
    """Return what is known of a run before it has run."""
    parameters = overlaid(base, run.changes)
    return {
        "run": run.name,
        "place": run.place,
        "twin": run.twin,
        "condition": run.condition,
        "split": run.split,
        "case": run.case,
        "seed": run.seed,
        "scenario": run.scenario,
        "dcrb_ros": __version__,
        "model": model_fingerprint(),
        "configuration": parameters,
    }


def fault_label(truths: list[Truth]) -> dict[str, Any]:
    """Return what is wrong at the end of a run, and at which speed and load it ran."""
    last = truths[-1]
    notches = {name: fault for name, fault in last.faults.items() if "width" in fault}
    largest: Mapping[str, Any] = max(notches.values(), key=lambda fault: fault["width"], default={})
    return {
        "fault": class_of(last.faults),
        "faults": {name: dict(fault) for name, fault in last.faults.items()},
        "width": largest.get("width"),
        "depth": largest.get("depth"),
        "row": largest.get("row"),
        "azimuth": largest.get("azimuth"),
        "broken_bars": sum("bar" in fault for fault in last.faults.values()),
        "onset": min((fault["onset"] for fault in last.faults.values()), default=None),
        "speed": last.speed,
        "load": math.hypot(*last.load),
        **{name.lower(): frequency for name, frequency in last.frequencies.items()},
    }
