"""What the wayside hot-box detector reads, and whether it alarms."""

from __future__ import annotations

from dcrb_ros.diagnosis.wayside import Passage
from dcrb_ros.messages.cdr import DIAGNOSTICS, FRAME
from dcrb_ros.messages.plain import TEMPERATURE, decode_temperature, encode_temperature
from dcrb_ros.messages.statuses import ERROR, OK, Status, decode_diagnostics, encode_diagnostics
from dcrb_ros.messages.topic import Topic

WAYSIDE_TEMPERATURE = Topic(
    "wayside/temperature", TEMPERATURE, "reading of a wayside detector at each passage [deg C]", decode=decode_temperature
)
WAYSIDE_ALARM = Topic(
    "wayside/alarm",
    DIAGNOSTICS,
    "status `hot_box` of each passage: OK, or ERROR by a rule, with reading, the other box, ambient, distance",
    decode=decode_diagnostics,
)


def encode_reading(passage: Passage, noise: float, frame: str = FRAME) -> bytes:
    """Return the reading of a passage."""
    return encode_temperature(passage.time_ns, passage.reading, noise, frame)


def encode_alarm(passage: Passage, frame: str = FRAME) -> bytes:
    """Return the verdict on a passage."""
    rules = [name for name, hot in (("ambient", passage.over_ambient), ("opposite", passage.over_opposite)) if hot]
    values = {
        "reading [deg C]": repr(passage.reading),
        "opposite [deg C]": repr(passage.opposite),
        "ambient [deg C]": repr(passage.ambient),
        "distance [km]": repr(passage.distance),
        "rules": ", ".join(rules),
    }
    return encode_diagnostics(passage.time_ns, [Status("hot_box", ERROR if rules else OK, passage.reason, values)], frame)
