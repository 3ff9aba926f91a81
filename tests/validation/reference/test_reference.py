"""The reference solver, and the agreement of the production solver with it."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from dcrb_ros.bearing.payload import degrees_of_freedom
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.parameters import Bearing
from dcrb_ros.validation.formulation import STEP, agreement, deviation, production
from dcrb_ros.validation.reference.bodies import ANGLE, CAGE, INNER_RING, Bodies
from dcrb_ros.validation.reference.cage_fracture import IntactBars, RollerPairs
from dcrb_ros.validation.reference.laws import pereira, pereira_exponent
from dcrb_ros.validation.reference.raceways import Raceway, raceways
from dcrb_ros.validation.reference.solver import History, ReferenceSolver

pytestmark = pytest.mark.slow

Floats = npt.NDArray[np.float64]

ONE_ROW, BOTH_ROWS = "row1/bar8", "row1/bar8, row2/bar8"


def configured(**groups: Any) -> Configuration:
    """Return a configuration of pinned rollers, as in the paper."""
    groups["cage"] = {"joint": "revolute", **groups.get("cage", {})}
    return Configuration.model_validate(groups)


@pytest.mark.parametrize(("broken_bars", "free"), [("", 10 + 32), (ONE_ROW, 14 + 32), (BOTH_ROWS, 18 + 32)])
def test_degrees_of_freedom(broken_bars: str, free: int) -> None:
    configuration = configured(faults={"broken_bars": broken_bars})
    reference = ReferenceSolver(configuration)
    assert degrees_of_freedom(configuration) == free
    assert reference.state.position.size == 111
    assert reference.bodies.degrees_of_freedom == free  # Fan et al. 2025, section 2.2.2; four freed rollers make 18 + nr
    jacobian = reference.constraints.jacobian(reference.state.position)
    assert np.linalg.matrix_rank(jacobian) == 111 - free  # the constraints are independent


def test_degrees_of_freedom_of_another_bearing() -> None:
    configuration = configured(bearing={"rows": 1, "rollers_per_row": 12})
    assert ReferenceSolver(configuration).bodies.degrees_of_freedom == degrees_of_freedom(configuration) == 7 + 12


@pytest.mark.parametrize(
    "groups",
    [
        {"cage": {"joint": "pocket"}},
        {"contact": {"notch": "edge"}},
        {"faults": {"roller_1": {"width": 1e-3}}},
        {"lubrication": {"law": "film"}},
        {"surfaces": {"law": "profile"}},
        {"housing": {"box_mass": 60.0}},
    ],
)
def test_settings_beyond_the_paper_are_refused(groups: dict[str, Any]) -> None:
    with pytest.raises(Refusal, match="is not part of the paper's formulation"):
        ReferenceSolver(configured(**groups))


def test_accelerations_solve_the_equations_of_motion_with_multipliers() -> None:
    reference = ReferenceSolver(configured(operating={"start": "cold"}, faults={"broken_bars": ONE_ROW}))
    rng = np.random.default_rng(1)
    force = rng.normal(scale=1e3, size=(37, 3))
    state = reference.state._replace(position=rng.normal(size=(37, 3)), velocity=rng.normal(size=(37, 3)))
    law, time, small = reference.constraints, 1.0, 1e-5
    jacobian = law.jacobian(state.position)
    ahead, behind = (state.position + sign * small * state.velocity for sign in (1.0, -1.0))
    rate = (law.values(ahead, time + small) - law.values(behind, time - small)) / (2.0 * small)
    assert law.rates(jacobian, state.velocity) == pytest.approx(rate, abs=1e-7)
    bend = (law.jacobian(ahead) - law.jacobian(behind)) @ state.velocity.ravel() / (2.0 * small)
    gamma = law.gamma(state.position, state.velocity)
    assert gamma == pytest.approx(-bend, abs=1e-7)  # Eq. 33

    mass = np.diag(reference.bodies.masses(Bearing()).ravel())
    matrix = np.block([[mass, jacobian.T], [jacobian, np.zeros((len(jacobian), len(jacobian)))]])
    target = gamma - 2.0 * 5e3 * law.rates(jacobian, state.velocity) - 5e3**2 * law.values(state.position, time)
    whole = np.linalg.solve(matrix, np.concatenate([force.ravel(), target]))[:111]  # Eqs. 34 and 35
    assert deviation(reference.acceleration(time, state, force).ravel(), whole) < 1e-9


OUTER = {"outer_1": {"width": 0.002, "azimuth": 0.025}}  # the rollers at psi = 0 reach its edge after 0.3 ms
INNER = {"inner_1": {"width": 0.002, "azimuth": -0.03, "row": 1}}


@pytest.mark.parametrize(
    ("faults", "duration", "least_rms", "acceleration_most", "normal_most"),
    [
        pytest.param({}, 1e-3, 1.0, 1e-3, 2e-6, id="healthy"),  # measured 3e-4, 4e-7
        pytest.param(OUTER, 1.5e-3, 300.0, 1e-2, 1e-3, id="outer"),  # measured 4.8e-3, 2.5e-4
        pytest.param({"broken_bars": "row1/bar15"}, 1e-3, 1.0, 2e-2, 1e-3, id="broken bar"),
        pytest.param(INNER, 1.5e-3, 100.0, 5e-3, 1e-3, id="inner"),  # measured 2.2e-3, 3.5e-4
    ],
)
def test_production_solver_agrees_with_the_reference_solver(
    faults: dict[str, Any], duration: float, least_rms: float, acceleration_most: float, normal_most: float
) -> None:
    configuration = configured(faults=faults)
    found = agreement(configuration, duration)
    history = found.history
    assert np.sqrt(np.mean(history.outer_acceleration**2)) > least_rms  # the fault excites the bearing
    assert found.acceleration < acceleration_most
    assert found.normal < normal_most
    assert history.drift.max() < 1e-12  # m or rad; measured 3e-15
    if not faults:
        weight = 7.316 * 9.81  # inner ring, Table 1 of Fan et al. 2025
        assert history.inner_ring_force[:, 1].mean() == pytest.approx(100e3 + weight, rel=1e-3)  # load of Figs. 9 and 10


@pytest.mark.parametrize("clearance", [1e-5, 2e-5])
def test_both_solvers_agree_where_a_spinning_freed_roller_strikes_its_bar(clearance: float) -> None:
    """The roller slides on the bar at 5.7 m/s: its bristle relaxes at 1.1e7 1/s, too fast for whole steps of 1 us."""
    configuration = configured(cage={"pocket_clearance": clearance}, faults={"broken_bars": ONE_ROW})
    found = agreement(configuration, 2e-4, 0.2)  # it strikes after 50 or 100 us
    assert found.rebound < 2e-3  # measured 3.4e-4
    assert found.acceleration < 5e-3
    assert found.normal < 1e-4
    softer = configured(cage={"pocket_clearance": clearance, "restitution": 0.8}, faults={"broken_bars": ONE_ROW})
    rebounds = [production(one, 2e-4, 0.2)[2] for one in (configuration, softer)]
    assert np.linalg.norm(rebounds[0] - rebounds[1]) > 0.01  # m/s: the strike is within the window


def test_fourth_order_on_a_smooth_motion() -> None:
    # Rings oscillating on loaded rollers, as in test_step: no contact opens, and no slip changes sign, where |s| has a kink.
    weak_bristles = {"kinetic_coefficient": 0.05, "static_coefficient": 0.05, "bristle_damping": 0.0, "bristle_stiffness": 1.0}
    configuration = configured(operating={"speed": 0.0}, friction=weak_bristles)

    def end(step: float) -> Floats:
        reference = ReferenceSolver(configuration)
        reference.state.velocity[INNER_RING, 1] = -2e-3
        reference.advance(1.92e-4, step)
        return reference.state.position[:CAGE, :ANGLE].ravel()

    steps = [6e-6, 4e-6, 3e-6]
    exact = end(1e-6)
    errors = [np.linalg.norm(end(step) - exact) for step in steps]
    assert 3.8 < np.polyfit(np.log(steps), np.log(errors), 1)[0] < 4.3


def test_baumgarte_stabilisation_returns_a_roller_to_its_pocket() -> None:
    reference = ReferenceSolver(configured())
    reference.bodies.rollers(reference.state.position)[0, 8, 0] += 1e-7  # an idle roller
    history = reference.advance(6e-4, 4e-6)
    fade = 5e3 * history.time
    # alpha = beta: Phi'' + 2 beta Phi' + beta^2 Phi = 0 is critically damped.
    assert history.drift == pytest.approx(1e-7 * (1.0 + fade) * np.exp(-fade), rel=1e-3)


def test_sink_depth_of_a_roller_in_a_defect() -> None:
    inner, outer = raceways(configured(), Bodies(2, 16))
    width = np.array([1e-3, 2e-3, 3e-3, 5e-3])
    for raceway, micrometres in ((inner, [9.9, 39.7, 89.4, 249.0]), (outer, [7.2, 28.8, 64.9, 181.0])):
        # Eqs. 8 and 14 of Fan et al. 2025 with Table 1, in the middle of a defect: alpha = b / (2 r).
        assert raceway.notch(0.5 * width / raceway.radius, 1.0)[0] * 1e6 == pytest.approx(micrometres, rel=6e-3)


def test_pereira_force_and_exponent() -> None:
    bearing = Bearing()
    assert pereira_exponent(1e-4) == pytest.approx(1.2129, abs=5e-5)  # Eq. 22: 1.51 [ln 100]^-0.151 0.1^-0.005
    force = pereira(np.array([-1e-6, 1e-6, 10e-6]), 1e-4, bearing.roller_length, bearing.effective_modulus)
    assert force == pytest.approx([0.0, 2427.0, 39.6e3], rel=1e-3)
    below, above = (pereira_exponent(clearance) for clearance in (0.34954e-3, 0.34955e-3))
    assert below == pytest.approx(above, rel=1e-4)


def pressed(bodies: Bodies, bars: IntactBars, seed: int) -> tuple[Floats, Floats]:
    """Return displaced positions, with freed rollers penetrating their bars and neighbours, and random velocities."""
    rng = np.random.default_rng(seed)
    position = ReferenceSolver(configured()).state.position + rng.normal(scale=1e-6, size=(bodies.count, 3))
    velocity = rng.normal(scale=0.1, size=(bodies.count, 3))
    tau = bars.kinematics(position, velocity).circumferential
    position[bars.roller, :ANGLE] += 2e-5 * bars.side[:, None] * tau
    behind, ahead = bodies.roller_bodies[1, 15], bodies.roller_bodies[1, 0]
    apart = position[ahead, :ANGLE] - position[behind, :ANGLE]
    position[ahead, :ANGLE] -= apart * (1.0 - 0.029999 / np.linalg.norm(apart))
    return position, velocity


@pytest.mark.parametrize("kind", ["inner", "outer", "pairs", "bars"])
def test_contact_forces_balance_and_their_power_is_that_of_penetration_and_slip(kind: str) -> None:
    configuration, bodies = configured(cage={"pocket_clearance": 1e-5}), Bodies(2, 16, ((0, 3), (0, 4), (1, 15)))
    bars = IntactBars(configuration, bodies)
    inner, outer = raceways(configuration, bodies)
    kinds: dict[str, Raceway | RollerPairs | IntactBars]
    kinds = {"inner": inner, "outer": outer, "pairs": RollerPairs(configuration, bodies), "bars": bars}
    contacts = kinds[kind]
    position, velocity = pressed(bodies, bars, seed=1)
    approach = contacts.kinematics(position, velocity)
    force = np.zeros_like(position)
    acting = contacts.act(position, velocity, np.full_like(approach.slip, 1e-7), force)
    assert (acting.normal > 100.0).any()
    assert force[:, :ANGLE].sum(axis=0) == pytest.approx(0.0, abs=1e-9 * np.abs(force).max())
    power = -(acting.normal * approach.rate + acting.friction * approach.slip).sum()
    assert (force * velocity).sum() == pytest.approx(power, rel=1e-9)


def launched(configuration: Configuration, *, roller: int, speed: float, duration: float) -> tuple[ReferenceSolver, History]:
    """Return a run from rest in which ``roller`` of row 1, beside the broken bar 7, has an initial speed along its pocket [m/s]."""
    reference = ReferenceSolver(configuration)
    azimuth = 2.0 * np.pi * roller / 16
    body = reference.bodies.roller_bodies[0, roller]
    reference.state.velocity[body, :ANGLE] = speed * np.array([np.cos(azimuth), np.sin(azimuth)])
    return reference, reference.advance(duration, STEP)


@pytest.mark.parametrize(("roller", "sign"), [(7, -1.0), (8, 1.0)], ids=["behind", "ahead"])
def test_a_freed_roller_rebounds_from_its_intact_bar(roller: int, sign: float) -> None:
    groups = {"operating": {"speed": 0.0, "gravity": 0.0}, "cage": {"pocket_clearance": 1e-5}, "faults": {"broken_bars": ONE_ROW}}
    reference, history = launched(configured(**groups), roller=roller, speed=0.2 * sign, duration=1.2e-4)
    k = int(np.flatnonzero(reference.bars.roller == reference.bodies.roller_bodies[0, roller])[0])
    approach = reference.bars.kinematics(reference.state.position, reference.state.velocity)
    assert reference.bars.side[k] == sign
    assert approach.penetration[k] < 0.0
    assert -approach.rate[k] / 0.2 == pytest.approx(0.9, abs=0.03)  # the restitution set; measured 0.87 and 0.89
    assert history.drift.max() < 1e-12
