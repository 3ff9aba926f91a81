"""Rows that pin the amplitude and the cage of the bench `dry`, which no figure of the paper shows.

Their values are this model's own, at the paper's speed; `assumptions.md` lists which changes of the bench they notice.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from dcrb_ros.validation.report_row import PAPER, ReportRow, between
from dcrb_ros.validation.runs import PaperRun

RMS = 8.9, 10.2
"""Accepted standard deviation of the outer ring's acceleration in Y [m/s^2]; parts of a run scatter by 3 %."""
PRESSING = 0.065, 0.09
"""Accepted share of time in which a roller presses a bar [-]."""
BAR_FORCE = 12.0, 20.0
"""Accepted root mean square of the force at bars [N]."""
OFFSET = 2.9e-4, 3.1e-4
"""Accepted mean distance of a cage's centre from the outer ring's [m]: the cages run along their lands."""
FRICTION = 42.0, 44.6
"""Accepted power lost in friction [W]."""


def dry_bench_rows(run: PaperRun) -> Iterator[ReportRow]:
    """Yield the comparisons of the healthy bearing with free rollers."""
    bars = run.bar_force[run.settled]
    for quantity, value, accepted, unit in (
        ("Acceleration of the outer ring, vertical: RMS", float(run.steady_acceleration.std()), RMS, "m/s^2"),
        ("Share of time in which a roller presses a bar", float((bars != 0.0).mean()), PRESSING, ""),
        ("Force at the bars: RMS", float(np.sqrt((bars.astype(np.float64) ** 2).mean())), BAR_FORCE, "N"),
        ("Distance of a cage's centre from the outer ring's", float(run.cage_offset[run.settled].mean()), OFFSET, "m"),
        ("Power lost in friction", run.energy.friction / float(run.time[-1]), FRICTION, "W"),
    ):
        yield between(PAPER, f"{quantity}, healthy", value, *accepted, unit)
