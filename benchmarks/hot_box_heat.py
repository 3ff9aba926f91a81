"""The heat of a bearing and its flow as tables for many bearings, from `dcrb_ros.bearing.quasi_steady`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.interpolate import RegularGridInterpolator

from dcrb_ros.bearing.heat_network import AXLE, AXLE_OVER_SPEED, surface_exchange
from dcrb_ros.bearing.quasi_steady import QuasiSteady, vehicle_speed
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.configuration import Configuration

Fault = Literal["loss", "clearance"]
"""Loss of lubricant [-], or loss of clearance [m]."""
SPEEDS = (0.0, 15.0, 35.0, 60.0, 85.0, 110.0, 140.0)
"""Of the shaft [rad/s]."""
LOADS = (50e3, 90e3, 140e3)
"""On the bearing [N]."""
TEMPERATURES = (-30.0, -10.0, 10.0, 25.0, 40.0, 55.0, 75.0, 100.0, 140.0, 200.0, 300.0, 450.0)
"""Of the oil at the inlets of a raceway [deg C]."""
SIZES: dict[Fault, tuple[float, ...]] = {
    "loss": (0.0, 0.25, 0.5, 0.7, 0.8, 0.85, 0.875, 0.9, 0.915, 0.93, 0.945, 0.96, 0.97, 0.98, 0.99, 1.0),
    "clearance": (0.0, 3e-5, 5e-5, 6e-5, 7e-5, 8e-5, 9e-5, 1.1e-4, 1.3e-4, 1.5e-4),
}
"""Sizes of the faults; the radial gap of the bench `healthy` is 70 um."""
AIR = (0.0, 2.0, 5.0, 10.0, 20.0, 30.0, 45.0, 60.0)
"""Speeds of the air at the box [m/s]."""
HOTTEST = 600.0
"""Temperature at which a node is kept [deg C]: the bearing is destroyed."""


class Grid:
    """A table of values over several axes, linear between its points and constant beyond them."""

    def __init__(self, axes: tuple[tuple[float, ...], ...], values: Floats) -> None:
        """Take values of shape (*points of each axis, quantities)."""
        self._limits, self._table = [(axis[0], axis[-1]) for axis in axes], RegularGridInterpolator(axes, values)

    def at(self, *coordinates: Floats) -> Floats:
        """Return the values at points, one array of shape (bearings,) for each axis; shape (quantities, bearings)."""
        inside = [np.clip(values, low, high) for values, (low, high) in zip(coordinates, self._limits, strict=True)]
        return np.asarray(self._table(np.stack(inside, 1)).T)


@dataclass(frozen=True)
class HeatTable:
    """The heat of a bearing with one kind of fault, and its thermal network with both rows in one."""

    heat: Grid
    """At inner and outer raceway [W], over speed, load, temperature of the oil and size of the fault."""
    rest: Grid
    """About cages and in seals [W], over speed, temperature and size of the fault."""
    flow: Grid
    """Conductance at inner and outer raceway [W/K], over speed and load."""
    cooling: Floats
    """From the box to the surroundings at `AIR`, shape (speeds,) [W/K]."""
    seat: float
    """From the outer ring to the box [W/K]."""
    capacity: Floats
    """Of inner rings, rollers, outer rings and box, shape (4,) [J/K]."""
    vehicle: float
    """Speed of the vehicle over that of the shaft [m]."""
    exposure: float
    """Share of that speed that reaches the box [-]."""

    def after(
        self, temperatures: Floats, speed: Floats, load: Floats, size: Floats, ambient: Floats, scale: Floats, wind: Floats, sun: Floats,
        duration: float,
    ) -> Floats:  # fmt: skip
        """Return temperatures of shape (4, bearings) [deg C] after a step of implicit Euler, with the heat of the temperatures before.

        All others have the shape (bearings,): ``speed`` of the shaft [rad/s], ``load`` [N], ``size`` of the fault, ``ambient`` [deg C], the
        friction of the individual over the usual one ``scale`` [-], the cooling over the usual one ``wind`` [-], and ``sun`` [W].
        """
        inner, rollers, outer, _ = temperatures
        at_inner = self.heat.at(speed, load, 0.5 * (inner + rollers), size)[0] * scale
        at_outer = self.heat.at(speed, load, 0.5 * (outer + rollers), size)[1] * scale
        rest = self.rest.at(speed, rollers, size)[0] * scale
        heat = np.stack([0.5 * at_inner, 0.5 * (at_inner + at_outer + rest), 0.5 * (at_outer + rest), sun])
        to_inner, to_outer = self.flow.at(speed, load)
        axle = AXLE + AXLE_OVER_SPEED * self.vehicle * speed
        air = wind * np.interp(self.exposure * self.vehicle * speed, AIR, self.cooling)
        matrix = np.zeros((len(speed), 4, 4))
        for first, second, conductance in ((0, 1, to_inner), (1, 2, to_outer), (2, 3, np.full(len(speed), self.seat))):
            for node in (first, second):
                matrix[:, node, node] += conductance
            matrix[:, first, second] = matrix[:, second, first] = -conductance
        stored = self.capacity / duration
        for node in range(4):
            matrix[:, node, node] += stored[node]
        matrix[:, 0, 0] += axle
        matrix[:, 3, 3] += air
        right = stored[:, None] * (temperatures - ambient) + heat
        rise = np.linalg.solve(matrix, right.T[:, :, None])[:, :, 0].T
        return np.asarray(np.minimum(ambient + rise, HOTTEST))


def heat_table(configuration: Configuration, fault: Fault) -> HeatTable:
    """Return the tables of a configured bearing with a thermal network."""
    bearing, rows = QuasiSteady(configuration), configuration.bearing.rows
    network, sizes = bearing.network, SIZES[fault]
    heat = np.zeros((len(SPEEDS), len(LOADS), len(TEMPERATURES), len(sizes), 2))
    rest = np.zeros((len(SPEEDS), len(TEMPERATURES), len(sizes), 1))
    flow = np.zeros((len(SPEEDS), len(LOADS), 2))
    for i, speed in enumerate(SPEEDS):
        for j, load in enumerate(LOADS):
            running = bearing.running(speed, load)
            matrix = bearing.conductances(running).matrix
            flow[i, j] = [-rows * matrix[network.inner(0)][network.rollers(0)], -rows * matrix[network.rollers(0)][network.outer(0)]]
            if speed == 0.0:
                continue
            for m, size in enumerate(sizes):
                worn = bearing.running(speed, load, configuration.bearing.radial_gap - size) if fault == "clearance" else running
                for k, temperature in enumerate(TEMPERATURES):
                    lost = bearing.power(worn, [temperature] * (network.box + 1), size if fault == "loss" else 0.0)
                    heat[i, j, k, m] = [rows * lost[0][0], rows * lost[0][1]]
                    rest[i, k, m] = rows * lost[0][2]
    nodes = network.inner, network.rollers, network.outer
    area, exchange = network.box_area, [surface_exchange(air, network.box_size) for air in AIR]
    return HeatTable(
        heat=Grid((SPEEDS, LOADS, TEMPERATURES, sizes), heat),
        rest=Grid((SPEEDS, TEMPERATURES, sizes), rest),
        flow=Grid((SPEEDS, LOADS), flow),
        cooling=area * np.array(exchange),
        seat=rows * network.seat,
        capacity=np.array([*(rows * network.capacity[node(0)] for node in nodes), network.capacity[network.box]]),
        vehicle=vehicle_speed(configuration, 1.0),
        exposure=configuration.thermal.exposure,
    )
