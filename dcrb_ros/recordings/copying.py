"""Copies of recordings for readers that take complete MCAP files only."""

from __future__ import annotations

from pathlib import Path

from dcrb_ros.recordings.mcap_writer import McapFile, described_channel
from dcrb_ros.recordings.reader import Recording


def plain_files(recording: Recording, folder: Path) -> tuple[Path, ...]:
    """Return the files of a recording that was read, or a copy of its readable messages where other readers do not take the files.

    Those take complete MCAP files with a summary and with messages that are not compressed; the copy is written to ``folder``.
    """
    if recording.complete and all(file.rereadable for file in recording.stored):
        return tuple(recording.files)
    copy = McapFile(folder / "copy.mcap", {}, "none")
    damage: list[str] = []
    for file in recording.stored:
        for number, stored in enumerate(file.messages(damage)):
            if stored.schema is not None:
                message = stored.message
                copy.write(described_channel(stored.channel, stored.schema), message.log_time, message.data, number)
    copy.close({})
    return (copy.path,)
