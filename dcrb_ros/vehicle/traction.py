"""The forces of gear and motor on the axle of a driven wheelset, at orders of its angle."""

from __future__ import annotations

import math

import numpy as np

from dcrb_ros.measurement.random_streams import random_stream
from dcrb_ros.measurement.stages.traction_drive import MESH_HARMONICS, ROTOR_SHARE
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.vehicle.description import Axle

WHEELSET_MASS = 1813.0
"""[kg]"""
FADE = 0.35, 0.4
"""Share of the rate of the ticks over which lines fade out, before they would be aliased [-]."""


class TractionForce:
    r"""The force of gear and motor, with the orders of `dcrb_ros.measurement.stages.traction_drive` and a slip.

    With the angle :math:`\theta` of the wheelset, its mass m, :math:`z` teeth, the ratio :math:`i`, :math:`p` pairs of poles, the slip s
    and the levels :math:`a_g` and :math:`a_m`,

    .. math:: F = \sqrt2 m \, [a_g (1 + r \cos(\theta + \varphi_0)) \sum_k h_k \cos(k z \theta + \varphi_k)
              + a_m (\cos(2 p i \theta / (1 - s) + \varphi_4) + \tfrac12 \cos(i \theta + \varphi_5))].

    The rotor turns slower than the field of the supply by the slip, so that twice the supply frequency is 2 p i / (1 - s) orders of the
    axle. Forces do not depend on the speed (an assumption).
    """

    def __init__(self, axle: Axle, seed: int) -> None:
        self._gear, self._motor = axle.gear, axle.motor
        self._phases = [float(phase) for phase in 2.0 * math.pi * random_stream(seed, f"drive/{axle.name}").random(len(MESH_HARMONICS) + 3)]

    @property
    def active(self) -> bool:
        """Whether there is any force."""
        return (self._gear.teeth > 0 and self._gear.level > 0.0) or self._motor.level > 0.0

    def at(self, angle: Floats) -> Floats:
        """Return the force at the angles of the wheelset at consecutive ticks [rad], shape (ticks,) [N]."""
        eccentric, *mesh, field, rotor = self._phases
        turn = abs(float(angle[-1] - angle[0])) / (len(angle) - 1)
        force = np.zeros(len(angle))

        def line(order: float, phase: float) -> Floats:
            per_tick = order * turn / (2.0 * math.pi)
            share = min(max((FADE[1] - per_tick) / (FADE[1] - FADE[0]), 0.0), 1.0)
            return share * np.cos(order * angle + phase)

        if self._gear.teeth > 0:
            for k, (share, phase) in enumerate(zip(MESH_HARMONICS, mesh, strict=True), start=1):
                force += self._gear.level * share * line(k * self._gear.teeth, phase)
            force *= 1.0 + self._gear.modulation * np.cos(angle + eccentric)
        if self._motor.level > 0.0:
            supply = self._motor.pole_pairs * self._motor.ratio / (1.0 - self._motor.slip)
            force += self._motor.level * (line(2.0 * supply, field) + ROTOR_SHARE * line(self._motor.ratio, rotor))
        return math.sqrt(2.0) * WHEELSET_MASS * force
