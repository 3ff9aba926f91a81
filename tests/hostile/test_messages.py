"""Random messages on every subscribed topic and random values of every parameter: refused in one sentence, or used as they are.

The nodes pass messages and parameters to the functions called here. A fixed number of inputs is run by default; `make hostile` runs more.
"""

from __future__ import annotations

import math
import os
import random
from collections import Counter
from collections.abc import Callable
from typing import Any

import pytest
from hostile_messages import SUBSCRIBED, changed_message, changed_text, sound_messages, value_of
from hostile_mutations import hostile_value

from dcrb_ros.bearing.runtime_change import altered
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.vehicle.parameters import VehicleDetectorParameters
from dcrb_ros.diagnosis.wayside import Wayside, WaysideParameters
from dcrb_ros.messages.topics import (
    AMBIENT_TEMPERATURE,
    GROUND_TRUTH,
    LOAD_COMMAND,
    OUTER_RING_TEMPERATURE,
    SENSOR,
    SPEED_COMMAND,
    VIBRATION,
)
from dcrb_ros.messages.topics.vehicle import VEHICLE_COMMANDS, VEHICLE_DESCRIPTION
from dcrb_ros.nodes.detector_input import DetectorInput
from dcrb_ros.nodes.vehicle_detector_input import VehicleDetectorInput, VehicleDetectorSettings
from dcrb_ros.recordings.replay import ReplayParameters
from dcrb_ros.schema.fields import Group
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import flatten, load_configuration, parameter_fields, validated
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.vehicle.changes import RANGES, checked_command

ALL = os.environ.get("DCRB_HOSTILE") == "all"
FIRST = int(os.environ.get("DCRB_HOSTILE_FIRST", "0"))
MESSAGES = range(FIRST, FIRST + (400 if ALL else 25))
"""Numbers of the messages of each topic."""
VALUES = range(FIRST, FIRST + (40 if ALL else 3))
"""Numbers of the values of each parameter."""
SCHEMAS: tuple[type[Group], ...] = (Configuration, DetectorParameters, VehicleDetectorParameters, ReplayParameters, WaysideParameters)
"""The declared parameters of the nodes."""


@pytest.fixture(scope="module")
def sound() -> dict[str, bytes]:
    return sound_messages()


def sentence(function: Callable[[], object]) -> str:
    """Return what is wrong with the answer of a function: an exception that is no refusal, or a refusal of several lines."""
    try:
        function()
    except Refusal as refusal:
        return "" if len(str(refusal).splitlines()) == 1 else f"several lines: {refusal}"
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return ""


def test_messages_without_a_change_are_decoded(sound: dict[str, bytes]) -> None:
    for topic in SUBSCRIBED:
        topic.decoded(sound[topic.name])


@pytest.mark.parametrize("topic", SUBSCRIBED, ids=lambda topic: topic.name)
def test_any_message_is_decoded_or_refused(topic: Any, sound: dict[str, bytes], tally: Counter[str]) -> None:
    found = {}
    for number in MESSAGES:
        draw = random.Random(f"{topic.name} {number}")
        data = changed_message(draw, sound[topic.name])
        found[number] = sentence(lambda data=data: topic.decoded(data))  # type: ignore[misc]
    tally[f"message on {topic.name}"] += len(found)
    assert {number: wrong for number, wrong in found.items() if wrong} == {}


def test_the_detector_answers_any_sequence_of_messages(sound: dict[str, bytes], tally: Counter[str]) -> None:
    found = {}
    detector = DetectorInput(DetectorParameters())
    takes = {
        SENSOR: detector.sensor,
        VIBRATION: detector.block,
        AMBIENT_TEMPERATURE: detector.ambient,
        OUTER_RING_TEMPERATURE: detector.temperature,
    }
    for number in MESSAGES:
        for topic, take in takes.items():
            draw = random.Random(f"detector {topic.name} {number}")
            text = topic is SENSOR and draw.random() < 0.7
            data = changed_text(draw, sound[topic.name]) if text else changed_message(draw, sound[topic.name])
            data = sound[topic.name] if draw.random() < 0.3 else data
            found[topic.name, number] = sentence(lambda take=take, data=data: take(data))  # type: ignore[misc]
    tally["message to the fault detector"] += len(found)
    assert {place: wrong for place, wrong in found.items() if wrong} == {}


