"""A user's detector of a vehicle as a process in its own ROS domain, to which the waveforms of all axle boxes are played."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from dcrb_ros.exam.running_detector import checked_statuses
from dcrb_ros.exam.vehicle.evaluation import VehicleOutcome
from dcrb_ros.exam.vehicle.signals import VehicleSignal
from dcrb_ros.messages.bundle import Bundle
from dcrb_ros.messages.plain import encode_temperature, encode_text
from dcrb_ros.messages.points import encode_waveform
from dcrb_ros.messages.received_diagnosis import checked_time, score_of
from dcrb_ros.messages.statuses import decode_diagnostics
from dcrb_ros.messages.topics import AMBIENT_TEMPERATURE, OUTER_RING_TEMPERATURE, VIBRATION, Message
from dcrb_ros.messages.topics.vehicle import VEHICLE_DESCRIPTION, VEHICLE_DIAGNOSIS
from dcrb_ros.nodes.detector_answers import Answers
from dcrb_ros.nodes.external_detector import Feed, NodeProgram
from dcrb_ros.stream.vehicle_description import VehicleDescription


@dataclass
class VehicleAnswers(Answers, VehicleOutcome):
    """The diagnoses of a vehicle that a detector published in a scenario."""

    description: VehicleDescription = field(kw_only=True)

    def forget(self) -> None:
        self.received.clear()

    def _taken(self, data: bytes) -> float:
        time_ns, statuses = decode_diagnostics(data)
        time = checked_time(time_ns)
        checked_statuses({status.name: status.values.get("verdict") for status in statuses}, self.description)
        found = {status.name: (status.values["verdict"], score_of(status.values["verdict"], status.values)) for status in statuses}
        self.add(self.description, time, found, self._signal_received(time))
        return time


def _vehicle_feed(signal: VehicleSignal) -> Feed:
    """Return the waveforms of the boxes of a vehicle, as the live vehicle publishes them, with a block of every box in each bundle."""
    waveforms = {box.name: VIBRATION.below(box.name) for box in signal.description.boxes}
    thermometers = {name: [topic.below(name) for topic in (AMBIENT_TEMPERATURE, OUTER_RING_TEMPERATURE)] for name in signal.temperatures}
    description = Message(VEHICLE_DESCRIPTION, 0, encode_text(signal.description.to_json()))

    def bundles() -> Iterator[Bundle]:
        rate, begin = signal.description.sampling_rate, 0
        for blocks, _, last in signal.pieces():
            messages = []
            for name, block in blocks.items():
                angle = block.shaft_angle if block.shaft_angle is not None else np.full(len(block.acceleration), np.nan)
                data = encode_waveform(block.index, rate, block.acceleration, angle, f"{name}/outer_ring")
                messages.append(Message(waveforms[name], block.index * 1_000_000_000 // rate, data))
            end = last * 1_000_000_000 // rate
            for name, (air, ring) in thermometers.items():
                for time, warm, ambient in signal.readings(name, begin * 1e-9, end * 1e-9):
                    at = round(time * 1e9)
                    messages += [
                        Message(topic, at, encode_temperature(at, value, 0.0, f"{name}/outer_ring"))
                        for topic, value in ((air, ambient), (ring, warm))
                    ]
            yield Bundle(begin, end, tuple(messages))
            begin = end

    awaited = tuple(waveforms.values())
    topics = (*awaited, *itertools.chain(*thermometers.values()), VEHICLE_DESCRIPTION)
    return Feed(topics, awaited, VEHICLE_DIAGNOSIS, lambda: [description], bundles)


class ExternalVehicleDetector(NodeProgram):
    """A detector of a vehicle given by its command as a candidate."""

    def diagnose(self, signal: VehicleSignal) -> VehicleAnswers:
        """Return the diagnoses for the signals of one vehicle; see `play` for errors."""
        answers = VehicleAnswers(description=signal.description)
        answers.failure = self.play(_vehicle_feed(signal), answers)
        return answers
