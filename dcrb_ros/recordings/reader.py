"""Reading recordings, complete or damaged."""

from __future__ import annotations

import json
import os
import re
from collections import Counter
from collections.abc import Container, Iterable, Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import yaml
from mcap.records import Channel, Metadata
from mcap.records import Message as McapMessage

from dcrb_ros.bearing.history import StateHistory
from dcrb_ros.bearing.kinematics import Orders, characteristic_orders
from dcrb_ros.bearing.waveform import Piece, Waveform
from dcrb_ros.messages.description import decode_range
from dcrb_ros.messages.points import Vibration, decode_vibration
from dcrb_ros.messages.statuses import decode_truth
from dcrb_ros.messages.topics import DETECTED, GROUND_TRUTH, MANIFEST, NAMESPACE, SENSOR, SIMULATED, VIBRATION, Message, Topic
from dcrb_ros.recordings import arrays
from dcrb_ros.recordings.arrays import RecordedVerdict
from dcrb_ros.recordings.manifest import OUTCOME
from dcrb_ros.recordings.mcap_reader import MAGIC, McapRecords
from dcrb_ros.runtime.version import __version__
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.simulation.ground_truth import GroundTruth, commands_in
from dcrb_ros.stream.event_text import decode_command
from dcrb_ros.stream.events import TimedCommand

if TYPE_CHECKING:
    import pandas as pd

METADATA = "metadata.yaml"
MAX_METADATA = 4_000_000
"""Largest metadata.yaml that is read [bytes]; those of the bench have a few thousand."""
TYPES: dict[str, type] = {
    **dict.fromkeys(("units", "software", "orders", "faults", "imported", "sensor", "configuration"), dict),
    **dict.fromkeys(("format", "first_index", "samples", "sampling_rate"), int),
    **dict.fromkeys(("namespace", "sha256", "dcrb_ros", "model"), str),
}
"""Types of entries of the manifest; a manifest with another type counts as damaged."""
DAMAGE = (ValueError, KeyError, TypeError, RecursionError)
"""Exceptions that a damaged manifest may raise."""


