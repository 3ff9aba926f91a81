"""Tables of the accuracy benchmark."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dcrb_ros.settings.parameters import SimulationParameters

Floats = npt.NDArray[np.float64]

STEP = SimulationParameters().step
"""The default step [s]."""
JOINTS = ("revolute", "pocket")


class Entry(NamedTuple):
    """One row of a table."""

    cells: tuple[str, ...]
    holds: bool | None = None
    """Whether it is within its tolerance; None for a row without tolerance."""


def print_table(title: str, tolerance: str, heads: Sequence[str], entries: Iterable[Entry]) -> bool:
    """Print a table row by row; return whether all rows are within their tolerances."""
    print(f"\n### {title}\n\n{tolerance}\n\n| " + " | ".join([*heads, "verdict"]) + " |\n|" + "---|" * (len(heads) + 1))
    passed = True
    for entry in entries:
        verdict = {None: "", True: "passed", False: "**failed**"}[entry.holds]
        print("| " + " | ".join([*entry.cells, verdict]) + " |", flush=True)
        passed = passed and entry.holds is not False
    return passed


def step_name(part: int) -> str:
    """Return the name of a fraction of the default step h."""
    return f"h/{part}" if part > 1 else "h"


def percent(share: float) -> str:
    """Return a ratio as text in percent."""
    return f"{100.0 * share:.3f} %"


def relative_rms(found: Floats, exact: Floats) -> float:
    """Return the rms of the error over the rms of the exact values [-]."""
    return float(np.linalg.norm(found - exact) / np.linalg.norm(exact))
