"""The axial preload of balls as an interference in the plane."""

from __future__ import annotations

import numpy as np
import pytest

from dcrb_ros.bearing.payload import build_payload, initial_state
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.files import load_configuration


def loads(share: float, bench: str = "ball_bearing_6205") -> Floats:
    """Return the forces of the rolling elements of row 1 of a resting bench over the largest one, from the load line on [-]."""
    even = ("waviness", "roundness", "roller_spread", "run_out", "short_waves")
    configuration = load_configuration(bench, [f"impacts.axial_share={share}", *(f"surfaces.{name}=0.0" for name in even)])
    payload = build_payload(configuration)
    forces = initial_state(configuration, payload).outer_force[0]
    return np.asarray(np.sort(forces / forces.max())[::-1])


def test_an_axial_preload_loads_balls_beside_the_load_line() -> None:
    """Balls 4 and 5 of nine lie 80 degrees from the load line, where (d_0 + d_r cos psi)^1.5 is 0.40 and 0.67 for shares of 0.3 and 0.6."""
    none, some, much = loads(1.0), loads(0.3), loads(0.6)
    assert none[3:].max() < 0.05
    assert some[3:5].mean() == pytest.approx(0.40, abs=0.06)
    assert much[3:5].mean() == pytest.approx(0.67, abs=0.06)
    assert np.all(much > some - 1e-9)


@pytest.mark.parametrize(("share", "forces"), [(0.3, (0.787, 0.300)), (0.6, (0.881, 0.600))])
def test_rollers_of_two_rows_share_the_load(share: float, forces: tuple[float, float]) -> None:
    """Of 16 rollers, two lie 45 and two 90 degrees from the load line, where (d_0 + d_r cos psi)^(10/9) has these shares."""
    found = loads(share, "healthy")
    assert (found[3:5].mean(), found[7:9].mean()) == pytest.approx(forces, abs=0.1)
