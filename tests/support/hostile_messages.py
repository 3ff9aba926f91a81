"""Random messages for every topic that a node subscribes to, changed from sound ones, and random values of parameters."""

from __future__ import annotations

import random
import struct
from pathlib import Path
from typing import Any

import numpy as np
from hostile_mutations import NUMBERS, changed_bytes, hostile_value
from made_up_blocks import blocks
from ros2_bag_record import messages_of

from dcrb_ros.messages.plain import encode_clock, encode_temperature, encode_text
from dcrb_ros.messages.points import encode_spectrum
from dcrb_ros.messages.pulses import encode_pulses
from dcrb_ros.messages.topics import COMMANDS, DETECTED, LOAD_COMMAND, SIMULATED, TACHO, TEMPERATURES, VIBRATION, WAYSIDE, Message, Topic
from dcrb_ros.messages.topics.bench_diagnostics import BENCH_DIAGNOSTICS
from dcrb_ros.messages.topics.clock import CLOCK
from dcrb_ros.messages.topics.diagnosis import DIAGNOSIS
from dcrb_ros.messages.topics.envelope_spectrum import ENVELOPE_SPECTRUM
from dcrb_ros.messages.topics.vehicle import VEHICLE_COMMANDS, VEHICLE_DESCRIPTION, VEHICLE_DETECTED, VEHICLE_TRUTH
from dcrb_ros.messages.topics.vibration import VIBRATION_CLEAN
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.schema.parameter_field import ParameterField
from dcrb_ros.stream.diagnosis import Diagnosis
from dcrb_ros.vehicle.description import described
from dcrb_ros.vehicle.file import read_vehicle

ROOT = Path(__file__).parents[2]
SUBSCRIBED: tuple[Topic, ...] = (
    *(*SIMULATED, *DETECTED, *WAYSIDE, *COMMANDS, BENCH_DIAGNOSTICS, CLOCK),
    *(VEHICLE_DESCRIPTION, VEHICLE_TRUTH, *VEHICLE_DETECTED, *VEHICLE_COMMANDS.values()),
)
"""Topics that some node of the package subscribes to."""
LITTLE_ENDIAN = b"\x00\x01\x00\x00"
"""Begin of a message in CDR."""
LENGTHS = (0, 1, 2**16, 2**31 - 1, 2**31, 2**32 - 1)
"""Lengths that a message claims for a text or an array."""


def numbers_message(*values: float) -> bytes:
    """Return a message of double-precision numbers, such as a Float64 or a Wrench."""
    return LITTLE_ENDIAN + struct.pack(f"<{len(values)}d", *values)


def description_of_a_vehicle() -> bytes:
    """Return the message that describes the shipped healthy bogie."""
    return encode_text(described(read_vehicle("healthy_bogie", {})).to_json())


def sound_messages() -> dict[str, bytes]:
    """Return a valid message for the name of each topic, from a shipped recording, an encoder or a fixed content."""
    found: dict[str, Message] = {}
    for message in Recording(ROOT / "bags" / "outer_ring_defect").messages():
        found[message.topic.name] = message
    messages = {name: message.data for name, message in found.items()}
    for message in messages_of(1):
        messages.setdefault(message.topic.name, message.data)
    messages |= {topic.name: encode_temperature(10**9, 40.0, 0.5) for topic in TEMPERATURES}
    messages |= {topic.name: numbers_message(1.0) for topic in (*COMMANDS, *VEHICLE_COMMANDS.values())}
    messages[LOAD_COMMAND.name] = numbers_message(0.0, -1e4, 0.0, 0.0, 0.0, 0.0)
    messages |= {CLOCK.name: encode_clock(10**9), VEHICLE_DESCRIPTION.name: description_of_a_vehicle()}
    judged = Diagnosis(0, 1.0, "outer_ring", "lines of the outer ring", confidence=0.9, scores={"outer_ring": 6.0})
    messages[DIAGNOSIS.name] = DIAGNOSIS.encode(judged)
    messages[ENVELOPE_SPECTRUM.name] = encode_spectrum(10**9, np.arange(5.0), np.arange(5.0), 20.0)
    (block,) = blocks(1)
    messages |= {TACHO.name: encode_pulses(block), VIBRATION_CLEAN.name: messages[VIBRATION.name]}
    alike = {topic.type: messages[topic.name] for topic in SUBSCRIBED if topic.name in messages}
    return {topic.name: messages.get(topic.name, alike.get(topic.type, b"")) for topic in SUBSCRIBED}


def changed_message(draw: random.Random, data: bytes) -> bytes:
    """Return a message with random bytes, another number, another length, or none of its own bytes."""
    kind = draw.randrange(8)
    if kind == 0:
        return draw.randbytes(draw.choice((0, 1, 3, 4, 8, 64, len(data))))
    if kind == 1:
        return LITTLE_ENDIAN + draw.randbytes(len(data) - 4)
    if kind in (2, 3) and len(data) >= 12:
        at = draw.randrange(4, len(data) - 7)
        return data[:at] + struct.pack("<d", _double(draw)) + data[at + 8 :]
    if kind == 4 and len(data) >= 12:
        at = 4 * draw.randrange(1, len(data) // 4)
        return data[:at] + struct.pack("<I", draw.choice(LENGTHS)) + data[at + 4 :]
    if kind == 5 and len(data) <= 64:
        return numbers_message(*(_double(draw) for _ in range((len(data) - 4) // 8)))
    return changed_bytes(draw, data).content


def _double(draw: random.Random) -> float:
    try:
        return float(draw.choice(NUMBERS))
    except OverflowError:
        return float("inf")


def changed_text(draw: random.Random, data: bytes) -> bytes:
    """Return a message of text, such as a description, with changed characters."""
    text = data[8:-1].decode()
    changed = changed_bytes(draw, text.encode()).content.decode(errors="replace")
    return encode_text(changed)


def value_of(draw: random.Random, field: ParameterField) -> Any:
    """Return a value for a parameter: any, one near its limits, or one of its type."""
    if draw.random() < 0.4:
        return hostile_value(draw)
    if field.kind in (int, float) and field.low is not None and field.high is not None:
        edge = draw.choice((field.low, field.high))
        value = draw.choice((edge, edge - 1, edge + 1, edge * 1.0000001, draw.uniform(field.low, field.high)))
        return field.kind(value) if draw.random() < 0.7 else value
    return draw.choice(("", "x", *field.choices, True, False, 1))
