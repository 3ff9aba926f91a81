"""The one timeline of the viewer: the simulated time of the messages' stamps."""

from __future__ import annotations

import rerun as rr

from dcrb_ros.viewer.content import Times

TIMELINE = "ros2_timestamp"
"""The name under which Rerun itself files the header stamps of ROS 2 messages."""


def time_column(time_ns: Times) -> rr.TimeColumn:
    """Return simulated times [ns] as a column of the timeline."""
    return rr.TimeColumn(TIMELINE, timestamp=time_ns.astype("datetime64[ns]"))
