"""A vehicle in Rerun: plan view, waveforms aligned by the wheelbase, spectra of the boxes, events on the track."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import rerun as rr

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.messages.statuses import ERROR, OK
from dcrb_ros.viewer import palette, plan_view, series, spectrum_picture
from dcrb_ros.viewer.columns import TIMELINE
from dcrb_ros.viewer.content import TimedWaveform
from dcrb_ros.viewer.document import written
from dcrb_ros.viewer.spectrum import envelope_spectra
from dcrb_ros.viewer.vehicle_blueprint import ALIGNED, SPECTRA, compose
from dcrb_ros.viewer.vehicle_content import TrackEvent, VehicleContent, Verdicts, lead_times

COLOURS = (palette.WAVEFORM, (255, 170, 64, 255), (110, 214, 130, 255), (232, 110, 196, 255))
"""Colours of the wheelsets, the leading one first."""


def write_vehicle_document(content: VehicleContent, path: Path, *, native: tuple[Path, ...] = (), picture_only: bool = False) -> None:
    """Write a vehicle and the arrangement of its views to a Rerun file, with the other topics of the MCAP files ``native``.

    Raises:
        OSError: not all of it was written.
    """
    with written(path, native) as recording:
        log_vehicle(content)
        log_spectra(content)
        recording.send_blueprint(compose(content, picture_only=picture_only))


def log_vehicle(
    content: VehicleContent,
    *,
    fixed: bool = True,
    before: Mapping[str, TimedWaveform] | None = None,
    largest: float | None = None,
    verdicts: dict[str, str] | None = None,
) -> None:
    """Log everything but spectra to the current recording.

    Args:
        content: the vehicle, or a part of its run.
        fixed: whether to log what does not move; false for later parts.
        before: the waveforms before this part.
        largest: the level of the brightest colour [m/s^2]; that of this part by default.
        verdicts: the verdicts before this part by the names of the parts of the vehicle, which are replaced by the last ones of this part.
    """
    if fixed:
        plan_view.log_fixed(content.description)
    plan_view.log_levels(content.description, content.features, largest_level(content) if largest is None else largest)
    plan_view.log_verdicts(content.description, content.verdicts, content.start_ns if fixed else None)
    plan_view.log_events(content.description, content.events)
    log_waveforms(content, fixed=fixed, before=before or {})
    log_texts(content.verdicts, content.events, {} if verdicts is None else verdicts)


def largest_level(content: VehicleContent) -> float:
    """Return the level of the brightest colour [m/s^2]."""
    columns = [s.values[:, s.names.index("rms")] for s in content.features.values() if "rms" in s.names]
    return max((float(column.max(initial=0.0)) for column in columns), default=0.0) or 1.0


def log_waveforms(content: VehicleContent, *, fixed: bool, before: Mapping[str, TimedWaveform]) -> None:
    """Log the vertical acceleration of each box over the time at which the leading wheelset was at the same place [m/s^2]."""
    leading_first = [axle.name for axle in sorted(content.description.axles, key=lambda axle: -axle.x)]
    for box in content.description.boxes:
        if box.name not in content.waveforms:
            continue
        waveform, number = content.waveforms[box.name], leading_first.index(box.axle)
        vertical = waveform.acceleration[:, 1:2] if waveform.acceleration.shape[1] > 1 else waveform.acceleration[:, :1]
        colour, path = COLOURS[number % len(COLOURS)], f"{ALIGNED}/{box.side}/{box.axle}"
        times = lead_times(content.description, box.name, waveform, before.get(box.name))
        series.log_lines(path, times, vertical, [box.name], [colour], width=1.0, fixed=fixed)
        series.log_lines(f"waveform/{box.name}", waveform.time_ns, vertical, [box.name], [colour], width=1.0, fixed=fixed)


def log_texts(verdicts: Sequence[Verdicts], events: Sequence[TrackEvent], before: dict[str, str]) -> None:
    """Log the events on the track, and each verdict when it changes; ``before`` has those logged last, by the names of their parts."""
    for event in events:
        rr.set_time(TIMELINE, timestamp=np.datetime64(event.time_ns, "ns"))
        text = f"{event.cause} at {event.where}, {event.place:.2f} m: {event.jump:.3f} m/s"
        rr.log("events", rr.TextLog(text, level=rr.TextLogLevel.INFO))
    levels = {OK: rr.TextLogLevel.INFO, ERROR: rr.TextLogLevel.ERROR}
    for verdict in verdicts:
        rr.set_time(TIMELINE, timestamp=np.datetime64(verdict.time_ns, "ns"))
        for name, status in verdict.statuses.items():
            if before.get(name) != status.message:
                text = f"{name}: {status.message.replace('_', ' ')}. {status.values.get('reason', '')}"
                rr.log("verdicts", rr.TextLog(text, level=levels.get(status.level, rr.TextLogLevel.WARN)))
                before[name] = status.message


def log_spectra(content: VehicleContent) -> None:
    """Log the squared envelope spectra of each box with its fault lines."""
    for box in content.description.boxes:
        spectra = envelope_spectra(content.judgements.get(box.name, ()))
        if spectra is not None:
            orders = Orders.from_dict(dict(box.orders))
            spectrum_picture.log_spectra(spectra, orders, content.start_ns, root=f"{SPECTRA}/{box.name}")


def picture_time(content: VehicleContent) -> int:
    """Return the time of the last event in the last third of the recording, or else its beginning [ns]."""
    begin = content.start_ns + 2 * (content.end_ns - content.start_ns) // 3
    flats = [event.time_ns for event in content.events if event.cause == "flat" and begin <= event.time_ns <= content.end_ns]
    others = [event.time_ns for event in content.events if begin <= event.time_ns <= content.end_ns]
    return (flats or others or [begin])[-1] + 10_000_000
