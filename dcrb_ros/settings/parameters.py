"""The parameters of a simulation: one group per class, in SI units.

These models are the schema of the YAML files, the ROS parameters, the manifest of a recording and the table in the documentation. Table 1
and the numbers of equations refer to Fan et al. 2025 (Lubricants 13(2), 80).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Literal

from pydantic import model_validator

from dcrb_ros.schema.fields import LENGTH_REMEDY, Group, choice, length, quantity
from dcrb_ros.settings.vehicle_speed import FASTEST_KMH, LARGEST_WHEEL, with_shaft_speed

COMMANDED = {"operating.speed": "command/speed", "operating.load": "command/load", "operating.lateral_load": "command/load"}
"""Parameters that are changed by commands while a node runs, and the topics of these commands."""
STEEL_DENSITY = 7850.0
"""Of rings and rolling elements [kg/m^3]."""


class Bearing(Group):
    """Geometry, masses and material; by default Table 1 of Fan et al. 2025, with the spin inertia m r^2/2 of a solid roller."""

    rows: int = quantity(2, "-", "Rows of rollers", 1, 2)
    rollers_per_row: int = quantity(16, "-", "Rollers in each row", 6, 60)
    inner_raceway_radius: float = length(0.07886, "Inner raceway radius", 0.002, 2.0, symbol="r_I")
    outer_raceway_radius: float = length(0.10914, "Outer raceway radius", 0.003, 2.5, symbol="r_O")
    pitch_radius: float = length(0.094, "Pitch radius", 0.0025, 2.2, symbol="r_M")
    roller_radius: float = length(0.015, "Roller radius in the plane of the model", 0.0005, 0.2, symbol="r_R")
    roller_length: float = length(0.048, "Effective roller length", 0.001, 0.5, symbol="L")
    contact_angle: float = quantity(
        0.0,
        "rad",
        "Contact angle, a mean of both raceways; roller_radius is that in the plane of the model, the roller's own times its cosine",
        0.0,
        1.0,
        symbol="alpha",
        remedy="give radians, 15 degrees are 0.2618",
    )
    row_phase: float = quantity(
        0.0, "pitch", "Offset of the second row around the circumference, in roller pitches (0: rows in phase)", 0.0, 1.0
    )
    outer_ring_mass: float = quantity(13.49, "kg", "Mass of the outer ring", 0.001, 1e4, symbol="m_O")
    inner_ring_mass: float = quantity(7.316, "kg", "Mass of the inner ring", 0.001, 1e4, symbol="m_I")
    cage_mass: float = quantity(2.459, "kg", "Mass of one cage", 0.0001, 1e3, symbol="m_C")
    roller_mass: float = quantity(0.248, "kg", "Mass of one roller", 0.00001, 1e2, symbol="m_R")
    cage_inertia: float = quantity(2.19e-2, "kg m^2", "Moment of inertia of one cage", 1e-10, 1e3, symbol="I_C")
    roller_inertia: float = quantity(
        2.79e-5,
        "kg m^2",
        "Moment of inertia of one roller about its axis; Table 1 gives 6.15e-5, the transverse one",
        1e-12,
        1e1,
        symbol="I_R",
        remedy="for a solid roller it is mass * radius^2 / 2",
    )
    youngs_modulus: float = quantity(
        207.5e9, "Pa", "Young's modulus of rings and rollers", 1e9, 1e12, symbol="E", remedy="give pascals, not GPa"
    )
    poisson_ratio: float = quantity(0.3, "-", "Poisson's ratio of rings and rollers", 0.0, 0.49, symbol="nu")

    @property
    def radial_gap(self) -> float:
        """Radial gap r_O - r_I - 2 r_R [m]."""
        return self.outer_raceway_radius - self.inner_raceway_radius - 2.0 * self.roller_radius

    @property
    def own_roller_radius(self) -> float:
        """Radius of a roller or ball itself, at its middle, r_R/cos(alpha) [m]."""
        return self.roller_radius / math.cos(self.contact_angle)

    @property
    def effective_modulus(self) -> float:
        """Effective modulus E* of two equal materials, Eq. 5 [Pa]."""
        return self.youngs_modulus / (2.0 * (1.0 - self.poisson_ratio**2))


class Housing(Group):
    """Spring and damper between outer ring and ground, equal in X and Y (Table 1)."""

    stiffness: float = quantity(212e6, "N/m", "Stiffness of the housing in X and in Y", 1e3, 1e12, symbol="k_h")
    damping: float = quantity(1e5, "N s/m", "Damping of the housing in X and in Y", 0.0, 1e8, symbol="c_h")
    box_mass: float = quantity(0.0, "kg", "Mass of the axle box, which moves with the outer ring", 0.0, 1e4)
    axle_mass: float = quantity(0.0, "kg", "Mass of the axle and wheels, which moves with the inner ring", 0.0, 1e4)
    suspension_stiffness: float = quantity(
        0.0,
        "N/m",
        "Stiffness of a primary suspension between axle box and a frame that carries the load, in X and in Y; 0 for none",
        0.0,
        1e12,
        symbol="k_p",
        remedy="primary springs have 0.5e6 to 50e6 N/m",
    )
    suspension_damping: float = quantity(0.0, "N s/m", "Damping of the primary suspension in X and in Y", 0.0, 1e8, symbol="c_p")


class Surfaces(Group):
    """Heights of raceways and rollers: perfect surfaces with notches, or profiles of an individual bearing."""

    law: Literal["smooth", "profile"] = choice(
        "smooth",
        "Surfaces: smooth, perfect ones (the paper), or profile, the waviness, dimensions and damage of an individual",
    )
    seed: int = quantity(0, "-", "Seed that makes the bearing an individual; 0 for simulation.seed", 0, 2**31 - 1)
    waviness: float = length(1e-7, "Waviness of the raceways of 15 to 150 lobes, root mean square; half of it on rollers", 0.0, 1e-5)
    waviness_slope: float = quantity(1.5, "-", "Exponent with which the amplitudes of waviness fall over the number of lobes", 0.5, 4.0)
    waviness_spread: float = quantity(
        0.4, "-", "Standard deviation of the logarithm of the waviness between bearings, which is within twice that", 0.0, 1.0
    )
    short_waves: float = length(
        0.0,
        "Level of waves shorter than 1/150 of a raceway, averaged along the length of a roller; rms, half of it from rollers",
        0.0,
        1e-6,
    )
    roundness: float = length(1e-6, "Out-of-roundness of the raceways of 2 to 14 lobes, root mean square", 0.0, 1e-4)
    roller_spread: float = length(4e-7, "Standard deviation of the diameters of the rollers", 0.0, 1e-5)
    clearance_spread: float = length(
        1e-5, "Standard deviation of the diametral clearance between bearings, which is within twice that", 0.0, 1e-4
    )
    row_spread: float = length(1e-6, "Standard deviation of the outer raceway's radius between rows", 0.0, 1e-5)
    run_out: float = length(
        5e-6,
        "Root mean square of the eccentricity of each inner raceway, which turns with the shaft and shifts load between rows",
        0.0,
        1e-4,
    )
    pocket_spread: float = length(1.5e-5, "Standard deviation of the places of the pockets along the pitch circle", 0.0, 1e-4)
    pocket_clearance_spread: float = length(
        1e-5, "Standard deviation of the clearance of pockets between bearings, which is within twice that", 0.0, 1e-4
    )
    single_pocket_spread: float = length(
        0.0, "Standard deviation of the clearance of single pockets within a bearing, which is within twice that", 0.0, 1e-4
    )
    cage_unbalance: float = length(5e-6, "Distance of each cage's centre of mass from its centre, at a random angle", 0.0, 1e-3)
    cage_unbalance_spread: float = quantity(
        0.0, "-", "Standard deviation of the logarithm of that distance between cages, which is within twice that", 0.0, 1.0
    )


class Cage(Group):
    """Joint of rollers and cage, and contacts of the cage."""

    joint: Literal["revolute", "pocket"] = choice(
        "pocket",
        "Joint of roller and cage: pocket lets every roller move between its bars; revolute pins its centre to the pocket's (the paper)",
    )
    pocket_clearance: float = length(
        0.0001, "Circumferential clearance between a roller and a bar, on either side", 5e-6, 0.005, symbol="c_p"
    )
    land_clearance: float = length(0.0003, "Radial clearance between cage and land", 5e-6, 0.01, symbol="c_l")
    land_radius: float = length(0.0, "Radius of the land on the outer ring; 0 for midway between pitch circle and outer raceway", 0.0, 2.5)
    restitution: float = quantity(0.9, "-", "Coefficient of restitution of impacts on bars and land (steel)", 0.0, 1.0, symbol="c_e")
    friction_coefficient: float = quantity(0.05, "-", "Friction coefficient of bars and land", 0.0, 1.0)


class Operating(Group):
    """Speed, load and initial state."""

    speed: float = quantity(
        125.664,
        "rad/s",
        "Speed of the inner ring, counter-clockwise positive",
        -1000.0,
        1000.0,
        symbol="omega_I",
        remedy="speeds are in rad/s, 1200 rpm is 125.664 rad/s",
        run_time=True,
    )
    load: float = quantity(
        100e3, "N", "Load on the inner ring, downwards (-Y)", -1e7, 1e7, symbol="Q", remedy="give newtons, not kN", run_time=True
    )
    lateral_load: float = quantity(0.0, "N", "Load on the inner ring along X", -1e7, 1e7, remedy="give newtons, not kN", run_time=True)
    speed_kmh: float = quantity(
        0.0,
        "km/h",
        "Speed of the vehicle instead of operating.speed, converted with wheel_diameter; 0 for none",
        -FASTEST_KMH,
        FASTEST_KMH,
    )
    wheel_diameter: float = quantity(
        0.92, "m", "Diameter of the wheels on the shaft", 0.05, LARGEST_WHEEL, symbol="D", remedy=LENGTH_REMEDY
    )
    speed_ramp: float = quantity(50.0, "rad/s^2", "Rate at which the speed changes to a commanded one", 1e-6, 1e5, run_time=True)
    load_ramp: float = quantity(2e5, "N/s", "Rate at which the load changes to a commanded one, per axis", 0.001, 1e9, run_time=True)
    speed_fluctuation: float = quantity(
        0.0,
        "-",
        "Slow random fluctuation of the speed, 0.1 to 5 Hz, root mean square over the speed; 0 for none",
        0.0,
        0.02,
        remedy="give a share, not per cent",
    )
    speed_ripple: float = quantity(
        0.0,
        "-",
        "Fluctuation of the speed with the orders 1 and 2 of the shaft, root mean square over the speed; 0 for none",
        0.0,
        0.02,
        remedy="give a share, not per cent",
    )
    gravity: float = quantity(9.81, "m/s^2", "Gravity, downwards", 0.0, 100.0, symbol="g")
    start: Literal["warm", "settled", "cold"] = choice(
        "warm",
        "Initial state: warm, static equilibrium and pure rolling; settled, the same with the cages lying on rollers or land instead of "
        "falling; cold, cage and rollers at rest (Fig. 8 of the paper)",
    )
    cage_angles: Literal["set", "drawn"] = choice(
        "set", "Angles of the cages at the start: set, by bearing.row_phase, or drawn by simulation.seed, for rows drift apart"
    )

    @model_validator(mode="before")
    @classmethod
    def _speed_of_vehicle(cls, given: Any) -> Any:
        """Replace a speed in km/h by the shaft's."""
        return with_shaft_speed(given, cls.model_fields["wheel_diameter"].default) if isinstance(given, Mapping) else given


