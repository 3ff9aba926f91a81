"""The summary page of the viewer: the recording, its ground truth and the detector's verdict."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
import rerun as rr

from dcrb_ros.faults.ground_truth import words_of
from dcrb_ros.stream.block import Truth
from dcrb_ros.viewer.columns import time_column
from dcrb_ros.viewer.content import Content
from dcrb_ros.viewer.series import DEGREES

MOST_PAGES = 400
"""Largest number of summary pages of a recording, without those where a fault comes or goes [-]."""


def log_summary(content: Content) -> None:
    """Log the summary page over time, with the ground truth at the cursor."""
    times, pages = [content.start_ns], [markdown(content, content.truths[0] if content.truths else None)]
    for truth in shown_truths(content.truths):
        page = markdown(content, truth)
        if page != pages[-1]:
            times.append(truth.time_ns)
            pages.append(page)
    documents = rr.TextDocument.columns(text=pages, media_type=["text/markdown"] * len(pages))
    rr.send_columns("summary", [time_column(np.array(times, np.int64))], documents)


def shown_truths(truths: Sequence[Truth], most: int = MOST_PAGES) -> Iterator[Truth]:
    """Yield at most ``most`` ground truths at equal distances, and those with which a fault comes or goes."""
    every = math.ceil(len(truths) / most) or 1
    faults: set[str] = set()
    for k, truth in enumerate(truths):
        if k % every == 0 or set(truth.faults) != faults:
            yield truth
        faults = set(truth.faults)


def markdown(content: Content, truth: Truth | None) -> str:
    """Return the summary page with a ground truth in Markdown."""
    return "\n".join(_lines(content, truth))


def _lines(content: Content, truth: Truth | None) -> Iterator[str]:
    bearing, seconds = content.bearing, (content.end_ns - content.start_ns) / 1e9
    yield f"| Recording | {content.title}, {seconds:.2f} s at {content.waveform.rate / 1e3:g} kHz |\n|---|---|"
    verdict = content.detector_output.verdicts[-1] if content.detector_output.verdicts else None
    if verdict:
        yield f"| Detector's verdict | **{verdict.title}** |"
    if truth:
        yield f"| Ground truth | {', '.join(_faults(truth, bearing.rows)) or 'no fault'} |"
        yield f"| Speed, load | {truth.speed * 30 / math.pi:.1f} rpm, {math.hypot(*truth.load) / 1e3:.4g} kN |"
        yield f"| Fault frequencies | {', '.join(f'{name} {value:.2f}' for name, value in truth.frequencies.items())} Hz |"
        if truth.thermal:
            yield f"| Temperatures | {', '.join(_temperatures(truth))} °C |"
            lapse = truth.thermal.get("acceleration", 1.0)
            if lapse > 1.0:
                yield f"| Time lapse | heat is stored {lapse:g} times as fast |"
    if content.imported:
        yield f"| Imported data | BPFO {content.orders.bpfo:.4g}, BPFI {content.orders.bpfi:.4g} orders |"
    else:
        diameter, pitch = 2e3 * bearing.own_roller_radius, 2e3 * bearing.pitch_radius
        elements = f"{bearing.rows} x {bearing.rollers_per_row} rolling elements"
        yield f"| Bearing | {elements} of {diameter:g} mm on a pitch circle of {pitch:g} mm |"
    if verdict and verdict.evidence.get("reason"):
        yield f"\nReason: {verdict.evidence['reason']}."


def _temperatures(truth: Truth) -> Iterator[str]:
    """Yield the warmest of the rings of all rows and of their rollers, box and ambient."""
    for part in ("inner_ring", "rollers", "outer_ring", "box", "ambient"):
        values = [value for name, value in truth.thermal.items() if name.removesuffix(DEGREES).split("/")[-1] == part]
        if values:
            yield f"{part.replace('_', ' ')} {max(values):.1f}"


def _faults(truth: Truth, rows: int) -> Iterator[str]:
    for name, fault in sorted(truth.faults.items()):
        row = int(fault.get("row", 0))
        where = "" if rows == 1 or "row" not in fault else f", row {row}" if row else ", both rows"
        yield f"{words_of(name, fault)}{where}"
