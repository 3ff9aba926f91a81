"""The scores of the experiment as a figure."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt
from sim_to_real_scores import Gap, Score

COLOURS = ("C0", "0.6", "C2", "C1")
"""Colours of the trainings."""


def write_figure(rows: Sequence[tuple[str, str, str, Score]], path: Path) -> None:
    """Write macro AUROC with its bounds by rig and training; of the sets of features the one without band levels."""
    rows = [row for row in rows if row[2].startswith(("-", "without"))]
    rigs = list(dict.fromkeys(rig for rig, *_ in rows))
    figure, axes = plt.subplots(1, len(rigs), figsize=(11.0, 3.2), sharex=True, squeeze=False, layout="constrained")
    for axis, rig in zip(axes[0], rigs, strict=True):
        scores = [(training, score) for name, training, _, score in rows if name == rig]
        for row, (training, score) in enumerate(reversed(scores)):
            colour = "C0" if training.startswith("simulated") else "C1" if training.startswith(("measured", "its own")) else "0.3"
            axis.plot([score.low, score.high], [row, row], color=colour, lw=2)
            axis.plot(score.macro, row, "o", color=colour)
        axis.set_yticks(range(len(scores)), [training for training, _ in reversed(scores)], fontsize=8)
        axis.set_title(f"tested on {rig}", fontsize=10)
        axis.set_xlim(0.48, 1.02)
        axis.axvline(0.85, color="0.7", lw=0.8, ls="--")
        axis.set_xlabel("macro AUROC, 90 % bounds", fontsize=8)
        axis.grid(axis="x", alpha=0.3)
    figure.savefig(path, dpi=110)


def write_gaps(gaps: Sequence[Gap], path: Path) -> None:
    """Write how far the windows of trainings are from the measured ones of a rig, by rig, class and training, as bars."""
    rigs = list(dict.fromkeys(gap.rig for gap in gaps))
    trainings = list(dict.fromkeys(gap.training for gap in gaps))
    figure, axes = plt.subplots(1, 2 * len(rigs), figsize=(11.0, 3.2), sharey=True, squeeze=False, layout="constrained")
    for number, axis in enumerate(axes[0]):
        rig, levels = rigs[number // 2], number % 2 == 0
        faults = list(dict.fromkeys(gap.fault for gap in gaps if gap.rig == rig))
        for k, training in enumerate(trainings):
            scores = [gap for gap in gaps if (gap.rig, gap.training) == (rig, training)]
            width = 0.8 / len(trainings)
            positions = [faults.index(gap.fault) + width * (k + 0.5) - 0.4 for gap in scores]
            axis.bar(positions, [gap.level if levels else gap.shape for gap in scores], 0.95 * width, color=COLOURS[k], label=training)
        axis.set_xticks(range(len(faults)), [fault.replace("_", " ") for fault in faults], fontsize=8)
        axis.set_title(f"{rig}: {'band levels' if levels else 'all other features'}", fontsize=10)
        axis.grid(axis="y", alpha=0.3)
    axes[0][0].set_ylim(0.0, 1.0)
    axes[0][0].set_ylabel("windows of the rig against others,\nmean of |2 AUROC - 1|", fontsize=8)
    axes[0][-1].legend(fontsize=8)
    figure.savefig(path, dpi=110)
