"""The topic of films and friction: only of lubricated benches, and read back as it was sent."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from dcrb_ros.bearing.payload import body_names
from dcrb_ros.messages.encoder import BlockEncoder
from dcrb_ros.messages.topics import LUBRICATION_STATE, Message
from dcrb_ros.messages.topics.lubrication_state import AT_RACEWAYS, BY_SOURCE, arrays_of, names_of
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.stream.states import FRICTION_SOURCES, States


def sent(*settings: str, bench: str = "healthy") -> tuple[list[Message], list[States]]:
    """Return the messages of a short run on the topic, and its states."""
    configuration = load_configuration(bench, settings)
    encoder, blocks = BlockEncoder(configuration, body_names(configuration)), list(Simulation(configuration).blocks(0.06))
    messages = [message for block in blocks for message in encoder.encode(block) if message.topic is LUBRICATION_STATE]
    return messages, [states for block in blocks for states in block.states]


def test_a_message_has_every_number_of_the_states_at_their_time() -> None:
    messages, states = sent()
    assert [message.time_ns for message in messages] == [one.time_ns for one in states]
    last = messages[-1].content
    arrays = arrays_of(last.names, last.position[None])
    assert arrays is not None
    assert set(arrays) == {*AT_RACEWAYS, *BY_SOURCE}
    for name, values in arrays.items():
        assert np.array_equal(values[0], getattr(states[-1].lubrication, name), equal_nan=True)
    assert last.position[last.names.index("row2/friction_power/rolling")] == states[-1].lubrication.friction_power[1, 1]  # type: ignore[union-attr]
    assert len(last.velocity) == len(last.effort) == 0


def test_a_dry_bench_sends_none() -> None:
    messages, states = sent(bench="dry")
    assert messages == []
    assert len(states) > 0


@pytest.mark.parametrize("rows", [1, 2])
def test_names_are_distinct_and_others_are_not_taken_for_them(rows: int) -> None:
    names = names_of(rows)
    assert len(set(names)) == len(names) == rows * (2 * len(AT_RACEWAYS) + len(BY_SOURCE) * len(FRICTION_SOURCES))
    assert arrays_of(names[::-1], np.zeros((1, len(names)))) is None


def test_a_recording_gives_films_and_friction_over_time(tmp_path: Path) -> None:
    simulation = Simulation(load_configuration("healthy"))
    with Recorder(tmp_path / "oiled", simulation.configuration, simulation.bodies) as recorder:
        for block in simulation.blocks(0.06):
            recorder.write(block)
    found, states = Recording(tmp_path / "oiled").states(), sent()[1]
    assert found.least_film is not None
    assert found.friction_power is not None
    assert found.least_film.shape == (len(states), 2, 2)
    assert np.array_equal(found.friction_power[-1], states[-1].lubrication.friction_power)  # type: ignore[union-attr]
