"""Heights of raceways and rollers under the contacts of bound rollers."""

from __future__ import annotations

import math

import numpy as np
import pytest

from dcrb_ros.bearing.payload import build_payload, initial_state
from dcrb_ros.core.contacts.force_line import LARGEST_CLOSING
from dcrb_ros.core.layout.workspace import workspace
from dcrb_ros.core.solver.step import advance
from dcrb_ros.settings.files import load_configuration


def test_contacts_that_stay_open_have_no_heights() -> None:
    configuration = load_configuration("healthy")
    payload = build_payload(configuration)
    state, work = initial_state(configuration, payload), workspace(payload)
    advance(payload, state, work, np.empty((3000, 2)), np.empty(3000))
    contact, nodes, end = work.bound[0].inner, work.inner[0], work.row_ends[-1]
    read, closed = nodes.before[:end] != 0, contact.force[:end] > 0.0
    assert read[closed].all()
    assert 0 < read.sum() < end
    # What lies outside of the reading distance is smooth: nothing can close there within a step.
    assert (contact.penetration[:end][~read] < -LARGEST_CLOSING * payload.step - payload.profile_height).all()
    assert not contact.tilt[:end][~read].any()
    assert not contact.sink_speed[:end][~read].any()


@pytest.mark.slow
@pytest.mark.parametrize("angle", [0.0, 0.4])
@pytest.mark.parametrize("ring", ["inner", "outer"])
def test_a_mark_sinks_as_fast_on_a_track_of_its_own_as_among_the_heights_of_its_ball(ring: str, angle: float) -> None:
    own, cosine = load_configuration("ball_bearing_6205").bearing, math.cos(angle)
    # A ball of the same radius in the plane is larger by 1/cos(alpha).
    bearing = {"contact_angle": angle, "roller_mass": own.roller_mass / cosine**3, "roller_inertia": own.roller_inertia / cosine**5}
    found = []
    for memory in (0.0, 1e4):
        mark = {"roller": 1, "row": 1, "width": 1e-3, "azimuth": 0.05 - (math.pi if ring == "inner" else 0.0)}
        surfaces = {"roller_spread": 0.0, "waviness": 0.0, "short_waves": 0.0}
        given = {"faults": {"roller_1": mark}, "impacts": {"spin_memory": memory}, "bearing": bearing, "surfaces": surfaces}
        configuration = load_configuration("ball_bearing_6205", given)
        payload = build_payload(configuration)
        if memory:
            impacts = payload.surfaces
            latitudes, strengths = np.full_like(impacts.latitudes, np.inf), np.ones_like(impacts.mark_strengths)
            always = impacts._replace(latitudes=latitudes, mark_strengths=strengths)
            payload = payload._replace(surfaces=always)
        state, work = initial_state(configuration, payload), workspace(payload)
        advance(payload, state, work, np.empty((1, 2)), np.empty(1))
        bound = work.bound[0]
        contact = np.flatnonzero(bound.roller[: work.row_ends[-1]] == 0)
        found.append(float(work.rollers[0].sink_speed[0] if ring == "outer" else bound.inner.sink_speed[contact[0]]))
    assert abs(found[0]) > 1e-3
    assert found[1] == pytest.approx(found[0], rel=0.02)  # of the equilibrium on both tables
