"""The exception for invalid input."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

MAX_COMPARED = 100
"""Longest word for which a suggestion is searched [characters]; the time grows with the square of the length."""


class Refusal(ValueError):
    """Invalid input. The message is one sentence with the value, the valid range and the remedy.

    The command line prints the sentence and exits with status 2; a running node logs and counts it and continues.
    """


def nearest(word: str, known: Iterable[str]) -> str:
    """Return ``"; did you mean 'x'?"`` for the known word closest to ``word``, or an empty string."""
    found = difflib.get_close_matches(word, list(known), n=1, cutoff=0.6) if len(word) <= MAX_COMPARED else []
    return f"; did you mean '{found[0]}'?" if found else ""
