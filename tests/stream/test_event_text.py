"""Events as text in recordings."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.stream.event_text import decode_command, decode_event, encode_command, encode_event
from dcrb_ros.stream.events import (
    BlockLost,
    Event,
    LoadCommand,
    ParameterChange,
    Refused,
    ScenarioEvent,
    SpeedCommand,
    Start,
    TimedCommand,
    UnknownCommand,
)

NUMBERS = st.floats(allow_nan=False, allow_infinity=False)
KEYS = st.from_regex(r"[a-z_0-9]+(\.[a-z_0-9]+){0,2}", fullmatch=True)
VALUES = st.one_of(NUMBERS, st.integers(), st.booleans(), st.text(max_size=20), st.sampled_from(["row1/bar3, row2/bar7", "a = 1", "': "]))
CHANGES = st.dictionaries(KEYS, VALUES, min_size=1, max_size=4)
DURATIONS = st.integers(1, 999_999).flatmap(lambda n: st.sampled_from([n * 1e-3, float(n), n / 8e6])).map(lambda x: float(f"{x:g}"))
PARAMETER_CHANGES = st.builds(ParameterChange, CHANGES)
SCENARIO_EVENTS = st.builds(ScenarioEvent, CHANGES, st.one_of(st.just(0.0), DURATIONS))
INDICES = st.integers(0, 10**15)
COMMANDS = st.one_of(st.builds(SpeedCommand, NUMBERS), st.builds(LoadCommand, NUMBERS, NUMBERS), PARAMETER_CHANGES)
EVENTS = st.one_of(
    COMMANDS,
    SCENARIO_EVENTS,
    st.just(Start()),
    st.builds(BlockLost, INDICES, INDICES),
    st.builds(Refused, st.one_of(PARAMETER_CHANGES, SCENARIO_EVENTS), st.text()),
)


@given(EVENTS)
def test_every_event_survives_the_round_trip(event: Event) -> None:
    assert decode_event(encode_event(event)) == event


@given(st.integers(0, 10**18), COMMANDS)
def test_every_command_survives_the_round_trip_through_the_manifest(time_ns: int, command: SpeedCommand) -> None:
    timed = TimedCommand(time_ns, command)
    assert decode_command(encode_command(timed)) == timed


@given(st.text())
def test_any_text_is_decoded_and_encoded_again(text: str) -> None:
    event = decode_event(text)
    assert decode_event(encode_event(event)) == event
    assert isinstance(event, UnknownCommand) or not text or encode_event(event)


OF_TODAY = {
    "": None,
    "start": Start(),
    "command/speed 130.0 rad/s": SpeedCommand(130.0),
    "command/speed 116.66666666666667 rad/s": SpeedCommand(116.66666666666667),
    "command/load -333.3333333333333 -80000.0 N": LoadCommand(-333.3333333333333, -80000.0),
    "faults.outer_1.width = 0.002, faults.outer_1.row = 1, faults.broken_bars = 'row2/bar7'": ParameterChange(
        {"faults.outer_1.width": 0.002, "faults.outer_1.row": 1, "faults.broken_bars": "row2/bar7"}
    ),
    "faults.broken_bars = 'row1/bar3, row1/bar4'": ParameterChange({"faults.broken_bars": "row1/bar3, row1/bar4"}),
    "scenario: operating.load = 95000.0": ScenarioEvent({"operating.load": 95000.0}),
    "scenario: faults.outer_1.width = 0.003 over 0.2 s begins": ScenarioEvent({"faults.outer_1.width": 0.003}, over=0.2),
    "refused: scenario: faults.outer_1.width = 0.002: parameters: faults.outer_2 overlaps faults.outer_1": Refused(
        ScenarioEvent({"faults.outer_1.width": 0.002}), "parameters: faults.outer_2 overlaps faults.outer_1"
    ),
    "lost: samples 1024 .. 2047": BlockLost(1024, 2047),
}
"""Texts as dcrb_ros wrote them before events were typed (commit 62b584c)."""


@pytest.mark.parametrize(("text", "event"), OF_TODAY.items(), ids=lambda part: repr(part)[:40])
def test_texts_of_old_recordings_are_decoded_and_still_written(text: str, event: Event | None) -> None:
    assert decode_event(text) == event
    assert encode_event(event) == text


OTHERS = ["command/tilt 3.0 rad", "command/speed ? rad/s", "a = f(1)", "x = 08", "starts", "lost: samples"]
OTHERS += ["a = 1, ", "a = 1; b = 2", "x = 1e999"]
LONG = ["a" * 200_000, "a = " + "-" * 200_000 + "1", "a = '" + "\\'" * 100_000]
LONG += ["refused: " + "a = 1, " * 30_000, "refused: a = 1" + " over 2" * 30_000]


@pytest.mark.timeout(20)  # a search that backtracks takes hours
@pytest.mark.parametrize("text", [*OTHERS, *LONG], ids=lambda text: text[:20])
def test_other_texts_are_unknown_commands(text: str) -> None:
    assert decode_event(text) == UnknownCommand(text)


@pytest.mark.parametrize("entry", [{}, {"time_ns": 1}, {"time_ns": 1, "command": "start"}, {"time_ns": "soon", "command": "a = 1"}])
def test_manifest_entries_that_are_not_commands_are_rejected(entry: dict[str, object]) -> None:
    with pytest.raises((KeyError, ValueError)):
        decode_command(entry)
