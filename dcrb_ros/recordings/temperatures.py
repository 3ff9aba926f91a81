"""The readings of temperature in a recording."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dcrb_ros.messages.topic import Topic
from dcrb_ros.messages.topics import AMBIENT_TEMPERATURE, BOX_TEMPERATURE, OUTER_RING_TEMPERATURE
from dcrb_ros.stream.states import TemperatureReading

if TYPE_CHECKING:
    from dcrb_ros.recordings.reader import Recording

PLACES: dict[Topic, str] = {OUTER_RING_TEMPERATURE: "outer_ring", BOX_TEMPERATURE: "box", AMBIENT_TEMPERATURE: "ambient"}


def temperatures_of(recording: Recording) -> list[TemperatureReading]:
    """Return the instants at which sensors at outer ring, axle box and in the air were all read, in the order of time."""
    if recording.configured and not recording.described and recording.configuration.thermal.law == "none":
        return []  # without reading the file
    found: dict[int, dict[str, float]] = {}
    for message in recording.messages(PLACES):
        found.setdefault(message.time_ns, {})[PLACES[message.topic]] = message.topic.decoded(message.data)
    return [TemperatureReading(time_ns, **places) for time_ns, places in sorted(found.items()) if len(places) == len(PLACES)]
