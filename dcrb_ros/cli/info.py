"""`dcrb info`: the contents of a recording."""

from __future__ import annotations

import json
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from dcrb_ros.cli.options import Bag
from dcrb_ros.text.counts import counted
from dcrb_ros.text.json import json_text

if TYPE_CHECKING:
    from rich.table import Table

    from dcrb_ros.recordings.digest import SampleDigests
    from dcrb_ros.recordings.reader import Recording

LONGEST_CELL = 400
"""Longest text in a table [characters]; --json prints all of it."""
SHOWN_COMMANDS = 20
"""Commands printed in the table at most [-]; --json prints all of them."""


def info(
    bag: Bag,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON: manifest, message counts, commands and damage.")] = False,
) -> None:
    """Print the manifest, the topics, the commands and the unreadable parts of a recording.

    Example: dcrb info bags/healthy
    """
    from dcrb_ros.recordings.reader import Recording
    from dcrb_ros.recordings.vehicle_folder import vehicle_boxes
    from dcrb_ros.recordings.verification import metadata_flaw, recovered, unsigned
    from dcrb_ros.stream.event_text import encode_command

    if vehicle_boxes(bag):
        vehicle_info(bag, as_json=as_json)
        return
    recording = Recording(bag)
    counts, flaw = recording.counts(), metadata_flaw(bag)
    commands = [encode_command(command) for command in recording.commands()]
    digests, mismatch = _digests(recording)
    damage = [*recording.damage, *([flaw] if flaw else []), *([mismatch] if mismatch else [])]
    if as_json:
        about = {
            "manifest": recording.manifest,
            "outcome": recording.outcome,
            "samples": {
                "stated_sha256": digests.stated.sha256 if digests and digests.stated else None,
                "actual_sha256": digests.read.sha256 if digests else None,
                "actual_count": digests.read.count if digests else None,
                "match": digests.match if digests else None,
            },
            "messages": counts,
            "commands": commands,
            "unverified": unsigned(recording) or None,
            "recovered": recovered(recording.stored) or None,
            "damage": damage,
        }
        print(json_text(about))
        return
    tables = [_table(str(bag), ("topic", "messages"), counts.items())]
    if commands:
        first = [(f"{command['time_ns'] * 1e-9:.6f}", command["command"]) for command in commands[:SHOWN_COMMANDS]]
        tables.append(_table(f"commands: {len(commands)}", ("simulated time [s]", "command"), first))
    if recording.configured:
        tables.append(_table("configuration, where it differs from the default", ("parameter", "value"), _changed(recording)))
    agreed = {True: "as stated", False: "NOT as stated", None: "no digest of the same samples is stated"}
    read = f"read: {digests.read.count} samples, sha256 {digests.read.sha256}, {agreed[digests.match]}" if digests else ""
    _print([*_lines(recording), read, unsigned(recording), recovered(recording.stored)], tables, damage)


def vehicle_info(bag: Path, *, as_json: bool) -> None:
    """Print the parameters, the boxes with their digests, the commands, the topics and the damage of a vehicle's recording."""
    from dcrb_ros.recordings.vehicle import VehicleRecording
    from dcrb_ros.recordings.verification import metadata_flaw, recovered, unsigned

    recording, flaw = VehicleRecording(bag), metadata_flaw(bag)
    counts = next(iter(recording.boxes.values())).counts()
    commands = [(command.time_ns * 1e-9, command.name, command.value) for command in recording.commands()]
    boxes, mismatches = dict[str, dict[str, Any]](), list[str]()
    for name, box in recording.boxes.items():
        digests, mismatch = _digests(box)
        boxes[name] = {
            "samples": digests.read.count if digests else None,
            "sha256": digests.read.sha256 if digests else None,
            "match": digests.match if digests else None,
            "unverified": unsigned(box) or None,
            "faults": list(box.manifest.get("faults") or ()),
        }
        mismatches += [f"{name}: {mismatch}"] if mismatch else []
    damage = [*recording.damage, *([flaw] if flaw else []), *mismatches]
    if as_json:
        about = {
            "sampling_rate": recording.sampling_rate,
            "vehicle": recording.parameters,
            "scenario": recording.scenario,
            "boxes": boxes,
            "commands": commands,
            "messages": counts,
            "recovered": recovered(recording.stored) or None,
            "damage": damage,
        }
        print(json_text(about))
        return
    lines = [
        f"the recording of a vehicle with {counted(len(boxes), 'box', 'boxes')}, sampling rate: {recording.sampling_rate} Hz",
        f"a box by itself: dcrb info {shlex.quote(str(bag / next(iter(boxes))))}",
        "" if recording.scenario is None else f"scenario: {json.dumps(recording.scenario)}",
        *(f"{name}: {box['unverified']}" for name, box in boxes.items() if box["unverified"]),
        recovered(recording.stored),
    ]
    agreed = {True: "as stated", False: "NOT as stated", None: "none stated"}
    rows = [
        (name, box["samples"], str(box["sha256"])[:16], agreed[box["match"]], ", ".join(box["faults"]) or "none")
        for name, box in boxes.items()
    ]
    tables = [_table(str(bag), ("box", "samples", "sha256", "digest", "faults at the start"), rows)]
    tables.append(_table("messages", ("topic", "messages"), counts.items()))
    if commands:
        first = [(f"{time:.6f}", name, value) for time, name, value in commands[:SHOWN_COMMANDS]]
        tables.append(_table(f"commands to the vehicle: {len(commands)}", ("simulated time [s]", "command", "value"), first))
    tables.append(_table("vehicle", ("parameter", "value"), recording.parameters.items()))
    _print(lines, tables, damage)


