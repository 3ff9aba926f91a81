"""How the recording of a vehicle names its boxes: records of their own in the file, and paths such as ``run/axle_1.left``."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from pathlib import Path

from dcrb_ros.messages.topic import MANIFEST
from dcrb_ros.recordings.storage import valid_files
from dcrb_ros.schema.printable import printable
from dcrb_ros.schema.refusal import Refusal

VEHICLE = f"{MANIFEST}_vehicle"
"""Name of the metadata record with the parameters of the vehicle."""
VEHICLE_OUTCOME = f"{MANIFEST}_vehicle_outcome"
"""Name of the metadata record with duration and commands of the run."""
BOX_NAME = re.compile(r"axle_\d+\.(left|right)")
"""Name of a box."""


def record_name(name: str, box: str) -> str:
    """Return the name of a metadata record of a box; that of a single bench if ``box`` is empty."""
    return f"{name}/{box}" if box else name


def box_of(path: Path) -> tuple[Path, str]:
    """Return the recording and the name of the box for a path such as ``run/axle_1.left``; the path itself and "" for any other."""
    if BOX_NAME.fullmatch(path.name) and not os.path.lexists(path) and os.path.lexists(path.parent):
        return path.parent, path.name
    return path, ""


def title_of(path: Path) -> str:
    """Return the name of a recording or of a box in it: that of its folder, or that of its file without the suffix."""
    whole = path.resolve()
    return whole.stem if whole.is_file() else whole.name


def boxes_in(records: Iterable[str]) -> tuple[str, ...]:
    """Return the boxes that metadata records of these names describe.

    Raises:
        Refusal: a record describes something else, such as a path out of the recording.
    """
    prefix = record_name(MANIFEST, " ").strip()
    boxes = tuple(dict.fromkeys(name.removeprefix(prefix) for name in records if name.startswith(prefix)))
    other = next((name for name in boxes if not BOX_NAME.fullmatch(name)), None)
    if other is not None:
        raise Refusal(
            f"the record {printable(prefix + other)} was changed: {printable(other)} is not the name of a box, such as axle_1.left"
        )
    return boxes


def boxes_of(parameters: Iterable[str]) -> tuple[str, ...]:
    """Return the boxes that parameters of a vehicle with these dotted keys have."""
    found = (BOX_NAME.match(key) for key in parameters)
    return tuple(dict.fromkeys(match.group() for match in found if match))


def vehicle_boxes(path: Path) -> tuple[str, ...]:
    """Return the boxes in the recording of a vehicle; none for any other path, which need not exist."""
    if not path.exists():
        return ()
    try:
        return boxes_in(record.name for file in valid_files(path)[0] for record in file.metadata())
    except Refusal:
        return ()
