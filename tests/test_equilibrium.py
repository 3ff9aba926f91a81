"""Static equilibrium: the forces of physics.md section 5."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.configuration import Configuration
from dcrb_ros.equilibrium import roller_forces, static_equilibrium, unbalanced_forces
from dcrb_ros.model import build_payload

DOWN = np.array([0.0, -100e3])


def mean_forces(phase: float) -> np.ndarray:
    """Return the mean of inner and outer normal force of each roller, shape (rows, rollers) [N]."""
    payload = build_payload(Configuration())
    turn = np.exp(1j * phase * 2.0 * np.pi / 16)
    turned = (payload.pocket_tangent[..., 0] + 1j * payload.pocket_tangent[..., 1]) * turn
    payload = payload._replace(pocket_tangent=np.stack([turned.real, turned.imag], axis=-1))
    inner, outer = roller_forces(payload, static_equilibrium(payload, DOWN))
    return 0.5 * (np.linalg.norm(inner, axis=-1) + np.linalg.norm(outer, axis=-1))


def test_roller_under_the_load() -> None:
    for row in mean_forces(0.0):
        assert row[[0, 1, 15]] == pytest.approx([30251.0, 10708.0, 10708.0], rel=1e-3)  # physics.md section 5
        assert not row[2:15].any()


def test_rollers_straddling_the_load() -> None:
    for row in mean_forces(0.5):
        assert row[[0, 15]] == pytest.approx([25508.0, 25508.0], rel=1e-3)  # physics.md section 5


@given(st.floats(1e3, 4e5), st.floats(-np.pi, np.pi))
def test_any_load_is_balanced(size: float, direction: float) -> None:
    payload = build_payload(Configuration())
    load = size * np.array([np.sin(direction), -np.cos(direction)])
    left = unbalanced_forces(payload, load, static_equilibrium(payload, load))
    assert np.abs(left).max() < 1e-3 * size


def test_sink_of_the_outer_ring() -> None:
    centres = static_equilibrium(build_payload(Configuration()), DOWN)
    assert centres[0] == pytest.approx([0.0, -0.47e-3], abs=5e-6)  # physics.md section 2: 0.47 mm under load
