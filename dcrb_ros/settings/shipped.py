"""The shipped files: where they are, their names, and what a user names by a file or by a shipped name.

Apart from `files`, so that lists and shell completion start at once.
"""

from __future__ import annotations

import sys
from pathlib import Path

from dcrb_ros.schema.refusal import Refusal, nearest
from dcrb_ros.text.files import checked_path, is_file

FOLDERS = {"configuration": "", "scenario": "scenarios", "exam": "exams", "sweep": "sweeps", "description": "about", "vehicle": "vehicles"}
"""Kinds of shipped files, and their folders below `shipped_folder`."""


def shipped(kind: str) -> dict[str, Path]:
    """Return the shipped files of a kind by name."""
    files = sorted((shipped_folder() / FOLDERS[kind]).glob("*.yaml"))
    return {path.stem: path for path in files if path.stem != "detector"}


def find_shipped(kind: str, source: str | Path, name: str = "") -> Path:
    """Return the path of a file of a kind, given as it is or by its shipped ``name``, which is ``source`` unless it is given.

    Raises:
        Refusal: there is neither.
    """
    path, known, name = checked_path(source), shipped(kind), name or str(source)
    if is_file(path):
        return path
    if name in known:
        return known[name]
    raise Refusal(f"there is no {kind} '{source}': give a YAML file or one of {', '.join(known)}{nearest(str(source), known)}")


def find_configuration(source: str | Path) -> Path:
    """Return the path of a configuration, given as a file or by a shipped name, which may have the folder and the suffix of its file."""
    path = Path(source)
    as_file = path.suffix in (".yaml", ".yml") and path.parent.name in ("", "config")
    return find_shipped("configuration", source, path.stem if as_file else "")


def shipped_folder() -> Path:
    """Return the folder of the shipped configurations: in the repository, or in the share folder of the installation."""
    package = Path(__file__).resolve().parents[1]
    candidates = [package.parent / "config", *(parent / "share" / "dcrb_ros" / "config" for parent in package.parents)]
    candidates.append(Path(sys.prefix) / "share" / "dcrb_ros" / "config")
    return next((folder for folder in candidates if (folder / "healthy.yaml").is_file()), candidates[0])