def test_the_comparing_detector_answers_any_sequence_of_messages(sound: dict[str, bytes], tally: Counter[str]) -> None:
    found = {}
    detector, box = VehicleDetectorInput(VehicleDetectorSettings()), "axle_1/left"
    for number in MESSAGES:
        draw = random.Random(f"comparing detector {number}")
        description = sound[VEHICLE_DESCRIPTION.name]
        description = description if draw.random() < 0.5 else changed_text(draw, description)
        found["description", number] = sentence(lambda data=description: detector.describe(data))  # type: ignore[misc]
        for topic, take in (
            (SENSOR, detector.sensor),
            (VIBRATION, detector.block),
            (AMBIENT_TEMPERATURE, detector.ambient),
            (OUTER_RING_TEMPERATURE, detector.temperature),
        ):
            data = sound[topic.name] if draw.random() < 0.3 else changed_message(draw, sound[topic.name])
            name = draw.choice((box, "axle_2/right"))
            found[topic.name, number] = sentence(lambda take=take, name=name, data=data: take(name, data))  # type: ignore[misc]
    tally["message to the comparing detector"] += len(found)
    assert {place: wrong for place, wrong in found.items() if wrong} == {}


def test_the_wayside_detector_answers_any_ground_truth(sound: dict[str, bytes], tally: Counter[str]) -> None:
    pytest.importorskip("rclpy", reason="the node needs ROS 2")
    from dcrb_ros.nodes.hot_box_detector import boxes_of

    wayside = Wayside(WaysideParameters())

    def take(data: bytes) -> None:
        truth = GROUND_TRUTH.decoded(data)
        if (boxes := boxes_of(truth)) is not None:
            wayside.follow(truth.time_ns, truth.speed, boxes)

    answers = {n: sentence(lambda n=n: take(changed_message(random.Random(f"truth {n}"), sound[GROUND_TRUTH.name]))) for n in MESSAGES}  # type: ignore[misc]
    tally["message to the wayside detector"] += len(answers)
    assert {number: wrong for number, wrong in answers.items() if wrong} == {}


def test_commands_are_taken_within_their_ranges_or_refused(sound: dict[str, bytes], tally: Counter[str]) -> None:
    simulation, found = Simulation(load_configuration("dry")), {}
    for number in MESSAGES:
        draw = random.Random(f"command {number}")
        speed, load = (changed_message(draw, sound[topic.name]) for topic in (SPEED_COMMAND, LOAD_COMMAND))
        found["speed", number] = sentence(lambda data=speed: simulation.command_speed(SPEED_COMMAND.decoded(data)))  # type: ignore[misc]
        found["load", number] = sentence(lambda data=load: simulation.command_load(*LOAD_COMMAND.decoded(data)))  # type: ignore[misc]
        for name, topic in VEHICLE_COMMANDS.items():
            data = changed_message(draw, sound[topic.name])

            def take(name: str = name, topic: Any = topic, data: bytes = data) -> None:
                value = checked_command(name, topic.decoded(data))
                low, high, _ = RANGES[name]
                assert low <= value <= high

            found[name, number] = sentence(take)
    tally["command"] += len(found)
    assert {place: wrong for place, wrong in found.items() if wrong} == {}
    for block in simulation.blocks(0.02):
        assert math.isfinite(float(abs(block.acceleration).max()))


@pytest.mark.parametrize("schema", SCHEMAS, ids=lambda schema: schema.__name__)
def test_any_value_of_a_parameter_is_used_as_it_is_or_refused(schema: type[Group], tally: Counter[str]) -> None:
    wrong = {}
    for field in parameter_fields(schema):
        for number in VALUES:
            value = value_of(random.Random(f"{schema.__name__} {field.key} {number}"), field)

            def take(key: str = field.key, value: Any = value, low: Any = field.low, high: Any = field.high) -> None:
                parameters = flatten(validated({key: value}, schema, "parameters").model_dump())
                if key == "operating.speed_kmh" and value:  # becomes the speed of the shaft
                    assert parameters["operating.speed"] == pytest.approx(value / 3.6 / (0.5 * parameters["operating.wheel_diameter"]))
                    return
                used = parameters[key]
                assert used == value, f"{value!r} became {used!r}"
                assert isinstance(used, bool) == isinstance(value, bool)
                assert low is None or high is None or low <= used <= high, f"{used!r} is out of range"

            if said := sentence(take):
                wrong[field.key, number] = f"{value!r}: {said}"
            tally[f"parameter of {schema.__name__}"] += 1
    assert wrong == {}


def test_any_change_of_a_running_bench_is_made_or_refused(tally: Counter[str]) -> None:
    configuration, wrong = load_configuration("dry"), {}
    fields = list(parameter_fields(Configuration))
    for number in range(FIRST, FIRST + (4000 if ALL else 200)):
        draw = random.Random(f"change {number}")
        asked = {field.key: value_of(draw, field) for field in draw.sample(fields, draw.randrange(1, 3))}
        if draw.random() < 0.1:
            asked[str(hostile_value(draw))[:50]] = hostile_value(draw)

        def take(asked: dict[str, Any] = asked) -> None:
            after = flatten(altered(configuration, asked).model_dump())
            assert {key: after[key] for key in asked} == asked

        if said := sentence(take):
            wrong[number] = f"{asked}: {said}"
    tally["change of a running bench"] += number - FIRST + 1
    assert wrong == {}
