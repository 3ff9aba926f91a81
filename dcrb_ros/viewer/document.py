"""From the content of a recording to a Rerun file."""

from __future__ import annotations

from pathlib import Path

import rerun as rr

from dcrb_ros.viewer import bearing_picture, blueprint, loading_zone, order_map, series, spectrum_picture, summary
from dcrb_ros.viewer.content import Content
from dcrb_ros.viewer.drawing import Drawing
from dcrb_ros.viewer.spectrum import envelope_spectra, fault_combs

APPLICATION = "dcrb"


def write_document(content: Content, path: Path, *, native: tuple[Path, ...] = (), picture_only: bool = False) -> None:
    """Write ``content`` with its arrangement as a Rerun file, together with the topics of ``native`` MCAP files as they are."""
    drawing = bearing_picture.drawing_of(content, content.motion) if content.motion else None
    arrangement = blueprint.compose(content, drawing, picture_only=picture_only)
    with rr.RecordingStream(APPLICATION) as recording:
        recording.save(path, default_blueprint=arrangement)
        for file in native:
            recording.log_file_from_path(file)
        log_content(content, drawing)
        recording.disconnect()


def log_content(content: Content, drawing: Drawing | None) -> None:
    """Log all that is shown into the current recording."""
    rr.log("summary", rr.TextDocument(summary.markdown(content), media_type="text/markdown"), static=True)
    series.log_waveform(content.waveform)
    series.log_truth(content)
    series.log_series("features", content.features)
    series.log_series("indicators", content.indicators)
    series.log_verdicts(content.verdicts)
    if content.motion and drawing:
        bearing_picture.log_bearing(content, content.motion, drawing)
        loading_zone.log_loading_zone(content, content.motion, drawing.largest_force)
        series.log_motion(content, content.motion)
    spectra = envelope_spectra(content.diagnoses)
    if spectra is not None:
        combs = fault_combs(content.orders, spectra.highest_order)
        spectrum_picture.log_spectra(spectra, combs, content.start_ns)
        order_map.log_order_map(spectra, combs)
