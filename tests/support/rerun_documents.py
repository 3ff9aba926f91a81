"""What a Rerun document contains."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any


def chunks(document: Path) -> Iterator[Any]:
    from rerun.chunk import RrdReader

    return iter(RrdReader(str(document)).stream())


def rows(document: Path) -> Counter[str]:
    """Return how many rows of every entity lie on the timeline."""
    found: Counter[str] = Counter()
    for chunk in chunks(document):
        found[chunk.entity_path] += 0 if chunk.is_static else chunk.num_rows
    return found
