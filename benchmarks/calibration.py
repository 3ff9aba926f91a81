"""Calibrate to benches whose path, gain, noise and modulation are known, and count how often the intervals contain the truth.

    python benchmarks/calibration.py [PLANTS]

Each plant is simulated for 5 s with another individual of the bearing, random modes of an axle box, gain, noise, modulation and hum, and
calibrated to from its recording alone. The calibrated bench with a known share of the bearing and once more another individual is a second
plant, for that share.
"""

from __future__ import annotations

import sys
import time
from collections import defaultdict
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.signal import sosfreqz

from dcrb_ros.calibration.calibration import Calibration, calibrate
from dcrb_ros.calibration.spectra import power_density
from dcrb_ros.diagnosis.features.band_levels import EDGE
from dcrb_ros.measurement.stages.structure import StructureParameters, sections
from dcrb_ros.simulation.run import SimulationResult, simulate

SECONDS = 5.0


def drawn(number: int) -> dict[str, Any]:
    """Return the parameters of a plant."""
    random = np.random.default_rng(number)
    return {
        "structure.modes": int(random.integers(2, 9)),
        "structure.seed": number,
        "structure.gain_x": float(10.0 ** random.uniform(-1.0, 1.0)),
        "structure.gain_y": float(10.0 ** random.uniform(-1.0, 1.0)),
        "structure.modulation": float(random.uniform(0.0, 0.6)),
        "sensor.noise_density": float(2e-3 * 10.0 ** random.uniform(-0.7, 0.7)),
        "sensor.range": 1e5,
        "background.hum_level": float(10.0 ** random.uniform(-2.0, -0.5)),
        "simulation.seed": number,
        "surfaces.seed": 100 + number,
    }


@dataclass
class Counts:
    """Results of the calibrations by quantity."""

    inside: dict[str, list[bool]] = field(default_factory=lambda: defaultdict(list))
    """Whether the intervals contain the truth."""
    errors: dict[str, list[float]] = field(default_factory=lambda: defaultdict(list))
    """Relative errors [-]."""
    unknown: dict[str, list[bool]] = field(default_factory=lambda: defaultdict(list))
    """Whether a calibration says that the share is unknown."""
    bands: list[tuple[float, float]] = field(default_factory=list)
    """Estimated over true path in a third octave, and half of the interval [dB]."""

    def add(self, calibration: Calibration, run: SimulationResult, settings: dict[str, Any]) -> None:
        """Compare a calibration with the truth."""
        for estimate in calibration.estimates:
            truth = settings.get(estimate.key)
            if truth is not None and estimate.key not in ("structure.gain_x", "structure.gain_y"):
                self.inside[estimate.key].append(estimate.low <= truth <= estimate.high)
                self.errors[estimate.key].append(estimate.value / truth - 1.0)
        for axis in "xy":
            power, middles = path_of(run, settings, axis)
            gain = calibration.gains[axis]
            truth = float(np.sqrt(power[:, 1].sum() / power[:, 0].sum()))
            self.inside["gain"].append(gain.low <= truth <= gain.high)
            self.errors["gain"].append(gain.value / truth - 1.0)
            for level in (estimate for estimate in calibration.path if estimate.axis == axis and estimate.identified):
                band = (middles >= level.frequency / EDGE) & (middles < level.frequency * EDGE)
                known = 10.0 * np.log10(power[band, 1].sum() / power[band, 0].sum())
                self.bands.append((level.level - known, 0.5 * (level.high - level.low)))
                self.inside["path in third octaves"].append(level.low <= known <= level.high)

    def add_share(self, calibration: Calibration, truth: float) -> None:
        """Compare the share of the bearing with the truth."""
        share, key = calibration["structure.bearing_share"], "share of the bearing" + ("" if truth < 1.0 else ", no other noise")
        self.inside[key].append(share.low <= truth <= share.high)
        self.errors[key].append(share.value / truth - 1.0)
        self.unknown[key].append(any("share of the power is unknown" in sentence for sentence in calibration.unidentified))
        print(f"  share {truth:.3g}: {share}", flush=True)

    def report(self) -> None:
        """Print rates and errors."""
        for key, values in self.inside.items():
            away = np.abs(self.errors[key]) if key in self.errors else None
            spread = "" if away is None else f", error {100 * np.sqrt(np.mean(away**2)):.2g} %, at most {100 * away.max():.2g} %"
            print(f"{key}: {np.mean(values):.0%} of {len(values)} within their intervals{spread}")
        for key, values in self.unknown.items():
            print(f"{key}: said to be unknown in {sum(values)} of {len(values)}")
        apart = np.abs([band[0] for band in self.bands])
        print(f"path: {np.sqrt(np.mean(apart**2)):.2f} dB, 99 % within {np.percentile(apart, 99):.2f} dB, at most {apart.max():.2f} dB")
        print(f"half of an interval of the path: {np.median([band[1] for band in self.bands]):.2f} dB")


def mixed_plant(calibration: Calibration, number: int) -> tuple[SimulationResult, float]:
    """Return a recording of a calibrated bench with another individual and a known share of the bearing."""
    share = float(10.0 ** np.random.default_rng(1000 + number).uniform(-1.3, -0.1))
    changes = {"structure.bearing_share": share, "surfaces.seed": 500 + number, "simulation.seed": 500 + number}
    return simulate(calibration.configuration, SECONDS, settings=changes).between(0.5), share


def main() -> None:
    """Run the plants and print what was found."""
    plants = int(sys.argv[1]) if len(sys.argv) > 1 else 24
    counts, seconds = Counts(), []
    for number in range(1, plants + 1):
        settings = drawn(number)
        run = simulate("healthy", SECONDS, settings=settings)
        begin = time.process_time()
        # In much noise the detector takes the sensor for a dead one.
        calibration = calibrate(run.between(0.5), base="healthy", trust=True)
        seconds.append(time.process_time() - begin)
        counts.add(calibration, run, settings)
        counts.add_share(calibration, 1.0)
        if calibration["structure.bearing_share"].low < 1.0:
            mixed, share = mixed_plant(calibration, number)
            counts.add_share(calibrate(mixed, base="healthy", trust=True), share)
        print(number, f"{seconds[-1]:.1f} s", {key: round(values[-1], 3) for key, values in counts.errors.items()}, flush=True)
    counts.report()
    print(f"processor time of a calibration: {np.median(seconds):.1f} s, at most {max(seconds):.1f} s")


def path_of(run: SimulationResult, settings: dict[str, Any], axis: str) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """Return the power of the ring before and behind the true path, shape (lines, 2), and the frequencies, from 200 Hz to 20 kHz."""
    spectrum = power_density(run.clean[run.sampling_rate // 2 :, "xy".index(axis)].astype(float), run.sampling_rate)
    used = (spectrum.frequency >= 200.0) & (spectrum.frequency <= 0.4 * run.sampling_rate)
    frequency, rate = spectrum.frequency[used], float(run.configuration.step_rate)
    response = np.abs(
        sosfreqz(sections(run.configuration.measurement.parameters[StructureParameters], rate)["xy".index(axis)], frequency, fs=rate)[1]
    )
    before = spectrum.density[used]
    return np.column_stack([before, before * (settings[f"structure.gain_{axis}"] * response) ** 2]), frequency


if __name__ == "__main__":
    main()
