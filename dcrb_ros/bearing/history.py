"""The bodies of a bearing over time, as arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np

from dcrb_ros.runtime.frames import pandas
from dcrb_ros.schema.arguments import of_type
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.refusal import Refusal, nearest
from dcrb_ros.stream.states import LubricationState, States, ThermalState

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class StateHistory:
    """States of all bodies over time; arrays of shape (times, bodies) unless stated otherwise, None where they were not recorded."""

    time: Floats
    """Simulated time, shape (times,) [s]."""
    names: tuple[str, ...]
    """Names of the bodies: ``row1/roller01`` ..., ``cage1`` ..., ``inner_ring``."""
    azimuth: Floats
    """Azimuth from the load line (-Y), counter-clockwise, of rollers and of the first pocket of each cage; rotation angle of the
    inner ring [rad]. Wrapped to (-pi, pi]."""
    speed: Floats
    """Absolute spin of rollers, rotation of cages and inner ring [rad/s]."""
    inner_force: Floats
    """Normal force at the inner raceway [N]; of the inner ring the sum of magnitudes."""
    outer_force: Floats | None = None
    """Normal force at the outer raceway [N]."""
    slip: Floats | None = None
    """Slip at the inner raceway [m/s]."""
    friction: Floats | None = None
    """Friction force at the inner raceway [N]."""
    torque: Floats | None = None
    """Friction torque of both raceways on a roller [N m]."""
    relative_speed: Floats | None = None
    """Spin of rollers relative to their cage [rad/s]."""
    bar_force: Floats | None = None
    """Normal force between a roller and its bar, positive at the bar ahead; of a cage the force of its land [N]."""
    cage_offset: Floats | None = None
    """Centre of each cage relative to that of the outer ring, shape (times, rows, 2) [m]."""
    inner_ring_force: Floats | None = None
    """Total force of the rollers on the inner ring in X and Y, shape (times, 2) [N]."""
    film: Floats | None = None
    """Central film of the most loaded contact at inner and outer raceway, shape (times, 2) [m]; like the following, None if dry."""
    film_ratio: Floats | None = None
    """Its ratio Lambda to the roughness, shape (times, 2) [-]."""
    least_film: Floats | None = None
    """Smallest central film of the loaded contacts of each row, at inner and outer raceway, shape (times, rows, 2) [m]; like the
    following NaN where a row has no contact under more than 500 N."""
    mean_film: Floats | None = None
    """Mean of the same films, shape (times, rows, 2) [m]."""
    least_film_ratio: Floats | None = None
    """Ratio Lambda of the smallest film to the roughness, shape (times, rows, 2) [-]."""
    loaded_traction: Floats | None = None
    """Friction over normal force of each row's most loaded contact, at inner and outer raceway, shape (times, rows, 2) [-]."""
    loaded_slip: Floats | None = None
    """Slip of the same contacts, shape (times, rows, 2) [m/s]."""
    friction_loss: Floats | None = None
    """Energy lost since the start in sliding at raceways, rolling, the damping of contacts with raceways, pockets, drag and lands (in
    this order, `dcrb_ros.stream.states.FRICTION_SOURCES`), shape (times, rows, sources) [J]."""
    friction_power: Floats | None = None
    """Power lost by each of these sources, the mean since the time before, shape (times, rows, sources) [W]."""
    friction_torque: Floats | None = None
    """The power over the speed of the shaft, shape (times, rows, sources) [N m]; NaN at standstill."""
    inner_ring_temperature: Floats | None = None
    """Temperature of each row's inner ring, shape (times, rows) [deg C]; like the following, None without a thermal network."""
    roller_temperature: Floats | None = None
    """Temperature of each row's rollers, shape (times, rows) [deg C]."""
    outer_ring_temperature: Floats | None = None
    """Temperature of each row's outer ring, shape (times, rows) [deg C]."""
    box_temperature: Floats | None = None
    """Temperature of the axle box, shape (times,) [deg C]."""
    ambient_temperature: Floats | None = None
    """Temperature of the surroundings, shape (times,) [deg C]."""
    heat: Floats | None = None
    """Heat at inner raceway, outer raceway and the rest of each row (`dcrb_ros.stream.states.HEAT_SOURCES`), shape (times, rows, sources)
    [W]."""
    clearance_change: Floats | None = None
    """By how much the radial gap is larger than configured, shape (times,) [m]."""
    clamped: Floats | None = None
    """Times so far at which a temperature was beyond the range of the oil's formulas, shape (times,) [-]."""

    @staticmethod
    def of(states: Sequence[States], names: Sequence[str]) -> StateHistory:
        """Return the history of some states, each an instant."""
        wanted = [field.name for field in fields(States) if field.name not in ("time_ns", "lubrication", "thermal")]
        arrays = {name: np.array([getattr(state, name) for state in states], np.float64) for name in wanted}
        if not states:
            bodies, rows = len(names), sum(name.startswith("cage") for name in names)
            shapes = {"cage_offset": (0, rows, 2), "inner_ring_force": (0, 2)}
            arrays = {name: np.zeros(shapes.get(name, (0, bodies))) for name in wanted}
        oiled = [state.lubrication for state in states if state.lubrication is not None]
        if oiled:
            arrays |= {field.name: np.array([getattr(oil, field.name) for oil in oiled]) for field in fields(LubricationState)}
        warm = [state.thermal for state in states if state.thermal is not None]
        if warm:
            arrays |= {field.name: np.array([getattr(one, field.name) for one in warm], np.float64) for field in fields(ThermalState)}
        return StateHistory(time=np.array([state.time_ns * 1e-9 for state in states]), names=tuple(names), **arrays)

    def __call__(self) -> StateHistory:
        """Return itself: ``states`` of a run or a recording is read with or without parentheses."""
        return self

    def __len__(self) -> int:
        return len(self.time)

    def __repr__(self) -> str:
        span = f", {self.time[0]:.4g} to {self.time[-1]:.4g} s" if len(self) else ""
        return f"<StateHistory: {len(self)} times{span}, {len(self.names)} bodies from {self.names[0]} to {self.names[-1]}>"

    def column(self, name: str) -> int:
        """Return the column of a body, given by its name.

        Raises
        ------
        Refusal
            There is no such body, or the name is not a text.
        """
        of_type(str)("name", name)
        if name not in self.names:
            known = f"{self.names[0]} to {self.names[-1]}"
            raise Refusal(f"there is no body '{name}': the bearing has {known}{nearest(name, self.names)}")
        return self.names.index(name)

    @property
    def rows(self) -> int:
        """Rows of rollers."""
        return sum(name.startswith("cage") for name in self.names)

    def rollers(self, row: int) -> slice:
        """Return the columns of the rollers of a row, counted from 1.

        Raises
        ------
        Refusal
            There is no such row.
        """
        columns = [k for k, name in enumerate(self.names) if name.startswith(f"row{row}/")]
        if not columns:
            raise Refusal(f"there is no row {row}: the bearing has {self.rows}, counted from 1")
        return slice(columns[0], columns[-1] + 1)

    def to_pandas(self) -> pd.DataFrame:
        """Return a DataFrame over time [s]; its columns have two levels, the quantity and the body.

        With a thermal network there is the quantity ``temperature`` [deg C] of ``row1/inner_ring``, ``row1/rollers``, ``row1/outer_ring``
        ..., ``box`` and ``ambient``.

        Raises
        ------
        Refusal
            pandas is not installed.
        """
        shaped = (len(self), len(self.names))
        recorded = {field.name: getattr(self, field.name) for field in fields(self) if field.name not in ("time", "names")}
        index = pandas().Index(self.time, name="time")
        frames = {
            name: pandas().DataFrame(values, index=index, columns=list(self.names))
            for name, values in recorded.items()
            if values is not None and values.shape == shaped
        }
        warm = self._temperatures()
        frames |= {"temperature": pandas().DataFrame(warm, index=index)} if warm else {}
        return pandas().concat(frames, axis=1, names=["quantity", "body"])

    def _temperatures(self) -> dict[str, Floats]:
        """Return the temperatures over time by body [deg C]; none without a thermal network."""
        if self.box_temperature is None or self.ambient_temperature is None:
            return {}
        parts = {"inner_ring": self.inner_ring_temperature, "rollers": self.roller_temperature, "outer_ring": self.outer_ring_temperature}
        by_row = {
            f"row{row + 1}/{part}": values[:, row] for row in range(self.rows) for part, values in parts.items() if values is not None
        }
        return by_row | {"box": self.box_temperature, "ambient": self.ambient_temperature}
