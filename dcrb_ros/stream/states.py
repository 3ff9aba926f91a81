"""Published quantities of a bearing: the names of its bodies, their states at one instant, and the energy account."""

from __future__ import annotations

from dataclasses import dataclass

from dcrb_ros.schema.arrays import Floats


@dataclass(frozen=True)
class BodyNames:
    """Numbers of rows and rollers, and the names of the bodies."""

    rows: int
    rollers_per_row: int

    @property
    def names(self) -> list[str]:
        """Body names in the order of `States`: row by row the rollers, then the cages, then the inner ring."""
        rollers = [f"row{row + 1}/roller{i + 1:02d}" for row in range(self.rows) for i in range(self.rollers_per_row)]
        return [*rollers, *(f"cage{row + 1}" for row in range(self.rows)), "inner_ring"]


@dataclass(frozen=True)
class Account:
    """Energy since the start [J]."""

    drive: float
    """Work of the shaft."""
    load: float
    """Work of the load on the inner ring."""
    friction: float
    """Dissipated by friction."""
    loss: float
    """Dissipated by the damping of normal contacts."""
    housing: float
    """Dissipated by the damper of the housing."""
    notch: float
    """Removed by the notch law `sink`, which changes the depth without a tangential force that would do the work."""
    stored: float
    """Increase of the kinetic, elastic and potential energy."""

    @property
    def residual(self) -> float:
        """Difference of work done and energy dissipated or stored [J]: the error of the integration."""
        return self.drive + self.load - self.friction - self.loss - self.housing - self.notch - self.stored


FRICTION_SOURCES = ("sliding", "rolling", "contacts", "pockets", "drag", "lands")
"""Where a lubricated bearing loses power: sliding at raceways, resistance of films to rolling, damping of the contacts with raceways
(squeezed films included), friction and damping at the bars of the pockets, drag of oil on turning and orbiting rollers, and friction and
damping at the lands of the cages."""


@dataclass(frozen=True)
class LubricationState:
    """The oil films at one instant, and the energy lost by each of `FRICTION_SOURCES`.

    A contact counts as loaded under more than `dcrb_ros.core.observation.LOADED_FORCE`. Where a row has no loaded contact, its films,
    traction and slip are NaN.
    """

    film: Floats
    """Central film of the most loaded contact at inner and outer raceway, shape (2,) [m]."""
    film_ratio: Floats
    """Its ratio Lambda to the roughness, shape (2,) [-]."""
    least_film: Floats
    """Smallest central film of the loaded contacts of each row, at inner and outer raceway, shape (rows, 2) [m]."""
    mean_film: Floats
    """Mean of the same films, shape (rows, 2) [m]."""
    least_film_ratio: Floats
    """Ratio Lambda of the smallest film to the roughness, shape (rows, 2) [-]."""
    loaded_traction: Floats
    """Friction over normal force of each row's most loaded contact, over the last step, shape (rows, 2) [-]."""
    loaded_slip: Floats
    """Slip of the same contacts, shape (rows, 2) [m/s]."""
    friction_loss: Floats
    """Energy lost since the start by each source, shape (rows, sources) [J]."""
    friction_power: Floats
    """Power lost by each source, the mean since the states before or the start, shape (rows, sources) [W]."""
    friction_torque: Floats
    """The power over the speed of the shaft, shape (rows, sources) [N m]; NaN at standstill."""


HEAT_SOURCES = ("inner_raceway", "outer_raceway", "rest")
"""Where a row is heated: at its raceways, and by its cage, the oil about the rollers and the seals together."""


@dataclass(frozen=True)
class ThermalState:
    """Temperatures and heat of bearing and axle box at one instant."""

    inner_ring_temperature: Floats
    """Of each row's inner ring with its journal, shape (rows,) [deg C]."""
    roller_temperature: Floats
    """Of each row's rollers with their cage, shape (rows,) [deg C]."""
    outer_ring_temperature: Floats
    """Of each row's outer ring, shape (rows,) [deg C]."""
    box_temperature: float
    """Of the axle box [deg C]."""
    ambient_temperature: float
    """Of the surroundings [deg C]."""
    heat: Floats
    """Heat of each row by `HEAT_SOURCES`, averaged over half a second, shape (rows, sources) [W]."""
    clearance_change: float
    """By how much the radial gap is larger than configured [m]."""
    clamped: int
    """Times so far at which a temperature was beyond the range of the oil's formulas, which then took the end of that range."""


@dataclass(frozen=True)
class TemperatureReading:
    """What the temperature sensors read at one instant."""

    time_ns: int
    """Simulated time [ns]."""
    outer_ring: float
    """At the outer ring of the last row, without lag [deg C]."""
    box: float
    """In the housing of the axle box over the load zone, with the lag of ``thermal.sensor_lag`` [deg C]."""
    ambient: float
    """In the air [deg C]."""


@dataclass(frozen=True)
class States:
    """States of the bodies at one instant; each array has one entry per name in `BodyNames.names`."""

    time_ns: int
    """Simulated time [ns]."""
    azimuth: Floats
    """Azimuth from the load line (-Y), counter-clockwise, of rollers and of each cage's first pocket;
    rotation angle of the inner ring [rad]. All wrapped to (-pi, pi]."""
    speed: Floats
    """Absolute spin of rollers, rotation of cages and inner ring [rad/s]."""
    inner_force: Floats
    """Normal force between roller and inner raceway [N]; zero for cages, the sum of magnitudes for the inner ring."""
    outer_force: Floats
    """Normal force between roller and outer raceway [N]; zero for cages and the inner ring."""
    slip: Floats
    """Slip at the inner raceway [m/s]; zero for cages and the inner ring."""
    friction: Floats
    """Friction force at the inner raceway [N]; zero for cages and the inner ring."""
    torque: Floats
    """Friction torque of both raceways on a roller [N m]; zero for cages and the inner ring."""
    relative_speed: Floats
    """Spin of rollers against their cage [rad/s]; zero for cages and the inner ring."""
    bar_force: Floats
    """Normal force between a roller and its bar [N], positive at the bar ahead; for cages, the force at the land."""
    cage_offset: Floats
    """Position of each cage's centre relative to the outer ring's, shape (rows, 2) [m]."""
    inner_ring_force: tuple[float, float]
    """Total force of the rollers on the inner ring in X and Y [N]."""
    lubrication: LubricationState | None = None
    """Films and losses; None for a dry bearing, and for states read from a recording."""
    thermal: ThermalState | None = None
    """Temperatures and heat; None without a thermal network, and for states read from a recording."""
