"""The power law, over arrays as in the kernels."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.bearing.payload import build_payload
from dcrb_ros.core.laws.power import power_energy, power_force, power_forces, power_penetration, power_stiffness
from dcrb_ros.core.laws.site import NoMemory
from dcrb_ros.settings.configuration import Configuration

pytestmark = pytest.mark.kernel

PAYLOAD = build_payload(Configuration.model_validate({"contact": {"law": "power"}}))
LAW, SITE = PAYLOAD.normal_law, PAYLOAD.outer


@given(st.floats(1e-8, 1e-3))
def test_force_stiffness_and_penetration_agree(depth: float) -> None:
    force, stiffness = power_force(LAW, NoMemory(), depth, SITE)
    forces, slopes = power_forces(LAW, np.array([depth, 0.0, -depth]), SITE)
    assert forces == pytest.approx([force, 0.0, 0.0])
    assert slopes == pytest.approx([stiffness, 0.0, 0.0])
    assert power_penetration(LAW, force, SITE) == pytest.approx(depth)
    assert power_stiffness(LAW, force, SITE) == pytest.approx(stiffness)
    before, after = (power_force(LAW, NoMemory(), share * depth, SITE)[0] for share in (0.999, 1.001))
    assert stiffness == pytest.approx((after - before) / (0.002 * depth), rel=1e-5)
    released, stored = (power_energy(LAW, NoMemory(), share * depth, force) for share, force in ((0.999, before), (1.001, after)))
    assert (stored - released) / (0.002 * depth) == pytest.approx(force, rel=1e-5)
