"""Shipped descriptions of public data sets: rate, bearing, channels, labels, licence and publisher, without any data."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from dcrb_ros.settings.shipped import find_shipped, shipped
from dcrb_ros.text.yaml import read_yaml


def public_sets() -> dict[str, Path]:
    """Return the shipped descriptions by name."""
    return shipped("description")


def find_description(source: str) -> Path:
    """Return the path of a description given as a file or by the name of a public data set.

    Raises:
        Refusal: it is neither.
    """
    return find_shipped("description", source)


def listed() -> list[str]:
    """Return a line for each public data set: its name, its title and its address."""
    width = max(map(len, public_sets()), default=0)
    return [f"{name:{width}}  {_line(read_yaml(path))}" for name, path in public_sets().items()]


def _line(tree: dict[str, Any]) -> str:
    source = tree["source"]
    return f"{source['title']}; {source['where']}"
