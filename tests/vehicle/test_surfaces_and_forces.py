"""Sizes of what moves a vehicle: roughness, corrugation, joints, out-of-round wheels, gear and motor, and waves along the axle."""

from __future__ import annotations

import math

import numpy as np
import pytest

from dcrb_ros.vehicle.description import Axle, Gear, Motor, Track, Vehicle
from dcrb_ros.vehicle.file import read_vehicle
from dcrb_ros.vehicle.paths import group_velocity
from dcrb_ros.vehicle.track import Rails, roughness
from dcrb_ros.vehicle.traction import TractionForce
from dcrb_ros.vehicle.wheels import WheelSurface, positions

SMOOTH = Track(spectrum="none", roughness=-40.0)


def vehicle(**changes: object) -> Vehicle:
    return read_vehicle("healthy_bogie", {key.replace("__", "."): value for key, value in changes.items()})


def third_octave(values: np.ndarray, spacing: float, wavelength: float) -> float:
    """Return the level of the third of an octave about a wavelength [dB re 1 um]."""
    power = np.abs(np.fft.rfft(values)) ** 2 * 2.0 / len(values) ** 2
    number = np.fft.rfftfreq(len(values), spacing) * wavelength
    return 10.0 * math.log10(power[(number >= 2.0 ** (-1 / 6)) & (number < 2.0 ** (1 / 6))].sum() / 1e-12)


def test_rails_have_the_roughness_of_the_file_in_third_octaves() -> None:
    track, place = Track(spectrum="none", roughness=8.0), np.arange(0.0, 2000.0, 0.01)
    heights = [Rails(track).displacements(place, (side,))[side] for side in (1, -1)]
    for height in heights:
        # 3 dB per octave of wavelength; the patch of 12 mm takes 0.2 dB at 0.1 m.
        assert third_octave(height, 0.01, 0.2) == pytest.approx(8.0 + 3.0, abs=0.5)
        assert third_octave(height, 0.01, 0.1) == pytest.approx(8.0 - 0.2, abs=0.5)
    assert abs(np.corrcoef(*heights)[0, 1]) < 0.05


def test_a_wheel_has_the_roughness_of_the_file_in_third_octaves() -> None:
    made = vehicle(track__spectrum="none", track__roughness=8.0)
    angle = np.linspace(0.0, 2.0 * math.pi, 4096, endpoint=False)
    levels = [third_octave(WheelSurface(made, box).displacement(angle, positions(angle), 20.0), 0.46 * angle[1], 0.1) for box in made.boxes]
    assert levels == pytest.approx([8.0 - 0.2] * 4, abs=1.0)  # a third of an octave has 6 or 7 lines of the wheel


@pytest.mark.parametrize(
    ("wavelength", "averaged"),
    # (1 + pi (2 pi a / wavelength)^3 / 4)^(-1/2) with a = 6 mm; 0 dB for long waves.
    [(0.25, 0.0), (0.1, 0.18), (0.02, 7.97), (0.01, 16.3)],
)
def test_the_contact_patch_averages_short_waves(wavelength: float, averaged: float) -> None:
    long, wavenumber = 0.25, 2.0 * math.pi * np.array([1.0 / 0.25, 1.0 / wavelength])
    density = roughness(0.0)(wavenumber) * wavenumber  # for each relative width of a band
    level = 10.0 * float(np.log10(density[1] / density[0])) - 3.0 * math.log2(wavelength / long)
    assert level == pytest.approx(-averaged, abs=0.05)


def test_a_corrugated_rail_has_its_wavelength_and_amplitude() -> None:
    rails = Rails(SMOOTH.model_copy(update={"corrugation": "0.05 10e-6 right"}))
    place = np.arange(0.0, 5.0, 0.001)
    line = 2.0 * np.fft.rfft(rails.displacements(place, (-1,))[-1]) / len(place)
    assert abs(line[100]) == pytest.approx(10e-6, rel=1e-9)  # 100 waves in 5 m
    assert np.abs(np.delete(line, 100)).max() < 1e-12
    assert not rails.displacements(place, (1,))[1].any()


