"""The result of the detector at the end of a hop."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from dcrb_ros.schema.verdicts import CHARACTERISTIC, Verdict, title_of

Spectrum = tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]


@dataclass(frozen=True)
class FoundLines:
    """The lines that are the evidence for a fault of one component."""

    probability: float
    """Of the fault: 0.5 at the threshold of the rule [-]."""
    order: float
    """Order of the fundamental [-]."""
    departure: float
    """Relative departure of that order from the kinematic one [-]."""
    orders: tuple[float, ...]
    """Orders of the harmonics [-]."""
    depth: float
    """Modulation depth: size relative to the mean squared envelope of the band [-]."""
    size: float
    """Square root of the amplitude in that band at 20 Hz of shaft frequency [m/s^2]."""
    significance: float
    """-log10 of the probability that noise has lines as strong within the range searched [-]."""
    band: tuple[float, float]
    """Edges of the band [Hz]."""


@dataclass(frozen=True)
class Diagnosis:
    """The result of the detector at the end of one hop."""

    index: int
    """Index of the last sample that it depends on."""
    time: float
    """Time of that sample [s]."""
    verdict: Verdict
    reason: str
    """The evidence in one sentence."""
    confidence: float = 0.0
    """Probability that the verdict is right: 0.5 at a threshold, up to 0.99 far from it; 0 without a verdict on the bearing."""
    levels: dict[str, float] = field(default_factory=lambda: dict.fromkeys(CHARACTERISTIC.values(), 0.0))
    """Level over background at BPFO, BPFI, BSF (twice its order) and FTF [dB]."""
    shaft_frequency: float = 0.0
    """Mean over the window [Hz]."""
    spectrum: Spectrum = field(default_factory=lambda: (np.zeros(0), np.zeros(0)))
    """Orders [-], and square root of the amplitudes of the squared envelope spectrum [m/s^2]; empty without a verdict, or if not kept."""
    gaps: int = 0
    """Gaps in the signal so far."""
    scores: dict[str, float] = field(default_factory=dict)
    """Evidence for a fault of each component relative to its threshold [dB]."""
    faults: tuple[str, ...] = ()
    """The confirmed faults, of which several make ``compound``."""
    lines: dict[str, FoundLines] = field(default_factory=dict)
    """Lines found for each component, in the band in which their evidence is strongest; empty without a judgement."""
    severity: float = 0.0
    """Square root of the amplitude of the fault's lines in the squared envelope spectrum, at 20 Hz of shaft frequency [m/s^2]."""
    trend: float = 0.0
    """Growth of the severity since this verdict was first made [dB/min]."""
    clipped: int = 0
    """Samples at the ends of the sensor's range so far."""
    baseline: str = ""
    """Which baseline of a healthy bearing was used, in words; empty for none."""
    remarks: tuple[str, ...] = ()
    """Peculiarities of the signal that do not prevent a verdict."""
    spectrum_remark: str = ""
    """The one of ``remarks`` that names the band of ``spectrum``; empty without a verdict."""

    @property
    def time_ns(self) -> int:
        """Time of the last sample [ns]."""
        return round(self.time * 1e9)

    @property
    def title(self) -> str:
        """The verdict in words, with the names of several faults."""
        return title_of(self.verdict, {name: self.scores[name] for name in self.faults})

    def without_spectrum(self) -> Diagnosis:
        """Return the diagnosis with an empty spectrum, which takes less memory."""
        return replace(self, spectrum=(np.zeros(0), np.zeros(0)))

    def __repr__(self) -> str:
        about = f"<Diagnosis: {self.verdict} at {self.time:.2f} s, confidence {self.confidence:.2f}"
        return f"{about}, shaft at {self.shaft_frequency:.2f} Hz: {self.reason}>"
