"""Contacts of two rollers across a broken bar."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from dcrb_ros.bearing.payload import build_payload
from dcrb_ros.core.contacts.roller_pair import add_pair_contacts
from dcrb_ros.core.jit import loop
from dcrb_ros.core.laws.lugre import stribeck_coefficient
from dcrb_ros.core.laws.squeeze import squeeze_impulse
from dcrb_ros.core.layout.state import FRICTION, LOSS, State, empty_state
from dcrb_ros.core.layout.workspace import Workspace, workspace
from dcrb_ros.core.payload import Payload
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration

pytestmark = pytest.mark.kernel

BEHIND, AHEAD = 4, 5
"""Rollers on either side of the broken bar 5, counted from zero."""
Floats = npt.NDArray[np.float64]


@loop
def touch(payload: Payload, state: State, work: Workspace) -> None:
    """Write the forces that rollers exert on each other across broken bars."""
    add_pair_contacts(payload, state, work.pair_force)


def pressed(row: int, depth: float, velocity: Floats, steps: int = 1, **groups: dict[str, object]) -> tuple[Payload, State, Workspace]:
    """Return a bearing after ``steps`` of no motion in which two rollers of a row are pressed together by ``depth`` [m].

    ``velocity`` is the predicted mean velocity of both [m/s, m/s, rad/s], shape (2, 3): half of it before the step, and as much
    as the whole was gained in the last one.
    """
    payload = build_payload(Configuration.model_validate({"faults": {"broken_bars": "row1/bar5, row2/bar5"}, **groups}))
    state, work = empty_state(payload), workspace(payload)
    state.roller_position[:, AHEAD] = (1.0, 1.0)  # far apart in the other row
    state.roller_position[row, BEHIND] = (0.03, -0.02)
    diameter = 2.0 * payload.roller_radius / payload.spin_share
    state.roller_position[row, AHEAD] = np.array((0.03, -0.02)) + (diameter - depth) * np.array((0.8, 0.6))
    state.roller_velocity[row, [BEHIND, AHEAD]] = 0.5 * velocity
    state.roller_change[row, [BEHIND, AHEAD]] = velocity
    work.pair_force[:] = 7.0  # from the last step
    for _ in range(steps):
        touch(payload, state, work)
    return payload, state, work


ANGLED = {"bearing": load_configuration("tapered_352213").bearing.model_dump(), "simulation": {"step": 4.8828125e-6}}
VELOCITY = np.array([(0.3, -0.1, -4.0), (-0.1, 0.2, 9.0)])


@pytest.mark.parametrize("groups", [{}, ANGLED], ids=["cylindrical", "tapered"])
@pytest.mark.parametrize("row", [0, 1])
@pytest.mark.parametrize("velocity", [VELOCITY, -0.1 * VELOCITY], ids=["closing", "opening"])
def test_rollers_push_each_other_apart_and_pay_for_slip_and_loss(row: int, velocity: Floats, groups: dict[str, object]) -> None:
    payload, state, work = pressed(row, 1e-5, velocity, **groups)
    behind, ahead = work.pair_force[row, BEHIND], work.pair_force[row, AHEAD]
    assert behind[:2] == pytest.approx(-ahead[:2])
    assert behind[2] == ahead[2]  # both spins are opposed
    normal = state.of_rollers(state.rollers[0].pair.force)[row, BEHIND]
    assert ahead[:2] @ (0.8, 0.6) == pytest.approx(normal)
    rate = (velocity[0, :2] - velocity[1, :2]) @ (0.8, 0.6)
    lever = np.array((1.0, 1.0, payload.roller_radius))
    power = float((work.pair_force[row, [BEHIND, AHEAD]] * velocity * lever).sum())
    assert power == pytest.approx(-normal * rate - state.account[FRICTION] / payload.step)
    assert state.account[FRICTION] > 0.0
    still = pressed(row, 1e-5, np.zeros((2, 3)), **groups)[1]
    elastic = still.of_rollers(still.rollers[0].pair.force)[row, BEHIND]
    assert elastic > 100.0
    assert state.account[LOSS] == pytest.approx((normal - elastic) * rate * payload.step)
    assert state.account[LOSS] > 0.0


BARRELS = load_configuration("spherical_22205")
LIGHT = {name: getattr(BARRELS, name).model_dump() for name in ("bearing", "operating", "simulation", "cage")}


@pytest.mark.parametrize("loss_time", [6e-6, 1e-5])
@pytest.mark.parametrize("speed", [0.01, 1.0, 10.0])
def test_light_rollers_do_not_part_faster_than_they_met(loss_time: float, speed: float) -> None:
    payload, state, work = pressed(0, 0.0, np.zeros((2, 3)), contact={"loss_time": loss_time}, **LIGHT)
    state.roller_position[0, BEHIND, :2] += 0.5 * payload.step * speed * np.array((0.8, 0.6))  # in mid-step: they touched when it began
    state.roller_velocity[0, BEHIND, :2] = speed * np.array((0.8, 0.6))
    touch(payload, state, work)
    normal = state.of_rollers(state.rollers[0].pair.force)[0, BEHIND]
    after = speed - 2.0 * payload.step * normal / payload.roller_mass
    assert -speed < after < speed


def test_what_light_rollers_lose_is_the_loss_and_the_work_of_the_elastic_force() -> None:
    depth, speed, loss_time = 1e-6, 1.0, 1e-5
    _, still, _ = pressed(0, depth, np.zeros((2, 3)), contact={"loss_time": 0.0}, **LIGHT)
    elastic = still.of_rollers(still.rollers[0].pair.force)[0, BEHIND]
    payload, state, work = pressed(0, depth, np.zeros((2, 3)), steps=0, contact={"loss_time": loss_time}, **LIGHT)
    state.roller_velocity[0, BEHIND, :2] = speed * np.array((0.8, 0.6))
    touch(payload, state, work)
    normal = state.of_rollers(state.rollers[0].pair.force)[0, BEHIND]
    after = speed - 2.0 * payload.step * normal / payload.roller_mass
    mean = 0.5 * (speed + after)
    assert state.account[LOSS] == pytest.approx(payload.step * (normal - elastic) * mean)
    assert 0.25 * payload.roller_mass * (speed**2 - after**2) == pytest.approx(state.account[LOSS] + payload.step * elastic * mean)


def test_light_rollers_under_a_constant_force_stay_where_they_are() -> None:
    _, still, _ = pressed(0, 1e-6, np.zeros((2, 3)), contact={"loss_time": 0.0}, **LIGHT)
    elastic = still.of_rollers(still.rollers[0].pair.force)[0, BEHIND]
    payload, state, work = pressed(0, 1e-6, np.zeros((2, 3)), steps=0, contact={"loss_time": 1e-5}, **LIGHT)
    forces = state.of_rollers(state.rollers[0].pair.force)
    forces[0, BEHIND] = elastic
    touch(payload, state, work)
    assert forces[0, BEHIND] == pytest.approx(elastic)
    assert state.account[LOSS] == pytest.approx(0.0, abs=1e-15)


def cones_touch_at(radius: float, pitch_radius: float, angle: float) -> float:
    """Return the distance [m] at which cones of a middle radius [m] touch, whose axes meet on the shaft at an angle [rad] to it.

    Their surfaces have the same apex, at R = pitch_radius/sin(angle) from the middles: the angle between their axes is 2 asin(d/(2 R)),
    that of two cones which touch along a line is twice the half-angle of a cone, whose tangent is radius/R.
    """
    apex = pitch_radius / math.sin(angle)
    return 2.0 * apex * math.sin(math.atan(radius / apex))


def test_tapered_rollers_touch_at_the_distance_of_cones_with_a_common_apex() -> None:
    bearing = load_configuration("tapered_352213").bearing
    distance = cones_touch_at(0.00615, 0.04625, math.radians(15.11))  # r and r_M as the comments of config/ state them
    assert distance == pytest.approx(2.0 * bearing.own_roller_radius, abs=1e-5)
    for apart, touching in ((-2e-5, True), (2e-5, False)):
        _, state, _ = pressed(0, 2.0 * bearing.own_roller_radius - distance - apart, np.zeros((2, 3)), **ANGLED)
        assert (state.of_rollers(state.rollers[0].pair.force)[0, BEHIND] > 0.0) == touching


def test_tapered_rollers_that_turn_as_one_body_do_not_slip_and_their_forces_have_no_torque() -> None:
    turn, payload = 30.0, build_payload(Configuration.model_validate({"faults": {"broken_bars": "row1/bar5"}, **ANGLED}))
    half = payload.roller_radius / payload.spin_share * np.array((0.8, 0.6))
    still = np.array([(turn * half[1], -turn * half[0], turn), (-turn * half[1], turn * half[0], turn)])
    spinning = still + np.array([(0.0, 0.0, 40.0), (0.0, 0.0, 40.0)])
    _, state, _ = pressed(0, 1e-9, still, **ANGLED)
    assert state.account[FRICTION] == pytest.approx(0.0, abs=1e-12)
    payload, state, work = pressed(0, 1e-5, spinning, **ANGLED)
    behind, ahead = work.pair_force[0, BEHIND], work.pair_force[0, AHEAD]
    apart = state.roller_position[0, BEHIND, :2] - state.roller_position[0, AHEAD, :2]
    about_middle = apart[0] * behind[1] - apart[1] * behind[0]
    assert state.account[FRICTION] > 0.0
    assert about_middle == pytest.approx(-payload.roller_radius * (behind[2] + ahead[2]), rel=2e-3)  # of the penetration


def test_the_constant_damping_acts_on_the_whole_step() -> None:
    payload, state, _ = pressed(0, 1e-5, VELOCITY, contact={"loss_time": 0.0, "damping": 2e3})
    rate = (VELOCITY[0, :2] - VELOCITY[1, :2]) @ (0.8, 0.6)
    assert state.account[LOSS] == pytest.approx(2e3 * rate**2 * payload.step)


def test_a_layer_between_rollers_takes_its_impulse_over_the_way_of_the_step() -> None:
    depth, rate = 1e-6, 0.8
    oil = {"law": "film", "lubricant": "vg100", "temperature": 70.0, "layer": 20e-6}
    velocity = np.array([(rate * 0.8, rate * 0.6, 0.0), (0.0, 0.0, 0.0)])
    payload, state, _ = pressed(0, depth, velocity, contact={"loss_time": 0.0}, lubrication=oil)
    film = payload.pair.film
    half = 0.5 * payload.step * rate
    assert half - depth > film.floor
    far, near = (squeeze_impulse(gap, film.squeeze, film.floor, film.layer) for gap in (-depth + half, -depth - half))
    assert state.account[LOSS] == pytest.approx((near - far) * rate)  # the momentum taken, times the speed


@pytest.mark.parametrize("spin", [20.0, -3.0])
def test_steady_slip_of_rollers_has_the_stribeck_coefficient(spin: float) -> None:
    velocity = np.array([(0.0, 0.0, spin), (0.0, 0.0, 0.0)])
    payload, state, work = pressed(1, 1e-5, velocity, steps=500)
    slip, law, normal = payload.roller_radius * spin, payload.traction_law, state.of_rollers(state.rollers[0].pair.force)[1, BEHIND]
    steady = stribeck_coefficient(slip, law.kinetic_coefficient, law.static_coefficient, law.stribeck_speed)
    assert work.pair_force[1, BEHIND, 2] == pytest.approx(-math.copysign(steady, spin) * normal, rel=1e-6)


@pytest.mark.parametrize("row", [0, 1])
def test_rollers_in_contact_leave_the_other_row_and_all_others(row: int) -> None:
    _, state, work = pressed(row, 1e-5, VELOCITY)
    other, untouched = 1 - row, [i for i in range(16) if i not in (BEHIND, AHEAD)]
    assert np.all(work.pair_force[other, [BEHIND, AHEAD]] == 0.0)
    assert np.all(work.pair_force[:, untouched] == 7.0)
    force = state.of_rollers(state.rollers[0].pair.force)
    assert np.flatnonzero(force).tolist() == [row * 16 + BEHIND]


@pytest.mark.parametrize("row", [0, 1])
def test_rollers_apart_exert_no_force_and_forget_their_bristle(row: int) -> None:
    payload, state, work = pressed(row, 1e-5, VELOCITY)
    rollers: Any = state.rollers[0]
    bristle = state.of_rollers(rollers.pair.traction.bristle)
    assert bristle[row, BEHIND] != 0.0
    state.roller_position[row, AHEAD] += 1e-4 * np.array((0.8, 0.6))
    account = state.account.copy()
    touch(payload, state, work)
    assert np.all(work.pair_force[:, [BEHIND, AHEAD]] == 0.0)
    assert not state.rollers[0].pair.force.any()
    assert not bristle.any()
    assert np.array_equal(state.account, account)
