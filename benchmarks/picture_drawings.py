"""The pictures of the documentation that a function draws from simulated runs."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, get_args

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy import signal

from dcrb_ros.diagnosis.detection import detect
from dcrb_ros.diagnosis.envelope_spectrum import envelope_spectrum
from dcrb_ros.diagnosis.rules.outer_ring import PAPER_LIMITS
from dcrb_ros.measurement.decimation import anti_alias_taps
from dcrb_ros.measurement.parameters import MICRO_G, SensorFault
from dcrb_ros.measurement.sensor import Sensor
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.settings.sensor import PRESETS
from dcrb_ros.simulation.run import simulate

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
QUIET = {"noise_density": 0.0, "white_noise_ug": 0.0, "pink_noise_ug": 0.0, "adc_bits": 0, "range": 1e6, "bias": 0.0, "bias_drift": 0.0}
"""A sensor whose response can be measured."""
SHAFT_SPEED = 125.664
"""At which the chain is measured [rad/s]."""
SIZE = re.compile(rf"has ([\d.]+) m/s\^2 \(baseline {PAPER_LIMITS[0]:g} m")
"""The size of BPFO lines over the whole band, in the reason of a diagnosis of the paper's bearing."""


def spectra(file: Path) -> None:
    """Draw squared envelope spectra of the shipped benches, with the lines that name the faults."""
    largest, duration = 30.0, 8.0
    figure = Figure(figsize=(9.0, 10.0), layout="constrained")
    axes = figure.subplots(len(FAMILIES), 1, sharex=True)
    for ax, (bench, family) in zip(axes, FAMILIES.items(), strict=True):
        run = simulate(bench, duration, settings=BEHIND_A_BOX)
        spectrum = envelope_spectrum(run)
        orders = spectrum.orders.as_dict()
        order = 2.0 * orders["BSF"] if family == "two_bsf" else orders[family.upper()]
        shown = (spectrum.order > 0.1) & (spectrum.order < largest)
        for number in range(1, int(largest / order) + 1):
            ax.axvspan(number * order - 0.06, number * order + 0.06, color="tab:orange", alpha=0.3, linewidth=0)
        ax.plot(spectrum.order[shown], spectrum.amplitude[shown] / spectrum.mean, linewidth=0.8)
        title = f"{bench}: verdict {detect(run).verdict}; shaded: {LABELS[family]} and harmonics"
        ax.set_title(title, loc="left", fontsize="medium")
    figure.supylabel("squared envelope over its mean [-]")
    axes[-1].set_xlabel("order of the shaft [-]")
    axes[-1].set_xlim(0.0, largest)
    figure.savefig(file, dpi=90)


def sizes(file: Path) -> None:
    """Draw the size of the BPFO lines of the paper's bearing over its speed, healthy and with defects of two widths.

    A bearing without significant lines has no size.
    """
    figure = Figure(figsize=(9.0, 4.5), layout="constrained")
    ax: Axes = figure.subplots()
    ax.set_yscale("log")
    speeds = np.linspace(600.0, 1800.0, 9)
    for width, colour in ((0.0, "tab:green"), (0.001, "tab:orange"), (0.002, "tab:red")):
        lines = []
        for number, speed in enumerate(speeds):
            fault = {"faults.outer_1.width": width} if width else {}
            run = simulate("dry", 2.5, settings={"operating.speed": speed * np.pi / 30.0, "simulation.seed": number, **fault})
            size = SIZE.search(detect(run).reason)
            lines.append(float(size[1]) if size else np.nan)
        label = f"outer-ring defect of {width * 1e3:g} mm" if width else "healthy, if its lines are significant"
        ax.scatter(speeds, lines, s=16, color=colour, label=label)
    ax.axhline(PAPER_LIMITS[0], color="black", linewidth=1.0, label="baseline")
    ax.set(xlabel="speed [rpm]", ylabel="BPFO lines, 2 to 20 kHz,\nscaled to 20 Hz [m/s²]")
    ax.legend()
    ax.grid(alpha=0.3)
    figure.savefig(file, dpi=80)


