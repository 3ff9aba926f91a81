"""The displacement between wheel and rail by the wheel: roughness, out-of-roundness and flats, locked to the angle of the wheelset."""

from __future__ import annotations

import math

import numpy as np

from dcrb_ros.measurement.random_streams import random_stream
from dcrb_ros.schema.arrays import Complexes, Floats
from dcrb_ros.vehicle.description import GRAVITY, Box, Vehicle, Wheel, orders
from dcrb_ros.vehicle.kernels import cubic
from dcrb_ros.vehicle.track import roughness

POINTS = 2048
"""Points of the roughness around a wheel [-]."""
UNSPRUNG_MASS = 905.5
"""Mass that falls into a flat: half a wheelset with a box [kg]."""


def jump(length: float, worn: float, radius: float, speed: float, load: float) -> float:
    """Return the jump of velocity at a flat [m/s], worn (l / R) min(v, sqrt(a R)) with a = g + F / m.

    Up to the speed sqrt(a R) the wheel rolls over the chord; above, it clears the rail and falls (two regimes as in Steenbergen 2008).
    """
    return worn * length / radius * min(speed, math.sqrt((GRAVITY + load / UNSPRUNG_MASS) * radius))


def positions(angle: Floats) -> Floats:
    """Return angles of a wheelset [rad] as positions in the points around its wheels [-], same shape."""
    return np.asarray(np.mod(angle, 2.0 * np.pi) * (POINTS / (2.0 * np.pi)), np.float64)


class WheelSurface:
    """The surface of a wheel as its angle passes the rail."""

    def __init__(self, vehicle: Vehicle, box: Box) -> None:
        self._radius, self._load = vehicle.axles[box.axle].radius, vehicle.static_load
        random = random_stream(vehicle.track.seed, f"wheel/{box.name}")
        order = np.arange(1, POINTS // 2 + 1)
        wavenumber = order / self._radius
        amplitude = np.sqrt(2.0 * roughness(vehicle.track.roughness)(wavenumber) / self._radius)
        spectrum = np.concatenate([[0.0], amplitude * np.exp(2j * np.pi * random.uniform(size=len(order)))]) * POINTS / 2.0
        spectrum[-1] = 0.0
        self._rough = self._table(np.asarray(spectrum, np.complex128))
        self._curvature = self._table(np.asarray(spectrum * np.concatenate([[0.0], -(wavenumber**2)]), np.complex128))
        self._flat_angle = float(random.uniform(0.0, 2.0 * math.pi))
        self._unbalance_angle = float(random.uniform(0.0, 2.0 * math.pi))
        self._name = box.name
        self.wear(box.wheel)

    def wear(self, wheel: Wheel) -> None:
        """Take other defects.

        Raises:
            Refusal: the orders of the polygon cannot be read.
        """
        self._polygon = orders(wheel.polygon, f"{self._name}.wheel.polygon")
        self._wheel = wheel

    @staticmethod
    def _table(spectrum: Complexes) -> Floats:
        """Return a turn with the points that the cubic needs beyond its ends."""
        turn = np.fft.irfft(spectrum, POINTS)
        return np.concatenate([turn[-1:], turn, turn[:3]])

    def displacement(self, angle: Floats, position: Floats, speed: float) -> Floats:
        """Return the displacement at angles of the wheelset [rad], whose `positions` are given [m]."""
        height = cubic(self._rough, position)
        for order, amplitude in self._polygon:
            height += amplitude * np.cos(order * angle)
        if self._wheel.flat > 0.0:
            # Where the wheel clears the rail, it falls for the time that makes the jump.
            falling = 0.5 * speed * self.jump(speed) / (GRAVITY + self._load / UNSPRUNG_MASS)
            reach = max(0.5 * self._wheel.flat, falling)
            depth = 0.5 * self.jump(speed) * reach / speed
            away = np.mod(angle - self._flat_angle + np.pi, 2.0 * np.pi) - np.pi
            height -= depth * np.exp(-abs(away) * self._radius / reach)
        return height

    @property
    def unbalanced(self) -> bool:
        """Whether the wheel has an unbalance."""
        return self._wheel.unbalance > 0.0

    def unbalance(self, angle: Floats, speed: Floats) -> Floats:
        """Return the vertical force of the unbalance U on the axle, U w^2 sin(angle), at angles and speeds w [rad/s] of a wheelset [N]."""
        return np.asarray(self._wheel.unbalance * speed**2 * np.sin(angle + self._unbalance_angle), np.float64)

    def curvature(self, position: Floats) -> Floats:
        """Return the second derivative of the roughness along the circumference at `positions` [1/m]."""
        return cubic(self._curvature, position)

    def jump(self, speed: float) -> float:
        """Return the jump of velocity at the flat at a speed [m/s]; 0 without a flat."""
        return jump(self._wheel.flat, self._wheel.flat_worn, self._radius, speed, self._load)

    def strikes(self, first: float, last: float) -> list[float]:
        """Return the angles from ``first`` up to ``last`` at which the flat meets the rail [rad]."""
        if self._wheel.flat <= 0.0:
            return []
        turn = 2.0 * math.pi
        turns = range(math.ceil((first - self._flat_angle) / turn), math.ceil((last - self._flat_angle) / turn))
        return [self._flat_angle + turn * k for k in turns]
