"""The file metadata.yaml of a recording, which ROS needs."""

from __future__ import annotations

from pathlib import Path

from dcrb_ros.recordings.storage import METADATA, named_files, plain_name, valid_files
from dcrb_ros.schema.refusal import Refusal


def metadata_flaw(path: Path) -> str:
    """Return the mistake in metadata.yaml, which ROS needs and this reader does not; the empty string if it is valid."""
    if not path.is_dir():
        return ""
    try:
        named = named_files(path)
    except Refusal as refusal:
        return str(refusal).replace(str(path / METADATA), METADATA)
    except (ValueError, KeyError, TypeError, RecursionError):
        return f"{METADATA} is damaged: it must have rosbag2_bagfile_information with relative_file_paths"
    files = [file.path.name for file in valid_files(path)[0]]
    missing = [name for name in files if plain_name(name) not in named]
    return f"{METADATA} does not name {', '.join(missing)}" if missing else ""
