"""The one exception that a border raises towards the user."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

LONGEST_WORD = 100
"""Longest word that is compared with known ones [characters]: comparing takes the square of it."""


class Refusal(Exception):
    """Input that is refused: one sentence with the value, the range and the remedy.

    The command line prints the sentence and ends with status 2; a running node logs it, counts it and runs on.
    """


def nearest(word: str, known: Iterable[str]) -> str:
    """Return ``"; did you mean 'x'?"`` for the known word closest to ``word``, or an empty string."""
    found = difflib.get_close_matches(word, list(known), n=1, cutoff=0.6) if len(word) <= LONGEST_WORD else []
    return f"; did you mean '{found[0]}'?" if found else ""
