"""A simulator as its services and its status see it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from dcrb_ros.messages.topics import COMMANDS, DETECTED, Topic
from dcrb_ros.nodes.base import BenchNode
from dcrb_ros.nodes.engine import Engine, Progress
from dcrb_ros.nodes.recording_switch import RecordingSwitch
from dcrb_ros.nodes.refusal_counts import Refusals
from dcrb_ros.settings.configuration import Configuration


class ServedNode(BenchNode):
    """A node with the engine of a simulation and its recordings; `dcrb_ros.nodes.simulating` puts it together."""

    purpose = "bench"
    commands: Sequence[Topic] = COMMANDS
    """Topics of commands, whose refusals are counted together."""
    detected: Sequence[Topic] = DETECTED
    """Topics of the detector, whose refusals are counted together."""
    behind = "behind real time"
    """What the status says where the engine is behind real time."""
    compiling = ""
    """The last sentence about a compilation, until a block is computed."""
    configuration: Configuration
    engine: Engine
    progress: Progress
    refusals: Refusals
    recording: RecordingSwitch

    def about(self) -> tuple[str, Mapping[str, str]]:
        """Return a message that makes the status a warning, or "", and more values; not called before the engine is prepared."""
        return "", {}

    def update_parameters(self) -> None:
        """Set the node's parameters to the present configuration, which a reset or a scenario may have changed."""
