"""The scores of the experiment as a figure."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt
from sim_to_real_scores import Score


def write_figure(rows: Sequence[tuple[str, str, str, Score]], path: Path) -> None:
    """Write macro AUROC with its bounds by rig and training; of the sets of features the one without band levels."""
    rows = [row for row in rows if row[2] != "with band levels"]
    rigs = list(dict.fromkeys(rig for rig, *_ in rows))
    figure, axes = plt.subplots(1, len(rigs), figsize=(11.0, 3.2), sharex=True, squeeze=False, layout="constrained")
    for axis, rig in zip(axes[0], rigs, strict=True):
        own = [(training, score) for name, training, _, score in rows if name == rig]
        for place, (training, score) in enumerate(reversed(own)):
            colour = "C0" if training.startswith("simulated") else "C1" if training.startswith("measured") else "0.3"
            axis.plot([score.low, score.high], [place, place], color=colour, lw=2)
            axis.plot(score.macro, place, "o", color=colour)
        axis.set_yticks(range(len(own)), [training for training, _ in reversed(own)], fontsize=8)
        axis.set_title(f"tested on {rig}", fontsize=10)
        axis.set_xlim(0.48, 1.02)
        axis.axvline(0.85, color="0.7", lw=0.8, ls="--")
        axis.set_xlabel("macro AUROC, 90 % bounds", fontsize=8)
        axis.grid(axis="x", alpha=0.3)
    figure.savefig(path, dpi=110)