class Recording:
    """A recording of the bench, or of imported data: a rosbag2 folder or a single MCAP file.

    Raises
    ------
    Refusal
        There is no recording, or it is not a recording of the bench.
    """

    def __init__(self, path: str | Path) -> None:
        if not isinstance(path, (str, os.PathLike)):
            raise Refusal(f"{path!r} is not the path of a recording: give a folder made by dcrb simulate or dcrb bench, or an .mcap file")
        self.path = Path(path)
        self.files, self.damage = valid_files(self.path)
        """The MCAP files in order; a sentence for everything that could not be read so far."""
        self.manifest = self._manifest()
        if self.manifest.get("format", 1) != 1 and self.outcome is None:
            self._report(f"{self.files[-1].name}: the end is missing, the recording was cut off")
        self._configuration = self._read_configuration()

    def __repr__(self) -> str:
        rate, samples = self.manifest.get("sampling_rate", 0), (self.outcome or {}).get("samples", 0)
        length = f"{samples / rate:.4g} s" if rate and samples else "of unknown length"
        content = "imported data" if self._configuration is None else self._configuration.summary
        return f"<Recording {self.path}: {length} at {rate / 1e3:g} kHz, {content}{'' if self.complete else ', damaged'}>"

    @property
    def complete(self) -> bool:
        """Whether everything read so far was intact."""
        return not self.damage

    @property
    def configuration(self) -> Configuration:
        """Configuration of the bench.

        Raises
        ------
        Refusal
            The recording contains imported data.
        """
        if self._configuration is None:
            raise Refusal(f"{self.path} contains imported data, not a run of the bench: it has no configuration")
        return self._configuration

    @property
    def imported(self) -> bool:
        """Whether the recording contains imported data."""
        return self._configuration is None

    @property
    def namespace(self) -> str:
        """Namespace of the topics."""
        return str(self.manifest.get("namespace", NAMESPACE))

    @cached_property
    def sampling_rate(self) -> int:
        """Sampling rate [Hz]."""
        rate = self.manifest.get("sampling_rate")
        if not isinstance(rate, int) or not 0 < rate <= 10_000_000:
            raise Refusal(f"the manifest of {self.path} gives a sampling rate of {rate!r} Hz: it must be a whole number above 0")
        return rate

    @cached_property
    def orders(self) -> Orders:
        """Characteristic orders of the bearing."""
        if self._configuration is not None:
            return characteristic_orders(self._configuration.bearing)
        try:
            return Orders.from_dict(self.manifest["orders"])
        except DAMAGE:
            raise Refusal(f"the manifest of {self.path} gives no fault orders: import the data again") from None

    @cached_property
    def outcome(self) -> Mapping[str, Any] | None:
        """The outcome record at the end of the recording; none if it was cut off."""
        return self._last(OUTCOME, "outcome")

    def commands(self) -> list[TimedCommand]:
        """Return the commands of the run, from the outcome record or from the ground truth."""
        entries = (self.outcome or {}).get("commands")
        if isinstance(entries, list):
            try:
                return [decode_command(entry) for entry in entries]
            except DAMAGE:
                self._report("the commands in the manifest are damaged")
        return commands_in(decode_truth(message.data) for message in self.messages((GROUND_TRUTH,)))

    def messages(self, topics: Iterable[Topic] | None = None, *, namespace: str | None = None) -> Iterator[Message]:
        """Yield the messages on some topics, by default on all topics of the bench, in the order of the file."""
        prefix = self.namespace if namespace is None else namespace
        wanted = {topic.resolved(prefix): topic for topic in (topics or (*SIMULATED, *DETECTED))}
        for channel, message in self._records(wanted):
            yield Message(wanted[channel.topic], message.log_time, message.data)

    def vibrations(self) -> Iterator[Vibration]:
        """Yield the blocks of the waveform; see `ranged_vibrations`."""
        return (vibration for vibration, _ in self.ranged_vibrations())

    def ranged_vibrations(self) -> Iterator[tuple[Vibration, float]]:
        """Yield the blocks of the waveform, each with the sensor's range at that time [m/s^2]; 0 if it is unknown.

        Raises
        ------
        Refusal
            The recording has no waveform.
        """
        found, sensor_range = False, self._first_range()
        for message in self.messages((SENSOR, VIBRATION)):
            if message.topic == SENSOR:
                sensor_range = decode_range(message.data)
                continue
            found = True
            yield decode_vibration(message.data), sensor_range
        if not found:
            raise Refusal(f"{self.path} contains no messages on {VIBRATION.resolved(self.namespace)}: give a recording of the bench")

    def pieces(self) -> Iterator[Piece]:
        """Yield the blocks of the waveform with their first samples, as `dcrb_ros.detect` takes them."""
        return arrays.pieces_of(self)

    def waveform(self, start: float | None = None, stop: float | None = None) -> Waveform:
        """Return the samples with ``start <= time < stop`` [s], all of them by default.

        Raises
        ------
        Refusal
            The recording has no waveform, or no sample in that time.

        Examples
        --------
        >>> from dcrb_ros import Recording
        >>> Recording("bags/outer_ring_defect").waveform(1.0, 1.5)
        <Waveform: 0.5 s at 51.2 kHz (25600 samples), shaft at 20.00 Hz>
        """
        return arrays.waveform_of(self, start, stop)

    def states(self) -> StateHistory:
        """Return the bodies over time: azimuth, speed and inner normal force, and the contacts where ``roller_contacts`` was recorded.

        Raises
        ------
        Refusal
            The recording has no ``roller_states``.
        """
        return arrays.states_of(self)

    def truth(self) -> GroundTruth:
        """Return the ground truth over time; of imported data it is empty."""
        return arrays.truth_of(self)

    def verdicts(self) -> list[RecordedVerdict]:
        """Return what a detector published while the recording was made; empty where none ran."""
        return arrays.verdicts_of(self)

    def to_pandas(self) -> pd.DataFrame:
        """Return the waveform as a DataFrame over time [s]; see `Waveform.to_pandas`. States and ground truth have one of their own.

        Raises
        ------
        Refusal
            pandas is not installed, or the recording has no waveform.
        """
        return self.waveform().to_pandas()

    def counts(self) -> dict[str, int]:
        """Return the number of messages per topic."""
        return dict(sorted(Counter(channel.topic for channel, _ in self._records()).items()))

    def _manifest(self) -> dict[str, Any]:
        """Return the manifest of the first file that has one."""
        for file in self.files:
            for record in McapRecords(file, chunks=False):
                if isinstance(record, Metadata) and record.name == MANIFEST:
                    found = _json(record, "manifest")
                    if found is not None:
                        return found
                    break
        raise Refusal(
            f"{self.path} has no manifest of the bench: give a recording made by dcrb simulate, dcrb bench or dcrb import; "
            "dcrb recover repairs the container of any other"
        )

    def _read_configuration(self) -> Configuration | None:
        if "imported" in self.manifest:
            return None
        try:
            return Configuration.model_validate(self.manifest["configuration"])
        except DAMAGE as error:
            first = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise Refusal(
                f"the configuration in {self.path} was written by dcrb_ros {self.manifest.get('dcrb_ros', 'of an unknown version')} and is "
                f"not understood by {__version__} ({first}): read it with that version"
            ) from None

    def _first_range(self) -> float:
        """Return the sensor's range in the manifest [m/s^2]; 0 if there is none."""
        about = self.manifest.get("sensor") or self.manifest.get("configuration", {}).get("sensor")
        found = about.get("range") if isinstance(about, Mapping) else None
        return float(found) if isinstance(found, int | float) and found > 0.0 else 0.0

    def _last(self, name: str, key: str) -> dict[str, Any] | None:
        """Return the last metadata record with a name in the last file."""
        found = None
        for record in McapRecords(self.files[-1], chunks=False):
            if isinstance(record, Metadata) and record.name == name:
                found = record
        return _json(found, key) if found else None

    def _records(self, topics: Container[str] | None = None) -> Iterator[tuple[Channel, McapMessage]]:
        """Yield the messages on some topics, by default on all, with their channels."""
        for file in self.files:
            channels: dict[int, Channel] = {}
            records = McapRecords(file, topics=topics)
            for record in records:
                if isinstance(record, Channel):
                    channels[record.id] = record
                elif isinstance(record, McapMessage) and record.channel_id in channels:
                    yield channels[record.channel_id], record
            for sentence in records.damage:
                self._report(sentence)

    def _report(self, sentence: str) -> None:
        if sentence not in self.damage:
            self.damage.append(sentence)


