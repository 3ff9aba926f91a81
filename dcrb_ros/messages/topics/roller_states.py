"""The motion of rollers, cages and inner ring."""

from __future__ import annotations

from dcrb_ros.messages.cdr import JOINT_STATE
from dcrb_ros.messages.joints import decode_joints, encode_joints
from dcrb_ros.messages.topic import Encoded, EncodedBench, SimulatedTopic
from dcrb_ros.stream.block import Block


def _encode(block: Block, source: EncodedBench) -> Encoded:
    for s in block.states:
        yield s.time_ns, encode_joints(s.time_ns, source.bodies, s.azimuth, s.speed, s.inner_force, source.frame)


ROLLER_STATES = SimulatedTopic(
    "roller_states",
    JOINT_STATE,
    "rollers, cages and inner ring: azimuth [rad], speed [rad/s], force at the inner raceway [N]; 100 Hz",
    depth=500,
    decode=decode_joints,
    encode=_encode,
)
