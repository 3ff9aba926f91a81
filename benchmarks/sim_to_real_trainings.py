"""Training sets beside the sweeps: machines drawn as those of a replica, and runs at the ring in the noise of the machine.

In the noise of the machine, which is Gaussian and has the spectrum of the healthy recording, the bearing of each simulated machine has a
share of the power from 1 to 100 %.
"""

from __future__ import annotations

import json
from itertools import groupby
from pathlib import Path

import numpy as np
from drawn_machines import TRUTHS, Machine, drawn_machines
from kept_results import digest_of
from scipy import signal
from sim_to_real_data import RPM, Measured, Rig, Windows, features, runs_of, saved, settings_of

from dcrb_ros.bearing.frequencies import characteristic_orders
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.simulation.run import simulate

SHARES = (-2.0, 0.0)
"""Range of the decimal logarithm of the bearing's share of the healthy power [-]."""
SEGMENT = 8192
SETTLING = 0.45
"""Simulated time before the windows [s]."""
SPEEDS = 3
"""Speeds of a drawn machine, evenly over the range of its rig [-]."""


def drawn_windows(rig: Rig, bench: str, folder: Path, machines: int, seconds: float) -> Windows:
    """Return the windows of the rig's bearing on machines drawn as those of a replica, which are simulated or continued in a folder."""
    orders = characteristic_orders(load_configuration(bench, settings_of(rig)).bearing)
    speeds = tuple(float(value) for value in np.linspace(*rig.speed, SPEEDS) / RPM)
    parts = []
    for number, machine in enumerate(drawn_machines(bench, orders, rig.rate, speeds, machines)):
        path = folder / f"machine-{number}-{digest_of(bench, [[*key, one] for key, one in machine.items()], seconds)}.npz"
        if not path.exists():
            saved(machine_windows(bench, machine, number, seconds), path)
            print(f"{rig.name}, machine {number}", flush=True)
        with np.load(path) as content:
            names, truth, recording = json.loads(str(content["about"]))
            parts.append(Windows(tuple(names), content["values"], truth, recording))
    truth, recording = ([one for part in parts for one in getattr(part, name)] for name in ("truth", "recording"))
    return Windows(parts[0].names, np.concatenate([part.values for part in parts]), truth, recording)


def machine_windows(bench: str, machine: Machine, number: int, seconds: float) -> Windows:
    """Return the windows of one machine, healthy and with a defect of each component, at all its speeds."""
    parts = []
    for (kind, _), settings in machine.items():
        run = simulate(bench, SETTLING + seconds, settings=settings)
        values = run.acceleration[round(SETTLING * run.sampling_rate) :, 1].astype(np.float64)
        angle = np.unwrap(run.shaft_angle[-len(values) :].astype(np.float64))
        parts.append((features(values - values.mean(), run.sampling_rate, angle, run.orders), TRUTHS[kind], str(number)))
    return Windows.of(parts)


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
