"""Machines of a laboratory with the bearing of a rig: speed, load, bearing, housing, impacts and background are drawn."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import qmc
from signal_draws import drawn
from sim_to_real_data import Rig, Windows, conditions, defects, features, saved, settings_of

from dcrb_ros.simulation.run import simulate

SETTLING = 0.45
"""Simulated time before the windows [s]."""
KINDS = {"healthy": "healthy", "outer": "outer_ring", "inner": "inner_ring", "ball": "roller"}
"""Class by kind of defect."""


def drawn_windows(rig: Rig, bench: str, folder: Path, machines: int, seconds: float) -> Windows:
    """Return the windows of drawn machines, which are simulated or continued in a folder."""
    ranges = conditions(rig)
    strata = qmc.LatinHypercube(len(ranges), seed=1).random(machines)
    parts = []
    for number, quantiles in enumerate(strata):
        path = folder / f"machine-{number}.npz"
        if not path.exists():
            machine = {key: within(one, share) for (key, one), share in zip(ranges.items(), quantiles, strict=True)}
            saved(machine_windows(rig, bench, machine, number, seconds), path)
            print(f"{rig.name}, machine {number}", flush=True)
        with np.load(path) as content:
            names, truth, recording = json.loads(str(content["about"]))
            parts.append(Windows(tuple(names), content["values"], truth, recording))
    truth, recording = ([one for part in parts for one in getattr(part, name)] for name in ("truth", "recording"))
    return Windows(parts[0].names, np.concatenate([part.values for part in parts]), truth, recording)


def machine_windows(rig: Rig, bench: str, machine: Mapping[str, Any], number: int, seconds: float) -> Windows:
    """Return the windows of one machine, healthy and with a defect of each component."""
    random, parts = np.random.default_rng([number, 4]), []
    seeds = {"structure.housing": "laboratory", "structure.seed": number + 1, "simulation.seed": number + 1}
    settings = {**settings_of(rig), **machine, **seeds}
    for kind, truth in KINDS.items():
        faults = {key: within(value, random.random()) if isinstance(value, dict) else value for key, value in defects(kind).items()}
        run = simulate(bench, SETTLING + seconds, settings={**settings, **drawn(bench, settings, kind, number + 1), **faults})
        values = run.acceleration[round(SETTLING * run.sampling_rate) :, 1].astype(np.float64)
        angle = np.unwrap(run.shaft_angle[-len(values) :].astype(np.float64))
        parts.append((features(values - values.mean(), run.sampling_rate, angle, run.orders), truth, str(number)))
    return Windows.of(parts)


def within(one: Mapping[str, Any], share: float) -> Any:
    """Return the value at a share of a range, of a logarithmic scale or of whole numbers."""
    low, high = one["low"], one["high"]
    value = math.exp(math.log(low) + share * math.log(high / low)) if one.get("scale") == "log" else low + share * (high - low)
    return round(value) if isinstance(low, int) else value
