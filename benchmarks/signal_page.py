"""The tables of docs/results/signals.md: measured beside simulated signals, and the ranges that the simulated ones must reach."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from signal_machines import Row

from dcrb_ros.text.markdown import table

Groups = Mapping[str, list[Row]]

QUANTITIES = {
    "ratio": "R",
    "ratio_growth": "growth of R, 2 to 20 kHz",
    "kurtogram_growth": "growth of R, kurtogram",
    "energy_scatter": "scatter of energy, c_E",
    "neighbour": "correlation at lag 1",
    "element": "correlation at lag Z",
    "shaft": "share of the angle of the shaft",
    "jitter": "shared jitter [ms]",
    "depth": "depth of the line",
    "harmonic_8": "depth of harmonic 8",
    "crest": "crest of the envelope [dB]",
    "cage": "depth of the lines of the cage",
    "sidebands": "sidebands at the shaft frequency",
    "kurtosis": "kurtosis",
    "middle": "power in 5 to 10 kHz [dB]",
    "upper": "power in 10 to 20 kHz [dB]",
    "cut_off": "95 % of the power below [kHz]",
    "octave_1": "spectral kurtosis, 1 to 2 kHz",
    "octave_2": "2 to 4 kHz",
    "octave_4": "4 to 8 kHz",
    "octave_8": "8 to 16 kHz",
}
"""Name and unit of the quantities in the order of the tables."""


class Aim(NamedTuple):
    """A range in which the median of simulated machines is expected."""

    test: str
    kind: str
    quantity: str
    low: float
    high: float


AIMS = (
    Aim("T3", "outer", "middle", -12.0, -5.0),
    Aim("T3", "outer", "upper", -18.0, -4.0),
    Aim("T3", "outer", "cut_off", 8.0, 19.0),
    Aim("T5", "outer", "ratio", 25.0, 60.0),
    Aim("T5", "outer", "ratio_growth", 2.5, 10.0),
    Aim("T5", "outer", "kurtogram_growth", 1.8, 4.5),
    Aim("T6", "outer", "energy_scatter", 0.4, 1.3),
    Aim("T6", "outer", "neighbour", -0.35, 0.0),
    Aim("T6", "outer", "jitter", 0.03, 0.2),
    Aim("T7", "outer", "depth", 0.6, 1.6),
    Aim("T7", "outer", "crest", 12.0, 24.0),
    Aim("T7", "outer", "cage", 0.03, 0.2),
    Aim("T7", "outer", "sidebands", 0.08, 0.55),
    Aim("T8", "inner", "sidebands", 0.35, 0.75),
    Aim("T9", "ball", "kurtosis", 3.2, 9.0),
    Aim("T10", "healthy", "kurtosis", 2.7, 3.5),
    Aim("T10", "healthy", "depth", 0.0, 0.3),
)
"""The expected ranges of T3 to T10, stated before the model was built."""
ELEMENT = 0.0, 0.25
"""Correlations at lag Z that the quartiles of T6 enclose [-]."""


def values_of(rows: list[Row], quantity: str) -> list[float]:
    """Return a quantity of some rows, without those that are unknown."""
    values = [getattr(row if hasattr(row, quantity) else row.statistics, quantity) for row in rows]
    return [value for value in values if np.isfinite(value)]


def number(value: float) -> str:
    """Return a number with two significant digits, or three from 10 on without a decimal point."""
    return f"{value:.0f}" if abs(value) >= 10.0 else f"{value:.1f}" if abs(value) >= 1.0 else f"{value:.2f}"


def cell(rows: list[Row], quantity: str) -> str:
    """Return median and quartiles of a quantity, or nothing if no row has it."""
    values = values_of(rows, quantity)
    if not values:
        return ""
    low, middle, high = np.percentile(values, (25, 50, 75))
    return f"{number(middle)} ({number(low)} to {number(high)})"


def statistics_table(groups: Groups) -> str:
    """Return a table of all quantities, a column for each group."""
    rows = []
    for quantity, name in QUANTITIES.items():
        cells = [cell(group, quantity) for group in groups.values()]
        if any(cells):
            rows.append((name, *cells))
    return table(("median (quartiles)", *(f"{name} ({len(group)})" for name, group in groups.items())), rows)


def aims_table(groups: Callable[[str, str], list[Row]], variants: tuple[str, ...]) -> str:
    """Return the expected ranges beside the medians of variants of the simulation, of which ``groups`` returns a kind of defect."""
    rows = []
    for aim in AIMS:
        cells = []
        for variant in variants:
            values = values_of(groups(variant, aim.kind), aim.quantity)
            middle = float(np.median(values)) if values else float("nan")
            cells.append(f"{number(middle)} {verdict(aim.low <= middle <= aim.high)}" if values else "")
        rows.append((aim.test, aim.kind, QUANTITIES[aim.quantity], f"{number(aim.low)} to {number(aim.high)}", *cells))
    quartiles, alarms = [], []
    for variant in variants:
        values = values_of(groups(variant, "outer"), "element")
        low, high = np.percentile(values, (25, 75)) if values else (np.nan, np.nan)
        quartiles.append(f"{number(low)} to {number(high)} {verdict(low <= ELEMENT[0] and high >= ELEMENT[1])}" if values else "")
        verdicts = [row.verdict for row in groups(variant, "healthy") if row.verdict]
        false = len(verdicts) - verdicts.count("healthy")
        alarms.append(f"{false} of {len(verdicts)} {verdict(false == 0)}" if verdicts else "")
    expected = f"enclose {ELEMENT[0]:g} to {ELEMENT[1]:g}"
    rows.append(("T6", "outer", "quartiles of the correlation at lag Z", expected, *quartiles))
    rows.append(("T10", "healthy", "false alarms of the shipped detector", "0", *alarms))
    return table(("test", "defect", "quantity", "expected", *variants), rows)


def verdict(reached: bool) -> str:
    """Return whether an aim is reached, in one word."""
    return "yes" if reached else "**no**"
