"""Rollers, cages and inner ring: their motion, and the forces on the rollers."""

from __future__ import annotations

from dcrb_ros.messages.cdr import JOINT_STATE
from dcrb_ros.messages.joints import decode_joints, encode_joints
from dcrb_ros.messages.topic import Encoded, EncodedBench, SimulatedTopic
from dcrb_ros.stream.block import Block


def _encode(block: Block, source: EncodedBench) -> Encoded:
    for s in block.states:
        yield s.time_ns, encode_joints(s.time_ns, source.bodies, s.azimuth, s.speed, s.inner_force, source.frame)


def _encode_contacts(block: Block, source: EncodedBench) -> Encoded:
    for s in block.states:
        yield s.time_ns, encode_joints(s.time_ns, source.bodies, s.outer_force, s.slip, s.friction, source.frame)


ROLLER_STATES = SimulatedTopic(
    "roller_states",
    JOINT_STATE,
    "rollers, cages and inner ring: azimuth [rad], speed [rad/s], force at the inner raceway [N]; 100 Hz",
    depth=500,
    decode=decode_joints,
    encode=_encode,
)
ROLLER_CONTACTS = SimulatedTopic(
    "roller_contacts",
    JOINT_STATE,
    "the same bodies: force at the outer raceway [N], slip [m/s] and friction force [N] at the inner raceway; off by default "
    "(`publishing.contacts`)",
    depth=500,
    decode=decode_joints,
    encode=_encode_contacts,
    enabled=lambda configuration: configuration.publishing.contacts,
)
