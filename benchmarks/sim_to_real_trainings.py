"""Training sets beside the sweeps: drawn machines of a laboratory, and runs at the ring in the noise of the machine.

Speed, load, bearing, housing, impacts and background of a drawn machine are random. In the noise of the machine, which is Gaussian and has
the spectrum of the healthy recording, the bearing of each simulated machine has a share of the power from 1 to 100 %.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from kept_results import digest_of
from scipy import signal
from scipy.stats import qmc
from signal_draws import drawn
from sim_to_real_data import Measured, Rig, Windows, conditions, defects, features, runs_of, saved, settings_of

from dcrb_ros.schema.arrays import Floats
from dcrb_ros.simulation.run import simulate

SHARES = (-2.0, 0.0)
"""Range of the decimal logarithm of the bearing's share of the healthy power [-]."""
SEGMENT = 8192
SETTLING = 0.45
"""Simulated time before the windows [s]."""
WAVINESS = {"low": 3e-9, "high": 3e-8, "scale": "log"}
"""Waviness of the raceways of drawn machines [m], as of `dcrb_ros.exam.replica_priors`."""
LOUDER = 10.0
"""Level of the background of drawn machines over that of `housing_priors.LABORATORY`, whose raceways are rougher by as much [dB]."""
KINDS = {"healthy": "healthy", "outer": "outer_ring", "inner": "inner_ring", "ball": "roller"}
"""Class by kind of defect."""


def drawn_windows(rig: Rig, bench: str, folder: Path, machines: int, seconds: float) -> Windows:
    """Return the windows of drawn machines, which are simulated or continued in a folder."""
    ranges = conditions(rig) | {"surfaces.waviness": WAVINESS}
    strata = qmc.LatinHypercube(len(ranges), seed=1).random(machines)
    parts = []
    for number, quantiles in enumerate(strata):
        machine = {key: within(one, share) for (key, one), share in zip(ranges.items(), quantiles, strict=True)}
        path = folder / f"machine-{number}-{digest_of(bench, settings_of(rig), machine, seconds)}.npz"
        if not path.exists():
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
        laboratory = drawn(bench, settings, kind, number + 1)
        louder = {"structure.background": laboratory["structure.background"] + LOUDER}
        run = simulate(bench, SETTLING + seconds, settings={**settings, **laboratory, **louder, **faults})
        values = run.acceleration[round(SETTLING * run.sampling_rate) :, 1].astype(np.float64)
        angle = np.unwrap(run.shaft_angle[-len(values) :].astype(np.float64))
        parts.append((features(values - values.mean(), run.sampling_rate, angle, run.orders), truth, str(number)))
    return Windows.of(parts)


def within(one: Mapping[str, Any], share: float) -> Any:
    """Return the value at a share of a range, of a logarithmic scale or of whole numbers."""
    low, high = one["low"], one["high"]
    value = math.exp(math.log(low) + share * math.log(high / low)) if one.get("scale") == "log" else low + share * (high - low)
    return round(value) if isinstance(low, int) else value


def surrogate(healthy: Floats, count: int, rate: int, random: np.random.Generator) -> Floats:
    """Return Gaussian noise with the spectrum of a recording, shape (count,)."""
    frequency, density = signal.welch(healthy, rate, nperseg=SEGMENT)
    gain = np.sqrt(np.interp(np.fft.rfftfreq(count, 1.0 / rate), frequency, density) * 0.5 * rate)
    return np.asarray(np.fft.irfft(np.fft.rfft(random.standard_normal(count)) * gain, count))


def noisy_windows(folder: Path, healthy: list[Measured], seed: int = 1) -> Windows:
    """Return the windows of a data set in the noise of a machine; all runs of a simulated machine have the same noise level and gain."""
    random, parts = np.random.default_rng(seed), []
    by_condition = groupby(sorted(runs_of(folder), key=lambda run: run.name), key=lambda run: run.name)
    for condition, group in by_condition:
        runs, share, recording = list(group), 10.0 ** random.uniform(*SHARES), healthy[random.integers(len(healthy))]
        gain = recording.values.std() / next(run.values.std() for run in runs if run.truth == "healthy")
        for run in runs:
            noise = surrogate(recording.values, len(run.values), run.rate, random)
            mixed = np.sqrt(share) * gain * run.values + np.sqrt(1.0 - share) * noise
            parts.append((features(mixed - mixed.mean(), run.rate, run.angle, run.orders), run.truth, condition))
    return Windows.of(parts)
