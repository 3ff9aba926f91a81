"""One self-contained HTML page on the diagnoses of recordings, to be sent to someone or printed."""

from __future__ import annotations

import base64
import io
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from itertools import groupby, islice
from typing import Any, Literal, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from dcrb_ros.bearing.waveform import Piece, Waveform
from dcrb_ros.diagnosis.detection import DetectionResult
from dcrb_ros.diagnosis.envelope_spectrum import envelope_spectrum, trackable
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.plots.envelope_spectrum import plot_envelope_spectrum
from dcrb_ros.plots.style import FAULT_LINES, labelled, legend_above
from dcrb_ros.plots.waveform import plot_waveform
from dcrb_ros.recordings.arrays import joined_waveform
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.verification import recovered, unsigned
from dcrb_ros.runtime.version import __version__
from dcrb_ros.schema.printable import decimal, printable
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.schema.verdicts import CHARACTERISTIC, COMPONENTS, TITLES, is_alarm
from dcrb_ros.stream.diagnosis import Diagnosis

RESOLUTION = 110
"""Resolution of the figures [dots per inch]."""
TOGETHER = 64
"""Blocks of a recording that are measured together [-]."""
LIBRARIES = ("numpy", "scipy", "matplotlib")
"""Libraries whose versions the page states."""
LIMITS = (
    "The verdict is not a measurement of damage: the severity is the strength of the lines in the envelope, not a size.",
    "A healthy verdict means that no rule found evidence in this signal. A small or unloaded defect can stay below every threshold.",
    "On held-out recordings of other rigs, the detector named 58 of 70 healthy bearings and ring defects without a false alarm, but only "
    "1 of 19 defects of rolling elements.",
    "Levels depend on sensor, mounting and path: compare them between recordings of the same measuring point only.",
)
"""What a reader must know about every verdict."""


class Samples(NamedTuple):
    """A range of samples, both ends included."""

    first: int
    """Index of the first sample."""
    last: int
    """Index of the last sample."""

    def __str__(self) -> str:
        return f"{self.first} to {self.last}"


@dataclass(frozen=True)
class Content:
    """What a recording contains, read in one pass."""

    judged: Sequence[Piece]
    """The blocks with the samples on which the last verdict is based."""
    axes: Literal["both", "y"]
    """``both``, or ``y`` for a recording of one axis, whose X repeats Y."""
    rms: float
    """Root mean square of the acceleration over the first two axes, without the mean [m/s^2]."""
    peak: float
    """Largest magnitude of the acceleration in one of these axes [m/s^2]."""
    largest_sample: int
    """Index of the sample with that magnitude."""


@dataclass(frozen=True)
class DiagnosedRecording:
    """A recording, and what the detector found in it."""

    name: str
    """Name of the recording, as the user gave it."""
    recording: Recording
    result: DetectionResult
    parameters: DetectorParameters
    """Parameters of the detector."""

    @property
    def judged(self) -> Samples:
        """Samples on which the last verdict is based: the latest window, from the start or the last long gap at most."""
        rate = self.recording.sampling_rate
        hops = max(1, round(self.parameters.window / self.parameters.hop))
        last = self.result.last.index
        return Samples(max(self.result.begin, last + 1 - hops * round(self.parameters.hop * rate)), last)


def read_content(recording: Recording, judged: Samples) -> Content:
    """Read a recording once, block by block, and keep the blocks with the ``judged`` samples.

    Raises:
        Refusal: it has no waveform.
    """
    kept = list[Piece]()
    count = largest = 0
    total, squares, peak, single = np.zeros(2), np.zeros(2), -1.0, True
    pieces = recording.pieces()
    while together := list(islice(pieces, TOGETHER)):
        kept += [piece for piece in together if piece.first_index <= judged.last and piece.end_index > judged.first]
        acceleration = np.nan_to_num(np.concatenate([piece.acceleration[:, :2] for piece in together]))
        count += len(acceleration)
        total += acceleration.sum(axis=0, dtype=np.float64)
        squares += np.square(acceleration, dtype=np.float64).sum(axis=0)
        single = single and np.array_equal(acceleration[:, 0], acceleration[:, 1])
        magnitudes = np.abs(acceleration)
        sample = int(magnitudes.argmax()) // magnitudes.shape[1]
        if (magnitude := float(magnitudes[sample].max())) > peak:
            indices = np.concatenate([np.arange(piece.first_index, piece.end_index) for piece in together])
            peak, largest = magnitude, int(indices[sample])
    powers = np.maximum(squares / count - np.square(total / count), 0.0)  # of a constant, rounding may be below
    rms = math.sqrt(float(powers[1] if single else powers.sum()))
    return Content(kept, "y" if single else "both", rms, peak, largest)


