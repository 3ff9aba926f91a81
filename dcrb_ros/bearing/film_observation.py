"""Films, traction and losses of a lubricated bearing, from the state of the kernels."""

from __future__ import annotations

import numpy as np

from dcrb_ros.core import observation as of
from dcrb_ros.core.laws.registry import law_of
from dcrb_ros.core.layout.state import SHAFT_SPEED, State
from dcrb_ros.core.payload import Payload
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.stream.states import LubricationState

STANDSTILL = 1e-3
"""Speed of the shaft below which there is no friction torque [rad/s]."""
LEAST_TIME = 1e-12
"""Time used where two observations coincide [s]."""


def friction_losses(state: State) -> Floats:
    """Return the energy that each row has lost since the start by each of `FRICTION_SOURCES`, shape (rows, sources) [J].

    Contacts between rollers beside a broken bar are not part of it.
    """
    rows = len(state.cage_position)
    losses = np.zeros((rows, of.LOSSES))
    of.observe_losses(state.rollers, state.rollers_per_row, losses)
    losses[:, -1] = state.land[0].loss[:rows]
    return losses


def observe_lubrication(payload: Payload, state: State, time: float, before: tuple[float, Floats]) -> LubricationState | None:
    """Return films and losses of a lubricated bearing at a simulated time [s]; None for a dry one.

    ``before`` are an earlier time [s] and the losses then, shape (rows, sources) [J].
    """
    if law_of(payload.lubrication).thickness is None:
        return None
    rows, each = payload.free.shape
    contacts = np.empty((rows, 2, of.AT_CONTACTS))
    of.observe_films(payload.lubrication, state.rollers, state.films, each, contacts)
    least, ratios = contacts[..., of.LEAST_FILM].min(axis=0), contacts[..., of.LEAST_RATIO].min(axis=0)
    contacts[contacts[..., of.LARGEST_FORCE] <= of.LOADED_FORCE] = np.nan
    losses = friction_losses(state)
    power = (losses - before[1]) / max(time - before[0], LEAST_TIME)
    speed = abs(float(state.shaft[SHAFT_SPEED]))
    return LubricationState(
        film=least,
        film_ratio=ratios,
        least_film=contacts[..., of.LEAST_FILM],
        mean_film=contacts[..., of.MEAN_FILM],
        least_film_ratio=contacts[..., of.LEAST_RATIO],
        loaded_traction=contacts[..., of.LOADED_TRACTION],
        loaded_slip=contacts[..., of.LOADED_SLIP],
        friction_loss=losses,
        friction_power=power,
        friction_torque=power / speed if speed > STANDSTILL else np.full_like(power, np.nan),
    )
