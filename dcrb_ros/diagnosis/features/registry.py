"""The families of features. A new one is a module of this package and a line here."""

from __future__ import annotations

from dcrb_ros.diagnosis.features.band_levels import BAND_LEVELS
from dcrb_ros.diagnosis.features.cepstrum import CEPSTRUM
from dcrb_ros.diagnosis.features.envelope_lines import ENVELOPE_LINES
from dcrb_ros.diagnosis.features.family import FeatureFamily
from dcrb_ros.diagnosis.features.kurtogram import KURTOGRAM
from dcrb_ros.diagnosis.features.spectral_coherence import SPECTRAL_COHERENCE
from dcrb_ros.diagnosis.features.statistics import STATISTICS

FAMILIES: tuple[FeatureFamily, ...] = (STATISTICS, BAND_LEVELS, KURTOGRAM, ENVELOPE_LINES, CEPSTRUM, SPECTRAL_COHERENCE)
"""In the order of their features; the kurtogram leaves its band for the lines of the envelope."""
