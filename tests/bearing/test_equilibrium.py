"""Static equilibrium: forces on the rollers, balance, and identical bits on every machine."""

from __future__ import annotations

import math
import os
import subprocess
import sys

import initial_states
import numpy as np
import pytest
from dry_benches import dry_bench
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from dcrb_ros.bearing.equilibrium import (
    LEAST_CONTACT_FORCE,
    penetration_under,
    penetrations,
    radial_directions,
    roller_forces,
    static_equilibrium,
    stored_energy,
)
from dcrb_ros.bearing.payload import build_payload, initial_state
from dcrb_ros.core.layout.workspace import workspace
from dcrb_ros.core.payload import Payload
from dcrb_ros.core.solver.step import advance
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration

pytestmark = pytest.mark.slow

DOWN = np.array([0.0, -100e3])
JOINTS = ("revolute", "pocket")


def bearing(joint: str, phase: float = 0.0) -> Payload:
    """Return a bearing whose rollers are turned by ``phase`` pitches."""
    payload = build_payload(Configuration.model_validate({"cage": {"joint": joint}}))
    turn = np.exp(1j * phase * 2.0 * np.pi / 16)
    turned = (payload.pocket_tangent[..., 0] + 1j * payload.pocket_tangent[..., 1]) * turn
    return payload._replace(pocket_tangent=np.stack([turned.real, turned.imag], axis=-1))


