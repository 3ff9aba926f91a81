"""The blocks of a vehicle to messages: each box below its own namespace, and the vehicle beside them."""

from __future__ import annotations

import functools
from collections.abc import Mapping

from dcrb_ros.messages.encoder import BlockEncoder
from dcrb_ros.messages.plain import encode_text
from dcrb_ros.messages.topic import Message, Topic
from dcrb_ros.messages.topics import SIMULATED, TRANSFORMS
from dcrb_ros.messages.topics.sensor import repeats_with
from dcrb_ros.messages.topics.vehicle import VEHICLE_DESCRIPTION, VEHICLE_STATE, VEHICLE_TRANSFORM, VEHICLE_TRUTH
from dcrb_ros.messages.vehicle import Pose, box_path, encode_frames, encode_pose, encode_state, encode_vehicle_truth
from dcrb_ros.stream.states import BodyNames
from dcrb_ros.vehicle.block import VehicleBlock
from dcrb_ros.vehicle.description import Vehicle, described

BESIDE = (VEHICLE_DESCRIPTION, VEHICLE_STATE, VEHICLE_TRUTH, TRANSFORMS, VEHICLE_TRANSFORM)
"""Topics of the vehicle that a simulation fills."""


@functools.cache
def box_topics(name: str) -> Mapping[Topic, Topic]:
    """Return the topics of a box by those of a single bench."""
    return {topic: topic.below(box_path(name)) for topic in SIMULATED}


def simulated_topics(vehicle: Vehicle) -> tuple[Topic, ...]:
    """Return all topics of a simulated vehicle, those of its boxes first."""
    boxes = [topic.below(box_path(box.name)) for box in vehicle.boxes for topic in SIMULATED if topic.enabled(box.configuration)]
    return (*boxes, *BESIDE)


class VehicleEncoder:
    """Encodes the blocks of a vehicle, once for publisher and recorder."""

    def __init__(self, vehicle: Vehicle, bodies: Mapping[str, BodyNames]) -> None:
        """Prepare for the boxes of ``vehicle``, whose bodies have the names ``bodies``."""
        self._encoders = {box.name: BlockEncoder(box.configuration, bodies[box.name], box_topics(box.name)) for box in vehicle.boxes}
        self._description = encode_text(described(vehicle).to_json())
        self._frames = encode_frames(vehicle)
        self._pose = Pose(0.0, 0.0, 0.0)
        self._place: float | None = None
        """Place at the last block [m]; the first one begins at 0, or in the middle of a run."""

    def start(self, time_ns: int = 0) -> list[Message]:
        """Return the messages that precede the first block, which begins at ``time_ns``."""
        boxes = [message for encoder in self._encoders.values() for message in encoder.start(time_ns)]
        return [*boxes, Message(TRANSFORMS, time_ns, self._frames), Message(VEHICLE_DESCRIPTION, time_ns, self._description)]

    def encode(self, block: VehicleBlock) -> list[Message]:
        """Return the messages of a block of every box and of the vehicle, sorted by time."""
        messages = [message for name, box in block.boxes.items() for message in self._encoders[name].encode(box)]
        truth = block.truth
        before = self._place if self._place is not None else truth.place if truth.time_ns else 0.0
        self._pose, self._place = self._pose.moved(truth.place - before, truth.curvature), truth.place
        if repeats_with(next(iter(block.boxes.values()))):
            messages.append(Message(TRANSFORMS, truth.time_ns, self._frames))
            messages.append(Message(VEHICLE_DESCRIPTION, truth.time_ns, self._description))
        messages.append(Message(VEHICLE_TRUTH, truth.time_ns, encode_vehicle_truth(truth)))
        messages.append(
            Message(VEHICLE_STATE, block.end_ns, encode_state(block.end_ns, self._pose, truth.speed, truth.speed * truth.curvature))
        )
        messages.append(Message(VEHICLE_TRANSFORM, block.end_ns, encode_pose(block.end_ns, self._pose)))
        return sorted(messages, key=lambda message: message.time_ns)
