"""The label of a run: its place in the design, its configuration, its faults, and its outcome."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from dcrb_ros.faults.ground_truth import class_of
from dcrb_ros.recordings.manifest import model_fingerprint
from dcrb_ros.runtime.version import __version__
from dcrb_ros.settings.files import overlaid
from dcrb_ros.stream.block import Truth
from dcrb_ros.sweep.plan import PlannedRun

DONE, REFUSED, FAILED, ERROR = "done", "refused", "failed", "error"
"""Outcomes of a run. A refused or failed run is not repeated, since it would fail again; a run that ended in an error is."""
AMBIENT, BOX, OUTER_RINGS = "ambient [deg C]", "box [deg C]", "outer_ring [deg C]"
"""Names of temperatures in the ground truth, that of the outer rings without their rows."""
TEMPERATURES: Mapping[str, tuple[type, str]] = {
    "ambient_temperature": (
        float,
        "temperature of the surroundings at the end of the run [deg C]; null, like the next two, without a network",
    ),
    "box_temperature": (float, "temperature of the axle box [deg C]"),
    "outer_ring_temperature": (float, "temperature of the hotter outer ring [deg C]"),
}
"""Columns of the labels with temperatures: type and meaning."""


def base_label(run: PlannedRun, base: Mapping[str, Any]) -> dict[str, Any]:
    """Return the part of the label that is known before the run."""
    parameters = overlaid(base, run.changes)
    return {
        "run": run.name,
        "place": run.position,
        "twin": run.twin,
        "condition": run.condition,
        "split": run.split,
        "case": run.case,
        "seed": run.seed,
        "scenario": run.scenario,
        "dcrb_ros": __version__,
        "model": model_fingerprint(),
        **run.truth,
        "configuration": parameters,
    }


def fault_label(truths: list[Truth]) -> dict[str, Any]:
    """Return the faults, the speed and the load at the end of a run; of several defects the size of the widest one."""
    last = truths[-1]
    defects = [fault for fault in last.faults.values() if "width" in fault]
    widest: Mapping[str, Any] = max(defects, key=lambda fault: fault["width"], default={})
    return {
        "fault": class_of(last.faults),
        "faults": {name: dict(fault) for name, fault in last.faults.items()},
        "width": widest.get("width"),
        "depth": widest.get("depth"),
        "row": widest.get("row"),
        "azimuth": widest.get("azimuth"),
        "broken_bars": sum("bar" in fault for fault in last.faults.values()),
        "onset": min((fault["onset"] for fault in last.faults.values()), default=None),
        "speed": last.speed,
        "load": math.hypot(*last.load),
        **temperatures(last.thermal),
        **{name.lower(): frequency for name, frequency in last.frequencies.items()},
    }


def temperatures(thermal: Mapping[str, float]) -> dict[str, float]:
    """Return the temperatures of a ground truth by their column; none without a thermal network."""
    if AMBIENT not in thermal:
        return {}
    rings = [value for name, value in thermal.items() if name.startswith("row") and name.endswith(OUTER_RINGS)]
    return {"ambient_temperature": thermal[AMBIENT], "box_temperature": thermal[BOX], "outer_ring_temperature": max(rings)}
