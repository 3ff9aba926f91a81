"""Shipped descriptions of public data sets: rate, bearing, channels, labels, licence and publisher, without any data."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from dcrb_ros.schema.refusal import Refusal, nearest
from dcrb_ros.settings.shipped import shipped_folder
from dcrb_ros.text.files import checked_path, is_file
from dcrb_ros.text.yaml import read_yaml


def public_sets() -> dict[str, Path]:
    """Return the shipped descriptions by name."""
    return {path.stem: path for path in sorted((shipped_folder() / "about").glob("*.yaml"))}


def find_description(source: str) -> Path:
    """Return the path of a description given as a file or by the name of a public data set.

    Raises:
        Refusal: it is neither.
    """
    path, shipped = checked_path(source), public_sets()
    if source in shipped and not is_file(path):
        return shipped[source]
    if path.suffix not in (".yaml", ".yml") and not path.exists():
        known = ", ".join(shipped)
        raise Refusal(f"there is no description '{source}'{nearest(source, shipped)}: give a YAML file or one of {known}")
    return path


def listed() -> list[str]:
    """Return a line for each public data set: its name, its title and its address."""
    width = max(map(len, public_sets()), default=0)
    return [f"{name:{width}}  {_line(read_yaml(path))}" for name, path in public_sets().items()]


def _line(tree: dict[str, Any]) -> str:
    source = tree["source"]
    return f"{source['title']}; {source['where']}"
