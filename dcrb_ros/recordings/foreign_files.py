"""Files of another recording in the folder of a recording."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from dcrb_ros.messages.topics import MANIFEST
from dcrb_ros.recordings.manifest import well_formed
from dcrb_ros.recordings.storage import StoredFile
from dcrb_ros.recordings.vehicle_folder import VEHICLE
from dcrb_ros.schema.refusal import Refusal

KEYS = {MANIFEST: "manifest", VEHICLE: "vehicle"}
"""Entry of each metadata record that is the same in all files of a recording."""


def refuse_foreign(path: Path, files: Sequence[StoredFile]) -> None:
    """Refuse the files of a recording unless all have the same manifest, or the same parameters of a vehicle.

    If no file has one, the recording was not made by the bench, and nothing is checked. A file whose record is damaged is accepted.

    Raises:
        Refusal: a file has another record, or an intact file has none.
    """
    for record in KEYS if len(files) > 1 else ():
        contents = {file.path.name: _content(file, record) for file in files}
        known = {name: content for name, content in contents.items() if content}
        first = next(iter(known), None)
        foreign = next((name for name, content in contents.items() if first and content is not None and content != known[first]), None)
        if foreign is not None:
            raise Refusal(
                f"{path} has files of more than one recording: the record {record} of {foreign} is missing or not that of {first}; "
                "move the files of the other recording out of the folder"
            )


def _content(file: StoredFile, record: str) -> str | None:
    """Return the content of a metadata record; empty if an intact file has none, None if it is damaged."""
    damage = list[str]()
    found = next((entry.metadata for entry in file.metadata(damage) if entry.name == record), None)
    if found is None:
        return None if damage else ""
    content = found.get(KEYS[record], "")
    try:
        return content if well_formed(json.loads(content)) else None
    except (ValueError, RecursionError):
        return None