def sensor_faults(file: Path) -> None:
    """Draw the waveform of an outer-ring defect with a sensor that fails, one axes per fault."""
    onset, duration = 0.2, 0.6
    faults = [fault for fault in get_args(SensorFault) if fault != "none"]
    figure = Figure(figsize=(9.0, 10.0), layout="constrained")
    axes = figure.subplots(len(faults), 1, sharex=True, sharey=True)
    for ax, fault in zip(axes, faults, strict=True):
        severity = 0.5 if fault == "stuck" else 0.8
        broken = {"sensor.fault": fault, "sensor.fault_severity": severity, "sensor.fault_time": 0.1}
        timeline = {"timeline": [{"at": onset, "set": broken}]}
        run = simulate("outer_ring_defect", duration, settings={**BEHIND_A_BOX, "sensor.range": 300.0}, scenario=timeline)
        ax.plot(np.arange(len(run.acceleration)) / run.sampling_rate, run.acceleration[:, 1], linewidth=0.5)
        ax.axvline(onset, color="tab:red", linewidth=0.8)
        ax.set_title(f"{fault}, severity {severity}", loc="left", fontsize="medium")
    axes[0].set_ylim(-150.0, 150.0)
    figure.supylabel("measured acceleration in Y [m/s²]")
    axes[-1].set_xlabel("time [s]")
    figure.savefig(file, dpi=90)


def measured(configuration: Configuration, ring: Floats) -> Floats:
    """Return an acceleration at every step as the chain measures it, shape (samples, 2) [m/s^2]."""
    angle = SHAFT_SPEED * np.arange(len(ring)) / configuration.step_rate
    return np.asarray(Sensor(configuration.measurement).measure(ring, angle).measured, np.float64)


def response(axis: int, **groups: Any) -> tuple[Floats, Floats]:
    """Return frequency [Hz] and gain [dB] of an axis, from the response to an impulse of one step."""
    sensor = groups.get("sensor", {})
    groups["sensor"] = {**PRESETS.get(sensor.get("preset", "none"), {}), **sensor, **QUIET, "cross_axis": 0.0}
    configuration = Configuration.model_validate(groups)
    ring = np.zeros((1 << 18, 2))
    ring[2048] = configuration.steps_per_sample
    impulse = measured(configuration, ring)[:, axis]
    frequency = np.fft.rfftfreq(len(impulse), 1.0 / configuration.sensor.sampling_rate)
    return np.asarray(frequency, np.float64), 20.0 * np.log10(np.maximum(np.abs(np.fft.rfft(impulse)), 1e-6))


def transfer(file: Path) -> None:
    """Draw the gain of presets, of an axle box and of the anti-alias filters."""
    presets = {name: response(0, sensor={"preset": name}) for name in ("ideal", "iepe_100mv_g", "mems")}
    boxes = {f"axle box, 6 modes, {axis}": response(k, structure={"modes": 6}) for k, axis in enumerate("XY")}
    figure = Figure(figsize=(11.0, 3.6), layout="constrained")
    left, middle, right = figure.subplots(1, 3)
    for ax, curves, title in ((left, presets, "presets"), (middle, boxes, "structural path")):
        for name, curve in curves.items():
            ax.semilogx(*curve, label=name, linewidth=1.1)
        ax.set(xlim=(0.4, 25600), ylim=(-30, 25), xlabel="frequency [Hz]", title=title)
    for rate, factor, steps in ((12800, 8, 102400), (25600, 4, 102400), (51200, 2, 102400), (102400, 2, 204800)):
        frequency, gain = signal.freqz(anti_alias_taps(factor, between=True), worN=8192, fs=steps)
        right.plot(frequency / 1e3, 20.0 * np.log10(np.maximum(np.abs(gain), 1e-7)), label=f"{rate / 1e3:g} kHz", linewidth=0.9)
    right.axhline(-80.0, color="black", linewidth=0.8, linestyle="--")
    right.set(xlim=(0, 102), ylim=(-120, 5), xlabel="frequency before decimation [kHz]", title="anti-alias filter by output rate")
    left.set_ylabel("gain [dB]")
    for ax in (left, middle, right):
        ax.title.set_fontsize(10)
        ax.grid(alpha=0.3)
        ax.legend(loc="upper right" if ax is right else "lower left", fontsize=8)
    figure.savefig(file, dpi=105)


