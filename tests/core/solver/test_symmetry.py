"""Symmetries of the time loop: a bearing that is turned moves as before, turned, and so do its rows when they change places."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numba
import numpy as np
import numpy.typing as npt
import pytest
from even_surfaces import EVEN

from dcrb_ros.bearing.observation import observe
from dcrb_ros.bearing.payload import build_payload, initial_state
from dcrb_ros.core.layout.state import CAGE, INNER, OUTER, State, copy_of
from dcrb_ros.core.layout.workspace import workspace
from dcrb_ros.core.payload import Payload
from dcrb_ros.core.solver.step import advance
from dcrb_ros.settings.configuration import Configuration

pytestmark = pytest.mark.kernel
Floats = npt.NDArray[np.float64]

STEPS = 1
"""More are not symmetric: the films of the rows are evaluated in turn after the first step."""
FREE: dict[str, Any] = {"joint": "pocket"}
NOTCHES = {
    "outer_1": {"width": 2e-3, "azimuth": 0.005, "row": 1},
    "inner_1": {"width": 2e-3, "azimuth": -0.004, "row": 1},
    "roller_1": {"width": 2e-3, "row": 1, "roller": 1},
}
OIL = {"law": "film_with_cages", "lubricant": "vg100", "temperature": 70.0}
CASES: dict[str, dict[str, Any]] = {
    "pinned": {"cage": {"joint": "revolute"}},
    "free": {"cage": FREE},
    "film": {"cage": FREE, "lubrication": OIL, "friction": {"convection": 0.7}, "surfaces": EVEN},
    "notch": {"cage": FREE, "faults": NOTCHES},
    "edge": {"cage": FREE, "faults": {**NOTCHES, "roller_1": {"width": 0.0}}, "contact": {"notch": "edge"}},
    "broken bars": {"cage": {"joint": "revolute"}, "faults": {"broken_bars": "row1/bar15, row1/bar16"}},
}


def moving(groups: dict[str, Any]) -> tuple[Payload, State]:
    """Return a loaded bearing without weight, in which nothing is at rest: what touches slips, closes and opens."""
    configuration = Configuration.model_validate({**groups, "operating": {"gravity": 0.0}})
    payload = build_payload(configuration)._replace(land_clearance=4e-6)
    if groups.get("surfaces"):  # those of the rollers turn with them
        payload = payload._replace(surfaces=payload.surfaces._replace(raceways=np.zeros_like(payload.surfaces.raceways)))
    state, rng = initial_state(configuration, payload), np.random.default_rng(1)
    state.position[:, :2] += rng.normal(scale=2e-6, size=state.position[:, :2].shape)
    state.position[CAGE:, :2] += ((3e-6, -4e-6), (-6e-6, 2e-6))
    state.velocity[:, :2] += rng.normal(scale=0.02, size=state.velocity[:, :2].shape)
    state.velocity[CAGE:, 2] *= (0.98, 1.01)
    for change in (state.change, state.earlier_change):
        change += rng.normal(scale=1e-3, size=change.shape)
        change[:CAGE, 2] = 0.0  # rings do not rotate freely
    state.roller_position[:] += rng.normal(scale=1e-5, size=state.roller_position.shape)
    state.roller_velocity[:] += rng.normal(scale=(0.05, 0.05, 3.0), size=state.roller_velocity.shape)
    state.roller_change[:] += rng.normal(scale=(1e-2, 1e-2, 0.3), size=state.roller_change.shape)
    state.target[0] += 5.0  # the load would change along each axis at a limited rate
    return payload, state


def moved(payload: Payload, state: State) -> tuple[State, Floats]:
    """Return the state after some steps, and the acceleration of the outer ring."""
    after, acceleration = copy_of(state), np.empty((STEPS, 2))
    advance(payload, after, workspace(payload), acceleration, np.empty(STEPS))
    contacts: Any = after.rollers[0]
    for contact in (contacts.inner, contacts.outer, contacts.bar, contacts.pair):
        # Where loss cancels the force of a contact that opens or closes, rounding decides whether its bristle is kept.
        contact.traction.bristle[contact.force <= 1e-4 * contact.force.max(initial=0.0)] = 0.0
    return after, acceleration


def tables(state: State) -> Iterator[tuple[str, Floats]]:
    """Yield name and values of all arrays of the state, those of tables included."""
    for name, part in state._asdict().items():
        if isinstance(part, np.ndarray) and part.dtype.names:
            yield from _fields(name, part)
        elif isinstance(part, np.ndarray):
            yield name, part


def _fields(name: str, record: np.ndarray[Any, Any]) -> Iterator[tuple[str, Floats]]:
    for field in record.dtype.names or ():
        if record[field].dtype.names:
            yield from _fields(f"{name}.{field}", record[field])
        elif field != "unused":
            yield f"{name}.{field}", record[field][0]


def same(found: State, expected: State) -> None:
    """Assert that two states are equal up to rounding."""
    for (name, one), (_, other) in zip(tables(found), tables(expected), strict=True):
        scale = max(float(np.abs(other).max(initial=0.0)), 1e-9)
        assert one == pytest.approx(other, rel=1e-6, abs=1e-7 * scale), name


def turned(state: State, angle: float) -> State:
    """Return the state of a bearing that is turned by an angle [rad]."""
    found, rotation = copy_of(state), np.array([(np.cos(angle), np.sin(angle)), (-np.sin(angle), np.cos(angle))])
    vectors = found.position, found.velocity, found.change, found.earlier_change
    for vector in (*vectors, found.roller_position, found.roller_velocity, found.roller_change):
        vector[..., :2] = vector[..., :2] @ rotation
    found.load[:], found.target[1:] = found.load @ rotation, found.target[1:] @ rotation
    found.position[CAGE:, 2] += angle
    found.spin_angle[:] += angle
    found.shaft[0] += angle
    return found


UNEVEN_ROLLERS = {"cage": FREE, "lubrication": {"law": "film_with_cages"}, "surfaces": {"law": "profile", "waviness": 1e-6}}


@pytest.mark.parametrize("case", [*CASES, "uneven rollers"])
def test_a_turned_bearing_moves_as_before_turned(case: str) -> None:
    payload, state = moving(CASES.get(case, UNEVEN_ROLLERS))
    angle = 2.1
    notches = payload.outer_notches.copy()
    notches.azimuth += angle
    after, acceleration = moved(payload, state)
    assert after.inner_force.max() > 1e3
    found, turned_acceleration = moved(payload._replace(outer_notches=notches), turned(state, angle))
    same(found, turned(after, angle))
    complex_of = acceleration @ (1.0, 1.0j) * np.exp(1j * angle)
    assert turned_acceleration @ (1.0, 1.0j) == pytest.approx(complex_of, rel=1e-6)


def exchanged(state: State) -> State:
    """Return a state in which the rows have changed places."""
    found = copy_of(state)
    for name, values in tables(found):
        if name.startswith("rollers.") and name != "rollers.second_row":
            rows = found.of_rollers(values)
            rows[:] = rows[::-1].copy()
        elif name.startswith("land."):
            values[:2] = values[1::-1].copy()
    for bodies in (found.position, found.velocity, found.change, found.earlier_change):
        bodies[CAGE:] = bodies[: CAGE - 1 : -1].copy()
    return found


def in_other_row(groups: dict[str, Any]) -> dict[str, Any]:
    """Return settings whose faults are in row 2 instead of row 1."""
    faults = {
        name: fault.replace("row1", "row2") if isinstance(fault, str) else {**fault, **({"row": 2} if "row" in fault else {})}
        for name, fault in groups.get("faults", {}).items()
    }
    return {**groups, "faults": faults}


@pytest.mark.parametrize("case", CASES)
def test_rows_that_change_places_change_their_motions(case: str) -> None:
    groups = CASES[case]
    if case == "film":  # those of the cages are evaluated row by row in the first step
        if not numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
            pytest.skip("no other test needs kernels of these laws: `make kernels` runs this one without the compiler")
        groups = {**groups, "lubrication": {**OIL, "law": "film"}}
    payload, state = moving(groups)
    other, _ = moving(in_other_row(groups))
    after, acceleration = moved(payload, state)
    found, other_acceleration = moved(other, exchanged(state))
    same(found, exchanged(after))
    assert other_acceleration == pytest.approx(acceleration, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("case", ["pinned", "free", "film"])
def test_rollers_off_the_inner_raceway_have_no_bristle_there(case: str) -> None:
    payload, state = moving(CASES[case])
    inner: Any = state.rollers[0].inner
    inner.traction.bristle[:] = 1e-7
    advance(payload, state, workspace(payload), np.empty((STEPS, 2)), np.empty(STEPS))
    apart = state.inner_force == 0.0
    assert apart.any()
    assert np.all(state.of_rollers(inner.traction.bristle)[apart] == 0.0)


def test_the_relative_speed_of_a_roller_is_that_past_its_own_cage() -> None:
    payload, state = moving(CASES["free"])
    found = observe(payload, state, 0)
    spins, cages = state.roller_velocity[..., 2], state.cage_velocity[:, 2]
    assert found.relative_speed[: spins.size].reshape(spins.shape) == pytest.approx(spins - cages[:, None])
    assert state.position[INNER, 0] != state.position[OUTER, 0]
