"""One run of a bench in a Rerun recording that grows: what stands still is logged once, what moves is added."""

from __future__ import annotations

import math
from collections.abc import Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import rerun as rr

from dcrb_ros.viewer import bearing_picture, load_zone, order_map, series, spectrum_picture, summary
from dcrb_ros.viewer.blueprint import compose_live
from dcrb_ros.viewer.content import Content, Judgement, Motion, Subject, Waveform
from dcrb_ros.viewer.drawing import Drawing, rounded_up
from dcrb_ros.viewer.fault_words import RowFaults
from dcrb_ros.viewer.spectrum import Spectra, envelope_spectra, fault_combs

RECENT = 1000
"""States of which the mean over the loading zone is taken."""
MOST_SPECTRA = 300
"""Spectra in the order map; it has about as many rows of pixels."""
ROOM = 1.25
"""Largest force that the scale has room for, as a share of its end [-]."""


class LiveRun:
    """A run of the bench from its start, or from a reset."""

    def __init__(self, stream: rr.RecordingStream, subject: Subject) -> None:
        self._stream, self._subject = stream, subject
        self._drawing = None if subject.imported else Drawing(subject.bearing, 1.0)
        self._told: set[str] = set()
        self._faults: list[RowFaults | None] = [None] * subject.bearing.rows
        self._largest_load = 0.0
        self._recent: Motion | None = None
        self._spectra: Spectra | None = None
        self._axes: spectrum_picture.Axes | None = None
        self._known = Content(
            subject.title, subject.bearing, subject.orders, subject.bodies, _nothing(subject), known(Judgement(None, (), ()))
        )
        stream.send_blueprint(compose_live(self._drawing))

    def log(self, content: Content) -> None:
        """Log what has come since the last time."""
        with _current(self._stream):
            self._log_plots(content)
            if content.motion is not None and self._drawing is not None:
                self._log_motion(content, content.motion)
            self._log_truth(content)
            self._log_spectra(content)
            self._log_summary(content)

    def close(self) -> None:
        """Bring everything to the viewer or into the file."""
        self._stream.flush()
        self._stream.disconnect()

    def _first(self, name: str) -> bool:
        """Return whether something is logged for the first time."""
        first = name not in self._told
        self._told.add(name)
        return first

    def _log_plots(self, content: Content) -> None:
        if len(content.waveform.time_ns):
            series.log_waveform(content.waveform, fixed=self._first("waveform"))
        if content.truths:
            series.log_truth(content, fixed=self._first("operating"))
        for path, found in (("features", content.features), ("indicators", content.judgement.indicators)):
            if found is not None:
                series.log_series(path, found, fixed=self._first(path))
        series.log_verdicts(content.judgement.verdicts)

    def _log_motion(self, content: Content, motion: Motion) -> None:
        drawing = self._scaled(motion)
        if self._first("bearing"):
            bearing_picture.log_still(drawing)
        series.log_motion(content, motion, fixed=self._first("motion"))
        shown = bearing_picture.thinned(motion)
        bearing_picture.log_moving(drawing, shown)
        self._recent = _joined(self._recent, shown)
        load_zone.log_mean(content.bodies, self._recent, drawing.largest_force)
        load_zone.log_now(content.bodies, shown, drawing.largest_force)

    def _scaled(self, motion: Motion) -> Drawing:
        """Return the drawing, with a new scale where a force has outgrown it; bars of the past keep their length."""
        assert self._drawing is not None
        largest = bearing_picture.drawing_of(self._known, motion).largest_force
        if largest > ROOM * self._drawing.largest_force:
            self._drawing = Drawing(self._drawing.bearing, rounded_up(largest))
            bearing_picture.log_force_scale(self._drawing)
            load_zone.log_still(self._known.bodies, self._drawing.largest_force)
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
        spectra = envelope_spectra(content.judgement.diagnoses)
        if spectra is None:
            return
        combs = fault_combs(self._subject.orders, spectra.highest_order)
        axes = spectrum_picture.axes_of(spectra)
        if self._axes is None or axes.highest_level > self._axes.highest_level or axes.highest_order != self._axes.highest_order:
            self._axes = axes
            spectrum_picture.log_combs(axes, combs)
            order_map.log_fault_lines(axes.highest_order, combs)
        spectrum_picture.log_axes(self._axes, float(spectra.shaft_frequency[-1]))
        spectrum_picture.log_levels(self._axes, combs, spectra)
        self._spectra = _together(self._spectra, spectra)
        order_map.log_map(self._spectra)

    def _log_summary(self, content: Content) -> None:
        """Log the page beside the pictures anew where it says something else."""
        ends = self._known.waveform.time_ns
        if len(content.waveform.time_ns):
            ends = np.array([ends[0] if "summary" in self._told else content.start_ns, content.end_ns])
        judgement = Judgement(None, content.judgement.verdicts[-1:] or self._known.judgement.verdicts, ())
        self._known = replace(
            self._known,
            waveform=replace(self._known.waveform, time_ns=ends),
            truths=content.truths[-1:] or self._known.truths,
            judging=known(judgement),
            imported=content.imported,
        )
        self._first("summary")
        rr.log("summary", rr.TextDocument(summary.markdown(self._known), media_type="text/markdown"), static=True)


@contextmanager
def _current(stream: rr.RecordingStream) -> Iterator[None]:
    """Let what is logged go to a stream; Rerun's own way would end the file each time."""
    previous = rr.set_thread_local_data_recording(stream)
    try:
        yield
    finally:
        rr.set_thread_local_data_recording(previous)


def known(judgement: Judgement) -> Future[Judgement]:
    """Return a judgement for which nobody has to wait."""
    future: Future[Judgement] = Future()
    future.set_result(judgement)
    return future


def _nothing(subject: Subject) -> Waveform:
    return Waveform(np.zeros(2, np.int64), np.zeros((2, 2), np.float32), np.zeros(2, np.float32), subject.rate)


def _together(before: Spectra | None, after: Spectra) -> Spectra:
    """Return the last spectra of two stretches; where they go up to other orders, those of the latter."""
    if before is None or not np.array_equal(before.orders, after.orders):
        return after
    times, levels, frequencies = (
        np.concatenate([getattr(before, name), getattr(after, name)])[-MOST_SPECTRA:] for name in ("time_ns", "level", "shaft_frequency")
    )
    return Spectra(times, after.orders, levels, frequencies)


def _joined(before: Motion | None, after: Motion) -> Motion:
    """Return the last states of two stretches."""
    if before is None:
        return after
    fields = ("time_ns", "azimuth", "speed", "force")
    return Motion(*(np.concatenate([getattr(before, name), getattr(after, name)])[-RECENT:] for name in fields))
