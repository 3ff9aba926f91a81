"""The families of features. A new family needs its own file and one line here."""

from __future__ import annotations

from pkgutil import resolve_name

from dcrb_ros.diagnosis.features.family import FeatureFamily

FAMILIES: tuple[FeatureFamily, ...] = tuple(
    resolve_name(f"dcrb_ros.diagnosis.features.{name}")
    for name in (
        "statistics:STATISTICS",
        "band_levels:BAND_LEVELS",
        "kurtogram:KURTOGRAM",
        "envelope_lines:ENVELOPE_LINES",
        "cepstrum:CEPSTRUM",
        "spectral_coherence:SPECTRAL_COHERENCE",
    )
)
"""In the order of their features; the kurtogram leaves its band for the lines of the envelope."""
