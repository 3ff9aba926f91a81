"""The oil films of the raceways over one step: they follow the speeds at which both surfaces of a contact move past it."""

from __future__ import annotations

from dcrb_ros.core.jit import piece
from dcrb_ros.core.laws.interface import Site, film_at, load_film, store_film
from dcrb_ros.core.layout.state import CAGE, State
from dcrb_ros.core.layout.workspace import Workspace
from dcrb_ros.core.payload import Payload

INNER_RACEWAY, OUTER_RACEWAY = 0, 1
"""Rows of ``Workspace.films``."""


@piece
def entrainment(payload: Payload, state: State) -> tuple[float, float]:
    """Return the speeds at which inner and outer raceway pass the rollers, as the cages carry them on average [m/s]."""
    rows = payload.free.shape[0]
    cages = 0.0
    for row in range(rows):
        cages += state.velocity[CAGE + row, 2]
    orbit = cages / rows
    return (state.shaft[1] - orbit) * payload.inner_raceway_radius, -orbit * payload.outer_raceway_radius


def entrainment_speeds(payload: Payload, state: State) -> tuple[float, float]:
    """Return `entrainment` outside of the kernels."""
    inner, outer = getattr(entrainment, "py_func", entrainment)(payload, state)
    return float(inner), float(outer)


@piece
def write_films(payload: Payload, state: State, work: Workspace) -> None:
    """Write the films of both raceways at the present speeds."""
    inner, outer = entrainment(payload, state)
    store_film(payload.lubrication, work.films, INNER_RACEWAY, film_at(payload.lubrication, payload.inner.number, inner))
    store_film(payload.lubrication, work.films, OUTER_RACEWAY, film_at(payload.lubrication, payload.outer.number, outer))


@piece
def raceway_site(payload: Payload, work: Workspace, inner: bool) -> Site:
    """Return the contacts with a raceway, with its film in this step."""
    site = payload.inner if inner else payload.outer
    film = load_film(payload.lubrication, work.films, INNER_RACEWAY if inner else OUTER_RACEWAY)
    return Site(site.number, site.raceway_radius, site.scale, site.width, site.reduced_radius, film)
