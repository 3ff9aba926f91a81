"""Writing of a recording's content to a Rerun file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import rerun as rr
from rerun.chunk import McapReader

from dcrb_ros.messages.topics import FAULT_INDICATORS, FEATURES, VIBRATION
from dcrb_ros.viewer import bearing_picture, blueprint, load_zone, order_map, series, spectrum_picture, summary
from dcrb_ros.viewer.content import Content
from dcrb_ros.viewer.drawing import Drawing
from dcrb_ros.viewer.spectrum import envelope_spectra

APPLICATION = "dcrb"
REDRAWN = (VIBRATION, FEATURES, FAULT_INDICATORS)
"""Topics that are logged here in full, so that Rerun need not log them again."""


def write_document(content: Content, path: Path, *, native: tuple[Path, ...] = (), picture_only: bool = False) -> None:
    """Write ``content`` and its arrangement to a Rerun file, together with the other topics of the MCAP files ``native``.

    Raises:
        OSError: not all of it was written.
    """
    drawing = bearing_picture.drawing_of(content, content.motion) if content.motion else None
    with written(path, native) as recording:
        log_content(content, drawing)
        log_detector_output(content)
        recording.send_blueprint(blueprint.compose(content, drawing, picture_only=picture_only))


@contextmanager
def written(path: Path, native: Iterable[Path]) -> Iterator[rr.RecordingStream]:
    """Write to a Rerun file what is logged in the context, and the other topics of the MCAP files ``native``.

    Raises:
        OSError: not all of it was written.
    """
    with rr.RecordingStream(APPLICATION) as recording:
        # To a file, Rerun would only log a failed write, or wait without end.
        stream = recording.binary_stream()
        try:
            # Rerun reads the files in threads of its own, parallel to the logging in the context.
            with ThreadPoolExecutor(1, "native") as pool:
                reading = pool.submit(log_native, recording, native)
                yield recording
                reading.result()
        finally:
            data = stream.read()  # Rerun would report what remains
        recording.disconnect()
    path.write_bytes(data or b"")


def log_native(recording: rr.RecordingStream, files: Iterable[Path]) -> None:
    """Log the topics of MCAP files with Rerun's own reader, except `REDRAWN`."""
    for file in files:
        reader = McapReader(file, exclude_topic_regex=[f"/{topic.name}$" for topic in REDRAWN])
        recording.send_chunks(reader.stream())


def log_content(content: Content, drawing: Drawing | None) -> None:
    """Log everything that does not depend on the detector to the current recording."""
    series.log_waveform(content.waveform)
    series.log_truth(content)
    if content.tacho is not None:
        series.log_tacho(content.tacho)
    series.log_series("features", content.features)
    if content.lubrication is not None:
        series.log_lubrication(content.lubrication)
    if content.motion and drawing:
        bearing_picture.log_bearing(content, content.motion, drawing)
        load_zone.log_load_zone(content, content.motion, drawing.largest_force)
        series.log_motion(content, content.motion)


def log_detector_output(content: Content) -> None:
    """Log the summary page, the indicators, the verdicts and the spectra of the detector."""
    summary.log_summary(content)
    output = content.detector_output
    series.log_series("indicators", output.indicators)
    series.log_verdicts(output.verdicts)
    spectra = envelope_spectra(output.diagnoses)
    if spectra is not None:
        spectrum_picture.log_spectra(spectra, content.orders, content.start_ns)
        order_map.log_order_map(spectra, content.orders)