def forces(payload: Payload, load: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    rest = static_equilibrium(payload, load)
    return roller_forces(payload, rest.outer, rest.inner, rest.rollers)


def mean_forces(joint: str, phase: float) -> np.ndarray:
    """Return the mean of inner and outer normal force of each roller, shape (rows, rollers) [N]."""
    inner, outer = forces(bearing(joint, phase), DOWN)
    return 0.5 * (np.linalg.norm(inner, axis=-1) + np.linalg.norm(outer, axis=-1))


def shared_forces(azimuths: list[float]) -> list[float]:
    """Return the forces on the loaded rollers at some azimuths [N], from Eq. 4 for the dimensions of Table 1.

    The inner ring moves along the load until the vertical components of the forces carry half of load and weight.
    """
    modulus = math.pi * 207.5e9 / (2.0 * (1.0 - 0.3**2)) * 0.048

    def penetration(force: float) -> float:
        scales = 4.0 * (0.07886 + 0.015), 4.0 * (0.10914 - 0.015)
        return sum(force / modulus * (math.log(modulus * scale / force) - 1.0) for scale in scales)

    def force(azimuth: float, moved: float) -> float:
        overlap = moved * math.cos(azimuth) - 0.28e-3
        return brentq(lambda force: penetration(force) - overlap, 1e-3, 1e6) if overlap > penetration(1e-3) else 0.0

    def missing(moved: float) -> float:
        return sum(force(azimuth, moved) * math.cos(azimuth) for azimuth in azimuths) - 0.5 * (100e3 + 9.81 * 7.316)

    moved = brentq(missing, 0.28e-3, 1e-3)
    return [force(azimuth, moved) for azimuth in azimuths]


@pytest.mark.parametrize("joint", JOINTS)
def test_a_roller_under_the_load_and_its_neighbours_share_it(joint: str) -> None:
    pitch = 2.0 * math.pi / 16
    for row in mean_forces(joint, 0.0):
        assert row[[0, 1, 15]] == pytest.approx(shared_forces([0.0, pitch, -pitch]), rel=1e-3)
        assert row[2:15].max() < 3.0  # the weight of a free roller is 2.4 N


@pytest.mark.parametrize("joint", JOINTS)
def test_two_rollers_beside_the_load_line_share_it(joint: str) -> None:
    pitch = 2.0 * math.pi / 16
    for row in mean_forces(joint, 0.5):
        assert row[[0, 15]] == pytest.approx(shared_forces([0.5 * pitch, -0.5 * pitch]), rel=1e-3)


@pytest.mark.parametrize("joint", JOINTS)
@settings(max_examples=10)
@given(size=st.floats(1e3, 4e5), direction=st.floats(-np.pi, np.pi))
def test_any_load_is_balanced(joint: str, size: float, direction: float) -> None:
    payload = bearing(joint)
    load = size * np.array([np.sin(direction), -np.cos(direction)])
    inner, outer = forces(payload, load)
    weight = 9.81 * payload.inner_ring_mass
    carried = 9.81 * 32 * payload.roller_mass * payload.free.all()  # free rollers rest on the inner ring above
    assert inner.sum(axis=(0, 1)) == pytest.approx(load - [0.0, weight], abs=2e-3 * size + 0.5 * carried)
    both = (inner + outer)[payload.free]
    assert np.linalg.norm(both, axis=-1).max(initial=0.0) < 0.004 * size + 5.0  # the tangents that friction would hold


@pytest.mark.parametrize("joint", JOINTS)
def test_the_housing_carries_the_load(joint: str) -> None:
    rest = static_equilibrium(bearing(joint), DOWN)
    weight = 9.81 * (13.49 + 7.316 + 2 * 2.459 + 32 * 0.248)  # Table 1
    assert rest.outer == pytest.approx([0.0, -(100e3 + weight) / 212e6], abs=1e-6)


@pytest.mark.parametrize("law", ["johnson", "power"])
@given(force=st.floats(1.0, 1e5))
def test_energy_is_the_integral_of_the_force(law: str, force: float) -> None:
    payload = build_payload(Configuration.model_validate({"contact": {"law": law}}))
    depth = penetration_under(payload, np.array([0.999, 1.0, 1.001]) * force, payload.inner)
    energy = stored_energy(payload, depth, payload.inner)
    assert (energy[2] - energy[0]) / (depth[2] - depth[0]) == pytest.approx(force, rel=1e-4)


def test_free_rollers_of_a_running_bearing_lie_on_the_outer_raceway() -> None:
    payload = bearing("pocket")
    rest = static_equilibrium(payload, DOWN, 52.8)
    _, outer = roller_forces(payload, rest.outer, rest.inner, rest.rollers)
    assert np.linalg.norm(outer, axis=-1).min() > 60.0  # m r omega_C^2 = 65 N, less the weight of 2.4 N


@pytest.mark.parametrize("joint", JOINTS)
@settings(max_examples=10)
@given(load=st.floats(1e3, 4e5))
def test_rows_in_phase_have_identical_positions(joint: str, load: float) -> None:
    rest = static_equilibrium(bearing(joint), np.array([0.0, -load]), orbit=52.8)
    assert np.array_equal(rest.rollers[0], rest.rollers[1])
    assert np.array_equal(rest.cages[0], rest.cages[1])


def rest_of(configuration: Configuration) -> np.ndarray:
    """Return the initial positions of the rollers, shape (rows, rollers, 2) [m]."""
    return initial_state(configuration, build_payload(configuration)).roller_position


NOTCHES = {
    "outer_1": {"width": 2e-3},
    "inner_1": {"width": 2e-3, "row": 2},
    "roller_1": {"roller": 1, "width": 2e-3, "depth": 2e-5},
}


@pytest.mark.parametrize("joint", JOINTS)
@pytest.mark.parametrize("fault", NOTCHES)
def test_the_initial_forces_are_those_of_the_first_step(joint: str, fault: str) -> None:
    # The roller under the load is over the notch and carries less than the 30.3 kN that it carries on a smooth raceway.
    configuration = Configuration.model_validate(
        {"cage": {"joint": joint}, "faults": {fault: NOTCHES[fault]}, "contact": {"loss_time": 0.0}}
    )
    payload = build_payload(configuration)._replace(step=1e-9, contact_damping=0.0)
    state = initial_state(configuration, payload)
    begun = np.array([state.inner_force, state.outer_force])
    advance(payload, state, workspace(payload), np.empty((1, 2)), np.empty(1))
    assert np.array([state.inner_force, state.outer_force]) == pytest.approx(begun, rel=1e-3, abs=1.0)
    over = 1 if fault == "inner_1" else 0
    assert begun[:, over, 0].min() < 25e3
    _, _, *depths = penetrations(payload, state.outer_position, state.inner_position, rest_of(configuration))
    assert np.maximum(*depths)[payload.free].min(initial=1.0) > 0.0  # every free roller touches a raceway
    inner, _ = forces(payload, DOWN)
    carried = 9.81 * (payload.inner_ring_mass + 32 * payload.roller_mass * payload.free.all())
    assert inner.sum(axis=(0, 1)) == pytest.approx(DOWN, abs=carried + 1.0)


def test_the_law_edge_does_not_change_the_initial_state() -> None:
    edged = {"faults": {"outer_1": {"width": 2e-3}}, "contact": {"notch": "edge"}}
    rests = [static_equilibrium(build_payload(Configuration.model_validate(each)), DOWN) for each in ({}, edged)]
    assert rests[0].inner == pytest.approx(rests[1].inner, abs=1e-12)


@pytest.mark.parametrize("name", ["outer_ring_defect", "inner_ring_defect", "compound", "cage_fracture", "healthy"])
def test_every_roller_of_a_dry_bench_touches_a_raceway_at_the_start(name: str) -> None:
    assert deepest_contacts(dry_bench(name)).min() > 0.0


@pytest.mark.parametrize("name", ["outer_ring_defect", "inner_ring_defect", "roller_defect", "compound", "cage_fracture", "healthy"])
def test_every_roller_of_a_shipped_bench_is_in_the_oil_of_a_raceway_at_the_start(name: str) -> None:
    layer = 5e-6  # docs/reference/parameters.md, lubrication.layer: grease
    assert deepest_contacts(load_configuration(name)).min() > -layer


def deepest_contacts(configuration: Configuration) -> Floats:
    """Return the larger penetration of each roller at the two raceways at the start, shape (rows, rollers) [m]."""
    payload = build_payload(configuration)
    state = initial_state(configuration, payload)
    _, _, *depths = penetrations(payload, state.outer_position, state.inner_position, state.roller_position)
    return np.maximum(*depths)


@settings(max_examples=25, deadline=None)
@given(load=st.floats(1e3, 2e5), speed=st.floats(-20.0, 20.0))
def test_every_roller_of_a_slow_bearing_touches_a_raceway(load: float, speed: float) -> None:
    # At these speeds weight and centrifugal force balance for some of the rollers.
    payload = bearing("pocket")
    rest = static_equilibrium(payload, np.array([0.0, -load]), speed)
    _, _, *depths = penetrations(payload, rest.outer, rest.inner, rest.rollers)
    assert np.maximum(*depths).min() > 0.0
    along = (sum(roller_forces(payload, rest.outer, rest.inner, rest.rollers)) * radial_directions(payload)).sum(axis=-1)
    held = payload.roller_mass * (payload.gravity * radial_directions(payload)[..., 1] - payload.pitch_radius * speed**2)
    assert along == pytest.approx(held, abs=2.0 * LEAST_CONTACT_FORCE)


def test_every_processor_gives_the_same_initial_state() -> None:
    # The order of additions in OpenBLAS depends on the processor; a variable of the environment selects an older one.
    starts = {initial_states.initial_states_hash()}
    for kind in ("Prescott", "Haswell"):
        command, environment = [sys.executable, initial_states.__file__], os.environ | {"OPENBLAS_CORETYPE": kind}
        starts.add(subprocess.run(command, env=environment, capture_output=True, text=True, check=True, timeout=400.0).stdout)
    assert len(starts) == 1


@settings(max_examples=15, deadline=None)
@given(width=st.floats(5e-4, 6e-3), azimuth=st.floats(-0.3, 0.3), load=st.floats(3e4, 1.5e5), ring=st.sampled_from(["inner_1", "outer_1"]))
def test_forces_balance_over_any_notch(width: float, azimuth: float, load: float, ring: str) -> None:
    faults = {ring: {"width": width, "azimuth": azimuth}}
    payload = build_payload(Configuration.model_validate({"faults": faults}))
    rest = static_equilibrium(payload, np.array([0.0, -load]), 52.8)
    _, _, *depths = penetrations(payload, rest.outer, rest.inner, rest.rollers)
    assert np.maximum(*depths).min() > 0.0
    inner, _ = roller_forces(payload, rest.outer, rest.inner, rest.rollers)
    carried = 9.81 * (payload.inner_ring_mass + 32 * payload.roller_mass) + 32 * payload.roller_mass * payload.pitch_radius * 52.8**2
    assert inner.sum(axis=(0, 1)) == pytest.approx([0.0, -load], abs=carried)
