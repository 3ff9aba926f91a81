"""The law of the normal force over arrays, for what lies outside of the time loop."""

from __future__ import annotations

from typing import Any

import numpy as np

from dcrb_ros.core.contacts.force_line import elastic, elastic_and_energy
from dcrb_ros.core.jit import loop
from dcrb_ros.core.laws.calls import film_reach
from dcrb_ros.core.laws.registry import fields_of, law_of
from dcrb_ros.core.laws.site import Site
from dcrb_ros.core.layout.records import Floats


@loop
def _evaluate(law: Any, memory: Any, site: Site, penetration: Floats, force: Floats, stiffness: Floats) -> None:
    for k in range(penetration.size):
        force[k], stiffness[k] = elastic(law, memory, penetration[k], site)


@loop
def _evaluate_energy(law: Any, memory: Any, site: Site, penetration: Floats, energy: Floats) -> None:
    for k in range(penetration.size):
        energy[k] = elastic_and_energy(law, memory, penetration[k], site)[1]


def lubricated(site: Site) -> bool:
    """Return whether there is a film between the bodies of a contact."""
    return film_reach(site.film) > 0.0


def no_memory(law: Any) -> Any:
    """Return the memory of a contact at which nothing has happened."""
    memory = law_of(law).memory
    return memory(*(0.0 for _ in fields_of(memory)))


def normal_forces(law: Any, penetration: Floats, site: Site) -> tuple[Floats, Floats]:
    """Return elastic forces [N] and stiffnesses [N/m] of contacts without memory at penetrations [m]; any shape."""
    known = law_of(law)
    if known.forces is not None and not lubricated(site):
        elastic_forces: tuple[Floats, Floats] = known.forces(law, penetration, site)
        return elastic_forces
    depth, force, stiffness = np.ascontiguousarray(penetration), np.empty(penetration.shape), np.empty(penetration.shape)
    _evaluate(law, no_memory(law), site, depth.reshape(-1), force.reshape(-1), stiffness.reshape(-1))
    return force, stiffness


def contact_energies(law: Any, penetration: Floats, site: Site) -> Floats:
    """Return the energies [J] of contacts without memory at penetrations [m], the work of the film's lift included; any shape."""
    depth, energy = np.ascontiguousarray(penetration), np.empty(penetration.shape)
    _evaluate_energy(law, no_memory(law), site, depth.reshape(-1), energy.reshape(-1))
    return energy
