"""Draw how a bearing without grease burns off: temperatures, heat, film and vibration over time.

dcrb simulate healthy --scenario burn_off --duration 45 -o burn_off
python examples/burn_off.py burn_off -o burn_off.png
"""

from __future__ import annotations

import argparse

import numpy as np
from matplotlib.figure import Figure

from dcrb_ros import Recording, Refusal

LIMIT = 94.4
"""Temperature above ambient at which wayside detectors alarm [K]."""


def main(folder: str, output: str) -> None:
    """Draw the recording in a folder to a file."""
    recording = Recording(folder)
    truth, states, waveform = recording.truth(), recording.states(), recording.waveform()
    time = truth.time
    node = {name: truth.thermal(f"row1/{name} [deg C]") for name in ("inner_ring", "outer_ring")} | {"box": truth.thermal("box [deg C]")}
    heat = sum(truth.thermal(name) for name in truth.truths[0].thermal if name.startswith("row") and name.endswith("[W]"))
    # Wayside detectors see the box, and a little of the ring.
    seen = node["box"] + 0.15 * (node["outer_ring"] - node["box"]) - truth.thermal("ambient [deg C]")
    part = waveform.sampling_rate // 4
    count = len(waveform) // part
    parts = waveform.acceleration[: count * part].reshape(count, part, 2)
    rms = np.sqrt((parts.astype(float) ** 2).mean(axis=1))

    figure = Figure(figsize=(8.0, 8.6), dpi=110, layout="constrained")
    warm, power, film, noise = figure.subplots(4, 1, sharex=True)
    for name, colour in (("inner_ring", "#D55E00"), ("outer_ring", "#E69F00"), ("box", "#0072B2")):
        warm.plot(time, node[name], color=colour, label=name.replace("_", " "))
    if (seen > LIMIT).any():
        warm.axvline(time[np.argmax(seen > LIMIT)], color="black", linestyle=":", linewidth=1.0, label="wayside rule: 94.4 K")
    warm.legend(loc="upper left", fontsize="small")
    power.plot(time, heat * 1e-3, color="#CC79A7")
    film.semilogy(states.time, states.least_film_ratio[:, 0, 0], color="#009E73", linewidth=0.8)
    film.axhline(1.0, color="black", linestyle=":", linewidth=1.0)
    for column, (axis, colour) in enumerate((("X", "#E69F00"), ("Y", "#0072B2"))):
        noise.plot(waveform.time[0] + (np.arange(len(rms)) + 0.5) * part / waveform.sampling_rate, rms[:, column], color=colour, label=axis)
    noise.legend(loc="upper left", fontsize="small")
    lost = truth.thermal("lubricant_loss")
    for ax, label in (
        (warm, "temperature [°C]"),
        (power, "heat of both rows [kW]"),
        (film, "film ratio Λ, inner"),
        (noise, "rms of 0.25 s [m/s²]"),
    ):
        ax.axvspan(time[np.argmax(lost > 0.0)], time[np.argmax(lost >= lost.max())], color="0.9")
        ax.set_ylabel(label)
        ax.grid(alpha=0.3)
    noise.set_xlabel(f"simulated time [s]; heat is stored {truth.thermal('acceleration')[0]:g} times as fast, grey: the grease is lost")
    figure.savefig(output)
    print(f"{output}: at most {node['inner_ring'].max():.0f} °C, {heat.max() * 1e-3:.1f} kW")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recording")
    parser.add_argument("-o", "--output", default="burn_off.png")
    arguments = parser.parse_args()
    try:
        main(arguments.recording, arguments.output)
    except Refusal as refusal:
        parser.error(str(refusal))
