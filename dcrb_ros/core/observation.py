"""Published quantities of the state, gathered in one compiled pass: in Python this would cost more than the simulation."""

from __future__ import annotations

import math
from typing import Any

from dcrb_ros.core.jit import loop
from dcrb_ros.core.laws.calls import film_thickness, load_film
from dcrb_ros.core.layout.records import Flags, Floats, OneRecord
from dcrb_ros.core.layout.rollers import Rollers
from dcrb_ros.core.layout.state import CAGE, INNER, OUTER

OBSERVED = 9
(AZIMUTH, SPEED, INNER_FORCE, OUTER_FORCE, SLIP, FRICTION, TORQUE, RELATIVE_SPEED, BAR_FORCE) = range(OBSERVED)
"""Rows of the observed quantities; see `dcrb_ros.stream.states.States`."""


@loop
def place_pinned(table: OneRecord[Rollers], free: Flags, tangent: Floats, position: Floats, velocity: Floats, pitch_radius: float) -> None:
    """Write position and velocity of the pinned rollers, which their cages carry, into the table of rollers."""
    rollers = table[0]
    for row in range(free.shape[0]):
        turn, vx, vy, speed = position[CAGE + row, 2], velocity[CAGE + row, 0], velocity[CAGE + row, 1], velocity[CAGE + row, 2]
        cosine, sine = math.cos(turn), math.sin(turn)
        for i in range(free.shape[1]):
            if not free[row, i]:
                c = row * free.shape[1] + i
                # A pocket lies a quarter turn behind its tangent.
                arm_x = pitch_radius * (sine * tangent[row, i, 0] + cosine * tangent[row, i, 1])
                arm_y = pitch_radius * (sine * tangent[row, i, 1] - cosine * tangent[row, i, 0])
                rollers.x[c], rollers.y[c] = position[CAGE + row, 0] + arm_x, position[CAGE + row, 1] + arm_y
                rollers.vx[c], rollers.vy[c] = vx - speed * arm_y, vy + speed * arm_x


@loop
def observe_rollers(
    table: OneRecord[Rollers],
    free: Flags,
    position: Floats,
    velocity: Floats,
    surface: float,
    roller_radius: float,
    share: float,
    observed: Floats,
) -> tuple[float, float]:
    """Write the observed quantities of each roller, shape (OBSERVED, rollers or more); return the force on the inner ring in X and Y [N].

    ``surface`` is the speed of the inner ring's surface [m/s]; a roller turns in its cage by ``share``, cos(alpha), as fast as that of the
    plane [-]. The azimuth counts from -Y; the slip is that at the inner raceway, of open contacts too.
    """
    rollers, force_x, force_y = table[0], 0.0, 0.0
    for row in range(free.shape[0]):
        for i in range(free.shape[1]):
            c = row * free.shape[1] + i
            x, y, spin = rollers.x[c], rollers.y[c], rollers.spin[c]
            nx, ny = x - position[INNER, 0], y - position[INNER, 1]
            distance = math.sqrt(nx * nx + ny * ny)
            nx, ny = nx / distance, ny / distance
            passing = (rollers.vy[c] - velocity[INNER, 1]) * nx - (rollers.vx[c] - velocity[INNER, 0]) * ny
            normal, friction = rollers.inner.force[c], rollers.inner.friction[c]
            force_x -= normal * nx + friction * ny
            force_y += friction * nx - normal * ny
            observed[AZIMUTH, c] = math.atan2(x - position[OUTER, 0], position[OUTER, 1] - y)
            relative = spin - velocity[CAGE + row, 2]
            observed[SPEED, c], observed[RELATIVE_SPEED, c] = spin + (share - 1.0) * relative, share * relative
            observed[INNER_FORCE, c], observed[OUTER_FORCE, c] = normal, rollers.outer.force[c]
            observed[SLIP, c] = passing - spin * roller_radius - surface
            observed[FRICTION, c], observed[TORQUE, c] = friction, roller_radius * (friction - rollers.outer.friction[c])
            observed[BAR_FORCE, c] = rollers.bar.force[c]
    return force_x, force_y


AT_CONTACTS = 6
(LARGEST_FORCE, LEAST_FILM, LEAST_RATIO, MEAN_FILM, LOADED_TRACTION, LOADED_SLIP) = range(AT_CONTACTS)
"""Observed quantities of the contacts of a row with a raceway; see `dcrb_ros.stream.states.LubricationState`."""
LOADED_FORCE = 500.0
"""Normal force above which a contact counts as loaded [N]; the centrifugal force of the default roller is 146 N at 1800 rpm."""


@loop
def observe_films(lubrication: Any, table: OneRecord[Rollers], films: Floats, each: int, observed: Floats) -> None:
    """Write the observed quantities of the films, shape (rows, 2, AT_CONTACTS).

    ``each`` is the number of rollers in a row; ``films`` are those of inner and outer raceway as they were evaluated last. The smallest
    film is that under the largest force.
    """
    rollers, rows = table[0], observed.shape[0]
    for ring in range(2):
        film = load_film(lubrication, films, ring)
        contacts = rollers.inner if ring == 0 else rollers.outer
        for row in range(rows):
            heaviest, loaded, total = row * each, 0.0, 0.0
            for c in range(row * each, (row + 1) * each):
                if contacts.force[c] > contacts.force[heaviest]:
                    heaviest = c
                if contacts.force[c] > LOADED_FORCE:
                    loaded += 1.0
                    total += film_thickness(film, contacts.force[c])[0]
            least, ratio = film_thickness(film, contacts.force[heaviest])
            observed[row, ring, LARGEST_FORCE] = contacts.force[heaviest]
            observed[row, ring, LEAST_FILM], observed[row, ring, LEAST_RATIO] = least, ratio
            observed[row, ring, MEAN_FILM] = total / max(loaded, 1.0)
            observed[row, ring, LOADED_TRACTION] = contacts.friction[heaviest] / max(contacts.force[heaviest], LOADED_FORCE)
            observed[row, ring, LOADED_SLIP] = contacts.slip[heaviest]


LOSSES = 6
"""Sources of losses, see `dcrb_ros.stream.states.FRICTION_SOURCES`."""


@loop
def observe_losses(table: OneRecord[Rollers], each: int, observed: Floats) -> None:
    """Write the energy that the ``each`` rollers of each row have lost by each source but lands, shape (rows, LOSSES) [J]."""
    rollers = table[0]
    for row in range(observed.shape[0]):
        sliding, rolling, contacts, pockets, drag = 0.0, 0.0, 0.0, 0.0, 0.0
        for c in range(row * each, (row + 1) * each):
            sliding += rollers.friction_loss[c] - rollers.rolling_loss[c] - rollers.bar_friction_loss[c]
            rolling += rollers.rolling_loss[c]
            contacts += rollers.contact_loss[c] - rollers.bar_contact_loss[c]
            pockets += rollers.bar_friction_loss[c] + rollers.bar_contact_loss[c] - rollers.drag_loss[c]
            drag += rollers.drag_loss[c]
        observed[row, 0], observed[row, 1], observed[row, 2], observed[row, 3], observed[row, 4] = sliding, rolling, contacts, pockets, drag
