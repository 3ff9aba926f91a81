"""Files that a command is to write, checked before the work begins."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from dcrb_ros.schema.refusal import Refusal

PICTURES = (".png", ".svg", ".pdf")
"""Suffixes of the pictures that matplotlib writes."""


def check_output(option: str, file: Path, suffixes: Sequence[str] = ()) -> None:
    """Refuse a file that could not be written, or whose name does not end in one of ``suffixes``.

    Raises:
        Refusal: an unknown suffix, a folder that does not exist, a folder instead of a file, or no permission.
    """
    if suffixes and file.suffix not in suffixes:
        raise Refusal(f"{option} {file} has an unknown file type: the name must end in {', '.join(suffixes)}")
    if not file.parent.is_dir():
        raise Refusal(f"{option} {file} cannot be written: there is no folder {file.parent}; make it or give another file")
    if file.is_dir():
        raise Refusal(f"{option} {file} is a folder: give the name of a file in it")
    if not os.access(file if file.exists() else file.parent, os.W_OK):
        raise Refusal(f"{option} {file} cannot be written: permission denied; give another file")
