"""Numbers of things in sentences."""

from __future__ import annotations


def counted(number: int, thing: str, things: str = "") -> str:
    """Return ``1 recording`` or ``2 recordings`` for the ``thing`` "recording", of which there are ``number``; ``things`` is its plural."""
    return f"{number} {thing if number == 1 else things or f'{thing}s'}"