def _json(record: Metadata, key: str) -> dict[str, Any] | None:
    """Return the JSON object in a metadata record; none if it is damaged."""
    try:
        found = json.loads(record.metadata[key])
    except DAMAGE:
        return None
    sound = isinstance(found, dict) and all(isinstance(found.get(name, kind()), kind) for name, kind in TYPES.items())
    return found if sound else None


def valid_files(path: Path) -> tuple[list[Path], list[str]]:
    """Return the MCAP files of a recording, and a sentence for each file that is left out because it does not begin like one.

    A crash or a power loss right after a split leaves an empty file.

    Raises
    ------
    Refusal
        There are none.
    """
    if not path.exists():
        raise Refusal(f"there is no recording {path}: give a folder made by dcrb simulate or dcrb bench, or an .mcap file")
    files = sorted(path.glob("*.mcap"), key=_file_order) if path.is_dir() else [path]
    if not files:
        raise Refusal(f"{path} contains no .mcap file: give the folder of a recording")
    flaws = {file: flaw for file in files if (flaw := _flaw(file))}
    if len(flaws) == len(files):
        raise Refusal(f"{files[0]} is not an MCAP file: it {flaws[files[0]]}")
    return [file for file in files if file not in flaws], [
        f"{file.name}: left out, not an MCAP file: it {flaw}" for file, flaw in flaws.items()
    ]


def _flaw(file: Path) -> str:
    """Return what is wrong with the first bytes of an MCAP file; the empty string if nothing."""
    try:
        with file.open("rb") as stream:
            magic = stream.read(len(MAGIC))
    except OSError as error:
        raise Refusal(f"{file} cannot be read: {error.strerror}") from None
    if magic == MAGIC:
        return ""
    return f"must begin with {MAGIC!r}" if magic else "is empty"


def _file_order(path: Path) -> tuple[str, int, str]:
    """Return a sort key that puts NAME_2 before NAME_10."""
    found = re.fullmatch(r"(.*)_(\d{1,9})", path.stem)
    return (found[1], int(found[2]), path.name) if found else (path.stem, -1, path.name)


def metadata_flaw(path: Path) -> str:
    """Return what is wrong with metadata.yaml, which ROS needs and this reader does not; the empty string if nothing."""
    file = path / METADATA
    if not path.is_dir():
        return ""
    try:
        if file.stat().st_size > MAX_METADATA:
            return f"{METADATA} has {file.stat().st_size} bytes, at most {MAX_METADATA} are read"
        about = yaml.safe_load(file.read_text(encoding="utf-8"))["rosbag2_bagfile_information"]
        named = [str(name) for name in about["relative_file_paths"]]
    except OSError as error:
        return f"{METADATA} cannot be read: {error.strerror}"
    except (yaml.YAMLError, UnicodeDecodeError, *DAMAGE):
        return f"{METADATA} is damaged"
    there = [found.name for found in valid_files(path)[0]]
    missing = [name for name in there if name not in named]
    return f"{METADATA} does not name {', '.join(missing)}" if missing else ""
