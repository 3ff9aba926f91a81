"""Commands to a running simulator: speed and load, which `simulation.drive` applies.

Their names are in `settings.parameters.COMMANDED`, their text in recordings in `stream.event_text`.
"""

from __future__ import annotations

from dcrb_ros.messages.plain import decode_float, decode_wrench
from dcrb_ros.messages.topic import Topic
from dcrb_ros.settings.parameters import COMMANDED

SPEED_COMMAND = Topic(
    COMMANDED["operating.speed"], "std_msgs/msg/Float64", "speed of the inner ring [rad/s]", depth=10, decode=decode_float
)
LOAD_COMMAND = Topic(
    COMMANDED["operating.load"], "geometry_msgs/msg/Wrench", "force on the inner ring in X and Y [N]", depth=10, decode=decode_wrench
)
