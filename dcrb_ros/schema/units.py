"""Units of acceleration that files and tables may use."""

from __future__ import annotations

ACCELERATION_UNITS = {"m/s^2": 1.0, "g": 9.80665, "mm/s^2": 1e-3}
"""Units of acceleration in m/s^2."""
