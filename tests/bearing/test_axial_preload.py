"""The axial preload of balls as an interference in the plane."""

from __future__ import annotations

import numpy as np
import pytest

from dcrb_ros.bearing.payload import build_payload, initial_state
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.files import load_configuration


def loads(share: float) -> Floats:
    """Return the forces of the balls of the resting bench over the largest one, from the load line on [-]."""
    configuration = load_configuration(
        "ball_bearing_6205",
        [f"impacts.axial_share={share}", "surfaces.waviness=0.0", "surfaces.roundness=0.0", "surfaces.roller_spread=0.0"],
    )
    payload = build_payload(configuration)
    forces = initial_state(configuration, payload).outer_force[0]
    return np.asarray(np.sort(forces / forces.max())[::-1])


def test_an_axial_preload_loads_balls_beside_the_load_line() -> None:
    """At 80 degrees from the load line, balls 2 and 3 of nine, the load is near the share."""
    none, some, much = loads(1.0), loads(0.3), loads(0.6)
    assert np.count_nonzero(none > 0.05) <= 5
    assert np.count_nonzero(some > 0.05) >= 7
    assert np.all(much >= some - 1e-9)
    assert some[3:5].mean() == pytest.approx(0.3, abs=0.15)
    assert much[3:5].mean() == pytest.approx(0.6, abs=0.15)
