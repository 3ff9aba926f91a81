"""Arguments and payloads of the node tests."""

from __future__ import annotations

GARBAGE = (b"\x00", b"\x00\x01\x00\x00", b"\x00\x01\x00\x00abc", b"\xff" * 12, b"\x4a\x93\x05\xe1\x77\x0c\xb2")
"""Bytes that are no CDR of any message here; short enough for every publisher to send them.

Not among them is the empty message: the middleware never delivers it, nor what the same publisher sends after it.
"""


def parameters(**values: object) -> list[str]:
    return ["--ros-args", *(word for key, value in values.items() for word in ("-p", f"{key.replace('__', '.')}:={value}"))]