def test_a_rail_bends_at_a_joint_by_twice_the_angle() -> None:
    rails = Rails(SMOOTH.model_copy(update={"joint_spacing": 25.0, "joint_angle": 0.004}))
    before, at, after = rails.displacements(np.array([25.0 - 1e-4, 25.0, 25.0 + 1e-4]), (1,))[1]
    assert (at - before) / 1e-4 == pytest.approx(-0.004, rel=1e-3)
    assert (after - at) / 1e-4 == pytest.approx(0.004, rel=1e-3)
    assert at == pytest.approx(-0.002, rel=1e-3)  # 4 mrad over 0.5 m
    assert not rails.displacements(np.array([25.0 + 6.0]), (1,))[1].any()


def test_an_out_of_round_wheel_has_its_orders_and_amplitudes() -> None:
    made = vehicle(track__spectrum="none", track__roughness=-40.0, axle_1__left__wheel__polygon="1 1e-4, 3 20e-6")
    angle = np.linspace(0.0, 2.0 * math.pi, 360, endpoint=False)
    line = 2.0 * np.abs(np.fft.rfft(WheelSurface(made, made.boxes[0]).displacement(angle, positions(angle), 20.0))) / 360
    assert line[:5] == pytest.approx([0.0, 1e-4, 0.0, 20e-6, 0.0], abs=1e-12)


def forces(gear: Gear, motor: Motor) -> np.ndarray:
    """Return the amplitudes of the force of a drive over a wheelset of 1813 kg, by orders of its angle [m/s^2 rms]."""
    angle = np.linspace(0.0, 2.0 * math.pi * 10.0, 40_000, endpoint=False)
    force = TractionForce(Axle("axle_1", 0.0, 0.46, 0.0, 0.0, gear, motor), 1).at(angle)
    return np.asarray(math.sqrt(2.0) * np.abs(np.fft.rfft(force)) / len(angle) / 1813.0)


def test_a_gear_accelerates_a_rigid_wheelset_by_its_level() -> None:
    line = forces(Gear(teeth=87, level=3.0, modulation=0.2), Motor())
    assert line[[870, 1740, 2610]] == pytest.approx([3.0, 1.5, 0.75], rel=1e-6)  # the mesh and its harmonics
    assert line[[860, 880]] == pytest.approx([0.3, 0.3], rel=1e-6)  # half of the modulation on either side


@pytest.mark.parametrize(("slip", "order"), [(0.0, 16), (-1.0 / 15.0, 15)])
def test_a_motor_accelerates_a_rigid_wheelset_by_its_level(slip: float, order: int) -> None:
    """At 2 p i / (1 - s) orders of the axle, and by half of it at the i of the rotor."""
    line = forces(Gear(), Motor(level=2.0, ratio=4.0, pole_pairs=2, slip=slip))
    assert line[[10 * order, 40]] == pytest.approx([2.0, 1.0], rel=1e-6)


def test_bending_waves_travel_at_the_slope_of_their_dispersion() -> None:
    """In a bar of 170 mm of steel w = k^2 (EI / rho A)^(1/2), whose slope dw/dk is the group velocity."""
    section = math.sqrt(2.06e11 / 7850.0) * 0.17 / 4.0  # (EI / rho A)^(1/2) [m^2/s]
    for frequency in (200.0, 500.0, 800.0):
        k = math.sqrt(2.0 * math.pi * frequency / section)
        slope = ((k + 1e-4) ** 2 - (k - 1e-4) ** 2) * section / 2e-4
        assert float(group_velocity(np.array([frequency]))[0]) == pytest.approx(slope, rel=1e-6)
    assert float(group_velocity(np.array([2e4]))[0]) == 3000.0
