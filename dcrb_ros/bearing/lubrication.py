"""Films, traction and losses of a lubricated bearing, from the state of the kernels."""

from __future__ import annotations

import numpy as np

from dcrb_ros.core.contacts.films import entrainment_speeds
from dcrb_ros.core.laws.calls import film_at
from dcrb_ros.core.laws.registry import law_of
from dcrb_ros.core.layout.state import State
from dcrb_ros.core.payload import Payload
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.stream.states import LubricationState

LOADED_FORCE = 500.0
"""Normal force above which a contact counts as loaded [N]; the centrifugal force of the default roller is 146 N at 1800 rpm."""
STANDSTILL = 1e-3
"""Speed of the shaft below which there is no friction torque [rad/s]."""


def friction_losses(state: State) -> Floats:
    """Return the energy that each row has lost since the start by each of `FRICTION_SOURCES`, shape (rows, sources) [J].

    Contacts between rollers beside a broken bar are not part of it.
    """
    rollers = state.rollers[0]
    friction, rolling, contact, bar_friction, bar_contact = (
        state.of_rollers(values).sum(axis=1)
        for values in (
            rollers.friction_loss,
            rollers.rolling_loss,
            rollers.contact_loss,
            rollers.bar_friction_loss,
            rollers.bar_contact_loss,
        )
    )
    lands = state.land[0].loss[: len(friction)]
    return np.stack([friction - rolling - bar_friction, rolling, contact - bar_contact, bar_friction + bar_contact, lands], axis=-1)


def row_films(film: Floats, force: Floats) -> tuple[Floats, Floats]:
    """Return the smallest and the mean film [m] of the loaded contacts of each row, shapes (rows,); of arrays (rows, rollers)."""
    loaded = force > LOADED_FORCE
    count, none = loaded.sum(axis=1), ~loaded.any(axis=1)
    least = np.where(none, np.nan, np.where(loaded, film, np.inf).min(axis=1))
    return least, np.where(none, np.nan, np.where(loaded, film, 0.0).sum(axis=1) / np.maximum(count, 1))


def observe_lubrication(payload: Payload, state: State, time: float, before: tuple[float, Floats]) -> LubricationState | None:
    """Return films and losses of a lubricated bearing at a simulated time [s]; None for a dry one.

    ``before`` are an earlier time [s] and the losses then, shape (rows, sources) [J].
    """
    law = law_of(payload.lubrication)
    if law.thickness is None:
        return None
    rollers, rows = state.rollers[0], np.arange(len(payload.free))
    speeds = entrainment_speeds(payload, state)
    most, least, mean, ratio, traction, slip = (np.empty((len(rows), 2)) for _ in range(6))
    heaviest, heaviest_ratio = np.empty(2), np.empty(2)
    for k, (site, contact) in enumerate(((payload.inner, rollers.inner), (payload.outer, rollers.outer))):
        force, friction, sliding = (state.of_rollers(values) for values in (contact.force, contact.friction, contact.slip))
        film, ratios = law.thickness(film_at(payload.lubrication, site.number, speeds[k]), force)
        place = force.argmax(axis=1)
        most[:, k] = force[rows, place]
        least[:, k], mean[:, k] = row_films(film, force)
        ratio[:, k] = row_films(ratios, force)[0]
        traction[:, k], slip[:, k] = friction[rows, place] / np.maximum(most[:, k], LOADED_FORCE), sliding[rows, place]
        heaviest[k], heaviest_ratio[k] = film.flat[force.argmax()], ratios.flat[force.argmax()]
    none = most <= LOADED_FORCE
    traction[none] = slip[none] = np.nan
    losses = friction_losses(state)
    power = (losses - before[1]) / max(time - before[0], 1e-12)
    speed = abs(float(state.shaft[1]))
    return LubricationState(
        film=heaviest,
        film_ratio=heaviest_ratio,
        least_film=least,
        mean_film=mean,
        least_film_ratio=ratio,
        loaded_traction=traction,
        loaded_slip=slip,
        friction_loss=losses,
        friction_power=power,
        friction_torque=power / speed if speed > STANDSTILL else np.full_like(power, np.nan),
    )
