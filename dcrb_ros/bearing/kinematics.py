"""Characteristic frequencies of a roller bearing from its geometry."""

from __future__ import annotations

from dataclasses import dataclass

from dcrb_ros.settings.parameters import Bearing


@dataclass(frozen=True)
class Orders:
    """Characteristic frequencies as multiples of the shaft frequency (Eqs. 43 to 45 of Fan et al. 2025, and BSF)."""

    ftf: float
    """Cage rotation [-]."""
    bpfo: float
    """Rollers passing a point of the outer raceway [-]."""
    bpfi: float
    """Rollers passing a point of the inner raceway [-]."""
    bsf: float
    """Roller spin relative to the cage [-]; a roller defect strikes twice as often."""

    def frequencies(self, shaft_frequency: float) -> dict[str, float]:
        """Return FTF, BPFO, BPFI and BSF [Hz] at a shaft frequency [Hz]."""
        orders = {"FTF": self.ftf, "BPFO": self.bpfo, "BPFI": self.bpfi, "BSF": self.bsf}
        return {name: order * abs(shaft_frequency) for name, order in orders.items()}


def characteristic_orders(bearing: Bearing) -> Orders:
    """Return the orders of pure rolling, from r_R, r_M and the roller count (Eqs. 43 to 45)."""
    ratio = bearing.roller_radius / bearing.pitch_radius
    ftf = 0.5 * (1.0 - ratio)
    return Orders(
        ftf=ftf,
        bpfo=bearing.rollers_per_row * ftf,
        bpfi=bearing.rollers_per_row * (1.0 - ftf),
        bsf=0.5 * (1.0 - ratio**2) / ratio,
    )
