"""The primary suspension between axle box and frame: static balance, natural frequency, damping, and what it leaves alone."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from dcrb_ros.bearing.payload import build_payload, initial_state
from dcrb_ros.core.layout.state import State
from dcrb_ros.core.layout.workspace import workspace
from dcrb_ros.core.payload import Payload
from dcrb_ros.core.solver.step import advance
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import validated

STIFFNESS, DAMPING = 2e6, 5e3  # N/m, N s/m
MASSES = {"box_mass": 60.0, "axle_mass": 600.0}


def suspended(**housing: float) -> Configuration:
    given: dict[str, Any] = {"housing": {**MASSES, "suspension_stiffness": STIFFNESS, **housing}, "operating": {"start": "settled"}}
    return Configuration.model_validate(given)


def motion(payload: Payload, state: State, duration: float) -> np.ndarray:
    """Return the height of the outer ring in steps of a millisecond [m]."""
    work, steps, found = workspace(payload), 102, []
    for _ in range(round(duration / (steps * payload.step))):
        found.append(float(state.outer_position[1]))
        advance(payload, state, work, np.empty((steps, 2)), np.empty(steps))
    return np.array(found)


def moving_mass(c: Configuration) -> float:
    """Return the mass that swings on the suspension [kg]."""
    b = c.bearing
    return (
        MASSES["box_mass"]
        + MASSES["axle_mass"]
        + b.outer_ring_mass
        + b.inner_ring_mass
        + b.rows * (b.cage_mass + b.rollers_per_row * b.roller_mass)
    )


def test_the_preload_keeps_the_box_at_its_seat() -> None:
    """Without it the load of 100 kN would press the spring by 50 mm."""
    configuration = suspended(suspension_damping=DAMPING)
    payload = build_payload(configuration)
    state = initial_state(configuration, payload)
    assert np.abs(state.outer_position).max() < 1e-9
    assert np.abs(motion(payload, state, 0.3)).max() < 2e-5


def test_box_and_axle_swing_at_the_frequency_of_the_spring() -> None:
    configuration = suspended(suspension_damping=DAMPING)
    payload = build_payload(configuration)
    state = initial_state(configuration, payload)
    away = 1e-3
    state.position[:, 1] += away
    state.roller_position[..., 1] += away
    height = motion(payload, state, 0.4)
    mass, series = moving_mass(configuration), 1.0 / (1.0 / STIFFNESS + 1.0 / configuration.housing.stiffness)
    expected, decay = math.sqrt(series / mass), 0.5 * DAMPING / mass
    time = 102 * payload.step * np.arange(len(height))
    damped = math.sqrt(expected**2 - decay**2)
    model = away * np.exp(-decay * time) * (np.cos(damped * time) + decay / damped * np.sin(damped * time))
    assert height == pytest.approx(model, abs=0.03 * away)


def test_a_changed_load_moves_the_frame_and_not_the_box() -> None:
    configuration = suspended(suspension_damping=DAMPING)
    payload = build_payload(configuration)
    state = initial_state(configuration, payload)
    state.target[2] = -60e3
    assert np.abs(motion(payload, state, 0.4)).max() < 5e-5
    assert state.load[1] == -60e3


def test_damping_without_a_spring_is_refused() -> None:
    with pytest.raises(Refusal, match=r"suspension_damping = 5000 N s/m damps a primary suspension, and there is none"):
        validated({"housing.suspension_damping": DAMPING}, Configuration, "test")


def test_without_a_suspension_the_housing_is_what_it_was() -> None:
    payload = build_payload(Configuration())
    assert not payload.suspended
    assert (payload.housing_stiffness, payload.housing_damping) == (212e6, 1e5)
