"""The figures of docs/explanation/measurement-chain.md, measured: transfer functions, noise, background and sensor faults."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import numpy.typing as npt
from scipy import signal

from dcrb_ros.measurement.decimation import anti_alias_taps
from dcrb_ros.measurement.parameters import MICRO_G
from dcrb_ros.measurement.sensor import Sensor
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.settings.sensor import PRESETS
from dcrb_ros.simulation.loop import Simulation

matplotlib.use("Agg")
import matplotlib.pyplot as plt

QUIET = {"noise_density": 0.0, "white_noise_ug": 0.0, "pink_noise_ug": 0.0, "adc_bits": 0, "range": 1e6, "bias": 0.0, "bias_drift": 0.0}
SPEED = 125.664
FAULTS = ("stuck", "loose", "saturated", "spikes", "dead", "gain_drift")


def measured(configuration: Configuration, ring: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return what the chain makes of an acceleration at every step, shape (samples, 2) [m/s^2]."""
    return Sensor(configuration.measurement).measure(ring, SPEED * np.arange(len(ring)) / configuration.step_rate).measured


def response(axis: int, **groups: Any) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return frequency [Hz] and gain [dB] of an axis, from the answer to a blow of one step."""
    groups["sensor"] = {**PRESETS[groups.get("sensor", {}).get("preset", "none")], **groups.get("sensor", {}), **QUIET, "cross_axis": 0.0}
    configuration = Configuration.model_validate(groups)
    ring = np.zeros((1 << 18, 2))
    ring[2048] = configuration.steps_per_sample
    answer = measured(configuration, ring)[:, axis]
    frequency = np.fft.rfftfreq(len(answer), 1.0 / configuration.sensor.sampling_rate)
    return frequency, 20.0 * np.log10(np.maximum(np.abs(np.fft.rfft(answer)), 1e-6))


def transfer(path: Path) -> None:
    """Draw the gain of the stages."""
    box = {"modes": 6}
    presets = {name: response(0, sensor={"preset": name}) for name in ("ideal", "iepe_100mv_g", "mems")}
    boxes = {f"axle box, 6 modes, {axis}": response(k, structure=box) for k, axis in enumerate("XY")}
    figure, panels = plt.subplots(1, 3, figsize=(11.0, 3.6), layout="constrained")
    for panel, curves in zip(panels, (presets, boxes), strict=False):
        for name, curve in curves.items():
            panel.semilogx(*curve, label=name, linewidth=1.1)
        panel.set(xlim=(0.4, 25600), ylim=(-30, 25))
    for rate, factor, steps in ((12800, 8, 102400), (25600, 4, 102400), (51200, 2, 102400), (102400, 2, 204800)):
        frequency, gain = signal.freqz(anti_alias_taps(factor, between=True), worN=8192, fs=steps)
        panels[2].plot(frequency / 1e3, 20.0 * np.log10(np.maximum(np.abs(gain), 1e-7)), label=f"{rate / 1e3:g} kHz", linewidth=0.9)
    panels[2].axhline(-80.0, color="black", linewidth=0.8, linestyle="--")
    panels[2].set(xlim=(0, 102), ylim=(-120, 5), xlabel="frequency before decimation [kHz]", title="anti-alias filter by output rate")
    panels[0].set(ylabel="gain [dB]", xlabel="frequency [Hz]", title="presets")
    panels[1].set(xlabel="frequency [Hz]", title="structural path")
    for panel in panels:
        panel.title.set_fontsize(10)
        panel.grid(alpha=0.3)
        panel.legend(loc="lower left" if panel is not panels[2] else "upper right", fontsize=8)
    figure.savefig(path / "measurement-transfer.png", dpi=105)


def noise(path: Path) -> None:
    """Draw the noise of the presets."""
    figure, panel = plt.subplots(figsize=(7.0, 3.8), layout="constrained")
    for name in PRESETS:
        if name == "ideal":
            continue
        configuration = load_configuration("healthy", [f"sensor.preset={name}", "sensor.bias=0.0", "sensor.bias_drift=0.0"])
        samples = measured(configuration, np.zeros((round(40.0 * configuration.step_rate), 2)))
        frequency, power = signal.welch(samples[:, 0], configuration.sensor.sampling_rate, nperseg=1 << 18)
        edges = np.geomspace(0.4, 25600.0, 120)
        place = np.digitize(frequency, edges)
        means = [(edges[k - 1], power[place == k].mean()) for k in range(1, len(edges)) if np.any(place == k)]
        label = "default (noise_density 2e-3 m/s²/√Hz)" if name == "none" else name
        panel.loglog([at for at, _ in means], [np.sqrt(mean) / MICRO_G for _, mean in means], label=label)
    panel.set(xlabel="frequency [Hz]", ylabel="noise density [µg/√Hz]", xlim=(0.4, 25600))
    panel.grid(alpha=0.3, which="both")
    panel.legend(fontsize=8)
    figure.savefig(path / "measurement-noise.png", dpi=110)


def background(path: Path) -> None:
    """Draw each disturbance alone on a rigid box, and all of them through the axle box."""
    alone = {
        "unbalance 5e-5 m": {"unbalance": 5e-5},
        "rail joints 40 m/s², 5 m apart": {"joint_level": 40.0, "joint_spacing": 5.0},
        "wheel flat 30 m/s²": {"flat_level": 30.0},
        "track noise 4 m/s²": {"track_level": 4.0},
        "look-alike impacts 20 /s, 150 m/s²": {"impact_rate": 20.0, "impact_level": 150.0},
        "mains hum 2 m/s²": {"hum_level": 2.0},
    }
    together: dict[str, float] = {}
    for levels in alone.values():
        together |= levels
    rows = [(name, {"background": levels}) for name, levels in alone.items()]
    rows.append(("all, through 6 modes of the axle box", {"background": together, "structure": {"modes": 6}}))
    figure, panels = plt.subplots(len(rows), 1, figsize=(9.0, 8.5), layout="constrained", sharex=True)
    for panel, (name, groups) in zip(panels, rows, strict=True):
        configuration = Configuration.model_validate({**groups, "sensor": {"preset": "ideal"}})
        samples = measured(configuration, np.zeros((round(0.4 * configuration.step_rate), 2)))[:, 1]
        panel.plot(np.arange(len(samples)) / configuration.sensor.sampling_rate, samples, linewidth=0.7)
        panel.set_title(name, fontsize=9, loc="left")
        panel.grid(alpha=0.3)
    panels[-1].set_xlabel("time [s]")
    figure.supylabel("acceleration in Y at 208 km/h [m/s²]", fontsize=9)
    figure.savefig(path / "measurement-background.png", dpi=90)


def faults(path: Path) -> None:
    """Draw an outer-ring defect as a sensor measures it that fails at 0.1 s."""
    figure, panels = plt.subplots(len(FAULTS), 1, figsize=(9.0, 8.0), layout="constrained", sharex=True)
    for panel, name in zip(panels, FAULTS, strict=True):
        configuration = load_configuration("outer_ring_defect", ["cage.joint=revolute", "sensor.fault_time=0.1"])
        simulation = Simulation(configuration)
        blocks = list(simulation.blocks(0.1))
        severity = 0.5 if name == "stuck" else 0.8
        simulation.change({"sensor.fault": name, "sensor.fault_severity": severity})
        samples = np.concatenate([block.acceleration for block in [*blocks, *simulation.blocks(0.2)]])[:, 1]
        panel.plot(np.arange(len(samples)) / configuration.sensor.sampling_rate, samples, linewidth=0.6)
        panel.set_title(f"{name}, severity {severity}", fontsize=9, loc="left")
        panel.axvline(0.1, color="tab:red", linewidth=0.8)
        panel.grid(alpha=0.3)
    panels[-1].set_xlabel("time [s]")
    figure.supylabel("measured acceleration in Y [m/s²]", fontsize=9)
    figure.savefig(path / "measurement-faults.png", dpi=90)


def main() -> None:
    """Draw all of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, nargs="?", default=Path(__file__).parents[1] / "docs" / "images")
    folder = parser.parse_args().folder
    for draw in (transfer, noise, background, faults):
        draw(folder)


if __name__ == "__main__":
    main()
