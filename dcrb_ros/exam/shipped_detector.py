"""The shipped detector under evaluation, run in this process."""

from __future__ import annotations

from pathlib import Path

from dcrb_ros.diagnosis.detector import FaultDetector
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.exam.case import Case
from dcrb_ros.exam.received_diagnosis import ReceivedDiagnosis, decode_diagnosis
from dcrb_ros.exam.recording_cache import cached_recording
from dcrb_ros.messages.verdicts import encode_diagnosis
from dcrb_ros.recordings.reader import Recording


def diagnoses_of_recording(bag: Path, parameters: DetectorParameters) -> list[ReceivedDiagnosis]:
    """Return the shipped detector's diagnoses of a recording, decoded from the messages that its node would publish."""
    recording = Recording(bag)
    rate = recording.sampling_rate
    detector = FaultDetector(recording.orders, rate, parameters)
    diagnoses = []
    for block, sensor_range in recording.ranged_vibrations():
        detector.sensor_range = sensor_range
        diagnosis = detector.update(block.first_index(rate), block.acceleration, block.shaft_angle)
        if diagnosis is not None:
            diagnoses.append(decode_diagnosis(encode_diagnosis(diagnosis)))
    return diagnoses


def diagnoses_of_case(case: Case, folder: Path, parameters: DetectorParameters) -> list[ReceivedDiagnosis]:
    """Return the shipped detector's diagnoses of a case; simulate the case if ``folder`` has no recording of it."""
    return diagnoses_of_recording(cached_recording(case, folder), parameters)
