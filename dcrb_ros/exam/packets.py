"""Packets between the exam and the process of a detector, over a pair of sockets: a length of four bytes, then as many bytes."""

from __future__ import annotations

import socket
import time

LENGTH = 4
"""Bytes of the length of a packet [-]."""
LARGEST = 64 << 20
"""Largest packet [bytes]; a block has some thousand."""


def send_packet(channel: socket.socket, content: bytes, seconds: float | None = None) -> None:
    """Send a packet.

    Raises:
        TimeoutError: the other process has not taken it within ``seconds``.
        OSError: the other process has ended.
    """
    channel.settimeout(seconds)
    channel.sendall(len(content).to_bytes(LENGTH, "big") + content)


def receive_packet(channel: socket.socket, seconds: float | None = None) -> bytes | None:
    """Return the next packet; None if the other process has ended, or sends a packet that is too large.

    Raises:
        TimeoutError: no whole packet arrived within ``seconds``.
    """
    deadline = None if seconds is None else time.monotonic() + seconds
    head = _received(channel, LENGTH, deadline)
    length = int.from_bytes(head, "big") if head is not None else LARGEST + 1
    return _received(channel, length, deadline) if length <= LARGEST else None


def _received(channel: socket.socket, count: int, deadline: float | None) -> bytes | None:
    """Return ``count`` bytes; None if the other process has ended."""
    content = bytearray()
    while len(content) < count:
        channel.settimeout(None if deadline is None else max(1e-3, deadline - time.monotonic()))
        try:
            part = channel.recv(count - len(content))
        except TimeoutError:
            raise
        except OSError:
            return None
        if not part:
            return None
        content += part
    return bytes(content)
