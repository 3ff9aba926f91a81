"""Vibration of the traction drive: meshing gears and the motor, at orders of the shaft that are not those of the bearing."""

from __future__ import annotations

import math

import numpy as np

from dcrb_ros.measurement.random_streams import random_stream
from dcrb_ros.measurement.stage import Parameters, Setup, Span, Stage
from dcrb_ros.measurement.stages.background import REFERENCE_SPEED
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import Group, quantity

MESH_HARMONICS = (1.0, 0.5, 0.25)
"""Amplitudes of the mesh harmonics relative to the first [-]; they fall by about 6 dB each in a gear without damage."""
ROTOR_SHARE = 0.5
"""Amplitude at one revolution of the rotor relative to that at twice the supply frequency [-]."""


class DriveParameters(Group):
    """Levels and orders of gears and motor."""

    gear_level: float = quantity(
        0.0, "m/s^2", "Amplitude of the gear mesh at 72 km/h, on both axes; proportional to the speed", 0.0, 1e3, run_time=True
    )
    gear_teeth: int = quantity(87, "-", "Teeth of the gear on the axle: order of the mesh", 5, 200)
    gear_modulation: float = quantity(0.2, "-", "Modulation of the mesh once per revolution of the axle, by run-out of the gear", 0.0, 1.0)
    motor_level: float = quantity(
        0.0,
        "m/s^2",
        "Amplitude of the motor at twice its supply frequency at 72 km/h, on both axes; proportional to the speed",
        0.0,
        1e3,
        run_time=True,
    )
    motor_ratio: float = quantity(4.14, "-", "Revolutions of the motor per revolution of the axle", 0.1, 20.0)
    motor_pole_pairs: int = quantity(2, "-", "Pairs of poles of the motor", 1, 12)


class TractionDrive(Stage):
    r"""Adds the vibration of gears and motor, alike in X and Y.

    With the shaft angle :math:`\theta`, :math:`z` teeth, the ratio :math:`i`, :math:`p` pairs of poles and the speed :math:`v` over 20 m/s,

    .. math:: a_{gear} = a_g v \, (1 + m \cos(\theta + \varphi_0)) \sum_k h_k \cos(k z \theta + \varphi_k), \qquad
              a_{motor} = a_m v \, (\cos(2 p i \theta + \varphi_4) + \tfrac12 \cos(i \theta + \varphi_5)).

    The radial magnetic force of an induction motor pulsates at twice the supply frequency, :math:`p i` per revolution of the axle without
    slip. The phases :math:`\varphi` follow from the seed.
    """

    group, parameters = "background", DriveParameters

    def __init__(self, setup: Setup, rate: float) -> None:
        super().__init__(setup, rate)
        self._drive = setup.parameters[DriveParameters]
        self._relative_speed = 0.5 * setup.wheel_diameter / REFERENCE_SPEED
        self._phases = 2.0 * math.pi * random_stream(setup.seed, "drive").random(len(MESH_HARMONICS) + 3)

    def set_parameters(self, parameters: Parameters, tick: int) -> None:
        self._drive = parameters[DriveParameters]

    @property
    def active(self) -> bool:
        return self._drive.gear_level > 0.0 or self._drive.motor_level > 0.0

    def process(self, acceleration: Floats, span: Span) -> Floats:
        drive, angle = self._drive, span.angle[1:]
        eccentric, *mesh, field, rotor = (float(phase) for phase in self._phases)
        vibration = np.zeros(len(angle))
        if drive.gear_level > 0.0:
            for k, (share, phase) in enumerate(zip(MESH_HARMONICS, mesh, strict=True), start=1):
                vibration += drive.gear_level * share * np.cos(k * drive.gear_teeth * angle + phase)
            vibration *= 1.0 + drive.gear_modulation * np.cos(angle + eccentric)
        if drive.motor_level > 0.0:
            supply = drive.motor_pole_pairs * drive.motor_ratio
            vibration += drive.motor_level * np.cos(2.0 * supply * angle + field)
            vibration += drive.motor_level * ROTOR_SHARE * np.cos(drive.motor_ratio * angle + rotor)
        vibration *= np.abs(np.diff(span.angle)) * (self.rate * self._relative_speed)
        return acceleration + vibration[:, None]
