"""The shipped configurations: where they are, and their names. Apart from `files`, so that lists and shell completion start at once."""

from __future__ import annotations

import sys
from pathlib import Path

from dcrb_ros.schema.refusal import Refusal, nearest
from dcrb_ros.text.files import checked_path, is_file


def find_configuration(source: str | Path) -> Path:
    """Return the path of a configuration given as a file or by a shipped name."""
    path = checked_path(source)
    if is_file(path):
        return path
    shipped = shipped_configurations()
    name = path.stem if path.suffix in (".yaml", ".yml") and path.parent.name in ("", "config") else str(source)
    if name in shipped and not path.exists():
        return shipped[name]
    raise Refusal(f"there is no configuration '{source}': give a YAML file or one of {', '.join(shipped)}{nearest(str(source), shipped)}")


def shipped_folder() -> Path:
    """Return the folder of the shipped configurations: in the repository, or in the share folder of the installation."""
    package = Path(__file__).resolve().parents[1]
    candidates = [package.parent / "config", *(parent / "share" / "dcrb_ros" / "config" for parent in package.parents)]
    candidates.append(Path(sys.prefix) / "share" / "dcrb_ros" / "config")
    return next((folder for folder in candidates if (folder / "healthy.yaml").is_file()), candidates[0])


def shipped_configurations() -> dict[str, Path]:
    """Return the files of the shipped configurations by name."""
    return {path.stem: path for path in sorted(shipped_folder().glob("*.yaml")) if path.stem != "detector"}
