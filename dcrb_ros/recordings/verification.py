"""What is known about the samples and records of a recording, in sentences for the user."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from dcrb_ros.messages.topics import MANIFEST
from dcrb_ros.recordings.digest import stated_samples
from dcrb_ros.recordings.manifest import DIGEST
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.storage import METADATA, StoredFile, named_files, plain_name, valid_files
from dcrb_ros.schema.printable import printable
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.json import parsed_json

RECOVERY = f"{MANIFEST}_recovery"
"""Name of the metadata record in which a recovery states its source and the losses."""
SHOWN_LOSSES = 5
"""Losses that are named at most [-]."""


def digest_mismatch(recording: Recording) -> str:
    """Return a sentence if the samples of a recording do not match the digest that it states, else the empty string."""
    return "" if stated_samples(recording.outcome) is None else recording.digests().mismatch


def unsigned(recording: Recording) -> str:
    """Return a sentence if manifest or outcome of a recording have no digest, so that they cannot be verified, else the empty string.

    Recordings of earlier versions have none. One without a manifest has nothing to verify.
    """
    records = {"manifest": None if recording.described else recording.manifest, "outcome record": recording.outcome}
    names = " and ".join(name for name, content in records.items() if content is not None and DIGEST not in content)
    if not names:
        return ""
    version = recording.manifest.get("dcrb_ros", "unknown")
    return (
        f"unverified: no digest in {names} (dcrb_ros {version}), so that a changed bearing, speed or fault is not found; recordings of "
        "earlier versions have none"
    )


def stated_losses(files: Sequence[StoredFile]) -> tuple[str, list[str]] | None:
    """Return the source and the losses that a recovered recording states; None if it was not recovered."""
    records = [record for file in files for record in file.metadata() if record.name == RECOVERY]
    if not records:
        return None
    try:
        about = parsed_json(records[-1].metadata["recovery"], RECOVERY)
        return printable(str(about["source"])), [printable(str(sentence)) for sentence in about["lost"]]
    except (ValueError, KeyError, TypeError):
        return "an unknown recording", [f"the record {RECOVERY} is damaged"]


def recovered(files: Sequence[StoredFile]) -> str:
    """Return a sentence on the losses of a recording that `dcrb recover` wrote, else the empty string.

    Its digests are those of the samples that were left, and match whatever was lost or altered before.
    """
    stated = stated_losses(files)
    if stated is None:
        return ""
    source, lost = stated
    more = [f"{len(lost) - SHOWN_LOSSES} more"] if len(lost) > SHOWN_LOSSES else []
    return f"recovered from {source}; lost: {'; '.join([*lost[:SHOWN_LOSSES], *more]) or 'nothing'}"


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
