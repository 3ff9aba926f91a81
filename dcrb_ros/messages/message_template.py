"""Templates of messages that differ only in stamp and numbers: encoded once, then filled."""

from __future__ import annotations

import struct

import numpy as np

STAMP = slice(4, 12)
"""Position of the stamp in a message that begins with a header: after the four bytes of the CDR encapsulation."""


def placeholder_bytes(count: int) -> bytes:
    """Return ``count`` random bytes by which the position of an array in an encoded message is found."""
    return np.random.default_rng(count).bytes(count)


class MessageTemplate:
    """An encoded message without its stamp and without arrays of constant length."""

    def __init__(self, encoded: bytes, *placeholders: bytes) -> None:
        """Cut the ``placeholders``, which occur once and in this order, out of a message; an empty one marks an empty array.

        Raises:
            ValueError: a placeholder is not in the message.
        """
        self._head, rest = encoded[: STAMP.start], encoded[STAMP.stop :]
        self._pieces: list[bytes] = []
        for placeholder in placeholders:
            begin = rest.index(placeholder)
            self._pieces.append(rest[:begin])
            rest = rest[begin + len(placeholder) :]
        self._end = rest

    def filled(self, time_ns: int, *numbers: bytes) -> bytes:
        """Return the message with a stamp [ns] and the bytes of the arrays in place of the placeholders."""
        parts = [self._head, struct.pack("<iI", *divmod(time_ns, 1_000_000_000))]
        for piece, number in zip(self._pieces, numbers, strict=True):
            parts += (piece, number)
        return b"".join((*parts, self._end))
