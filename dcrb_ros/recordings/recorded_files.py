"""The files of a recording with their metadata records and messages, and a sentence for each part that could not be read."""

from __future__ import annotations

from collections.abc import Container, Iterator
from pathlib import Path
from typing import Any

from mcap.records import Metadata

from dcrb_ros.messages.topics import MANIFEST
from dcrb_ros.recordings.latched import described_manifest
from dcrb_ros.recordings.manifest import well_formed
from dcrb_ros.recordings.storage import StoredMessage, valid_files
from dcrb_ros.recordings.vehicle_folder import boxes_in, record_name
from dcrb_ros.schema.printable import printable
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.json import parsed_json


class RecordedFiles:
    """The files of a recording."""

    def __init__(self, path: Path) -> None:
        self.stored, self.damage = valid_files(path)
        """The files in order; a sentence for each part that could not be read so far."""

    def report(self, sentence: str) -> None:
        """Keep a new sentence about damage."""
        shown = printable(sentence)
        if shown not in self.damage:
            self.damage.append(shown)

    def messages(self, topics: Container[str] | None = None) -> Iterator[StoredMessage]:
        """Yield the messages on some topics, by default on all."""
        for file in self.stored:
            flaws: list[str] = []
            yield from file.messages(flaws, topics)
            for sentence in flaws:
                self.report(sentence)

    def content(self, record: Metadata, key: str, file: str) -> dict[str, Any] | None:
        """Return the JSON object in a metadata record; None if it is damaged, which is reported."""
        try:
            content = parsed_json(record.metadata.get(key, ""), f"{file}: the record {record.name}")
        except Refusal as refusal:
            self.report(str(refusal))
            return None
        if well_formed(content):
            return dict(content)
        self.report(f"{file}: the record {record.name} is damaged: it does not have the form and the digest that the bench writes")
        return None

    def manifest(self, path: Path, box: str) -> dict[str, Any]:
        """Return the manifest of the first file that has one, or the entries that follow from the description of the sensor.

        Raises:
            Refusal: there is neither, or the recording has no such ``box``; the sentence names the ``path``.
        """
        names = list[str]()
        for file in self.stored:
            records = list(file.metadata())
            names += [record.name for record in records]
            record = next((record for record in records if record.name == record_name(MANIFEST, box)), None)
            manifest = self.content(record, "manifest", file.path.name) if record else None
            if manifest is not None:
                return manifest
        boxes = boxes_in(names)
        if boxes and not box:
            raise Refusal(f"{path} is the recording of a vehicle: give one of its boxes, such as {path / boxes[0]}")
        if box in boxes:
            raise Refusal(f"{path} cannot be read: {self.damage[-1]}; simulate or record the vehicle again")
        if box:
            known = f"its boxes are {', '.join(boxes)}" if boxes else "it is not the recording of a vehicle"
            raise Refusal(f"there is no box {box} in {path.parent}: {known}")
        try:
            return described_manifest(path, self.stored)
        except Refusal as refusal:
            if not self.damage:
                raise
            raise Refusal(f"{refusal} ({self.damage[0]})") from None
