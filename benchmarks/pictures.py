"""Pictures of the documentation that show the shipped benches: ``python benchmarks/pictures.py [--output docs/images]``.

``detector-spectra.png`` shows squared envelope spectra with the lines that name the faults, ``measurement-faults.png`` each sensor fault.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import get_args

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from dcrb_ros import detect, envelope_spectrum, simulate
from dcrb_ros.measurement.parameters import SensorFault

IMAGES = Path(__file__).resolve().parents[1] / "docs/images"
FAMILIES = {
    "healthy": "bpfo",
    "outer_ring_defect": "bpfo",
    "inner_ring_defect": "bpfi",
    "roller_defect": "two_bsf",
    "cage_fracture": "ftf",
}
"""Bench and the family of lines that is shaded."""
LABELS = {"bpfo": "BPFO", "bpfi": "BPFI", "two_bsf": "2 BSF", "ftf": "FTF"}
BEHIND_A_BOX = {"structure.modes": 6}
LARGEST_ORDER = 30.0
DURATION, ONSET, END = 8.0, 0.2, 0.6
"""Of the spectra; onset and end of the sensor faults [s]."""


def spectra(file: Path) -> None:
    """Draw the spectra over orders of the shaft."""
    figure, axes = plt.subplots(len(FAMILIES), 1, figsize=(9.0, 10.0), sharex=True, layout="constrained")
    for ax, (bench, family) in zip(axes, FAMILIES.items(), strict=True):
        run = simulate(bench, DURATION, settings=BEHIND_A_BOX)
        spectrum = envelope_spectrum(run)
        own = spectrum.orders.as_dict()
        order = 2.0 * own["BSF"] if family == "two_bsf" else own[family.upper()]
        shown = (spectrum.order > 0.1) & (spectrum.order < LARGEST_ORDER)
        for number in range(1, int(LARGEST_ORDER / order) + 1):
            ax.axvspan(number * order - 0.06, number * order + 0.06, color="tab:orange", alpha=0.3, linewidth=0)
        ax.plot(spectrum.order[shown], spectrum.amplitude[shown] / spectrum.mean, linewidth=0.8)
        verdict = detect(run).verdict
        ax.set_title(f"{bench}: called {verdict}; shaded: {LABELS[family]} and harmonics", loc="left", fontsize="medium")
        print(f"{bench}: {verdict}, largest line {spectrum.amplitude[shown].max() / spectrum.mean:.2f} of the mean")
    figure.supylabel("squared envelope over its mean [-]")
    axes[-1].set_xlabel("order of the shaft [-]")
    axes[-1].set_xlim(0.0, LARGEST_ORDER)
    figure.savefig(file, dpi=90)
    plt.close(figure)


def sensor_faults(file: Path) -> None:
    """Draw the waveform of an outer-ring defect with a sensor that fails, one axes per fault."""
    faults = [fault for fault in get_args(SensorFault) if fault != "none"]
    figure, axes = plt.subplots(len(faults), 1, figsize=(9.0, 10.0), sharex=True, sharey=True, layout="constrained")
    for ax, fault in zip(axes, faults, strict=True):
        severity = 0.5 if fault == "stuck" else 0.8
        broken = {"sensor.fault": fault, "sensor.fault_severity": severity, "sensor.fault_time": 0.1}
        timeline = {"timeline": [{"at": ONSET, "set": broken}]}
        run = simulate("outer_ring_defect", END, settings={**BEHIND_A_BOX, "sensor.range": 300.0}, scenario=timeline)
        ax.plot(np.arange(len(run.acceleration)) / run.sampling_rate, run.acceleration[:, 1], linewidth=0.5)
        ax.axvline(ONSET, color="tab:red", linewidth=0.8)
        ax.set_title(f"{fault}, severity {severity}", loc="left", fontsize="medium")
    axes[0].set_ylim(-150.0, 150.0)
    figure.supylabel("measured acceleration in Y [m/s²]")
    axes[-1].set_xlabel("time [s]")
    figure.savefig(file, dpi=90)
    plt.close(figure)


def main() -> None:
    """Draw both."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, default=IMAGES)
    output = parser.parse_args().output
    spectra(output / "detector-spectra.png")
    sensor_faults(output / "measurement-faults.png")


if __name__ == "__main__":
    main()
