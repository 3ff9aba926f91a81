"""Bearings other than the default one, configured in YAML: frequencies, load and cage speed."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from runs import Run
from scipy import signal

from dcrb_ros.bearing.equilibrium import roller_forces, static_equilibrium
from dcrb_ros.bearing.frequencies import characteristic_orders
from dcrb_ros.bearing.payload import build_payload
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.settings.loaded_contacts import cage_speed
from dcrb_ros.simulation.loop import Simulation

JOINTS = ("revolute", "pocket")
SECONDS, SETTLING = 1.5, 0.3
STEEL = 7850.0  # kg/m^3


@dataclass(frozen=True)
class Drawing:
    """Dimensions of a bearing as in its drawing [mm]."""

    rows: int
    rollers: int
    roller_diameter: float
    roller_length: float
    pitch_diameter: float


DRAWINGS = {"nu205": Drawing(1, 13, 7.5, 9.0, 39.016), "nn3020": Drawing(2, 30, 11.0, 11.0, 126.01)}
BEARINGS = pytest.mark.parametrize("name", list(DRAWINGS))


def configured(name: str, joint: str, *settings: str) -> Configuration:
    return load_configuration(Path(__file__).parent / "bearings" / f"{name}.yaml", [f"cage.joint={joint}", *settings])


@functools.cache
def defective(name: str, joint: str) -> Run:
    """Return a noiseless run with a notch in the outer raceway of row 1."""
    settings = ("faults.outer_1.width=0.0006", "faults.outer_1.row=1", "sensor.noise_density=0.0")
    configuration = configured(name, joint, *settings)
    return Run(configuration, list(Simulation(configuration).blocks(SECONDS)))


def cage_speeds(run: Run) -> np.ndarray:
    """Return the mean speed of each cage after the transient [rad/s]."""
    bearing = run.configuration.bearing
    first = bearing.rows * bearing.rollers_per_row
    settled = round(SETTLING * run.configuration.publishing.state_rate)
    return run.series("speed")[settled:, first : first + bearing.rows].mean(axis=0)


@BEARINGS
def test_orders_follow_the_formulas_of_the_textbook(name: str) -> None:
    drawing, orders = DRAWINGS[name], characteristic_orders(configured(name, "pocket").bearing)
    ratio = drawing.roller_diameter / drawing.pitch_diameter  # the formulas of Randall and Antoni 2011, contact angle 0
    assert orders.bpfo == pytest.approx(0.5 * drawing.rollers * (1.0 - ratio), rel=1e-6)
    assert orders.bpfi == pytest.approx(0.5 * drawing.rollers * (1.0 + ratio), rel=1e-6)
    assert orders.ftf == pytest.approx(0.5 * (1.0 - ratio), rel=1e-6)
    assert orders.bsf == pytest.approx(0.5 / ratio * (1.0 - ratio**2), rel=1e-6)


@BEARINGS
def test_rollers_are_solid_steel(name: str) -> None:
    drawing, bearing = DRAWINGS[name], configured(name, "pocket").bearing
    mass = STEEL * 0.25 * math.pi * drawing.roller_diameter**2 * drawing.roller_length * 1e-9
    assert bearing.roller_mass == pytest.approx(mass, rel=1e-3)
    assert bearing.roller_inertia == pytest.approx(0.5 * mass * bearing.roller_radius**2, rel=3e-3)


@pytest.mark.parametrize("joint", JOINTS)
@BEARINGS
def test_forces_balance_the_load_at_rest(name: str, joint: str) -> None:
    configuration = configured(name, joint)
    payload, load = build_payload(configuration), configuration.operating.load
    rest = static_equilibrium(payload, np.array([0.0, -load]), cage_speed(configuration, configuration.operating.speed))
    inner, outer = roller_forces(payload, rest.outer, rest.inner, rest.rollers)
    weight = 9.81 * configuration.bearing.inner_ring_mass
    assert inner.sum(axis=(0, 1)) == pytest.approx([0.0, -load - weight], abs=3e-3 * load)
    carried = outer.sum(axis=(0, 1)) + 9.81 * np.array([0.0, configuration.bearing.outer_ring_mass])
    assert carried == pytest.approx(-configuration.housing.stiffness * rest.outer, abs=3e-3 * load)
    heaviest = np.linalg.norm(inner, axis=-1).max()
    assert 4.0 * load < heaviest * inner[..., 0].size < 6.0 * load  # Stribeck: 4.6 without a radial gap, 5 with one, more under small loads


@pytest.mark.parametrize("joint", JOINTS)
@BEARINGS
def test_the_cage_rotates_at_the_speed_of_pure_rolling(name: str, joint: str) -> None:
    run = defective(name, joint)
    expected = cage_speed(run.configuration, run.configuration.operating.speed)
    # A free cage is lower by the clearance of its land, closer to the loaded rollers that drive it, and so rotates a little faster.
    hanging = run.configuration.cage.land_clearance / run.configuration.bearing.pitch_radius
    assert cage_speeds(run) == pytest.approx(expected, rel={"revolute": 5e-4, "pocket": hanging}[joint])


@pytest.mark.parametrize("joint", JOINTS)
@BEARINGS
def test_the_running_bearing_carries_its_load(name: str, joint: str) -> None:
    run = defective(name, joint)
    force = np.array([states.inner_ring_force for states in run.states])[10:]
    load = run.configuration.operating.load
    assert np.median(force, axis=0) == pytest.approx([0.0, load], abs=0.01 * load)


@pytest.mark.parametrize("joint", JOINTS)
@BEARINGS
def test_an_outer_raceway_defect_has_a_line_at_bpfo(name: str, joint: str) -> None:
    run = defective(name, joint)
    rate = run.configuration.sensor.sampling_rate
    envelope = np.abs(signal.hilbert(signal.detrend(run.clean[round(SETTLING * rate) :, 1])))
    window = signal.windows.hann(len(envelope))
    spectrum = np.abs(np.fft.rfft((envelope - envelope.mean()) * window, 4 * len(envelope)))
    frequency = np.fft.rfftfreq(4 * len(envelope), 1.0 / rate)
    expected = run.configuration.bearing.rollers_per_row * cage_speeds(run)[0] / (2.0 * math.pi)
    searched = (frequency > 0.25 * expected) & (frequency < 1.4 * expected)
    assert frequency[searched][spectrum[searched].argmax()] == pytest.approx(expected, rel=0.01)
