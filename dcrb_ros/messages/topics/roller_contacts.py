"""The contacts of the rollers with the raceways."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dcrb_ros.messages.cdr import JOINT_STATE
from dcrb_ros.messages.joints import decode_joints, encode_contacts
from dcrb_ros.messages.topic import Encoded, EncodedBench, SimulatedTopic
from dcrb_ros.stream.block import Block

if TYPE_CHECKING:
    from dcrb_ros.settings.configuration import Configuration


def _enabled(configuration: Configuration) -> bool:
    return configuration.publishing.contacts


def _encode(block: Block, source: EncodedBench) -> Encoded:
    return ((states.time_ns, encode_contacts(states, source.bodies, source.frame)) for states in block.states)


ROLLER_CONTACTS = SimulatedTopic(
    "roller_contacts",
    JOINT_STATE,
    "the same bodies: force at the outer raceway [N], slip [m/s] and friction force [N] at the inner raceway; off by default "
    "(`publishing.contacts`)",
    depth=500,
    decode=decode_joints,
    encode=_encode,
    enabled=_enabled,
)
