"""The leaderboard as a figure: marks with their intervals, and which detectors are distinguished."""

from __future__ import annotations

import itertools

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from dcrb_ros.exam.leaderboard import Board
from dcrb_ros.exam.marking import compare
from dcrb_ros.schema.printable import printable, shortened

COLOURS = {"safety": "#b23a48", "cost": "#2a9d5c"}
COLOUR = "#1f6fb4"
"""Colour of the mark by which entries are sorted."""
LONGEST = 34
"""Longest name shown [characters]."""


def board_figure(board: Board) -> Figure:
    """Return the figure of a leaderboard."""
    count = len(board.entries)
    figure = Figure(figsize=(12, 2.2 + 0.42 * count), dpi=90, layout="constrained")
    scores, pairs = figure.subplots(1, 2, width_ratios=(1.4, 1.0))
    _scores(scores, board)
    _pairs(pairs, board)
    figure.suptitle(f"{printable(board.exam)}: {board.marking.name}, 0 to 100", fontsize=12, parse_math=False)
    return figure


def _names(board: Board) -> list[str]:
    return [shortened(printable(entry.detector), LONGEST, "…") for entry in board.entries]


def _scores(axes: Axes, board: Board) -> None:
    axes.set_title("95 % confidence (bootstrap over scenarios)", fontsize=10)
    rows = [board.marking.series(entry) for entry in board.entries]
    names = list(rows[0])
    for number, name in enumerate(names):
        estimates, shift = [row[name] for row in rows], 0.22 * (number - 0.5 * (len(names) - 1))
        # A percentile interval need not contain its estimate.
        error = [[max(0.0, s.value - s.low) for s in estimates], [max(0.0, s.high - s.value) for s in estimates]]
        heights = np.arange(len(estimates)) + shift
        axes.errorbar(
            [s.value for s in estimates],
            heights,
            xerr=error,
            fmt="o",
            ms=4,
            lw=1.2,
            capsize=2,
            color=COLOURS.get(name, COLOUR),
            label=name,
        )
    labels = [f"{name}  {number}" for number, name in enumerate(_names(board), 1)]
    axes.set_yticks(range(len(rows)), labels, fontsize=8, parse_math=False)
    axes.set(xlabel=f"{board.marking.name} [{board.marking.unit}]", xlim=(-2.0, 102.0), ylim=(len(rows) - 0.5, -0.5))
    if len(names) > 1:
        axes.legend(fontsize=8, loc="best")
    axes.grid(alpha=0.25)


MOST_NUMBERS = 15
"""Entries up to which every pair has its number [-]; more do not fit."""


def _pairs(axes: Axes, board: Board) -> None:
    axes.set_title("Row better than column [% of samples]", fontsize=10)
    count = len(board.entries)
    shares, marking, entries = np.full((count, count), np.nan), board.marking, board.entries
    for i, j in itertools.combinations(range(count), 2):
        comparison = compare(marking, entries[i], entries[j])
        shares[i, j], shares[j, i] = 100.0 * comparison.confidence, 100.0 * (1.0 - comparison.confidence)
        for row, column in ((i, j), (j, i)):
            weight = "bold" if comparison.distinguished else "normal"
            colour = "white" if shares[row, column] > 75.0 else "black"
            text = f"{shares[row, column]:.0f}" if count <= MOST_NUMBERS else "×" * comparison.distinguished
            axes.text(column, row, text, ha="center", va="center", fontsize=8, color=colour, fontweight=weight)
    axes.imshow(shares, cmap="Blues", vmin=0.0, vmax=110.0, aspect="auto")
    places = range(0, count, 1 if count <= MOST_NUMBERS else 5)
    axes.set_xticks(places, [str(k + 1) for k in places], fontsize=8)
    axes.set_yticks(places, [str(k + 1) for k in places], fontsize=8)
    mark = "bold" if count <= MOST_NUMBERS else "×"
    axes.set(xlabel=f"place\n{mark}: 95 % interval of the difference excludes 0", ylabel="place")
