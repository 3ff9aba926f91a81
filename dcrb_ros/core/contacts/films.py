"""The oil films of the raceways: they follow the speeds at which both surfaces pass a contact, and the forces on it.

Their formulas take long and change little within a step. So the films of both raceways at their speeds, and what the film remembers of each
contact under its force, are evaluated in turn, each once in `INTERVAL` steps: in some 0.08 ms, the time in which a surface passes through
a contact. Between evaluations they stay as they are. The turn follows from the count of steps in the state, so that it depends on nothing
else.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from dcrb_ros.core.jit import piece
from dcrb_ros.core.laws.calls import film_at, film_memory, film_reach, load_film, load_memory, store_film, store_memory
from dcrb_ros.core.laws.site import Site
from dcrb_ros.core.layout.records import VECTOR
from dcrb_ros.core.layout.state import CAGE, SHAFT_SPEED, State
from dcrb_ros.core.payload import Payload

INNER_RACEWAY, OUTER_RACEWAY = 0, 1
"""Rows of ``State.films``."""
GROUPS = 4
"""Parts of the contacts with a raceway that are evaluated together."""
INTERVAL = 2 * GROUPS
"""Steps in which each film is evaluated once."""


@piece
def entrainment(payload: Payload, state: State) -> tuple[float, float]:
    """Return the speeds at which the rollers roll over inner and outer raceway, as the cages carry them on average [m/s]."""
    rows = payload.free.shape[0]
    cages = 0.0
    for row in range(rows):
        cages += state.velocity[CAGE + row, 2]
    orbit = cages / rows
    return (orbit - state.shaft[SHAFT_SPEED]) * payload.inner_raceway_radius, orbit * payload.outer_raceway_radius


def entrainment_speeds(payload: Payload, state: State) -> tuple[float, float]:
    """Return `entrainment` outside of the kernels."""
    inner, outer = getattr(entrainment, "py_func", entrainment)(payload, state)
    return float(inner), float(outer)


@piece
def write_films(payload: Payload, state: State) -> None:
    """Evaluate the films whose turn it is, before the first step all of them."""
    tick = state.tick[0]
    state.tick[0] = tick + 1
    if film_reach(payload.inner.film) == 0.0:
        return
    for turn in range(tick, tick + (INTERVAL if tick == 0 else 1)):
        # The raceways take turns, and of each the groups.
        raceway, group = turn % 2, turn // 2 % GROUPS
        if group == 0:
            speed = entrainment(payload, state)[raceway]
            store_film(payload.lubrication, state.films, raceway, film_at(payload.lubrication, raceway, speed))
        write_memories(payload, state, raceway, group)


@piece
def write_memories(payload: Payload, state: State, raceway: int, group: int) -> None:
    """Write what a film remembers of a group of the contacts with a raceway, under their forces in the last step."""
    film, law = load_film(payload.lubrication, state.films, raceway), payload.lubrication
    contacts = state.rollers[0].inner if raceway == INNER_RACEWAY else state.rollers[0].outer
    size = (payload.free.size + GROUPS * VECTOR - 1) // (GROUPS * VECTOR) * VECTOR
    first = np.uint64(group * size)
    for k in range(size):
        # Unsigned, for the compiler vectorises no loop over an index that might count from the end.
        c = first + np.uint64(k)
        store_memory(law, contacts.film, c, film_memory(film, contacts.force[c]))


@piece
def raceway_site(payload: Payload, state: State, inner: bool) -> Site:
    """Return the contacts with a raceway, with their film."""
    site = payload.inner if inner else payload.outer
    film = load_film(payload.lubrication, state.films, INNER_RACEWAY if inner else OUTER_RACEWAY)
    return Site(site.number, site.raceway_radius, site.scale, site.width, site.reduced_radius, film, site.memory)


@piece
def contact_site(payload: Payload, site: Site, table: Any, k: int) -> Site:
    """Return the contact at element ``k`` of a table, with what the film remembers of it."""
    memory = load_memory(payload.lubrication, table, k)
    return Site(site.number, site.raceway_radius, site.scale, site.width, site.reduced_radius, site.film, memory)
