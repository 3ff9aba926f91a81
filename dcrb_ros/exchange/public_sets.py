"""Shipped descriptions of public data sets: rate, bearing, channels, labels, licence and publisher, without any data."""

from __future__ import annotations

from typing import Any

from dcrb_ros.settings.shipped import shipped
from dcrb_ros.text.yaml import read_yaml


def listed() -> list[str]:
    """Return a line for each public data set: its name, its title and its address."""
    sets = shipped("description")
    width = max(map(len, sets), default=0)
    return [f"{name:{width}}  {_line(read_yaml(path))}" for name, path in sets.items()]


def _line(tree: dict[str, Any]) -> str:
    source = tree["source"]
    return f"{source['title']}; {source['where']}"
