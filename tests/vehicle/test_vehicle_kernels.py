"""Compiled loops of the vehicle, against numpy."""

from __future__ import annotations

import numpy as np
import pytest

from dcrb_ros.schema.arrays import Complexes, Floats
from dcrb_ros.vehicle.kernels import add_motion_of_others, along_lines, modal_outputs, ramped

MODES, BOXES, TICKS, STEPS = 5, 3, 6, 8


def complexes(random: np.random.Generator, *shape: int) -> Complexes:
    return np.asarray(random.normal(size=shape) + 1j * random.normal(size=shape), np.complex128)


@pytest.mark.parametrize("outputs", [1, 3, 4, 6, 8])
def test_outputs_of_modes_follow_their_recursion(outputs: int) -> None:
    random = np.random.default_rng(outputs)
    growth, before, after = 0.5 * complexes(random, MODES), complexes(random, MODES, 2), complexes(random, MODES, 2)
    read, direct, inputs = complexes(random, outputs, MODES), random.normal(size=(outputs, 2)), random.normal(size=(TICKS + 1, 2))
    state = complexes(random, MODES)
    expected, x = [], state.copy()
    for n in range(TICKS):
        expected.append((read @ x).real + direct @ inputs[n])
        x = growth * x + before @ inputs[n] + after @ inputs[n + 1]
    assert modal_outputs(growth, before, after, read, direct, state, inputs) == pytest.approx(np.array(expected), abs=1e-12)
    assert state == pytest.approx(x, abs=1e-12)


def test_each_box_moves_by_the_inputs_of_the_others_along_straight_lines() -> None:
    random = np.random.default_rng(1)
    growth, read, states = 0.5 * complexes(random, MODES), complexes(random, BOXES, MODES), complexes(random, BOXES, MODES)
    before, after = complexes(random, BOXES, MODES, 1), complexes(random, BOXES, MODES, 1)
    direct, inputs = random.normal(size=(BOXES, BOXES, 1)), random.normal(size=(BOXES, TICKS + 1, 1))
    last, target = random.normal(size=(BOXES, BOXES)), np.zeros((BOXES, TICKS * STEPS))
    expected, fine = np.zeros_like(target), np.arange(TICKS * STEPS) / STEPS
    ends = last.copy()
    for source in range(BOXES):
        own = states[source].copy()
        outputs = modal_outputs(growth, before[source], after[source], read, direct[source], own, inputs[source])
        for box in {0, 1, 2} - {source}:
            expected[box] += np.interp(fine, np.arange(TICKS + 1), [last[source, box], *outputs[:, box]])
        ends[source] = outputs[-1]
    add_motion_of_others(growth, before, after, read, direct, states, inputs, last, target)
    assert np.array_equal(target, expected)
    assert np.array_equal(last, ends)


def test_lines_between_ticks_are_those_of_numpy() -> None:
    ticks: Floats = np.random.default_rng(2).normal(size=(2, TICKS + 1))
    fine = np.arange(TICKS * STEPS) / STEPS
    assert np.array_equal(along_lines(ticks, STEPS), [np.interp(fine, np.arange(TICKS + 1), row) for row in ticks])


@pytest.mark.parametrize(("target", "values"), [(2.0, [1.0, 1.4, 1.8, 2.0, 2.0]), (0.5, [1.0, 0.6, 0.5, 0.5, 0.5]), (1.0, [1.0] * 5)])
def test_a_ramp_ends_at_its_target(target: float, values: list[float]) -> None:
    assert ramped(1.0, target, 0.4, 4).tolist() == pytest.approx(values, rel=1e-15)
