"""The exception for invalid input, and the warning about input that was altered."""

from __future__ import annotations

import difflib
from collections import Counter
from collections.abc import Hashable, Iterable
from typing import TypeVar

from dcrb_ros.schema.printable import printable

Item = TypeVar("Item", bound=Hashable)

MAX_COMPARED = 100
"""Longest word for which a suggestion is searched [characters]; the time grows with the square of the length."""

LONGEST = 2000
"""Longest sentence [characters]; it may quote a value of any length."""


MAX_SUGGESTED = 3
"""Suggestions in a message at most [-]."""
LEAST_LIKENESS, GOOD_LIKENESS = 0.6, 0.8
"""Likeness of words from which one is suggested for the other, and from which it is the likely one [-]; see `difflib`."""


class Refusal(ValueError):
    """Invalid input. The message is one sentence with the value, the valid range and the remedy.

    The command line prints the sentence and exits with status 2; a running node logs and counts it and continues. What it quotes comes from
    outside: control characters are escaped, and the middle of a very long sentence is left out.
    """

    def __init__(self, sentence: str) -> None:
        shown = printable(sentence)
        super().__init__(shown if len(shown) <= LONGEST else f"{shown[: LONGEST // 2]} ... {shown[-LONGEST // 2 :]}")


class AlteredSamples(UserWarning):
    """The samples of a recording do not match the digest that it states."""


def nearest(word: str, known: Iterable[str], likeness: float = LEAST_LIKENESS) -> str:
    """Return ``"; did you mean 'x'?"`` for the known word closest to ``word``, or an empty string if none is like it."""
    return _question(_close(word, known, likeness))


def repeated(items: Iterable[Item]) -> Item | None:
    """Return the first of the items, such as names, that occur more than once; None if there is none."""
    return next((item for item, count in Counter(items).items() if count > 1), None)


def nearest_key(key: str, known: Iterable[str]) -> str:
    """Return ``"; did you mean 'group.x'?"`` for the dotted keys closest to ``key``, or an empty string.

    A key is also found by its last parts: in full, without its group or with another one, misspelt, or as one word of several.
    """
    if len(key) > MAX_COMPARED:
        return ""
    keys = list(known)
    last = key.rpartition(".")[2]
    return _question(
        _ending_with(key, keys)
        or _close(key, keys, GOOD_LIKENESS)
        or next(filter(None, (_ending_with(part, keys) for part in _endings(key))), [])
        or [known for known in keys if last in known.rpartition(".")[2].split("_")]
        or _close(key, keys, LEAST_LIKENESS)
        or next(filter(None, (_ending_with(part, keys) for part in _close(last, {k.rpartition(".")[2] for k in keys}, GOOD_LIKENESS))), [])
    )


def _close(word: str, known: Iterable[str], likeness: float) -> list[str]:
    """Return the known word closest to ``word``, if their likeness is large enough."""
    return difflib.get_close_matches(word, sorted(known), n=1, cutoff=likeness) if len(word) <= MAX_COMPARED else []


def _ending_with(part: str, keys: Iterable[str]) -> list[str]:
    """Return the dotted keys whose last parts are ``part``."""
    return [key for key in keys if key.endswith(f".{part}")]


def _endings(key: str) -> list[str]:
    """Return a dotted key without its first part, without its first two parts and so on."""
    parts = key.split(".")
    return [".".join(parts[first:]) for first in range(1, len(parts))]


def _question(words: list[str]) -> str:
    """Return the words found as a question; of many the first ones."""
    if not words:
        return ""
    *others, last = [f"'{word}'" for word in words[:MAX_SUGGESTED]]
    return f"; did you mean {', '.join(others)}{' or ' if others else ''}{last}?"
