"""Free rollers over notches."""

from __future__ import annotations

import math

import pytest

from dcrb_ros.bearing.payload import build_payload
from dcrb_ros.core.contacts.notch import turn_notches
from dcrb_ros.core.jit import loop
from dcrb_ros.core.layout.state import OUTER, State, empty_state
from dcrb_ros.core.layout.workspace import Workspace, workspace
from dcrb_ros.core.payload import Payload
from dcrb_ros.core.solver.free import find_notches
from dcrb_ros.settings.configuration import Configuration

pytestmark = pytest.mark.kernel


@loop
def find(payload: Payload, state: State, work: Workspace) -> None:
    """Write the depth of notches under free rollers, and how fast it grows."""
    find_notches(payload, state, work)


def sunk(fault: str, row: int, ahead: float, motion: tuple[float, float], ring: tuple[float, float]) -> tuple[float, float]:
    """Return the depth of a notch under the third roller of a row and how fast it grows, ``ahead`` [s] of the middle of the step.

    ``motion`` is the predicted mean speed of the roller's centre along the outer raceway [m/s] and its predicted mean spin [rad/s],
    ``ring`` the ring's mean velocity [m/s]. The roller has a tenth of both before the step, and gained twice the rest in the last one.
    """
    middle = 0.8  # azimuth of the notch [rad]
    groups = {
        "outer": {"outer_1": {"width": 4e-3, "row": row, "azimuth": middle}},
        "roller": {"roller_1": {"row": row, "roller": 3, "width": 4e-3}},
    }
    payload = build_payload(Configuration.model_validate({"cage": {"joint": "pocket"}, "faults": groups[fault]}))
    state, work = empty_state(payload), workspace(payload)
    turn_notches(payload.outer_notches, 0.0, work.outer_notch_direction)
    c, distance = (row - 1) * payload.free.shape[1] + 2, payload.outer_raceway_radius - payload.roller_radius
    normal = middle + 0.4 * 2e-3 / payload.outer_raceway_radius
    rollers, step, (along, spin) = state.rollers[0], work.rollers[0], motion
    velocity = (along * math.cos(normal) + ring[0], along * math.sin(normal) + ring[1])
    rollers.vx[c], rollers.change_vx[c] = 0.1 * velocity[0], 1.8 * velocity[0]
    rollers.vy[c], rollers.change_vy[c] = 0.1 * velocity[1], 1.8 * velocity[1]
    rollers.spin[c], rollers.change_spin[c] = 0.1 * spin, 1.8 * spin
    rollers.angle[c] = middle + spin * ahead
    work.mean_velocity[OUTER, :2] = ring
    state.position[OUTER, :2] = (3e-5 + ring[0] * ahead, -2e-5 + ring[1] * ahead)
    azimuth = normal + along * ahead / distance
    rollers.x[c] = step.x[c] = state.position[OUTER, 0] + distance * math.sin(azimuth)
    rollers.y[c] = step.y[c] = state.position[OUTER, 1] - distance * math.cos(azimuth)
    step.near_outer[c] = 1.0
    find(payload, state, work)
    return float(step.notch_depth[c]), float(step.sink_speed[c])


@pytest.mark.parametrize("row", [1, 2])
@pytest.mark.parametrize(("fault", "motion"), [("outer", (3.0, 0.0)), ("roller", (0.0, -50.0)), ("roller", (2.0, 25.0))])
def test_depth_under_a_free_roller_grows_with_its_predicted_motion_past_the_ring(fault: str, row: int, motion: tuple[float, float]) -> None:
    ring = (0.7, -0.4)
    short = 1e-7
    before, after = (sunk(fault, row, ahead, motion, ring)[0] for ahead in (-short, short))
    depth, sink_speed = sunk(fault, row, 0.0, motion, ring)
    assert depth > 1e-6
    assert abs(sink_speed) > 1e-4
    assert sink_speed == pytest.approx((after - before) / (2.0 * short), rel=0.02)  # the mean over the step
