"""The kernels as they are compiled for different processors."""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys

import numba
import pytest

from dcrb_ros.recordings.processor import FUSED, processor
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.simulation.loop import Simulation

AVX2 = {"NUMBA_CPU_NAME": "haswell", "NUMBA_CPU_FEATURES": "+sse4.2,+popcnt,+avx,+avx2,+fma,+bmi,+bmi2,+lzcnt"}
CASES = {
    "compound": ("compound", 0.5),
    "without oil, with losses": ("dry", 0.06),
}
"""Configuration and simulated time [s]."""
SETTINGS = {"without oil, with losses": ("contact.loss_time=1e-5", "contact.damping=50.0")}


def fingerprints() -> dict[str, str]:
    """Return a hash of the samples of each case."""
    found = {}
    for name, (bench, seconds) in CASES.items():
        made = Simulation(load_configuration(bench, SETTINGS.get(name, ())))
        found[name] = hashlib.sha256(b"".join(block.clean.tobytes() for block in made.blocks(seconds))).hexdigest()
    return found


@pytest.mark.slow
@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="needs the compiler")  # type: ignore[attr-defined]
def test_samples_do_not_depend_on_the_vectors_of_the_processor() -> None:
    """On those with fused multiply-add; of the two, AVX-512 has conditions inside of sums."""
    present = processor()["features"]
    if not {FUSED, "avx2", "avx512f"} <= set(present):
        pytest.skip(f"needs a processor with AVX-512; this one has {', '.join(present) or 'none of its features'}")
    code = "import json, test_jit; print(json.dumps(test_jit.fingerprints()))"
    path = os.pathsep.join([os.path.dirname(__file__), os.environ.get("PYTHONPATH", "")])
    environment = {**os.environ, **AVX2, "PYTHONPATH": path}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, timeout=600, check=True)
    assert json.loads(done.stdout) == fingerprints()
