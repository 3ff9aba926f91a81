"""What the detector says at the end of a hop."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from dcrb_ros.diagnosis.judgement import Verdict

Spectrum = tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]


def _no_levels() -> dict[str, float]:
    return {"BPFO": 0.0, "BPFI": 0.0, "BSF": 0.0, "FTF": 0.0}


def _no_spectrum() -> Spectrum:
    return np.zeros(0), np.zeros(0)


@dataclass(frozen=True)
class Diagnosis:
    """What the detector thinks at the end of one hop."""

    index: int
    """Index of the last sample that was seen."""
    time: float
    """Time of that sample [s]."""
    verdict: Verdict
    reason: str
    """The evidence in one sentence."""
    confidence: float = 0.0
    """From 0.5 at a threshold towards 1 far from it; 0 without a verdict on the bearing."""
    levels: dict[str, float] = field(default_factory=_no_levels)
    """Level over background at BPFO, BPFI, BSF (twice its order) and FTF [dB]."""
    shaft_frequency: float = 0.0
    """Mean over the window [Hz]."""
    spectrum: Spectrum = field(default_factory=_no_spectrum)
    """Orders [-], and root of the squared envelope's amplitude there [m/s^2]; empty when there is none."""
    gaps: int = 0
    """Interruptions of the stream so far."""
    scores: dict[str, float] = field(default_factory=dict)
    """Evidence for each fault over its threshold, negative below it [dB]."""
    severity: float = 0.0
    """Lines of the named fault in the squared envelope, as an amplitude at 20 Hz of shaft frequency [m/s^2]."""
    trend: float = 0.0
    """Growth of the severity since the verdict began [dB/min]."""
    clipped: int = 0
    """Samples at the ends of the sensor's range so far."""
    remarks: tuple[str, ...] = ()
    """What was wrong with the stream, or special about it, without forbidding a verdict."""

    @property
    def time_ns(self) -> int:
        """Time of the last sample [ns]."""
        return round(self.time * 1e9)
