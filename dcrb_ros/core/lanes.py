"""Where the quantities of rollers lie: field by field in one array, a lane per roller.

Compilers work on four or eight rollers at once when the fields are neighbours in one array, at distances known beforehand. So a
name here is the place of a field's first lane, and ``lanes[X + c]`` is the X of the roller in lane ``c``. A loop over lanes
runs from 0 and holds no branch but a choice between two values.
"""

from __future__ import annotations

import numpy as np

from dcrb_ros.core.payload import Floats

LANES = 136
"""Lanes of a field: two rows of 60 rollers and some to fill up; no power of two, or all fields would fall on few cache lines."""
CACHE_LINE = 64
"""[bytes]"""
VECTOR = 4
"""Lanes that are worked on at once at least; counts of lanes are filled up to a multiple."""

# Of the state, in the order of the rollers, row by row.
STATE_FIELDS = 28
(
    X,
    Y,
    VX,
    VY,
    SPIN,
    CHANGE_X,
    CHANGE_Y,
    CHANGE_SPIN,
    ANGLE,
    INNER_BRISTLE,
    OUTER_BRISTLE,
    BAR_BRISTLE,
    INNER_FORCE,
    OUTER_FORCE,
    BAR_FORCE,
    INNER_FRICTION,
    OUTER_FRICTION,
    INNER_SLIP,
    OUTER_SLIP,
    BAR_IMPACT,
    POCKET_X,
    POCKET_Y,
    FREE,
    IN_SECOND,
    FRICTION_LOSS,
    CONTACT_LOSS,
    NOTCH_LOSS,
    DRIVE_WORK,
) = (LANES * field for field in range(STATE_FIELDS))
"""Centre, velocity, spin, their changes over the last step, rotation; bristles, forces and slips of the contacts; speed at which
a bar's contact closed; pocket tangent at cage angle zero; 1 for a free roller; 1 in the second row; what each roller adds to the
energy account."""

# Of a step, in the order of the rollers or of those that are bound.
ROLLER_FIELDS = 41
(
    PLACE_X,
    PLACE_Y,
    BEFORE_X,
    BEFORE_Y,
    BEFORE_RIM,
    COMING_X,
    COMING_Y,
    COMING_RIM,
    TAU_X,
    TAU_Y,
    ALONE_X,
    ALONE_Y,
    ALONE_RIM,
    MOVING,
    MEAN_X,
    MEAN_Y,
    MEAN_RIM,
    OUTER_NEAR,
    BAR_NEAR,
    BOUND,
    ON_INNER_X,
    ON_INNER_Y,
    ON_OUTER_X,
    ON_OUTER_Y,
    ON_CAGE_X,
    ON_CAGE_Y,
    ON_CAGE_TURN,
    SECOND,
    REST_X,
    REST_Y,
    REST_RIM,
    YIELD_XX,
    YIELD_XY,
    YIELD_YY,
    YIELD_RIM,
    COUPLED_X,
    COUPLED_Y,
    LOST_IN_FRICTION,
    LOST_IN_CONTACT,
    TAKEN_BY_NOTCH,
    DRIVEN,
) = (LANES * field for field in range(ROLLER_FIELDS))
"""Place; velocity and surface speed r_R omega_R before the step, as predicted, without contacts, and their means; pocket tangent; 1
for a free roller; what tells how near to closing a contact is; 1 for a bound roller; forces on rings and cage; 1 in the second row;
momentum without what the bodies touched add to it; how velocity and surface speed yield to momentum, and how they are coupled; powers."""

CONTACT = LANES * ROLLER_FIELDS
CONTACT_FIELDS = 20
(
    NORMAL_X,
    NORMAL_Y,
    RADIAL_X,
    RADIAL_Y,
    DISTANCE,
    PENETRATION,
    SINK,
    SURFACE_N,
    BRISTLE,
    PUSH,
    GIVE,
    CONSTANT,
    SLOPE,
    RATE,
    PHI,
    KNOWN,
    DAMPING,
    EXPECTED,
    FRICTION,
    SLIP,
) = (CONTACT + LANES * field for field in range(CONTACT_FIELDS))
"""Of a contact: normal; direction from the ring; distance from its centre; penetration; speed at which a notch's floor falls away;
surface speed of the ring along the normal; bristle; normal force PUSH + GIVE * approach, friction CONSTANT + SLOPE * slip and its
bristle's law; normal force of the last step, then that expected, then that found; damping; speed of penetration expected; friction and
slip found."""
CUT, OVER = COMING_X, COMING_Y
"""Of a roller that is not bound, in the same places: depth of notches under it; 1 where there may be one."""
CROSSES, LAST_FORCE = OUTER_NEAR, REST_X
"""Of a bound roller, in the same places, while a raceway's contacts are drawn: 1 where one closes or opens within the step; its force in
the last step."""
LEVER_X, LEVER_Y, AHEAD, IMPACT = RADIAL_X, RADIAL_Y, DISTANCE, SINK
"""Of a bar's contact, in the same places: lever from the cage's centre; 1 for the bar ahead of the roller, -1 for the one behind, 0 for
none in reach; speed at which the contact closed."""

INNER, OUTER, BAR = 0, LANES * CONTACT_FIELDS, 2 * LANES * CONTACT_FIELDS
"""What is added to a contact's field for each of a roller's contacts; a bar's normal is the pocket's tangent."""
STEP_FIELDS = ROLLER_FIELDS + 3 * CONTACT_FIELDS

# Of the conformal contacts of a step: lands in reach of their cages, then bars in reach of bound rollers.
CONFORMAL_FIELDS = 19
(
    BEGIN,
    BEFORE,
    CLOSING,
    SLIDING,
    LAST,
    CLOSED_AT,
    BENT,
    COEFFICIENT,
    EXPONENT,
    LIGHTNESS,
    TOWARDS_X,
    TOWARDS_Y,
    ELASTIC,
    YIELD,
    LOSING,
    HOLD,
    HOLD_SLOPE,
    RELAXATION,
    WEIGHT,
) = (LANES * field for field in range(CONFORMAL_FIELDS))
"""Penetration at the step's beginning; speed of penetration before the step and over it; slip; force of the last step, then of the last
sweep; speed at which the contact closed; bristle; coefficient and exponent of its law; half the step over the bodies' reduced mass; normal
of a land. Found: elastic force and its slope over the speed of penetration, damping, friction per normal force as a line over the slip, its
bristle's law."""


def empty_lanes(fields: int) -> Floats:
    """Return zeros for ``fields`` fields, each of which begins at a cache line: loads across lines cost half the speed."""
    room = np.zeros(fields * LANES + CACHE_LINE // 8)
    first = -room.ctypes.data % CACHE_LINE // 8
    return room[first : first + fields * LANES]


def field_of(lanes: Floats, field: int, rows: int, rollers: int, parts: int = 0) -> Floats:
    """Return a view of a field, shape (rows, rollers), or of ``parts`` fields that follow each other, with a last axis for them."""
    table = lanes.reshape(-1, LANES)[field // LANES :][: max(parts, 1), : rows * rollers]
    split = table.reshape(max(parts, 1), rows, rollers)
    return np.moveaxis(split, 0, -1) if parts else split[0]
