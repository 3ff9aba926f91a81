"""The summary page of the viewer: the recording, its ground truth and the detector's verdict."""

from __future__ import annotations

import math
from collections.abc import Iterator

from dcrb_ros.faults.ground_truth import words_of
from dcrb_ros.schema.verdicts import TITLES
from dcrb_ros.stream.block import Truth
from dcrb_ros.viewer.content import Content


def markdown(content: Content) -> str:
    """Return the summary page in Markdown."""
    return "\n".join(_lines(content))


def _lines(content: Content) -> Iterator[str]:
    bearing, seconds = content.bearing, (content.end_ns - content.start_ns) / 1e9
    yield f"| Recording | {content.title}, {seconds:.2f} s at {content.waveform.rate / 1e3:g} kHz |\n|---|---|"
    verdict = content.detector_output.verdicts[-1] if content.detector_output.verdicts else None
    if verdict:
        yield f"| Detector's verdict | **{TITLES.get(verdict.name, verdict.name)}** |"
    if content.truths:
        truth = content.truths[-1]
        yield f"| Ground truth | {', '.join(_faults(truth)) or 'no fault'} |"
        yield f"| Speed, load | {truth.speed * 30 / math.pi:.1f} rpm, {math.hypot(*truth.load) / 1e3:.4g} kN |"
        yield f"| Fault frequencies | {', '.join(f'{name} {value:.2f}' for name, value in truth.frequencies.items())} Hz |"
    if content.imported:
        yield f"| Imported data | BPFO {content.orders.bpfo:.4g}, BPFI {content.orders.bpfi:.4g} orders |"
    else:
        diameter, pitch = 2e3 * bearing.roller_radius, 2e3 * bearing.pitch_radius
        yield f"| Bearing | {bearing.rows} x {bearing.rollers_per_row} rollers of {diameter:g} mm on a pitch circle of {pitch:g} mm |"
    if verdict and verdict.evidence.get("reason"):
        yield f"\nReason: {verdict.evidence['reason']}."


def _faults(truth: Truth) -> Iterator[str]:
    for name, fault in sorted(truth.faults.items()):
        row = int(fault.get("row", 0))
        where = f"row {row}" if row else "both rows"
        yield f"{words_of(name, fault)}, {where}"
