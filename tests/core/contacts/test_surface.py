"""Heights of raceways and rollers under the contacts of bound rollers."""

from __future__ import annotations

import numpy as np

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
