"""The pictures of docs/explanation/detector.md: `python benchmarks/detector_pictures.py [--data DIR]`.

The spectra come from the shipped recordings, the sizes of BPFO lines from the waveforms that `benchmarks/detector.py` keeps in --data.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import matplotlib as mpl
import numpy as np
from detector import Scenario, detector_of, scenarios, watch, waveforms

from dcrb_ros.diagnosis.detector import FaultDetector
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.recordings.reader import Recording

mpl.use("Agg")
import matplotlib.pyplot as plt

REPOSITORY = Path(__file__).parents[1]
IMAGES = REPOSITORY / "docs" / "images"
RECORDINGS = {"healthy": "BPFO", "outer_ring_defect": "BPFO", "inner_ring_defect": "BPFI", "cage_fracture": "FTF"}
HIGHEST_ORDER = 30.0
COLOURS = {"healthy": "tab:green", "outer_ring": "tab:red"}


def spectra() -> None:
    """Draw the published spectrum of each recording with the lines that name it."""
    figure, axes = plt.subplots(len(RECORDINGS), 1, figsize=(9.0, 8.0), sharex=True, layout="constrained")
    for axis, (name, line) in zip(axes, RECORDINGS.items(), strict=True):
        recording = Recording(REPOSITORY / "bags" / name)
        detector = FaultDetector(recording.orders, recording.sampling_rate)
        blocks = ((b.first_index(recording.sampling_rate), b.acceleration, b.shaft_angle) for b in recording.vibrations())
        last = [found for block in blocks if (found := detector.update(*block))][-1]
        orders, amplitude = last.spectrum
        shown = (orders > 0.2) & (orders <= HIGHEST_ORDER)
        base = {"BPFO": recording.orders.bpfo, "BPFI": recording.orders.bpfi, "FTF": recording.orders.ftf}[line]
        for k in range(1, int(HIGHEST_ORDER / base) + 1):
            axis.axvline(k * base, color="tab:orange", linewidth=3.0, alpha=0.3)
        axis.plot(orders[shown], amplitude[shown], linewidth=0.8)
        axis.set_title(f"{name}: called {last.verdict}; shaded: {line} and harmonics", fontsize=10, loc="left")
        axis.set_ylabel("m/s²")
    axes[-1].set_xlabel("order of the shaft")
    axes[-1].set_xlim(0.0, HIGHEST_ORDER)
    figure.savefig(IMAGES / "detector-spectra.png", dpi=80)


def sizes(found: list[tuple[float, str, float, float]]) -> None:
    """Draw BPFO lines over the speed: frequency [Hz], kind, size and excess [dB] of each run."""
    figure, axis = plt.subplots(figsize=(9.0, 4.5), layout="constrained")
    for kind, colour in COLOURS.items():
        own = [(frequency * 60.0, size) for frequency, of, size, _ in found if of == kind]
        axis.scatter(*np.array(own).T, s=16, color=colour, label=kind.replace("_", " "))
    axis.axhline(DetectorParameters().outer_limit, color="black", linewidth=1.0, label="outer_limit")
    axis.set(yscale="log", xlabel="speed [rpm]", ylabel="BPFO lines, 2 to 20 kHz,\nscaled to 20 Hz [m/s²]", ylim=(0.3, None))
    axis.legend()
    axis.grid(alpha=0.3)
    figure.savefig(IMAGES / "detector-sizes.png", dpi=80)


def measured(scenario: Scenario, stream: tuple[np.ndarray, np.ndarray]) -> tuple[float, str, float, float]:
    """Return shaft frequency [Hz], kind, size [m/s^2] and excess [dB] of BPFO lines in the last judgement."""
    limit = DetectorParameters().outer_limit
    # The size is read back from the score: with no demand on the depth and no other band it is the size over the limit.
    detector = detector_of(scenario, DetectorParameters(band="fixed", outer_depth=1e-6, shadow=100.0, comb_shadow=100.0))
    last = [d for d in watch(detector, stream) if d.scores][-1]
    excess = last.scores["outer_ring"]
    return last.shaft_frequency, scenario.kind, limit * 10.0 ** (excess / 20.0), excess


def main() -> None:
    """Draw the pictures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, default=Path(tempfile.gettempdir()) / "dcrb_detector")
    parser.add_argument("--count", type=int, default=90)
    given = parser.parse_args()
    spectra()
    asked = [s for design in ("tuned", "untuned") for s in scenarios(design, given.count) if s.kind in COLOURS]
    sizes([measured(scenario, stream) for scenario, stream in waveforms(asked, given.data)])


if __name__ == "__main__":
    main()
