"""Blocks to messages, each encoded once."""

from __future__ import annotations

from dcrb_ros.bearing.states import BodyNames
from dcrb_ros.messages.description import sensor_text
from dcrb_ros.messages.joints import encode_contacts, encode_features, encode_states
from dcrb_ros.messages.plain import encode_preview, encode_text
from dcrb_ros.messages.points import encode_vibration
from dcrb_ros.messages.statuses import encode_truth
from dcrb_ros.messages.topics import (
    ACCELERATION,
    FEATURES,
    GROUND_TRUTH,
    ROLLER_CONTACTS,
    ROLLER_STATES,
    SENSOR,
    VIBRATION,
    VIBRATION_CLEAN,
    Message,
)
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.simulation.block import Block


class BlockEncoder:
    """Blocks to messages, each encoded once."""

    def __init__(self, configuration: Configuration, bodies: BodyNames) -> None:
        self._configuration = configuration
        self._names = tuple(bodies.names)
        self._frame = configuration.publishing.frame

    def start(self, time_ns: int = 0) -> list[Message]:
        """Return the messages that come before the first block, which begins at ``time_ns``."""
        return [Message(SENSOR, time_ns, encode_text(sensor_text(self._configuration)))]

    def _described(self, block: Block) -> list[Message]:
        """Return the sensor's description anew where its range has changed."""
        sensor = self._configuration.sensor
        if block.range in (0.0, sensor.range):
            return []
        changed = self._configuration.model_copy(update={"sensor": sensor.model_copy(update={"range": block.range})})
        self._configuration = changed
        return [Message(SENSOR, block.stamp_ns, encode_text(sensor_text(changed)))]

    def encode(self, block: Block) -> list[Message]:
        """Return the messages of a block in the order of their times."""
        messages = self._described(block) + ([] if block.lost else self._waveform(block))
        messages += [Message(ROLLER_STATES, states.time_ns, encode_states(states, self._names)) for states in block.states]
        if self._configuration.publishing.contacts:
            messages += [Message(ROLLER_CONTACTS, states.time_ns, encode_contacts(states, self._names)) for states in block.states]
        messages += [Message(GROUND_TRUTH, truth.time_ns, encode_truth(truth)) for truth in block.truths]
        return sorted(messages, key=lambda message: message.time_ns)

    def _waveform(self, block: Block) -> list[Message]:
        """Return the messages that are made of a block's samples."""
        messages = [Message(VIBRATION, block.stamp_ns, encode_vibration(block, block.acceleration, self._frame))]
        if self._configuration.publishing.clean:
            messages.append(Message(VIBRATION_CLEAN, block.stamp_ns, encode_vibration(block, block.clean, self._frame)))
        messages.append(Message(FEATURES, block.stamp_ns, encode_features(block)))
        previews = zip(block.preview_ns, block.preview, strict=True)
        return messages + [Message(ACCELERATION, time_ns, encode_preview(time_ns, sample, self._frame)) for time_ns, sample in previews]
