"""Names of kept results, which change with everything on which they depend: a later call continues with results of the same model only."""

from __future__ import annotations

import hashlib
from pathlib import Path

from dcrb_ros.exam.case import canonical
from dcrb_ros.exam.detector_families import package_digest
from dcrb_ros.recordings.manifest import model_fingerprint

HERE = Path(__file__).parent
SOURCES = (
    *("drawn_machines.py", "impact_trains.py", "line_ratio.py", "signal_machines.py", "signal_statistics.py"),
    *("../dcrb_ros/exam/replica.py", "../dcrb_ros/exam/replica_geometry.py", "../dcrb_ros/exam/replica_priors.py"),
    *("sim_to_real_data.py", "sim_to_real_trainings.py", "spectrum_shares.py", "../dcrb_ros/validation/realism.py"),
)
"""Sources beside those of the model and of the detector, which draw machines and take statistics and features."""


def digest_of(*about: object) -> str:
    """Return a short hash of the model, the detector, `SOURCES`, and what else a result depends on: numbers, texts and lists of them."""
    digest = hashlib.sha256(canonical([model_fingerprint(), package_digest(), *about]).encode())
    for name in SOURCES:
        digest.update(hashlib.sha256((HERE / name).read_bytes()).digest())
    return digest.hexdigest()[:12]
