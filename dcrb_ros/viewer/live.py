"""The view of a running bench: messages are logged to Rerun as they arrive, in batches of some tenths of a second."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence

import rerun as rr

from dcrb_ros.messages.cdr import STAMP_END, stamps
from dcrb_ros.messages.description import decode_entry, decode_pulses_per_turn, decode_sensor
from dcrb_ros.messages.pulses import decode_pulses
from dcrb_ros.messages.topics import (
    DIAGNOSIS,
    ENVELOPE_SPECTRUM,
    FAULT_INDICATORS,
    SENSOR,
    TACHO,
    VIBRATION,
    Topic,
)
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.parameters import Bearing
from dcrb_ros.viewer.content import BenchInfo, DetectorOutput
from dcrb_ros.viewer.live_run import LiveRun, ReceivedMessages, completed
from dcrb_ros.viewer.reader import SHOWN as RECORDED
from dcrb_ros.viewer.reader import content_of, series_of, verdicts_in
from dcrb_ros.viewer.spectrum import spectra_in

SHOWN = (*RECORDED, SENSOR, ENVELOPE_SPECTRUM)


class LiveView(ReceivedMessages):
    """Logs the messages of a running bench to Rerun; see `ReceivedMessages`."""

    def __init__(self, begin: Callable[[int], rr.RecordingStream], title: str, log: Callable[[str], object]) -> None:
        """Log to the streams that ``begin`` returns; see `ReceivedMessages`."""
        super().__init__(begin, title, log)
        self._bench: BenchInfo | None = None
        self._run: LiveRun | None = None
        self._pulses: list[bytes] = []
        """The last message with pulses of the tacho, from which the next speed follows."""

    def take(self, topic: Topic, data: bytes) -> None:
        """Keep a message until the next `flush`."""
        if topic is not SENSOR and len(data) < STAMP_END:
            self._refuse(Refusal(f"a message on {topic.name} has {len(data)} bytes, too few for a stamp"))
            return
        if topic is VIBRATION:
            self._check_time(int(stamps([data])[0]))
        self._keep(topic, data)

    def flush(self) -> None:
        """Log the received messages, once the sensor has been described."""
        received, self._received = self._received, defaultdict(list)
        self._bench = self._sound(self._described, received.pop(SENSOR, []))
        if self._bench is None:
            self._received = received
            return
        output = DetectorOutput(
            self._sound(series_of, received[FAULT_INDICATORS]),
            self._sound(verdicts_in, received[DIAGNOSIS]),
            self._sound(spectra_in, received[ENVELOPE_SPECTRUM]),
        )
        received[TACHO] = self._pulses + self._sound(_with_pulses, received[TACHO])
        self._pulses = received[TACHO][-1:]
        content = content_of(received, self._bench, lambda _: completed(output), self._sound)
        self._run = self._run or LiveRun(self._next_stream(), self._bench)
        self._run.log(content)

    def _described(self, descriptions: Sequence[bytes]) -> BenchInfo | None:
        """Return the bench in the last of some descriptions of the sensor; without one, the present bench."""
        return bench_info(descriptions[-1], self._title) if descriptions else self._bench

    def close(self) -> None:
        """Log the remaining messages and close the recording."""
        self.flush()
        if self._run is not None:
            self._run.close()
        self._run, self._pulses = None, []


def _with_pulses(messages: Sequence[bytes]) -> list[bytes]:
    """Return the messages of a tacho that have a pulse."""
    return [data for data in messages if len(decode_pulses(data).number)]


def bench_info(data: bytes, title: str) -> BenchInfo:
    """Return the bench described by a message on the sensor.

    Raises:
        Refusal: the description is invalid.
    """
    rate, orders = decode_sensor(data)
    try:
        described = decode_entry(data, "bearing") or {}
        # A bench describes its whole bearing, an import only the geometry from which the orders follow.
        whole = "outer_raceway_radius" in described
        bearing = Bearing.model_validate(described) if whole else Bearing()
    except (ValueError, TypeError) as error:
        raise Refusal(f"the bearing in the sensor's description is invalid ({type(error).__name__})") from None
    return BenchInfo(title, bearing, orders, rate, imported=not whole, pulses_per_turn=decode_pulses_per_turn(data))
