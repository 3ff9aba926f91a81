"""The time loop: its order, its energy, its repeatability."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from dcrb_ros.configuration import Configuration
from dcrb_ros.core.payload import Payload
from dcrb_ros.core.state import State
from dcrb_ros.core.step import advance, workspace
from dcrb_ros.equilibrium import potential_energy, roller_forces, static_equilibrium
from dcrb_ros.model import build_payload, initial_state


def model(step: float, groups: dict[str, Any]) -> tuple[Payload, State]:
    configuration = Configuration.model_validate(groups)
    payload = build_payload(configuration)._replace(step=step)
    return payload, initial_state(configuration, payload)


def run(payload: Payload, state: State, steps: int) -> npt.NDArray[np.float64]:
    acceleration, angle = np.empty((steps, 2)), np.empty(steps)
    advance(payload, state, workspace(*state.spin.shape), acceleration, angle)
    return acceleration


FRICTIONLESS = {"kinetic_coefficient": 0.0, "static_coefficient": 1e-9, "bristle_damping": 0.0, "bristle_stiffness": 1.0}


@pytest.mark.parametrize("groups", [{"contact": {"loss_time": 0.0}}, {"friction": FRICTIONLESS}], ids=["friction", "loss"])
def test_second_order_on_a_smooth_motion(groups: dict[str, Any]) -> None:
    # The rollers stay in their contacts: rings swinging on loaded rollers, no shaft speed, no contact opening. Friction
    # and loss one at a time: the loss's share of the normal force reaches the friction a step late.
    duration, steps = 4e-4, [1e-5, 5e-6, 2.5e-6, 1.25e-6]

    def end(step: float) -> npt.NDArray[np.float64]:
        payload, state = model(step, {"operating": {"speed": 0.0}, **groups})
        state.inner_velocity[1] = -2e-3
        run(payload, state, round(duration / step))
        return np.array([*state.outer_position, *state.inner_position])

    exact = end(1.5625e-7)
    errors = [np.linalg.norm(end(step) - exact) for step in steps]
    order = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert order > 1.85


def test_waveform_of_a_defect_converges() -> None:
    # physics.md section 4: 2.0 % at 5 us and 4.2 % at 10 us of a plain scheme; 12 ms, before chaos sets in.
    def waveform(step: float) -> npt.NDArray[np.float64]:
        payload, state = model(step, {"faults": {"outer_1": {"width": 0.002}}})
        return run(payload, state, round(0.012 / step))

    fine = waveform(5e-7)
    for step, most in ((1e-5, 0.03), (5e-6, 0.015)):
        means = fine.reshape(-1, round(step / 5e-7), 2).mean(axis=1)
        assert np.linalg.norm(waveform(step) - means) < most * np.linalg.norm(means)


def total_energy(payload: Payload, state: State) -> float:
    """Return the energy of position and motion; the cages stand at angle zero [J]."""
    centres = np.array([state.outer_position, state.inner_position, *state.cage_position[:, :2]])
    return potential_energy(payload, state.load, centres) + kinetic_energy(payload, state)


def kinetic_energy(payload: Payload, state: State) -> float:
    """Return the energy of motion of rings and cages [J]."""
    rings = payload.outer_ring_mass * state.outer_velocity @ state.outer_velocity
    rings += payload.inner_ring_mass * state.inner_velocity @ state.inner_velocity
    cages = payload.train_mass * (state.cage_velocity[:, :2] ** 2).sum() + payload.train_inertia * (state.cage_velocity[:, 2] ** 2).sum()
    return 0.5 * float(rings + cages)


def test_energy_is_kept_without_friction_and_loss() -> None:
    groups = {
        "contact": {"loss_time": 0.0},
        "housing": {"damping": 0.0},
        "friction": FRICTIONLESS,
        "operating": {"speed": 0.0},
    }
    payload, state = model(1.0 / 102400.0, groups)
    state.inner_velocity[1] = -0.02
    excitation = kinetic_energy(payload, state)
    start = total_energy(payload, state)
    drift = []
    for _ in range(64):
        run(payload, state, 16)
        drift.append(abs(total_energy(payload, state) - start))
    assert max(drift) < 0.05 * excitation  # within the swing of a step's phase
    assert np.mean(drift[-8:]) < 2.0 * np.mean(drift[:8])  # and no trend over 10 ms


def test_rest_stays_at_rest() -> None:
    payload, state = model(1.0 / 102400.0, {"operating": {"speed": 0.0}})
    acceleration = run(payload, state, 2000)
    assert np.abs(acceleration).max() < 1e-3
    inner, _ = roller_forces(payload, static_equilibrium(payload, state.load))
    assert state.inner_force == pytest.approx(np.linalg.norm(inner, axis=-1), rel=1e-5, abs=1e-3)


def test_same_bits_however_the_steps_are_split() -> None:
    groups = {"faults": {"inner_1": {"width": 0.002}}}
    payload, whole = model(1.0 / 102400.0, groups)
    once = run(payload, whole, 3000)
    payload, split = model(1.0 / 102400.0, groups)
    parts = np.concatenate([run(payload, split, steps) for steps in (1, 999, 1500, 500)])
    assert np.array_equal(once, parts)


@pytest.mark.kernel
def test_a_few_steps_without_a_compiler() -> None:
    payload, state = model(1.0 / 102400.0, {})
    acceleration = run(payload, state, 5)
    assert np.isfinite(acceleration).all()
    assert state.inner_force.sum() == pytest.approx(2.0 * (30251.0 + 2.0 * 10708.0), rel=0.01)  # physics.md section 5
