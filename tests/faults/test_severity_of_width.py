"""How loud a spall of a constant share of the length is over its width: it grows until the rollers reach its floor."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from dcrb_ros.simulation.run import simulate

pytestmark = pytest.mark.slow


@cache
def level(width: float, rpm: float) -> float:
    """Return the rms of Y [m/s^2] for a spall of a width [m] over 0.3 of the length, averaged over the impacts of 0.5 s in both rows."""
    spall = {"kind": "spall", "width": width, "depth": 60e-6, "share": 0.3, "roughness": 0.0}
    settings = {f"faults.outer_1.{key}": value for key, value in spall.items()}
    settings |= {"operating.speed": rpm * np.pi / 30.0, "structure.housing": "none"}
    run = simulate("healthy", 0.6, settings=settings)
    return float(run.between(0.1).acceleration[:, 1].std())


def test_a_wider_spall_is_louder_until_rollers_reach_its_floor() -> None:
    """At 2400 rpm both edges are crossed within half a period of the oscillation that they excite: docs/results/realism.md."""
    levels = [level(width, 2400.0) for width in (0.0005, 0.001, 0.002, 0.003)]
    assert np.all(np.diff(levels) > 0.0), levels
    assert levels[-1] > 3.0 * levels[1], levels


def test_a_spall_wider_than_its_reach_is_not_louder() -> None:
    """At 600 rpm from 3 mm on, rollers reach 60 um; the edges add up or cancel by a tenth."""
    levels = [level(width, 600.0) for width in (0.003, 0.006, 0.010)]
    assert max(levels) < 1.25 * min(levels), levels
    assert min(levels) > level(0.001, 600.0), levels
