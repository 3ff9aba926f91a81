"""Text for terminals and pages: control characters escaped, numbers without a negative zero."""

from __future__ import annotations


def printable(text: str) -> str:
    """Return a text whose control characters, directional marks and surrogates are escaped, as `repr` escapes them."""
    return text if text.isprintable() else "".join(map(_escaped, text))


def printable_lines(text: str) -> str:
    """Return a text of several lines, each of them `printable`."""
    return "\n".join(map(printable, text.split("\n")))


def shortened(text: str, longest: int, mark: str = " ...") -> str:
    """Return a text of at most ``longest`` characters; a longer one ends with a ``mark``."""
    return text if len(text) <= longest else f"{text[: longest - len(mark)]}{mark}"


def decimal(value: float, digits: int) -> str:
    """Return a number with some digits behind the point; what rounds to zero has no sign."""
    text = f"{value:.{digits}f}"
    return text.removeprefix("-") if float(text) == 0.0 else text


def _escaped(character: str) -> str:
    return character if character.isprintable() else character.encode("unicode_escape").decode("ascii")
