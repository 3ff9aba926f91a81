"""The shipped detector as an examinee, in this process."""

from __future__ import annotations

from pathlib import Path

from dcrb_ros.diagnosis.detector import FaultDetector
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.exam.case import Case
from dcrb_ros.exam.library import recorded
from dcrb_ros.exam.opinion import Opinion, opinion_of
from dcrb_ros.messages.topics.diagnosis import encode_diagnosis
from dcrb_ros.recordings.reader import Recording


def opinions(bag: Path, parameters: DetectorParameters) -> list[Opinion]:
    """Return what the shipped detector says of a recording, taken from the message that its node would publish."""
    recording = Recording(bag)
    rate = recording.sampling_rate
    detector = FaultDetector(recording.orders, rate, parameters)
    found = []
    for block, sensor_range in recording.ranged_vibrations():
        detector.sensor_range = sensor_range
        diagnosis = detector.update(block.first_index(rate), block.acceleration, block.shaft_angle)
        if diagnosis is not None:
            found.append(opinion_of(encode_diagnosis(diagnosis)))
    return found


def examined(case: Case, folder: Path, parameters: DetectorParameters) -> list[Opinion]:
    """Return what the shipped detector says of a case, simulated where it is not in ``folder`` yet."""
    return opinions(recorded(case, folder), parameters)