def detection_report(diagnosed: Sequence[DiagnosedRecording]) -> str:
    """Return the page: for each recording verdict, reason, lines, waveform, spectrum, history, conditions; then trend, limits, versions.

    The page contains its style and its figures and loads nothing. Equal recordings, parameters and versions give equal pages.

    Raises:
        Refusal: a recording has no waveform, or jinja2 is not installed.
    """
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("dcrb_ros.plots"), autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    sections = [_section(number, entry) for number, entry in enumerate(diagnosed, 1)]
    return environment.get_template("detection_report.html").render(
        sections=sections,
        trend=_trend(diagnosed) if len(diagnosed) > 1 else "",
        fault_lines=list(FAULT_LINES),
        limits=LIMITS,
        versions=[("dcrb_ros", __version__), *((name, version(name)) for name in LIBRARIES)],
        parameters=_changed_parameters(diagnosed[0].parameters) if diagnosed else [],
    )


def _section(number: int, entry: DiagnosedRecording) -> dict[str, Any]:
    """Return what the template shows of one recording."""
    last, recording = entry.result.last, entry.recording
    content = read_content(recording, entry.judged)
    return {
        "number": number,
        "name": printable(entry.name),
        "title": last.title,
        "state": "alarm" if is_alarm(last.verdict) else last.verdict,
        "verdict": last.verdict,
        "confidence": f"{last.confidence:.2f}",
        "since": f"{entry.result.since:.2f}",
        "reason": printable(last.reason),
        # The page has another spectrum, in the band of the evidence.
        "remarks": [printable(remark) for remark in last.remarks if remark != last.spectrum_remark],
        "lines": [_line_row(component, last) for component in COMPONENTS],
        "sizes": [f"{last.lines[component].size:.3g}" if component in last.lines else "–" for component in COMPONENTS],
        "judged": str(entry.judged),
        "figures": _figures(entry, content),
        "changes": _changes_of_verdict(entry.result.history, recording.sampling_rate),
        "conditions": _conditions(entry, content),
    }


def _line_row(component: str, diagnosis: Diagnosis) -> dict[str, str]:
    """Return one row of the table of lines."""
    frequency = CHARACTERISTIC[component]
    lines = diagnosis.lines.get(component)
    row = {
        "component": TITLES[component],
        "line": "2 BSF" if frequency == "BSF" else frequency,
        "level": decimal(diagnosis.levels.get(frequency, 0.0), 1),
        "score": _signed(diagnosis.scores[component]) if component in diagnosis.scores else "–",
    }
    if lines is None:
        return row | dict.fromkeys(("order", "departure", "depth", "size", "band"), "–")
    low, high = lines.band
    return row | {
        "order": f"{lines.order:.4f}",
        "departure": _signed(100.0 * lines.departure, 2),
        "depth": f"{lines.depth:.3f}",
        "size": f"{lines.size:.3g}",
        "band": f"{low:.0f} to {high:.0f}",
    }


def _signed(value: float, digits: int = 1) -> str:
    """Return a number with its sign; zero has none."""
    text = f"{value:+.{digits}f}"
    return text if float(text) else f"{0.0:.{digits}f}"


def _figures(entry: DiagnosedRecording, content: Content) -> list[tuple[str, str]]:
    """Return caption and picture of the evidence: waveform and spectrum of the judged samples, and the history."""
    recording, judged = entry.recording, entry.judged
    rate = recording.sampling_rate
    figures = []
    if not content.judged:
        return [(f"No waveform: there are no samples {judged}.", "")]
    span = judged.first / rate, (judged.last + 1) / rate
    waveform = joined_waveform(content.judged, rate, recording.orders, recording.path, *span)
    figure = Figure(figsize=(9.0, 2.6), dpi=RESOLUTION, layout="constrained")
    plot_waveform(waveform, ax=figure.subplots(), axis=content.axes)
    figures.append((f"Waveform, samples {judged}.", _picture(figure)))
    figures.append(_spectrum_figure(entry, waveform))
    if len(entry.result.history) > 1:
        first, last = entry.result.history[0].index, entry.result.history[-1].index
        figures.append((f"Level of the lines over background, one value for each hop, samples up to {first} .. {last}.", _history(entry)))
    return figures


def _spectrum_figure(entry: DiagnosedRecording, waveform: Waveform) -> tuple[str, str]:
    """Return caption and picture of the squared envelope spectrum in the band of the evidence."""
    last = entry.result.last
    component = last.verdict if last.verdict in last.lines else max(last.scores, key=lambda name: last.scores[name], default="")
    band = last.lines[component].band if component in last.lines else None
    figure = Figure(figsize=(9.0, 3.2), dpi=RESOLUTION, layout="constrained")
    try:
        spectrum = envelope_spectrum(waveform, band=band, order_tracking=trackable(waveform))
        plot_envelope_spectrum(spectrum, ax=figure.subplots())
    except Refusal as refusal:
        return f"No spectrum of samples {entry.judged}: {refusal}", ""
    low, high = spectrum.band
    return f"Squared envelope spectrum of samples {entry.judged}, band {low:.0f} to {high:.0f} Hz, with the fault lines.", _picture(figure)