def noise(file: Path) -> None:
    """Draw the noise density of the default sensor and of the presets."""
    figure = Figure(figsize=(7.0, 3.8), layout="constrained")
    ax: Axes = figure.subplots()
    for name, label in {"none": "default sensor", "iepe_100mv_g": "iepe_100mv_g", "mems": "mems"}.items():
        configuration = load_configuration("dry", [f"sensor.preset={name}", "sensor.bias=0.0", "sensor.bias_drift=0.0"])
        samples = measured(configuration, np.zeros((round(40.0 * configuration.step_rate), 2)))
        frequency, power = signal.welch(samples[:, 0], configuration.sensor.sampling_rate, nperseg=1 << 18)
        edges = np.geomspace(0.4, 25600.0, 120)
        band = np.digitize(frequency, edges)
        means = [(edges[k - 1], power[band == k].mean()) for k in range(1, len(edges)) if np.any(band == k)]
        ax.loglog([edge for edge, _ in means], [np.sqrt(mean) / MICRO_G for _, mean in means], label=label)
    ax.set(xlabel="frequency [Hz]", ylabel="noise density [µg/√Hz]", xlim=(0.4, 25600))
    ax.grid(alpha=0.3, which="both")
    ax.legend(fontsize=8)
    figure.savefig(file, dpi=110)


def background(file: Path) -> None:
    """Draw each disturbance alone on a rigid box, and all of them through the axle box."""
    alone: dict[str, dict[str, float]] = {
        "unbalance 5e-5 m": {"unbalance": 5e-5},
        "rail joints 40 m/s², 5 m apart": {"joint_level": 40.0, "joint_spacing": 5.0},
        "wheel flat 30 m/s²": {"flat_level": 30.0},
        "track noise 4 m/s²": {"track_level": 4.0},
        "look-alike impacts 20 /s, 150 m/s²": {"impact_rate": 20.0, "impact_level": 150.0},
        "mains hum 2 m/s²": {"hum_level": 2.0},
    }
    together = {key: level for levels in alone.values() for key, level in levels.items()}
    rows: list[tuple[str, dict[str, Any]]] = [(name, {"background": levels}) for name, levels in alone.items()]
    rows.append(("all, through 6 modes of the axle box", {"background": together, "structure": {"modes": 6}}))
    figure = Figure(figsize=(9.0, 8.5), layout="constrained")
    axes = figure.subplots(len(rows), 1, sharex=True)
    for ax, (name, groups) in zip(axes, rows, strict=True):
        configuration = Configuration.model_validate({**groups, "sensor": {"preset": "ideal"}})
        samples = measured(configuration, np.zeros((round(0.4 * configuration.step_rate), 2)))[:, 1]
        ax.plot(np.arange(len(samples)) / configuration.sensor.sampling_rate, samples, linewidth=0.7)
        ax.set_title(name, fontsize=9, loc="left")
        ax.grid(alpha=0.3)
    axes[-1].set_xlabel("time [s]")
    kmh = 3.6 * SHAFT_SPEED * 0.5 * load_configuration("dry").operating.wheel_diameter
    figure.supylabel(f"acceleration in Y at {kmh:.0f} km/h [m/s²]", fontsize=9)
    figure.savefig(file, dpi=90)
