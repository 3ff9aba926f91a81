"""Messages compressed one by one."""

from __future__ import annotations

import pytest
import zstandard

from dcrb_ros.recordings.compression import compression_of, unpacked_message

DATA = bytes(range(256)) * 40
PACKED = {
    "with its size": zstandard.compress(DATA),
    "without its size": zstandard.ZstdCompressor(write_content_size=False).compress(DATA),
}


@pytest.mark.parametrize("name", PACKED)
def test_a_message_up_to_the_limit_is_unpacked(name: str) -> None:
    assert compression_of(PACKED[name]) == "zstd"
    assert unpacked_message(PACKED[name], len(DATA)) == DATA
    words = {
        "with its size": f"it unpacks to {len(DATA)} bytes; at most {len(DATA) - 1} are read",
        "without its size": f"damaged or has more than {len(DATA) - 1} bytes",
    }
    with pytest.raises(ValueError, match=words[name]):
        unpacked_message(PACKED[name], len(DATA) - 1)


@pytest.mark.parametrize("name", PACKED)
def test_a_message_that_is_cut_off_is_refused(name: str) -> None:
    for kept in range(4, len(PACKED[name])):
        with pytest.raises(ValueError, match="error"):
            unpacked_message(PACKED[name][:kept], len(DATA))


def test_a_message_in_cdr_is_not_compressed() -> None:
    for encapsulation in (b"\0\0\0\0", b"\0\1\0\0", b"\0\7\0\0"):
        assert compression_of(encapsulation + DATA) == ""
