"""Bundles: messages that are sent together, simulated or recorded."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from dcrb_ros.messages.topics import Message
from dcrb_ros.stream.block import Block


@dataclass(frozen=True)
class Bundle:
    """Messages that are sent at the same time, in the order in which they are sent."""

    begin_ns: int
    """Time after the end of the previous bundle [ns]: the first sample of a block."""
    end_ns: int
    """Time at which the bundle is due [ns]: the end of a block."""
    messages: tuple[Message, ...]
    block: Block | None = None
    """The block that was encoded; none in a replay."""
    commands: tuple[Any, ...] = ()
    """Commands that took effect in it, as the recorder of the source takes them."""
