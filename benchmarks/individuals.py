"""Variance of usual features between bearings, against that between runs of one bearing with other seeds.

``python benchmarks/individuals.py [BEARINGS] [drawn|set] [DURATION ...]`` simulates two runs of each bearing of the bench `healthy`, which
differ in the seed of the run: the fluctuation of the speed, and with ``drawn`` the angles of the cages at the start. DURATION is the
simulated time of the features [s]; several ones are windows of the same runs, which begin together. The last line shows how fast the cages
of a bearing turn against each other: while that is less than a pitch of the rollers, a run has one stagger of its rows.
``python benchmarks/individuals.py BEARINGS staggers [DURATION]`` stands for recordings of minutes: it averages features over 1, 2, 4 and 8
runs with drawn angles.
"""

from __future__ import annotations

import sys

import numpy as np
from scipy import fft

from dcrb_ros.bearing.frequencies import characteristic_orders
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.validation.realism import lines_of, squared_envelope

BEARINGS, RUNS = 200, 2
SETTLING, DURATION = 0.1, 0.5
"""Simulated time before the features, and of the features [s]."""
STAGGERS = (1, 2, 4, 8)
"""Runs with drawn angles over which features are averaged."""
BANDS = ((0, 500), (500, 1000), (1000, 2000), (2000, 4000), (4000, 8000), (8000, 16000))
"""[Hz]"""
NAMES = (
    *(f"{name} {axis}" for axis in "XY" for name in ("rms", "kurtosis", "crest factor", "envelope rms")),
    *(f"level {low} to {high} Hz, Y" for low, high in BANDS),
    *("level 0 to 500 Hz, X", "level 2000 to 4000 Hz, X", "1x line, X", "1x line, Y", "BPFO of the envelope, Y", "FTF of the envelope, Y"),
)


def level(power: Floats, frequency: Floats, low: float, high: float) -> float:
    """Return the level of a band [dB]."""
    return float(10.0 * np.log10(power[(frequency >= low) & (frequency < high)].sum()))


def run(bearing: int, seed: int, angles: str, durations: list[float]) -> tuple[list[list[float]], float]:
    """Return the features `NAMES` of the windows of a run of a bearing, and by how much its cages turn against each other [pitches/s]."""
    given = (f"surfaces.seed={bearing}", f"simulation.seed={seed}", f"operating.cage_angles={angles}", "sensor.noise_density=0")
    configuration = load_configuration("healthy", given)
    simulation = Simulation(configuration, waveform_only=True)
    list(simulation.blocks(SETTLING))
    begin = stagger(simulation)
    blocks = list(simulation.blocks(max(durations)))
    drift = (stagger(simulation) - begin) / max(durations)
    signal, rate = np.concatenate([block.clean for block in blocks]).astype(np.float64), blocks[0].rate
    return [features(signal[: round(duration * rate)], rate, configuration) for duration in durations], drift


def stagger(simulation: Simulation) -> float:
    """Return the angle between the cages of both rows [pitches of the rollers]."""
    first, second = simulation._state.cage_position[:, 2]
    return float(second - first) * simulation.configuration.bearing.rollers_per_row / (2.0 * np.pi)


def features(signal: Floats, rate: float, configuration: Configuration) -> list[float]:
    """Return the features `NAMES` of an acceleration, shape (samples, 2) [m/s^2]."""
    orders = characteristic_orders(configuration.bearing)
    signal = signal - signal.mean(axis=0)
    frequency = fft.rfftfreq(len(signal), 1.0 / rate)
    power = np.abs(fft.rfft(signal * np.hanning(len(signal))[:, None], axis=0)) ** 2
    levels: list[float] = []
    for axis in (0, 1):
        squared, _ = squared_envelope(signal[:, axis], rate)
        rms = float(signal[:, axis].std())
        levels += [
            rms,
            float((signal[:, axis] ** 4).mean()) / rms**4,
            float(np.abs(signal[:, axis]).max()) / rms,
            float(squared.mean() ** 0.5),
        ]
    levels += [level(power[:, 1], frequency, low, high) for low, high in BANDS]
    levels += [level(power[:, 0], frequency, low, high) for low, high in (BANDS[0], BANDS[3])]
    shaft = configuration.operating.speed / (2.0 * np.pi)
    levels += [level(power[:, axis], frequency, 0.8 * shaft, 1.2 * shaft) for axis in (0, 1)]
    squared, envelope_rate = squared_envelope(signal[:, 1], rate)
    lines = lines_of(squared, envelope_rate)
    return [*levels, float(lines.at(orders.bpfo * shaft)), float(lines.at(orders.ftf * shaft))]


def compare(values: Floats, angles: str, duration: float) -> None:
    """Print the standard deviation of each feature between bearings and within one, of values of the shape (bearings, runs, features)."""
    within = values.var(axis=1, ddof=1).mean(axis=0)
    between = np.maximum(values.mean(axis=1).var(axis=0, ddof=1) - within / RUNS, 0.0)
    print(f"{len(values)} bearings, {RUNS} runs of {duration:g} s each, angles of the cages {angles}")
    for name, one, other in zip(NAMES, between, within, strict=True):
        print(f"{name:32s} between {one**0.5:10.4g}   within {other**0.5:10.4g}   ratio of variances {one / other:8.2f}")
    print(f"{(between > within).sum()} of {len(NAMES)} features vary more between bearings than between runs of one")


def main() -> None:
    """Print the comparison of each window, or of means over staggers."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else BEARINGS
    angles = sys.argv[2] if len(sys.argv) > 2 else "drawn"
    durations = [float(text) for text in sys.argv[3:]] or [DURATION]
    drawn, seeds = "drawn" if angles == "staggers" else angles, RUNS * STAGGERS[-1] if angles == "staggers" else RUNS
    runs = [[run(bearing, seed, drawn, durations) for seed in range(1, seeds + 1)] for bearing in range(1, count + 1)]
    if angles == "staggers":
        values = np.array([[levels[0] for levels, _ in run] for run in runs])
        for averaged in STAGGERS:
            groups = values[:, : RUNS * averaged].reshape(count, RUNS, averaged, len(NAMES))
            compare(groups.mean(axis=2), f"drawn, means over {averaged} staggers", durations[0])
        return
    for window, duration in enumerate(durations):
        compare(np.array([[levels[window] for levels, _ in both] for both in runs]), angles, duration)
    drifts = np.abs([drift for both in runs for _, drift in both])
    print(f"cages against each other: {np.median(drifts):.3g} (at most {drifts.max():.3g}) pitches/s, mean over {max(durations):g} s")


if __name__ == "__main__":
    main()