def _print(lines: Sequence[str], tables: Sequence[Table], damage: Sequence[str]) -> None:
    """Print lines that are not empty, tables, and a line for each unreadable part."""
    from dcrb_ros.runtime.terminal import console

    shown = console()
    for line in filter(None, lines):
        shown.print(line, soft_wrap=True)
    for table in tables:
        shown.print(table)
    readable = "the counts above are of the readable part; dcrb recover writes it to a complete recording"
    for line in [*(f"damaged: {description}" for description in damage), readable] if damage else ():
        shown.print(line, soft_wrap=True)


def _lines(recording: Recording) -> list[str]:
    """Return lines on the software, the sensor, the faults and the outcome of the recording."""
    manifest, orders, outcome = recording.manifest, recording.orders, recording.outcome
    lines = [
        _origin(recording),
        f"sampling rate: {recording.sampling_rate} Hz",
        "units: " + ", ".join(f"{key} [{unit}]" for key, unit in manifest.get("units", {}).items()),
        f"orders: FTF {orders.ftf:.5f}, BPFO {orders.bpfo:.5f}, BPFI {orders.bpfi:.5f}, BSF {orders.bsf:.5f}",
    ]
    if recording.imported:
        lines.append(f"imported: {json.dumps(manifest['imported'])}")
    elif recording.configured:
        faults = manifest.get("faults") or recording.configuration.faults.described()
        lines.append(f"seed {manifest.get('seed')}, faults at the start: {', '.join(faults) or 'none'}")
    lines += _streams(recording)
    if manifest.get("scenario"):
        lines.append(f"scenario: {json.dumps(manifest['scenario'])}")
    if outcome is not None:
        seconds = outcome.get("samples", 0) / recording.sampling_rate
        count, ended = outcome.get("samples"), outcome.get("ended")
        lines.append(f"{count} samples, {seconds:.3f} s, stated sha256 {outcome.get('sha256')}, ended {ended}")
    elif recording.described:
        lines.append(_samples(recording))
    return lines


def _digests(recording: Recording) -> tuple[SampleDigests | None, str]:
    """Return the stated and the actual digest, and a sentence if they differ; None and the reason if the samples cannot be decoded."""
    from dcrb_ros.schema.refusal import Refusal

    try:
        digests = recording.digests()
    except Refusal as refusal:
        return None, str(refusal)
    return digests, digests.mismatch


def _streams(recording: Recording) -> list[str]:
    """Return lines on the readings of temperature and the pulses of the tacho, where there are any."""
    lines, readings, tacho = [], recording.temperatures(), recording.tacho()
    if len(readings):
        first, last = (readings.to_words(number) for number in (0, -1))
        lines.append(f"{len(readings)} readings of temperature, at {readings.time[0]:.3f} s {first}, at {readings.time[-1]:.3f} s {last}")
    if len(tacho):
        lines.append(f"{len(tacho)} pulses of a tacho, {tacho.pulses_per_turn or 'an unknown number'} per turn")
    return lines


def _origin(recording: Recording) -> str:
    """Return the software that made the recording."""
    from dcrb_ros.recordings.processor import described

    manifest = recording.manifest
    if recording.described:
        return f"no manifest, as ros2 bag record writes none: sampling rate and bearing are those of {manifest['described_by']}"
    software = ", ".join(f"{name} {value}" for name, value in manifest.get("software", {}).items())
    made = f"dcrb_ros {manifest.get('dcrb_ros')}, model {manifest.get('model', 'unknown')}, recorded {manifest.get('recorded')}"
    kernels = f", kernels for {described(manifest['processor'])}" if "processor" in manifest else ""
    return made + (f" with {software}" if software else "") + kernels


def _samples(recording: Recording) -> str:
    """Return number and time of the samples of a recording without an outcome, read block by block, or why they are not read."""
    from dcrb_ros.messages.topics import VIBRATION
    from dcrb_ros.schema.refusal import Refusal

    if next(recording.messages((VIBRATION,)), None) is None:
        return "no waveform"
    try:
        spans = [(piece.first_index, len(piece.shaft_angle)) for piece in recording.pieces()]
    except Refusal as refusal:
        return str(refusal)
    first, last = min(first for first, _ in spans), max(first + count for first, count in spans)
    rate = recording.sampling_rate
    return f"{sum(count for _, count in spans)} samples from {first / rate:.3f} to {last / rate:.3f} s"


def _changed(recording: Recording) -> list[tuple[str, str]]:
    from dcrb_ros.settings.configuration import Configuration
    from dcrb_ros.settings.files import flatten

    default = flatten(Configuration().model_dump())
    return [(key, str(value)) for key, value in flatten(recording.configuration.model_dump()).items() if value != default[key]]


def _table(title: str, heads: tuple[str, ...], rows: Any) -> Table:
    from dcrb_ros.runtime.terminal import table
    from dcrb_ros.schema.printable import shortened

    return table(title, heads, ([shortened(str(cell), LONGEST_CELL) for cell in row] for row in rows))
