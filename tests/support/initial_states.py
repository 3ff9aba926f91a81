"""A hash of the initial states of shipped benches, in this process or, as a program, in one of its own."""

from __future__ import annotations

import hashlib

import numpy as np

from dcrb_ros.bearing.payload import build_payload, initial_state
from dcrb_ros.settings.files import load_configuration

BENCHES = ("healthy", "outer_ring_defect", "compound", "cage_fracture", "paper")
SPEEDS = (20.0, 40.0, 124.8)


def initial_states_hash() -> str:
    """Return a hash of the initial states of all benches at all speeds."""
    digest = hashlib.sha256()
    for name in BENCHES:
        for speed in SPEEDS:
            configuration = load_configuration(name, (f"operating.speed={speed}",))
            digest.update(b"".join(np.asarray(part).tobytes() for part in initial_state(configuration, build_payload(configuration))))
    return digest.hexdigest()


if __name__ == "__main__":
    print(initial_states_hash(), end="")
