"""Random numbers by counters: the same for equal counters, whatever was drawn before, so that a run can be cut into any blocks."""

from __future__ import annotations

import math

from dcrb_ros.core.arithmetic import logarithm
from dcrb_ros.core.jit import kernel

WORD = 0xFFFFFFFF
"""The lower 32 bits."""
FIRST, SECOND = 0x21F0AAAD, 0x735A2D97
"""Multipliers of a mixing function of 32 bits, both below 2^31, so that no product exceeds 63 bits; "lowbias32" of C. Wellons and others,
https://github.com/skeeto/hash-prospector."""
SECOND_DRAW = 0x5BD1E995
"""What makes the second number of a pair another one."""


@kernel
def mixed(word: int) -> int:
    """Return a permutation of 32 bits in which every bit depends on every other."""
    word = word & WORD
    word = ((word ^ (word >> 16)) * FIRST) & WORD
    word = ((word ^ (word >> 15)) * SECOND) & WORD
    return word ^ (word >> 15)


@kernel
def key_of(seed: int, first: int, second: int, counter: int) -> int:
    """Return a word of 32 bits for a seed, two names of a stream and a counter, which may be below zero."""
    return mixed(mixed(mixed(mixed(seed) ^ (first & WORD)) ^ (second & WORD)) ^ (counter & WORD))


@kernel
def normal_of(key: int) -> float:
    """Return a standard normal number for a word of 32 bits (Box and Muller)."""
    first, second = mixed(key), mixed(key ^ SECOND_DRAW)
    return math.sqrt(-2.0 * logarithm((first + 1.0) * (1.0 / 4294967296.0))) * math.cos(second * (2.0 * math.pi / 4294967296.0))
