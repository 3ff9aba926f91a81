"""Messages that wait to be shown, and a run of a bench in a growing Rerun recording: fixed shapes come once, moving ones are added."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import rerun as rr

from dcrb_ros.messages.cdr import STAMP_END, stamps
from dcrb_ros.messages.topics import Topic
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.viewer import bearing_picture, load_zone, order_map, series, spectrum_picture, summary
from dcrb_ros.viewer.blueprint import compose_live
from dcrb_ros.viewer.content import BenchInfo, Content, DetectorOutput, Motion, TimedWaveform, joined
from dcrb_ros.viewer.drawing import Drawing, rounded_up
from dcrb_ros.viewer.reader import Decoded
from dcrb_ros.viewer.row_faults import RowFaults
from dcrb_ros.viewer.spectrum import Spectra, envelope_spectra

MOST_QUEUED = 2000
"""Messages of a topic kept until they are logged, at most [-]."""
RECENT = 1000
"""Number of latest states from which the mean forces in the load zone are computed [-]."""
MOST_SPECTRA = 300
"""Spectra in the order map at most [-]; it has about as many rows of pixels."""
EARLY_NS = 200_000_000
"""Simulated time after a reset whose messages may arrive before it is noticed [ns]."""
HEADROOM = 1.25
"""Largest force over the end of the force scale before a new scale is drawn [-]."""

LONGEST_FLUSH = 30.0
"""Wall time in which Rerun must write what is left [s]: after a failed write it may never answer."""


class ReceivedMessages(ABC):
    """Keeps messages until they are logged; after a reset a new Rerun recording is started."""

    def __init__(self, begin: Callable[[int], rr.RecordingStream], title: str, log: Callable[[str], object]) -> None:
        """Log to the stream that ``begin`` returns for a run number; ``log`` is called with warnings about invalid messages."""
        self._begin, self._title, self._log = begin, title, log
        self._received: dict[Topic, list[bytes]] = defaultdict(list)
        self._runs = self._newest_ns = 0
        self.refused = 0
        """Number of batches on a topic with an invalid message."""

    def _keep(self, topic: Topic, data: bytes) -> None:
        """Keep a message; if there are more than `MOST_QUEUED` on its topic, the oldest is dropped."""
        queue = self._received[topic]
        queue.append(data)
        if len(queue) > MOST_QUEUED:
            del queue[0]

    def _check_time(self, stamp_ns: int) -> None:
        """Close the recording if the simulated time has gone back; messages of the new run that arrived before are kept for it."""
        if stamp_ns < self._newest_ns:
            early = {topic: [data for data in queue if self._is_early(data, stamp_ns)] for topic, queue in self._received.items()}
            for topic, queue in early.items():
                self._received[topic] = [data for data in self._received[topic] if data not in queue]
            self.close()
            self._received.update(early)
        self._newest_ns = stamp_ns

    def _is_early(self, data: bytes, stamp_ns: int) -> bool:
        """Return whether a message is of the run that begins at a time [ns], and not of the one before."""
        latest = stamp_ns + EARLY_NS
        return self._newest_ns > latest and len(data) >= STAMP_END and int(stamps([data])[0]) <= latest

    @abstractmethod
    def close(self) -> None:
        """Log the remaining messages and close the recording."""

    def _sound(self, decode: Callable[[Sequence[bytes]], Decoded], messages: Sequence[bytes]) -> Decoded:
        """Return the decoded messages on a topic, or those of none if one is invalid."""
        try:
            return decode(messages)
        except Refusal as refusal:
            self._refuse(refusal)
            return decode(())

    def _next_stream(self) -> rr.RecordingStream:
        self._runs += 1
        return self._begin(self._runs)

    def _refuse(self, refusal: Refusal) -> None:
        """Warn of the first invalid message, the second, the fourth and so on."""
        self.refused += 1
        if self.refused & (self.refused - 1) == 0:
            self._log(f"not shown: {refusal} ({self.refused} so far)")


class LiveRun:
    """A run of the bench from its start, or from a reset."""

    def __init__(self, stream: rr.RecordingStream, bench: BenchInfo) -> None:
        self._stream, self._bench = stream, bench
        self._drawing = None if bench.imported else Drawing(bench.bearing, 1.0)
        self._logged: set[str] = set()
        self._lubricated = self._warm = False
        """Whether films, and temperatures, have arrived and have a plot."""
        self._faults: list[RowFaults | None] = [None] * bench.bearing.rows
        self._largest_load = 0.0
        self._tacho_ns = -1
        """Time of the last speed of the tacho that was logged [ns]."""
        self._recent: Motion | None = None
        self._spectra: Spectra | None = None
        self._growing = spectrum_picture.GrowingSpectra(bench.orders)
        nothing = TimedWaveform(np.zeros(2, np.int64), np.zeros((2, 2), np.float32), np.zeros(2, np.float32), bench.rate)
        self._latest = Content(**vars(bench), waveform=nothing, pending_output=completed(DetectorOutput(None, (), ())))
        stream.send_blueprint(compose_live(self._drawing))

    def log(self, content: Content) -> None:
        """Log new content."""
        with as_current(self._stream):
            self._log_plots(content)
            if content.motion is not None and self._drawing is not None:
                self._log_motion(content, content.motion)
            self._log_truth(content)
            self._log_spectra(content)
            self._log_summary(content)

    def close(self) -> None:
        """Send everything to the viewer or write it to the file."""
        self._stream.flush(timeout_sec=LONGEST_FLUSH)
        self._stream.disconnect()

    def _first(self, name: str) -> bool:
        """Return whether something is logged for the first time."""
        first = name not in self._logged
        self._logged.add(name)
        return first

    def _log_plots(self, content: Content) -> None:
        if len(content.waveform.time_ns):
            series.log_waveform(content.waveform, fixed=self._first("waveform"))
        if content.truths:
            series.log_truth(content, fixed=self._first("operating"))
        if content.tacho is not None and (new := content.tacho.time_ns > self._tacho_ns).any():
            tacho = replace(content.tacho, time_ns=content.tacho.time_ns[new], values=content.tacho.values[new])
            series.log_tacho(tacho, fixed=self._first("tacho"))
            self._tacho_ns = int(tacho.time_ns[-1])
        for path, values in (("features", content.features), ("indicators", content.detector_output.indicators)):
            if values is not None:
                series.log_series(path, values, fixed=self._first(path))
        lubricated, warm = self._lubricated or content.lubrication is not None, self._warm or series.is_warm(content.truths)
        if (lubricated, warm) != (self._lubricated, self._warm):
            self._lubricated, self._warm = lubricated, warm
            self._stream.send_blueprint(compose_live(self._drawing, lubricated=lubricated, warm=warm))
        if content.lubrication is not None:
            series.log_lubrication(content.lubrication, fixed=self._first("lubrication"))
        series.log_verdicts(content.detector_output.verdicts)

    def _log_motion(self, content: Content, motion: Motion) -> None:
        drawing = self._scaled(motion)
        if self._first("bearing"):
            bearing_picture.log_static(drawing)
        series.log_motion(content, motion, fixed=self._first("motion"))
        shown = bearing_picture.thinned(motion)
        bearing_picture.log_moving(drawing, shown)
        self._recent = joined(self._recent, shown, "time_ns", "azimuth", "speed", "force", last=RECENT)
        load_zone.log_mean(content.bodies, self._recent, drawing.largest_force)
        load_zone.log_now(content.bodies, shown, drawing.largest_force)

    def _scaled(self, motion: Motion) -> Drawing:
        """Return the drawing, with a new scale if a force exceeds it; bars already drawn keep their length."""
        assert self._drawing is not None
        largest = bearing_picture.drawing_of(self._latest, motion).largest_force
        if largest > HEADROOM * self._drawing.largest_force:
            self._drawing = Drawing(self._drawing.bearing, rounded_up(largest))
            bearing_picture.log_force_scale(self._drawing)
            load_zone.log_static(self._latest.bodies, self._drawing.largest_force)
        return self._drawing

    def _log_truth(self, content: Content) -> None:
        if self._drawing is None or not content.truths:
            return
        truths = content.truths
        self._largest_load = max(self._largest_load, *(math.hypot(*truth.load) for truth in truths))
        bearing_picture.log_load(self._drawing, truths, self._largest_load)
        for row, shown in enumerate(self._faults):
            self._faults[row] = bearing_picture.log_faults(self._drawing, row, truths, truths[0].time_ns, shown)

    def _log_spectra(self, content: Content) -> None:
        spectra = envelope_spectra(content.detector_output.diagnoses)
        if spectra is None:
            return
        if self._growing.log(spectra):
            order_map.log_fault_lines(spectra.highest_order, self._bench.orders)
        before = self._spectra if self._spectra is not None and np.array_equal(self._spectra.orders, spectra.orders) else None
        self._spectra = joined(before, spectra, "time_ns", "level", "shaft_frequency", last=MOST_SPECTRA)
        order_map.log_map(self._spectra)

    def _log_summary(self, content: Content) -> None:
        """Log the summary page again, with the latest values."""
        ends = self._latest.waveform.time_ns
        if len(content.waveform.time_ns):
            ends = np.array([ends[0] if "summary" in self._logged else content.start_ns, content.end_ns])
        output = DetectorOutput(None, content.detector_output.verdicts[-1:] or self._latest.detector_output.verdicts, ())
        self._latest = replace(
            self._latest,
            waveform=replace(self._latest.waveform, time_ns=ends),
            truths=content.truths[-1:] or self._latest.truths,
            pending_output=completed(output),
        )
        self._first("summary")
        page = summary.markdown(self._latest, self._latest.truths[-1] if self._latest.truths else None)
        rr.log("summary", rr.TextDocument(page, media_type="text/markdown"), static=True)


@contextmanager
def as_current(stream: rr.RecordingStream) -> Iterator[None]:
    """Make a stream the current recording; Rerun's own context manager would close the file each time."""
    previous = rr.set_thread_local_data_recording(stream)
    try:
        yield
    finally:
        rr.set_thread_local_data_recording(previous)


def completed(output: DetectorOutput) -> Future[DetectorOutput]:
    """Return a future with an output that is already available."""
    future: Future[DetectorOutput] = Future()
    future.set_result(output)
    return future
