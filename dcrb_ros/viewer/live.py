"""A running bench in Rerun: what its topics say is logged as it comes, some tenths of a second at a time."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence

import rerun as rr

from dcrb_ros.diagnosis.detector import Diagnosis
from dcrb_ros.messages.cdr import STAMP_END, stamps
from dcrb_ros.messages.description import decode_sensor
from dcrb_ros.messages.plain import decode_text
from dcrb_ros.messages.points import decode_spectrum
from dcrb_ros.messages.topics import (
    DIAGNOSIS,
    ENVELOPE_SPECTRUM,
    FAULT_INDICATORS,
    FEATURES,
    GROUND_TRUTH,
    ROLLER_STATES,
    SENSOR,
    VIBRATION,
    Topic,
)
from dcrb_ros.runtime.refusal import Refusal
from dcrb_ros.settings.parameters import Bearing
from dcrb_ros.viewer.content import Judgement, Subject
from dcrb_ros.viewer.live_run import LiveRun, known
from dcrb_ros.viewer.reader import content_of, series_of, verdicts_in

SHOWN = (VIBRATION, SENSOR, ROLLER_STATES, GROUND_TRUTH, FEATURES, FAULT_INDICATORS, DIAGNOSIS, ENVELOPE_SPECTRUM)
MOST_WAITING = 2000
"""Messages of a topic that wait to be logged."""


class LiveView:
    """The messages of a running bench on their way to Rerun; a reset of the bench begins another Rerun recording."""

    def __init__(self, begin: Callable[[int], rr.RecordingStream], title: str, log: Callable[[str], object]) -> None:
        """Log to what ``begin`` returns for the number of the run; what is not understood is told to ``log``."""
        self._begin, self._title, self._log = begin, title, log
        self._heard: dict[Topic, list[bytes]] = defaultdict(list)
        self._subject: Subject | None = None
        self._run: LiveRun | None = None
        self._runs = self._newest_ns = 0
        self.refused = 0
        """Batches with a message that was not understood."""

    def take(self, topic: Topic, data: bytes) -> None:
        """Keep a message until the next `flush`; of too many the oldest are left out."""
        if topic is not SENSOR and len(data) < STAMP_END:
            self._refuse(Refusal(f"a message on {topic.name} of {len(data)} bytes has no stamp"))
            return
        if topic is VIBRATION:
            self._heed_time(int(stamps([data])[0]))
        waiting = self._heard[topic]
        waiting.append(data)
        if len(waiting) > MOST_WAITING:
            del waiting[0]

    def flush(self) -> None:
        """Log what has come, once it is known what the bench is."""
        heard, self._heard = self._heard, defaultdict(list)
        try:
            if heard[SENSOR]:
                self._subject = subject_of(heard[SENSOR][-1], self._title)
            if self._subject is None:
                self._heard = heard
                return
            content = content_of(heard, self._subject, lambda _: known(judgement_in(heard)))
            self._current(self._subject).log(content)
        except Refusal as refusal:
            self._refuse(refusal)

    def close(self) -> None:
        """Log the rest and end."""
        self.flush()
        if self._run is not None:
            self._run.close()

    def _current(self, subject: Subject) -> LiveRun:
        if self._run is None:
            self._runs += 1
            self._run = LiveRun(self._begin(self._runs), subject)
        return self._run

    def _heed_time(self, stamp_ns: int) -> None:
        """Begin another run where time has run back."""
        if stamp_ns < self._newest_ns:
            self.flush()
            if self._run is not None:
                self._run.close()
            self._run = None
        self._newest_ns = stamp_ns

    def _refuse(self, refusal: Refusal) -> None:
        self.refused += 1
        if self.refused & (self.refused - 1) == 0:
            self._log(f"not shown: {refusal} ({self.refused} so far)")


def subject_of(data: bytes, title: str) -> Subject:
    """Return what the bench is from the description of its sensor.

    Raises:
        Refusal: it is not understood.
    """
    rate, orders = decode_sensor(data)
    try:
        described = json.loads(decode_text(data)).get("bearing")
        bearing = Bearing.model_validate(described) if described else Bearing()
    except (ValueError, AttributeError) as error:
        raise Refusal(f"the bearing in the sensor's description is not understood ({type(error).__name__})") from None
    return Subject(title, bearing, orders, rate, imported=not described)


def judgement_in(heard: Mapping[Topic, Sequence[bytes]]) -> Judgement:
    """Return what the bench's fault detector says in its messages."""
    spectra = [decode_spectrum(data) for data in heard.get(ENVELOPE_SPECTRUM, ())]
    return Judgement(
        indicators=series_of(heard.get(FAULT_INDICATORS, ())),
        verdicts=verdicts_in(heard.get(DIAGNOSIS, ())),
        diagnoses=tuple(
            Diagnosis(0, time_ns * 1e-9, "waiting", "", shaft_frequency=frequency, spectrum=(orders, amplitude))
            for time_ns, orders, amplitude, frequency in spectra
        ),
    )
