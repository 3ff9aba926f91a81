"""What may happen to a file that a program keeps for itself: other bytes, or something else in its place."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path


def flip(file: Path) -> None:
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 1
    file.write_bytes(content)


def flip_last(file: Path) -> None:
    content = bytearray(file.read_bytes())
    content[-1] ^= 1
    file.write_bytes(content)


def folder(file: Path) -> None:
    file.unlink()
    file.mkdir()
    (file / "file").write_text("within")


def pipe(file: Path) -> None:
    file.unlink()
    os.mkfifo(file)


def broken_link(file: Path) -> None:
    file.unlink()
    file.symlink_to(file.with_name("missing"))


def link_to_folder(file: Path) -> None:
    file.unlink()
    target = file.parent.parent / "linked"
    target.mkdir(exist_ok=True)
    file.symlink_to(target)


def link_to_other(file: Path) -> None:
    """Put a link to a damaged file of another name in its place."""
    other = file.parent.parent / "another"
    shutil.move(file, other)
    file.symlink_to(other)
    flip(other)


def unreadable(file: Path) -> None:
    """Make a file unreadable; for root, who reads any file, put a link that leads to itself in its place."""
    if os.geteuid():
        file.chmod(0)
    else:
        file.unlink()
        file.symlink_to(file)


CHANGES: dict[str, Callable[[Path], object]] = {
    "flipped": flip,
    "flipped at the end": flip_last,
    "truncated": lambda file: file.write_bytes(file.read_bytes()[:-5]),
    "without digest": lambda file: file.write_bytes(file.read_bytes()[32:]),
    "nearly empty": lambda file: file.write_bytes(file.read_bytes()[:9]),
    "empty": lambda file: file.write_bytes(b""),
}
"""Other bytes."""
REPLACEMENTS: dict[str, Callable[[Path], object]] = {
    "folder": folder,
    "pipe": pipe,
    "broken link": broken_link,
    "link to a folder": link_to_folder,
    "link to other bytes": link_to_other,
    "unreadable": unreadable,
}
"""Something else under the name of the file."""
ATTACKS = CHANGES | REPLACEMENTS
