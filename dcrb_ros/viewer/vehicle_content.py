"""The content of a vehicle's recording as the viewer shows it; messages that cannot be decoded are refused."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, MutableMapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from types import MappingProxyType

import numpy as np

from dcrb_ros.bearing.temperature_readings import TemperatureReadings
from dcrb_ros.bearing.waveform import Piece
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.vehicle import detection
from dcrb_ros.diagnosis.vehicle.detector import VehicleDetector
from dcrb_ros.messages.description import decode_range
from dcrb_ros.messages.points import decode_waveform, index_at
from dcrb_ros.messages.statuses import Status, decode_diagnostics
from dcrb_ros.messages.topics import ENVELOPE_SPECTRUM, FEATURES, GROUND_TRUTH, SENSOR, VIBRATION, Topic
from dcrb_ros.messages.topics.vehicle import VEHICLE_DESCRIPTION, VEHICLE_DIAGNOSIS, VEHICLE_TRUTH
from dcrb_ros.messages.vehicle import box_path, encode_vehicle_diagnosis
from dcrb_ros.recordings.vehicle import VehicleRecording
from dcrb_ros.recordings.vehicle_folder import title_of
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.stream.diagnosis import Diagnosis
from dcrb_ros.stream.vehicle_description import VehicleDescription
from dcrb_ros.stream.vehicle_diagnosis import VehicleDiagnosis
from dcrb_ros.viewer.content import Series, TimedWaveform, Times, joined
from dcrb_ros.viewer.reader import series_of, time_lapse
from dcrb_ros.viewer.spectrum import pieces, spectra_in

PARTS = ("time_ns", "acceleration", "shaft_angle")
"""Arrays of a waveform over time."""


@dataclass(frozen=True)
class TrackEvent:
    """An event on the track, such as a joint or a flat."""

    time_ns: int
    """[ns]"""
    cause: str
    where: str
    """The box over the wheel, such as ``axle_1/left``, or the wheelset."""
    place: float
    """Place on the track [m]."""
    jump: float
    """Jump of velocity [m/s]."""


@dataclass(frozen=True)
class Verdicts:
    """The verdicts on the parts of a vehicle at one time."""

    time_ns: int
    """[ns]"""
    statuses: Mapping[str, Status]
    """By the name of the part, such as ``axle_1/left/bearing``."""


@dataclass(frozen=True)
class VehicleContent:
    """Everything that is shown of a vehicle, or of a part of its run."""

    title: str
    description: VehicleDescription
    waveforms: Mapping[str, TimedWaveform]
    """The waveform of each box by name."""
    features: Mapping[str, Series] = field(default_factory=dict)
    """Statistics of every block by box."""
    verdicts: tuple[Verdicts, ...] = ()
    events: tuple[TrackEvent, ...] = ()
    judgements: Mapping[str, Sequence[Diagnosis]] = field(default_factory=dict)
    """Diagnoses of each box by itself, with their spectra."""

    @property
    def start_ns(self) -> int:
        """Time of the first sample [ns]."""
        return min(int(waveform.time_ns[0]) for waveform in self.waveforms.values())

    @property
    def end_ns(self) -> int:
        """Time of the last sample [ns]."""
        return max(int(waveform.time_ns[-1]) for waveform in self.waveforms.values())


def read_vehicle_content(recording: VehicleRecording) -> VehicleContent:
    """Return the content of a recording, with the verdicts in it, or else those of the shipped detector.

    Raises:
        Refusal: a box has no waveform, or a message cannot be decoded.
    """
    received: dict[Topic, list[bytes]] = defaultdict(list)
    ranges: dict[str, list[tuple[int, float]]] = defaultdict(list)
    names = {SENSOR.below(box_path(name)): box_path(name) for name in recording.boxes}
    truth = GROUND_TRUTH.below(next(iter(names.values())))
    for message in recording.messages((*shown_topics(recording.boxes), *names, truth)):
        if message.topic in names:
            ranges[names[message.topic]].append((message.time_ns, decode_range(message.data)))
        else:
            received[message.topic].append(message.data)
    description = recording.description
    content = content_of(received, description, title_of(recording.path))
    if not content.waveforms:
        raise Refusal(f"{recording.path} has no waveform of any box: give a recording that contains outer_ring/vibration")
    readings = {box_path(name): box.temperatures for name, box in recording.boxes.items()}
    diagnoses = diagnoses_of(content, ranges, readings, time_lapse(received[truth]))
    verdicts = content.verdicts or tuple(verdicts_in(encode_vehicle_diagnosis(diagnosis) for diagnosis in diagnoses))
    judgements = {box.name: [each.boxes[box.name] for each in diagnoses if box.name in each.boxes] for box in description.boxes}
    return replace(content, verdicts=verdicts, judgements=judgements)


def shown_topics(boxes: Iterable[str]) -> list[Topic]:
    """Return the topics that are shown of a vehicle with some boxes."""
    each = [topic.below(box_path(name)) for name in boxes for topic in (VIBRATION, FEATURES, ENVELOPE_SPECTRUM)]
    return [*each, VEHICLE_DESCRIPTION, VEHICLE_TRUTH, VEHICLE_DIAGNOSIS]


def content_of(received: MutableMapping[Topic, list[bytes]], description: VehicleDescription, title: str) -> VehicleContent:
    """Return the content of messages by topic; those with waveforms are removed from ``received``."""
    waveforms, features, judgements = dict[str, TimedWaveform](), dict[str, Series](), dict[str, Sequence[Diagnosis]]()
    for box in description.boxes:
        blocks = received.pop(VIBRATION.below(box.name), ())
        if blocks:
            time_ns, acceleration, angle = decode_waveform(blocks)
            waveforms[box.name] = TimedWaveform(time_ns, acceleration, angle, description.sampling_rate)
        series = series_of(received.get(FEATURES.below(box.name), ()))
        if series is not None:
            features[box.name] = series
        judgements[box.name] = spectra_in(received.get(ENVELOPE_SPECTRUM.below(box.name), ()))
    events = tuple(event for data in received.get(VEHICLE_TRUTH, ()) for event in events_in(data))
    verdicts = tuple(verdicts_in(received.get(VEHICLE_DIAGNOSIS, ())))
    return VehicleContent(title, description, waveforms, features, verdicts, events, judgements)


def events_in(data: bytes) -> list[TrackEvent]:
    """Return the events in the ground truth of a vehicle."""
    listed = []
    for status in decode_diagnostics(data)[1]:
        if status.name.startswith("events/"):
            values = status.values
            try:
                time, place, jump = (float(values.get(key, "nan")) for key in ("time", "place", "jump"))
                listed.append(TrackEvent(round(time * 1e9), status.message, values.get("box", ""), place, jump))
            except ValueError:
                raise Refusal(f"the event '{status.message}' in the ground truth of the vehicle has no time and place") from None
    return listed


def verdicts_in(messages: Iterable[bytes]) -> list[Verdicts]:
    """Return the verdicts in messages of a comparing detector."""
    decoded = (decode_diagnostics(data) for data in messages)
    return [Verdicts(time_ns, {status.name: status for status in statuses}) for time_ns, statuses in decoded]


def diagnoses_of(
    content: VehicleContent,
    ranges: Mapping[str, Sequence[tuple[int, float]]] = MappingProxyType({}),
    readings: Mapping[str, TemperatureReadings] = MappingProxyType({}),
    heat_time_lapse: float = 1.0,
) -> list[VehicleDiagnosis]:
    """Return the diagnoses of the waveforms by the shipped comparing detector.

    ``ranges`` are those of the sensor of each box [m/s^2] after the times from which they are in effect [ns], and ``readings`` its
    temperatures. The parameters are the default ones, but for the ``heat_time_lapse`` of the bench [-].
    """
    boxes = {name: _pieces_of(waveform, ranges.get(name, ())) for name, waveform in content.waveforms.items()}
    parameters = DetectorParameters().model_copy(update={"heat_time_lapse": heat_time_lapse})
    return list(detection.diagnoses_of(boxes, VehicleDetector(content.description, box_parameters=parameters), readings))


def _pieces_of(waveform: TimedWaveform, ranges: Sequence[tuple[int, float]]) -> Iterator[Piece]:
    """Yield pieces of a waveform, none of them across missing samples or a change of the ranges."""
    begins, limits = np.searchsorted(waveform.time_ns, [time_ns for time_ns, _ in ranges]), [0.0, *(limit for _, limit in ranges)]
    for part in pieces(waveform, max(1, len(waveform.time_ns))):
        within = begins[(begins > part.start) & (begins < part.stop)].tolist()
        for first, last in pairwise([part.start, *within, part.stop]):
            index, limit = index_at(int(waveform.time_ns[first]), waveform.rate), limits[np.searchsorted(begins, first, "right")]
            yield Piece(index, waveform.acceleration[first:last], waveform.shaft_angle[first:last], limit)


def lead_times(description: VehicleDescription, name: str, waveform: TimedWaveform, before: TimedWaveform | None = None) -> Times:
    """Return when the leading wheelset was where a box is at each of its samples, by the rolling of its wheels, shape (samples,) [ns].

    Rails excite all boxes of a side at the same place, so the waveforms of a side agree over this time, except for what belongs to a box.
    The part of the waveform ``before`` is known, too.
    """
    axle = description.axle(description.box(name).axle)
    behind = max(other.x for other in description.axles) - axle.x
    whole = joined(before, waveform, *PARTS)
    distance: Floats = axle.wheel_radius * np.unwrap(whole.shaft_angle.astype(np.float64))
    if behind == 0.0 or not np.isfinite(distance).all() or distance[-1] <= distance[0]:
        return waveform.time_ns
    times, sought = whole.time_ns.astype(np.float64), distance - behind
    earlier = np.interp(sought, distance, times)
    # Before the part that is known, the vehicle is taken to run at the mean speed of that part.
    speed = (distance[-1] - distance[0]) / (times[-1] - times[0])
    early = sought < distance[0]
    earlier[early] = times[0] - (distance[0] - sought[early]) / speed
    return np.rint(earlier[-len(waveform.time_ns) :]).astype(np.int64)
