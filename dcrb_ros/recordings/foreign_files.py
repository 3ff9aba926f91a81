"""Files of another recording in the folder of a recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from dcrb_ros.messages.topics import MANIFEST
from dcrb_ros.recordings.manifest import well_formed
from dcrb_ros.recordings.storage import StoredFile
from dcrb_ros.recordings.vehicle_folder import VEHICLE
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.json import digest_of, parsed_json

KEYS = {MANIFEST: "manifest", VEHICLE: "vehicle"}
"""Entry of each metadata record that is the same in all files of a recording."""


def sound(name: str, entries: Mapping[str, str]) -> bool:
    """Return whether a metadata record has the form and the digest that the bench writes; those of other programs count as sound."""
    kind = name.partition("/")[0]
    if kind not in KEYS:
        return True
    try:
        content = parsed_json(entries.get(KEYS[kind], ""), name)
    except Refusal:
        return False
    return well_formed(content) and (kind != VEHICLE or content.get("sha256") == digest_of(content, "sha256"))


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
    return found.get(KEYS[record], "") if sound(record, found) else None
