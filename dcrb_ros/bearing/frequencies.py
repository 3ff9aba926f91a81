"""Characteristic frequencies of a roller bearing from its geometry."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

from dcrb_ros.schema.arguments import number
from dcrb_ros.schema.refusal import Refusal

CHARACTERISTIC_FREQUENCIES = ("FTF", "BPFO", "BPFI", "BSF")
LOWEST_ORDER, HIGHEST_ORDER = 0.01, 1000.0
"""Range of the orders [-]: three rollers that almost touch have an FTF of 0.07, a row of 1000 a BPFI below 1000."""


@dataclass(frozen=True)
class Orders:
    """Characteristic frequencies as multiples of the shaft frequency (Eqs. 43 to 45 of Fan et al. 2025, and BSF).

    Raises:
        Refusal: an order is outside `LOWEST_ORDER` .. `HIGHEST_ORDER`; the memory of a detector grows with the orders. All of them are NaN
            if the bearing is unknown.
    """

    ftf: float
    """Fundamental train frequency, the rotation of the cage [-]."""
    bpfo: float
    """Ball (here roller) pass frequency of the outer ring [-]."""
    bpfi: float
    """Ball pass frequency of the inner ring [-]."""
    bsf: float
    """Ball spin frequency: roller spin relative to the cage [-]; a roller defect strikes twice as often."""

    def __post_init__(self) -> None:
        by_name = self.as_dict()
        for name, order in by_name.items():
            number(name, order)
        if all(map(math.isnan, by_name.values())):
            return
        for name, order in by_name.items():
            if not LOWEST_ORDER <= order <= HIGHEST_ORDER:
                raise Refusal(f"{name} = {order:g} is outside {LOWEST_ORDER:g} .. {HIGHEST_ORDER:g} orders of the shaft: check the bearing")

    @classmethod
    def from_dict(cls, orders: Mapping[str, float]) -> Orders:
        """Return the orders given by name, as `as_dict` returns them.

        Raises:
            KeyError: one of `CHARACTERISTIC_FREQUENCIES` is missing.
            TypeError, ValueError: an order is not a number, or out of range.
        """
        return cls(*(float(orders[name]) for name in CHARACTERISTIC_FREQUENCIES))

    def as_dict(self) -> dict[str, float]:
        """Return FTF, BPFO, BPFI and BSF by name [-]."""
        return dict(zip(CHARACTERISTIC_FREQUENCIES, (self.ftf, self.bpfo, self.bpfi, self.bsf), strict=True))

    def frequencies(self, shaft_frequency: float) -> dict[str, float]:
        """Return FTF, BPFO, BPFI and BSF by name [Hz] at a shaft frequency [Hz].

        Raises:
            Refusal: the frequency is not a number.
        """
        number("shaft_frequency", shaft_frequency)
        return {name: order * abs(shaft_frequency) for name, order in self.as_dict().items()}


class RollerSet(Protocol):
    """The geometry on which the characteristic frequencies depend; `dcrb_ros.settings.parameters.Bearing` has it."""

    @property
    def rollers_per_row(self) -> int:
        """Rollers in each row [-]."""

    @property
    def roller_radius(self) -> float:
        """In the plane of rotation, of a ball r cos a [m]."""

    @property
    def contact_angle(self) -> float:
        """[rad]"""

    @property
    def pitch_radius(self) -> float:
        """[m]"""


def characteristic_orders(bearing: RollerSet) -> Orders:
    """Return the orders for pure rolling, from r_R, r_M, the number n of rollers and the contact angle a (Eqs. 43 to 45).

    FTF = (1 - c)/2, BPFO = n FTF, BPFI = n (1 - FTF) and BSF = (1 - c^2)/(2 r_R/r_M) with c = r_R/r_M cos a. The paper has a = 0; the
    general case is that of Randall and Antoni 2011, eqs. 1 to 4.
    """
    contact = bearing.roller_radius / bearing.pitch_radius
    ratio = contact / math.cos(bearing.contact_angle)
    ftf = 0.5 * (1.0 - contact)
    return Orders(
        ftf=ftf,
        bpfo=bearing.rollers_per_row * ftf,
        bpfi=bearing.rollers_per_row * (1.0 - ftf),
        bsf=0.5 * (1.0 - contact**2) / ratio,
    )
