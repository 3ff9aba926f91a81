"""The load zone as a polar plot."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from dcrb_ros.bearing.history import StateHistory
from dcrb_ros.bearing.load_zone import mean_force, sector_azimuths
from dcrb_ros.plots.style import MATPLOTLIB_AXES, ROWS, new_axes
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.schema.arguments import checked_arguments
from dcrb_ros.schema.refusal import Refusal

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.projections.polar import PolarAxes

    from dcrb_ros.simulation.run import SimulationResult


@checked_arguments(ax=MATPLOTLIB_AXES)
def plot_load_zone(source: SimulationResult | StateHistory | Recording, *, ax: Axes | None = None) -> Axes:
    """Plot the mean normal force at the inner raceway over the azimuth, a curve for each row.

    The load line points down, azimuths are counted counter-clockwise from it. Each value is the mean over the rollers that passed a
    sector of 5 degrees.

    Parameters
    ----------
    source
        A `SimulationResult`, a `Recording` with ``roller_states``, or their `StateHistory`.
    ax
        Polar axes to draw into; those of a new figure by default.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    Refusal
        Axes that are not polar, or a source without states.

    Examples
    --------
    >>> import dcrb_ros
    >>> ax = dcrb_ros.plot_load_zone(dcrb_ros.simulate("healthy", 0.5))
    >>> [line.get_label() for line in ax.lines]
    ['row 1', 'row 2']
    """
    states = source.states() if isinstance(source, Recording) else getattr(source, "states", source)
    if not isinstance(states, StateHistory):
        raise Refusal(f"{source!r} has no states: give a SimulationResult, a Recording or a StateHistory")
    if not len(states):
        raise Refusal(f"{source!r} has no states: simulate at least {1.0 / 100.0:g} s, or raise publishing.state_rate")
    if ax is not None and ax.name != "polar":
        raise Refusal(f"the load zone needs polar axes and these are {ax.name}: make them with projection='polar'")
    polar: PolarAxes = ax if ax is not None else new_axes(polar=True, size=(4.6, 4.6))  # type: ignore[assignment]
    azimuth = np.append(sector_azimuths(), sector_azimuths()[0] + 2.0 * math.pi)
    for row in range(1, states.rows + 1):
        rollers = states.rollers(row)
        force = mean_force(states.azimuth[:, rollers], states.inner_force[:, rollers]) * 1e-3
        colour, style = ROWS[(row - 1) % len(ROWS)], "-" if row % 2 else "--"
        polar.plot(azimuth, np.append(force, force[0]), color=colour, linestyle=style, linewidth=1.4, label=f"row {row}")
        polar.fill(azimuth, np.append(force, force[0]), color=colour, alpha=0.08)
    polar.set_theta_zero_location("S")
    polar.set_theta_direction(1)
    polar.set_thetagrids(range(0, 360, 45))
    polar.set_rlabel_position(112.5)
    polar.tick_params(labelsize="small")
    polar.grid(alpha=0.35, linewidth=0.6)
    polar.legend(loc="upper right", bbox_to_anchor=(1.12, 1.08), fontsize="small", frameon=False)
    polar.set_title("mean normal force at the inner raceway [kN]", fontsize="medium")
    return polar