def _history(entry: DiagnosedRecording) -> str:
    """Return the picture of the levels over time; a judgement that still waits has none."""
    figure = Figure(figsize=(9.0, 2.4), dpi=RESOLUTION, layout="constrained")
    ax = figure.subplots()
    time = [diagnosis.time for diagnosis in entry.result.history]
    for (line, colour), frequency in zip(FAULT_LINES.items(), CHARACTERISTIC.values(), strict=True):
        levels = [diagnosis.levels.get(frequency, 0.0) if diagnosis.scores else math.nan for diagnosis in entry.result.history]
        ax.plot(time, levels, color=colour, marker=".", label=line)
    legend_above(ax)
    labelled(ax, "time [s]", "level [dB]")
    return _picture(figure)


def _changes_of_verdict(history: Iterable[Diagnosis], rate: int) -> list[dict[str, str]]:
    """Return the diagnoses at which the verdict changed."""
    return [
        {
            "time": f"{diagnosis.time:.2f}",
            "sample": str(diagnosis.index),
            "verdict": TITLES.get(diagnosis.verdict, diagnosis.verdict),
            "confidence": f"{diagnosis.confidence:.2f}",
            "reason": printable(diagnosis.reason),
        }
        for diagnosis in (next(same) for _, same in groupby(history, key=lambda diagnosis: diagnosis.verdict))
    ]


def _conditions(entry: DiagnosedRecording, content: Content) -> list[tuple[str, str]]:
    """Return the conditions of the measurement as names and values."""
    recording, last, rate = entry.recording, entry.result.last, entry.recording.sampling_rate
    orders, digests = recording.orders, recording.digests()
    read = digests.read
    samples = Samples(read.first_index, read.end - 1)
    manifest: Mapping[str, Any] = recording.manifest
    conditions = [
        ("sampling rate", f"{rate} Hz"),
        ("signal", f"{read.count / rate:.2f} s, samples {samples}"),
        ("shaft", f"{last.shaft_frequency:.3f} Hz, {60.0 * last.shaft_frequency:.1f} rpm, mean over samples {entry.judged}"),
        ("orders", f"FTF {orders.ftf:.4f}, BPFO {orders.bpfo:.4f}, BPFI {orders.bpfi:.4f}, BSF {orders.bsf:.4f}"),
        ("axes", "X and Y" if content.axes == "both" else "one"),
        ("rms", f"{content.rms:.3g} m/s² over the axes, samples {samples}"),
        ("peak", f"{content.peak:.3g} m/s², sample {content.largest_sample}"),
        ("severity", f"{last.severity:.3g} m/s² at 20 Hz of shaft frequency, samples {entry.judged}"),
        ("gaps", f"{last.gaps}"),
        ("clipped samples", f"{last.clipped}"),
        ("baseline", printable(last.baseline) or "none"),
    ]
    if manifest.get("units", {}).get("acceleration") == "relative":
        conditions.append(("unit", "unknown: levels in m/s² are relative; compare them only at the same measuring point"))
    if "recorded" in manifest:
        conditions.append(("recorded", printable(str(manifest["recorded"]))))
    if "imported" in manifest:
        conditions.append(("imported", printable(json.dumps(manifest["imported"], sort_keys=True))))
    readings = recording.temperatures()
    if len(readings):
        conditions.append(("temperatures", f"at the start {readings.to_words(0)}, at the end {readings.to_words(-1)}"))
    conditions.append(("sha256 of the samples", read.sha256))
    if reason := digests.mismatch or unsigned(recording):
        conditions.append(("digest", printable(reason)))
    if reason := recovered(recording.stored):
        conditions.append(("recovered", reason))
    if not recording.complete:
        conditions += [("damage", printable(description)) for description in recording.damage]
    return conditions


def _trend(diagnosed: Sequence[DiagnosedRecording]) -> str:
    """Return the picture of the size of the lines over the recordings in the given order."""
    figure = Figure(figsize=(9.0, 2.8), dpi=RESOLUTION, layout="constrained")
    ax = figure.subplots()
    numbers = np.arange(1, len(diagnosed) + 1)
    for component, (line, colour) in zip(COMPONENTS, FAULT_LINES.items(), strict=True):
        found_lines = [entry.result.last.lines.get(component) for entry in diagnosed]
        ax.plot(numbers, [math.nan if lines is None else lines.size for lines in found_lines], color=colour, marker="o", label=line)
    ax.set_xticks(numbers)
    legend_above(ax)
    labelled(ax, "recording", "size of the lines [m/s²]")
    return _picture(figure)


def _changed_parameters(parameters: DetectorParameters) -> list[tuple[str, str]]:
    """Return the parameters of the detector that differ from their defaults."""
    defaults = DetectorParameters().model_dump()
    return [(name, printable(str(value))) for name, value in parameters.model_dump().items() if value != defaults[name]]


def _picture(figure: Figure) -> str:
    """Return a figure as the address of an embedded PNG, without a date."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", metadata={"Software": None})
    return "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode("ascii")
