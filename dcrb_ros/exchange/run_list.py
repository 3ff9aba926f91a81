"""The list of measured files that become a data set: a CSV table with a row for each recording."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from dcrb_ros.bearing.waveform import Waveform
from dcrb_ros.exchange.description import read_description
from dcrb_ros.exchange.importing import WaveformImport
from dcrb_ros.exchange.plausibility import implausible
from dcrb_ros.schema.refusal import Refusal, repeated
from dcrb_ros.settings.shipped import find_shipped
from dcrb_ros.text.files import checked_path
from dcrb_ros.text.tables import read_rows

NEEDED = ("file", "fault")
TEXTS = ("name", "split", "bearing_id", "machine")
NUMBERS = ("width", "depth", "load")
IMPORT = ("about", "speed_rpm", "set")
"""Columns that the import of a file takes: its description, its speed, and other settings, divided by semicolons."""
LARGEST_DEFECT = 0.05
"""Largest width or depth of a defect, as of one that is simulated [m]."""
SHA256 = "sha256"
"""Column with the SHA-256 of a file; a file with another one is refused."""
OPTIONAL = (*TEXTS, *NUMBERS, *IMPORT, SHA256)


class ListedRun(NamedTuple):
    """A row of the list with the recording that it names."""

    name: str
    waveform: Waveform
    source: dict[str, Any]
    """Origin of the recording, from its description."""
    fields: dict[str, Any]
    """The other columns: ``fault``, `TEXTS` and `NUMBERS` that are given."""
    warnings: list[str]
    """Sentences on what is implausible in the recording."""


def read_list(table: Path, about: str) -> list[Entry]:
    """Return the rows of a list; no file is read.

    Args:
        table: CSV file with the columns `NEEDED`, and any of `OPTIONAL`; files and descriptions are relative to its folder.
        about: description of the files whose row has none: a YAML file or the name of a public data set.

    Raises:
        Refusal: a column is unknown, a value or a description is refused, or a defect is implausibly large or on a healthy bearing.
    """
    return [_entry(f"{table}, line {number}", row, table.parent, about) for number, row in read_rows(table, NEEDED, OPTIONAL)]


def listed_runs(entries: Iterable[Entry], rate: int = 0) -> Iterator[ListedRun]:
    """Yield the recordings of a list, one after the other.

    Args:
        entries: rows of the list.
        rate: sampling rate to which all are decimated [Hz]; 0 leaves them.

    Raises:
        Refusal: a file cannot be imported, has another hash than stated, or the content of one with another fault or split, or a rate is
            not a whole multiple of ``rate``.
    """
    known = dict[tuple[Any, ...], Entry]()
    for entry in entries:
        line, file = entry.line, entry.file
        read = _imported(file, entry.description, entry.settings, line)
        sha256 = read.sha256()
        if (entry.sha256 or sha256).lower() != sha256:
            raise Refusal(f"{line}: {file} has the SHA-256 {sha256} instead of {entry.sha256}: get the file again, or correct the list")
        # The channels of one file may be sensors at several bearings.
        other = known.setdefault((sha256, *read.description.channels.axes.values()), entry)
        if (labels := entry.fault_and_split) != other.fault_and_split:
            raise Refusal(
                f"{line}: {file} has the same content as {other.file} in line {other.line.rpartition(' ')[2]}, which is "
                f"{' in '.join(other.fault_and_split)}, not {' in '.join(labels)}: give the right file, or the same fault and split"
            )
        waveform = Waveform(
            acceleration=read.acceleration, shaft_angle=read.angle, sampling_rate=read.rate, index=read.index, orders=read.orders
        )
        source = dict(read.description.source or {})
        warnings = [f"{line}: {sentence}" for sentence in implausible(read)]
        yield ListedRun(entry.name, decimated(waveform, rate, f"{line}: {file}") if rate else waveform, source, entry.fields, warnings)


class Entry(NamedTuple):
    """A row of the list, checked before any file is read."""

    line: str
    name: str
    file: Path
    description: Path
    settings: list[str]
    sha256: str
    fields: dict[str, Any]
    """The other columns, as in `ListedRun`."""

    @property
    def fault_and_split(self) -> tuple[str, str]:
        """The fault and the split, test if none is given."""
        return self.fields["fault"], self.fields.get("split", "test")


def _entry(line: str, row: dict[str, str], folder: Path, about: str) -> Entry:
    """Return a row, whose ``line`` begins the messages.

    Raises:
        Refusal: a value is missing, unknown or given twice, or there is no such file.
    """
    if not row["file"] or not row["fault"]:
        raise Refusal(f"{line}: file and fault are needed: give both")
    description = _description(row["about"], folder, line) if row.get("about") else about
    if not description:
        raise Refusal(f"{line}: there is no description of {row['file']}: add the column about, or give --about")
    file = folder / row["file"]
    if not checked_path(file).is_file():
        raise Refusal(f"{line}: there is no file {file}")
    settings = [part.strip() for part in (row.get("set") or "").split(";") if part.strip()]
    keys = [*(["speed_rpm"] if row.get("speed_rpm") else []), *(part.partition("=")[0].strip() for part in settings)]
    if (twice := repeated(keys)) is not None:
        raise Refusal(f"{line}: {twice} is given more than once: give it once, in the column set or in one of its own")
    if row.get("speed_rpm"):  # it is that of the file, and replaces the speed of the description
        settings = ["channels.rpm=null", "speed=null", *settings, f"speed_rpm={row['speed_rpm']}"]
    fields: dict[str, Any] = {"fault": row["fault"]} | {name: row[name] for name in TEXTS[1:] if row.get(name)}
    sizes = {name: _number(row[name], f"{line}: {name}") for name in NUMBERS if row.get(name)}
    fields |= _checked_sizes(sizes, row["fault"], line)
    name = row.get("name") or file.stem
    entry = Entry(line, name, file, find_shipped("description", description), settings, row.get(SHA256) or "", fields)
    _check_description(entry)
    return entry


def _check_description(entry: Entry) -> None:
    """Refuse a description that a file cannot have, whatever it contains."""
    try:
        described = read_description(entry.description, entry.settings)
        described.shaft_source(entry.description)
        described.fault_orders(entry.description)
        described.factor(entry.description)
    except Refusal as refusal:
        raise Refusal(f"{entry.line}: {refusal}") from None


def _description(about: str, folder: Path, line: str) -> Path:
    """Return the description that a row names: a file in the folder of the list, or a public data set.

    Raises:
        Refusal: there is neither.
    """
    try:
        return find_shipped("description", folder / about, about)
    except Refusal as refusal:
        raise Refusal(f"{line}: {refusal}") from None


def _imported(file: Path, description: Path, settings: Sequence[str], line: str) -> WaveformImport:
    try:
        return WaveformImport([file], description, settings)
    except Refusal as refusal:
        raise Refusal(f"{line}: {refusal}") from None


def _checked_sizes(sizes: dict[str, float], fault: str, line: str) -> dict[str, float]:
    """Return the numbers of a row.

    Raises:
        Refusal: a healthy bearing has a defect, or a defect is larger than one that can be simulated.
    """
    for name in ("width", "depth"):
        size = sizes.get(name, 0.0)
        if size and fault == "healthy":
            raise Refusal(f"{line}: {name} = {size:g} m, but the bearing is healthy: leave it empty, or name the fault")
        if size > LARGEST_DEFECT:
            raise Refusal(f"{line}: {name} = {size:g} m is larger than {LARGEST_DEFECT:g} m: give it in metres")
    return sizes


def _number(text: str, name: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise Refusal(f"{name} = '{text}' is not a number") from None
    if not 0.0 <= value < np.inf:
        raise Refusal(f"{name} = {text} is not a positive number")
    return value


def decimated(waveform: Waveform, rate: int, name: str) -> Waveform:
    """Return a waveform at a lower sampling rate [Hz], after an anti-alias filter without phase.

    Raises:
        Refusal: its own rate is not a whole multiple of it, or samples are missing.
    """
    factor, rest = divmod(waveform.sampling_rate, rate)
    if rest or factor < 1:
        raise Refusal(f"{name} is sampled at {waveform.sampling_rate} Hz, which is not a whole multiple of --rate {rate}")
    if factor == 1:
        return waveform
    if len(waveform) and int(waveform.index[-1] - waveform.index[0]) != len(waveform) - 1:
        raise Refusal(f"{name} has gaps and cannot be decimated to {rate} Hz: leave out --rate, or cut it")
    from scipy.signal import resample_poly

    first = int(-waveform.index[0] % factor) if len(waveform) else 0  # so that all instants are those of the lower rate
    acceleration = resample_poly(waveform.acceleration[first:].astype(np.float64), 1, factor, axis=0, padtype="line").astype(np.float32)
    index = (waveform.index[0] + first) // factor + np.arange(len(acceleration))
    return replace(waveform, acceleration=acceleration, shaft_angle=waveform.shaft_angle[first::factor], sampling_rate=rate, index=index)
