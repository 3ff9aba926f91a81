"""Export of a recording's waveform to a file for other tools, and of the remaining information to a description in YAML."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from dcrb_ros.exchange.description import COPY, RELATIVE
from dcrb_ros.exchange.files import WRITERS, WRITING
from dcrb_ros.exchange.pieces import Show, unseen
from dcrb_ros.exchange.pulse_train import LEVELS, sampled_pulses
from dcrb_ros.exchange.temperatures import CHANNELS, TIME, own_arrays
from dcrb_ros.exchange.temperatures import columns as beside_samples
from dcrb_ros.exchange.text_table import Array
from dcrb_ros.messages.points import check_axes, decode_vibration
from dcrb_ros.messages.topics import GROUND_TRUTH, VIBRATION
from dcrb_ros.recordings.arrays import truths_of
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.schema.arrays import Samples
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.stream.axes import AXES
from dcrb_ros.stream.block import Truth
from dcrb_ros.text.counts import counted
from dcrb_ros.text.writing import whole_files
from dcrb_ros.text.yaml import yaml_text

WITH_FURTHER_ARRAYS = (".npz", ".mat")
"""Formats with arrays of other lengths than the waveform."""
IMPORTED = ("index", *AXES, "shaft_angle", "tacho")
"""Columns that an import reads; the time follows from index and sampling rate."""
UNITS = {"deg C": "_temperature", "W": "_heat", "m": ""}
"""Words in the names of arrays for the units of numbers in the ground truth."""
RENAMED = {"acceleration": "time_lapse", "clamped": "clamped_temperatures"}
"""Names of numbers in the ground truth that would mean something else beside a waveform."""


def description_of(path: Path) -> Path:
    """Return the path of the description of an exported file, such as ``healthy.csv.yaml`` of ``healthy.csv``."""
    return path.with_name(f"{path.name}.yaml")


def export(recording: Recording, path: Path, *, notes: list[str] | None = None, show: Show = unseen) -> Path:
    """Write the waveform to ``path``, whose suffix is one of `WRITERS`, and its description to `description_of` it, which is returned.

    The caller has checked the paths: existing files are replaced. Blocks that came twice or too late are written once, in their place. A
    sentence on them, and one on what the format leaves out, is appended to ``notes``.

    Raises:
        Refusal: the recording has no waveform, or a file cannot be written.
    """
    suffix, described = path.suffix.lower(), description_of(path)
    notes = [] if notes is None else notes
    rate = recording.sampling_rate if suffix == ".wav" else _measured_rate(recording)
    columns, extra, labels, block_size = _collect(recording, notes, rate, suffix, show)
    about = {"manifest": recording.manifest, "outcome": recording.outcome, "labels": labels}
    description = _description(recording, path, rate, {**columns, **extra}, labels, block_size)
    with whole_files(path, described) as (waveform, text):
        show(WRITING, 0, 0)
        WRITERS[suffix](waveform, columns, extra, rate, about, show)
        text.write_bytes(yaml_text(description).encode())
    return described


def _measured_rate(recording: Recording) -> float:
    """Return the sampling rate of the measurement [Hz], which an import rounds to an integer."""
    rate, sensor = recording.sampling_rate, recording.manifest.get("sensor")
    measured = sensor.get("measured_sampling_rate") if recording.imported and isinstance(sensor, dict) else None
    return measured if isinstance(measured, float) and measured > 0.0 and round(measured) == rate else rate


def _collect(
    recording: Recording, notes: list[str], measured_rate: float, suffix: str, show: Show
) -> tuple[dict[str, Array], dict[str, Array], dict[str, Any], int]:
    """Return the sample columns with times at ``measured_rate`` [Hz], the ground truth over time, the labels and the block size.

    Readings of temperature are arrays of their own or columns beside the samples, as the format of ``suffix`` requires.
    """
    whole = suffix in WITH_FURTHER_ARRAYS
    rate, total = recording.sampling_rate, (recording.outcome or {}).get("samples")
    accelerations, angles, received, truth_messages, samples = [], [], [], [], 0
    for message in recording.messages((VIBRATION, GROUND_TRUTH)):
        if message.topic != VIBRATION:
            truth_messages.append(message.data)
            continue
        block = decode_vibration(message.data)
        accelerations.append(block.acceleration)
        angles.append(block.shaft_angle)
        received.append(range(block.first_index(rate), block.first_index(rate) + len(block.shaft_angle)))
        samples += len(block.shaft_angle)
        show("reading", samples, total if isinstance(total, int) else 0)
    if not received:
        raise Refusal(f"{recording.path} has no messages on {VIBRATION.resolved(recording.namespace)}: give a recording of the bench")
    check_axes(accelerations)
    truths, block_size = truths_of(truth_messages), max(map(len, received))
    index, order = _in_order(received, notes)
    acceleration = _joined(accelerations, order)
    columns: dict[str, Array] = {
        "index": index,
        "time": index / measured_rate,
        **dict(zip(AXES, acceleration.T, strict=False)),
        "shaft_angle": _joined(angles, order),
    }
    tacho, readings = recording.tacho(), recording.temperatures()
    if len(tacho):
        columns["tacho"] = sampled_pulses(tacho.time * rate, index)
    beside = {} if whole else beside_samples(readings, index, rate)
    columns |= beside
    if suffix == ".wav" and (len(tacho) or len(readings)):
        notes.append("a WAV file has neither temperatures nor pulses of a tacho: export npz, mat, csv or parquet to keep them")
    elif not whole and (left_out := len(readings) - _readings_in(beside)):
        notes.append(
            f"{left_out} of {counted(len(readings), 'reading')} of temperature are at no sample, but before or after the waveform or in a "
            "gap, and are left out: export npz or mat to keep them"
        )
    extra: dict[str, Array] = {**(own_arrays(readings, rate / measured_rate) if whole else {}), **_truth_arrays(truths)}
    return columns, extra, _labels(recording, truths), block_size


def _in_order(received: Sequence[range], notes: list[str]) -> tuple[Array, Array | None]:
    """Return the index of each sample once, and its place among the ``received`` ones; None if these are in order."""
    as_received = np.concatenate([np.arange(block.start, block.stop, dtype=np.int64) for block in received])
    if all(first.stop <= second.start for first, second in pairwise(received)):
        return as_received, None
    index, order = np.unique(as_received, return_index=True)
    notes.append(f"samples came twice or too late, {len(as_received) - len(index)} of them twice: each is written once, in its place")
    return index, order


def _joined(parts: list[Samples], order: Array | None) -> Samples:
    """Return the samples of all blocks in their ``order``; the list is cleared, since both would take much memory."""
    joined = np.concatenate(parts)
    parts.clear()
    return joined if order is None else joined[order]


def _readings_in(beside: Mapping[str, Array]) -> int:
    """Return the number of samples that have a reading of temperature."""
    return int(np.isfinite(list(beside.values())).any(axis=0).sum()) if beside else 0


def _truth_arrays(truths: Sequence[Truth]) -> dict[str, Array]:
    """Return the ground truth over time as arrays of shape (times,); no arrays without it."""
    if not truths:
        return {}
    names = dict.fromkeys(name for truth in truths for name in truth.thermal)
    return {
        "truth_time": np.array([truth.time_ns * 1e-9 for truth in truths]),
        "truth_speed": np.array([truth.speed for truth in truths]),
        "truth_load": np.array([truth.load for truth in truths]),
        **{array_name(name): np.array([truth.thermal.get(name, np.nan) for truth in truths]) for name in names},
    }


def _labels(recording: Recording, truths: Sequence[Truth]) -> dict[str, Any]:
    """Return the ground truth at the end; without one, the labels of the import."""
    if not truths:
        return dict(recording.manifest.get("imported", {}).get("labels", {}))
    last = truths[-1]
    labels = {"faults": {name: dict(fault) for name, fault in last.faults.items()}, "speed": last.speed, "load": list(last.load)}
    return labels | ({"thermal": dict(last.thermal)} if last.thermal else {})


def array_name(name: str) -> str:
    """Return the name of an array for a number of the ground truth: ``truth_box_temperature`` for ``box [deg C]``."""
    name = RENAMED.get(name, name)
    for unit, word in UNITS.items():
        name = name.replace(f" [{unit}]", word)
    return f"truth_{name.replace('/', '_')}"


def _description(
    recording: Recording, path: Path, rate: float, columns: dict[str, Array], labels: dict[str, Any], block_size: int
) -> dict[str, Any]:
    wav = path.suffix.lower() == ".wav"
    known = (name for name in sorted(columns) if name in CHANNELS or name in (*IMPORTED, TIME))
    channels: dict[str, Any] = {name: number for number, name in enumerate(_in_wav(columns), 1)} if wav else {name: name for name in known}
    sensor = recording.manifest.get("sensor", {}) if recording.imported else {}
    source = recording.manifest["imported"].get("source", {}) if recording.imported else {}
    axes = sensor.get("axes")
    if isinstance(axes, dict) and axes.get("ay") == COPY:
        del channels["ay"]
    tacho, warm = "tacho" in channels, any(name in channels for name in CHANNELS)
    return {
        "sampling_rate": rate,
        "unit": RELATIVE if sensor.get("acceleration_unit") == RELATIVE else "m/s^2",
        "channels": channels,
        **({"pulses_per_turn": recording.pulses_per_turn or 1, "tacho_levels": list(LEVELS)} if tacho else {}),
        **({"temperature_deviation": _deviation(recording)} if warm else {}),
        "orders": recording.orders.as_dict(),
        "first_index": int(columns["index"][0]),
        "block_size": max(16, block_size),
        "labels": labels,
        **({"source": source} if source else {}),
    }


def _in_wav(columns: dict[str, Array]) -> list[str]:
    """Return the channels of a WAV file."""
    return [name for name in (*AXES, "shaft_angle") if name in columns]


def _deviation(recording: Recording) -> float:
    """Return the standard deviation of a reading of temperature [K]; 0 if it is unknown."""
    if recording.configured:
        return recording.configuration.thermal.sensor_noise
    deviation = recording.manifest.get("imported", {}).get("temperature_deviation", 0.0)
    return float(deviation) if isinstance(deviation, (int, float)) else 0.0
