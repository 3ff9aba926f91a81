"""Simulated time for other nodes."""

from __future__ import annotations

from dcrb_ros.messages.cdr import CLOCK as CLOCK_TYPE
from dcrb_ros.messages.plain import decode_clock
from dcrb_ros.messages.topic import Topic

CLOCK = Topic(
    "/clock", CLOCK_TYPE, "simulated time, at most 100 Hz of wall time; off by default (`publishing.clock`)", depth=10, decode=decode_clock
)
