"""The topics of the bench, one per file, or two that are encoded alike. A new topic needs its own file and one line in the lists below.

The constants are the topics that other modules refer to. The quality of service (QoS) of a topic is `Topic.qos`.
"""

from __future__ import annotations

from collections.abc import Iterable
from pkgutil import resolve_name
from typing import Any

from dcrb_ros.messages.topic import MANIFEST as MANIFEST
from dcrb_ros.messages.topic import NAMESPACE as NAMESPACE
from dcrb_ros.messages.topic import Message as Message
from dcrb_ros.messages.topic import SimulatedTopic
from dcrb_ros.messages.topic import Topic as Topic
from dcrb_ros.messages.topics.acceleration import ACCELERATION as ACCELERATION
from dcrb_ros.messages.topics.bench_diagnostics import BENCH_DIAGNOSTICS as BENCH_DIAGNOSTICS
from dcrb_ros.messages.topics.clock import CLOCK as CLOCK
from dcrb_ros.messages.topics.commands import LOAD_COMMAND as LOAD_COMMAND
from dcrb_ros.messages.topics.commands import SPEED_COMMAND as SPEED_COMMAND
from dcrb_ros.messages.topics.diagnosis import DIAGNOSIS as DIAGNOSIS
from dcrb_ros.messages.topics.envelope_spectrum import ENVELOPE_SPECTRUM as ENVELOPE_SPECTRUM
from dcrb_ros.messages.topics.fault_indicators import FAULT_INDICATORS as FAULT_INDICATORS
from dcrb_ros.messages.topics.features import FEATURES as FEATURES
from dcrb_ros.messages.topics.ground_truth import GROUND_TRUTH as GROUND_TRUTH
from dcrb_ros.messages.topics.lubrication_state import LUBRICATION_STATE as LUBRICATION_STATE
from dcrb_ros.messages.topics.roller_states import ROLLER_CONTACTS as ROLLER_CONTACTS
from dcrb_ros.messages.topics.roller_states import ROLLER_STATES as ROLLER_STATES
from dcrb_ros.messages.topics.sensor import SENSOR as SENSOR
from dcrb_ros.messages.topics.tacho import TACHO as TACHO
from dcrb_ros.messages.topics.temperatures import AMBIENT_TEMPERATURE as AMBIENT_TEMPERATURE
from dcrb_ros.messages.topics.temperatures import BOX_TEMPERATURE as BOX_TEMPERATURE
from dcrb_ros.messages.topics.temperatures import OUTER_RING_TEMPERATURE as OUTER_RING_TEMPERATURE
from dcrb_ros.messages.topics.transforms import TRANSFORMS as TRANSFORMS
from dcrb_ros.messages.topics.vibration import VIBRATION as VIBRATION
from dcrb_ros.messages.topics.vibration import VIBRATION_CLEAN as VIBRATION_CLEAN
from dcrb_ros.messages.topics.wayside import WAYSIDE_ALARM as WAYSIDE_ALARM
from dcrb_ros.messages.topics.wayside import WAYSIDE_TEMPERATURE as WAYSIDE_TEMPERATURE
from dcrb_ros.text.markdown import table


def _topics(*names: str) -> tuple[Any, ...]:
    """Return topics by module and constant below this package."""
    return tuple(resolve_name(f"{__name__}.{name}") for name in names)


SIMULATED: tuple[SimulatedTopic, ...] = _topics(
    "sensor:SENSOR",
    "vibration:VIBRATION",
    "vibration:VIBRATION_CLEAN",
    "tacho:TACHO",
    "features:FEATURES",
    "window_features:WINDOW_FEATURES",
    "acceleration:ACCELERATION",
    "roller_states:ROLLER_STATES",
    "roller_states:ROLLER_CONTACTS",
    "lubrication_state:LUBRICATION_STATE",
    "temperatures:OUTER_RING_TEMPERATURE",
    "temperatures:BOX_TEMPERATURE",
    "temperatures:AMBIENT_TEMPERATURE",
    "ground_truth:GROUND_TRUTH",
)
"""Topics that the simulator publishes and records; messages of one time are sent in this order."""

TEMPERATURES = OUTER_RING_TEMPERATURE, BOX_TEMPERATURE, AMBIENT_TEMPERATURE
"""Those of them with readings of thermometers."""

DETECTED = DIAGNOSIS, FAULT_INDICATORS, ENVELOPE_SPECTRUM
"""Topics that the fault detector publishes, in the order of its messages."""

WAYSIDE = WAYSIDE_TEMPERATURE, WAYSIDE_ALARM
"""Topics that the wayside hot-box detector publishes."""

BENCH = BENCH_DIAGNOSTICS, CLOCK, TRANSFORMS
"""Topics that the nodes publish about themselves."""

COMMANDS = SPEED_COMMAND, LOAD_COMMAND
"""Topics to which the simulator subscribes."""


def topic_table() -> str:
    """Return the topics of a bench as a Markdown table."""
    return table_of((*SIMULATED, *DETECTED, *WAYSIDE, *BENCH))


def table_of(topics: Iterable[Topic]) -> str:
    """Return topics as a Markdown table."""
    kinds = ((topic, f"`{topic.type.replace('/msg/', '/')}`" + (", latched" if topic.latched else "")) for topic in topics)
    return table(("topic", "type", "content"), ((f"`{topic.name}`", kind, topic.content) for topic, kind in kinds))
