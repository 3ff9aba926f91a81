"""Films, traction and friction of a lubricated bearing."""

from __future__ import annotations

import functools

import numpy as np

from dcrb_ros.messages.cdr import JOINT_STATE
from dcrb_ros.messages.joints import decode_joints, encode_joints
from dcrb_ros.messages.topic import Encoded, EncodedBench, SimulatedTopic
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.stream.block import Block
from dcrb_ros.stream.states import FRICTION_SOURCES, LubricationState

RACEWAYS = ("inner", "outer")
AT_RACEWAYS = ("least_film", "mean_film", "least_film_ratio", "loaded_traction", "loaded_slip")
"""Numbers of each row and raceway, attributes of `LubricationState`."""
BY_SOURCE = ("friction_power", "friction_torque")
"""Numbers of each row and source."""


@functools.cache
def names_of(rows: int) -> tuple[str, ...]:
    """Return the names of the numbers in a message, such as ``row1/inner/least_film`` and ``row2/friction_power/rolling``."""
    return tuple(
        name
        for row in range(1, rows + 1)
        for name in (
            *(f"row{row}/{raceway}/{number}" for number in AT_RACEWAYS for raceway in RACEWAYS),
            *(f"row{row}/{number}/{source}" for number in BY_SOURCE for source in FRICTION_SOURCES),
        )
    )


def values_of(state: LubricationState) -> Floats:
    """Return the numbers in the order of `names_of`."""
    return np.concatenate([getattr(state, number) for number in (*AT_RACEWAYS, *BY_SOURCE)], axis=1).ravel()


def arrays_of(names: tuple[str, ...], values: Floats) -> dict[str, Floats] | None:
    """Return the numbers of messages, shape (times, names), by attribute; arrays (times, rows, ...). None for other names."""
    rows = len({name.split("/")[0] for name in names})
    if names != names_of(rows):
        return None
    by_row, arrays, first = values.reshape(len(values), rows, -1), {}, 0
    for number in (*AT_RACEWAYS, *BY_SOURCE):
        count = len(RACEWAYS) if number in AT_RACEWAYS else len(FRICTION_SOURCES)
        arrays[number] = np.ascontiguousarray(by_row[:, :, first : first + count])
        first += count
    return arrays


def _encode(block: Block, source: EncodedBench) -> Encoded:
    for states in block.states:
        if states.lubrication is not None:
            names = names_of(len(states.cage_offset))
            yield states.time_ns, encode_joints(states.time_ns, names, values_of(states.lubrication), frame=source.frame)


LUBRICATION_STATE = SimulatedTopic(
    "lubrication/state",
    JOINT_STATE,
    "films, traction, friction power and torque of each row in `position`, see below; 100 Hz, only with a lubricant",
    depth=500,
    decode=decode_joints,
    encode=_encode,
    enabled=lambda configuration: configuration.lubrication.law != "dry",
)
