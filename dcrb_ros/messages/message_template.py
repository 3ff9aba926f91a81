"""Messages that repeat themselves: encoded once, then only the stamp and the numbers are put in anew."""

from __future__ import annotations

import struct

import numpy as np

STAMP = slice(4, 12)
"""Where the stamp of a message lies that begins with a header: behind the four bytes that say how CDR is encoded."""


def marks(count: int) -> bytes:
    """Return ``count`` bytes that no message has by itself, to be found again in one that was encoded with them."""
    return np.random.default_rng(count).bytes(count)


class MessageTemplate:
    """The bytes of an encoded message with holes for its stamp and for numbers whose count stays."""

    def __init__(self, encoded: bytes, *holes: bytes) -> None:
        """Cut the ``holes``, each of which occurs once, in this order, out of a message; an empty one is where the next piece begins.

        Raises:
            ValueError: a hole is not in the message.
        """
        self._head, rest = encoded[: STAMP.start], encoded[STAMP.stop :]
        self._pieces: list[bytes] = []
        for hole in holes:
            begin = rest.index(hole)
            self._pieces.append(rest[:begin])
            rest = rest[begin + len(hole) :]
        self._end = rest

    def filled(self, time_ns: int, *numbers: bytes) -> bytes:
        """Return the message of a stamp [ns] with ``numbers`` in its holes."""
        parts = [self._head, struct.pack("<iI", *divmod(time_ns, 1_000_000_000))]
        for piece, number in zip(self._pieces, numbers, strict=True):
            parts += (piece, number)
        return b"".join((*parts, self._end))
