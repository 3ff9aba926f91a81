"""Random numbers: a stream of its own for every stage, so that switching one stage changes no other."""

from __future__ import annotations

import hashlib

import numpy as np


def stream(seed: int, stage: str) -> np.random.Generator:
    """Return the random numbers of a stage: a Philox stream whose key is a hash of the seed and the stage's name."""
    key = hashlib.sha256(f"{seed}/{stage}".encode()).digest()
    return np.random.Generator(np.random.Philox(key=int.from_bytes(key[:16], "little")))