class Publishing(Group):
    """Blocks and rates on the topics."""

    block_size: int = quantity(1024, "samples", "Samples in a block", 16, 65536)
    state_rate: int = quantity(100, "Hz", "Rate of roller_states in simulated time; use 100 to 1000 for a live topic", 1, 10000)
    loss_probability: float = quantity(
        0.0, "-", "Probability that a block of the waveform is lost in transmission", 0.0, 0.9, remedy="give a share, not per cent"
    )
    burst_length: float = quantity(0.0, "s", "Burst mode: length of a burst; only blocks that begin in a burst are published", 0.0, 1e5)
    burst_period: float = quantity(0.0, "s", "Burst mode: period of the bursts; 0 for a continuous waveform", 0.0, 1e6)
    preview_rate: int = quantity(200, "Hz", "Rate of the low-pass filtered preview in simulated time", 10, 1000)
    truth_rate: int = quantity(10, "Hz", "Rate of ground_truth in simulated time; every change is published in addition", 1, 100)
    listeners: int = quantity(0, "-", "Subscribers to the waveform that a node waits for before its first block", 0, 1000)
    wait: float = quantity(30.0, "s", "Longest wall time to wait for them", 0.0, 1e4)
    clock: bool = choice(False, "Also publish /clock, the simulated time, at most 100 times per second of wall time")
    frame: str = choice("outer_ring", "Frame id of the sensor's messages; several bearings in one graph need different ones")
    clean: bool = choice(False, "Also publish outer_ring/vibration_clean, the acceleration of the ring after the anti-alias filter alone")
    features: bool = choice(False, "Also publish outer_ring/window_features: features of windows of a second, as dcrb_ros.extract_features")
    contacts: bool = choice(False, "Also publish roller_contacts: outer normal force, slip and friction of every roller")


class Recording(Group):
    """The MCAP recording."""

    path: str = choice("", "Folder of the recording; empty for no recording")
    compression: Literal["zstd", "lz4", "none"] = choice("zstd", "Compression of the chunks")
    topics: str = choice("", "Topics to record, such as 'outer_ring/vibration, ground_truth'; empty for all published topics")
    split_size: int = quantity(
        0, "B", "Size at which the recording continues in a new file; 0 for a single file", 0, 2**40, remedy="1 GB is 1000000000 bytes"
    )
    split_duration: float = quantity(
        0.0, "s", "Simulated time after which the recording continues in a new file; 0 for a single file", 0.0, 1e6
    )
    queue: int = quantity(500, "blocks", "Blocks that may wait to be written before the node ends the recording", 10, 100000)


def rpm(speed: float) -> float:
    """Return a speed [rad/s] in revolutions per minute."""
    return speed * 30.0 / math.pi
