"""Notches: a groove of constant depth across a surface (Eqs. 8, 9 and 13 to 15 of Fan et al. 2025)."""

from __future__ import annotations

import math
from collections.abc import Iterator

from dcrb_ros.faults.fault import Fault
from dcrb_ros.schema.fields import LENGTH_REMEDY, length


class Notch(Fault):
    """The parameters that every notch has."""

    width: float = length(0.0, "Width along the surface; 0 for no defect", 0.0, 0.05, symbol="b", run_time=True)
    depth: float = length(0.0003, "Depth; 0 for no defect", 0.0, 0.01, symbol="h", run_time=True)

    @property
    def present(self) -> bool:
        """Whether the notch has a width and a depth."""
        return self.width > 0.0 and self.depth > 0.0

    def too_wide(self, key: str, limit: float, what: str) -> Iterator[str]:
        """Yield a sentence if the width is not below a ``limit`` [m], the size of ``what``."""
        if self.width >= limit:
            yield f"faults.{key}.width = {self.width:g} m is not below the {what} of {limit:.4g} m: {LENGTH_REMEDY}"


def floor(half_angle: float, edge: float, other: float, distance: float, hollow: bool) -> tuple[float, float]:
    """Return where the other body touches the floor of a notch: the angle on either side of the middle [rad], and the drop of the slope
    of the depth at either end of it [m/rad].

    ``edge`` is the radius on which the notch's edges lie, ``other`` the other body's [m]; ``distance`` [m] is that of the centres with the
    floor in contact. ``hollow`` says that the other body is a raceway around the notched one.
    """
    squares = other**2 - edge**2 - distance**2 if hollow else distance**2 + edge**2 - other**2
    cosine = squares / (2.0 * distance * edge)
    inside = math.acos(min(cosine, 1.0)) if cosine > math.cos(half_angle) else half_angle
    sine, cosine = edge * math.sin(inside), edge * math.cos(inside)
    bend = sine * cosine / math.sqrt(other**2 - sine**2)
    return half_angle - inside, abs(bend - sine if hollow or distance < edge else bend + sine)
