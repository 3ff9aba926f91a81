"""The timeline of the viewer: simulated time, as in the stamps of the messages."""

from __future__ import annotations

import rerun as rr

from dcrb_ros.viewer.content import Times

TIMELINE = "ros2_timestamp"
"""Name that Rerun's own reader gives to the header stamps of ROS 2 messages."""


def time_column(time_ns: Times) -> rr.TimeColumn:
    """Return simulated times [ns] as a column of the timeline."""
    return rr.TimeColumn(TIMELINE, timestamp=time_ns.astype("datetime64[ns]"))
