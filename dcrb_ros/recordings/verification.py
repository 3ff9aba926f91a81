"""What is known about the samples and records of a recording, in sentences for the user."""

from __future__ import annotations

from dcrb_ros.recordings.digest import stated_samples
from dcrb_ros.recordings.manifest import DIGEST
from dcrb_ros.recordings.reader import Recording


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
