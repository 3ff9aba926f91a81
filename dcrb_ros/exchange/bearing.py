"""The bearing of an external waveform: its orders, or the geometry from which they follow."""

from __future__ import annotations

import math
from pathlib import Path

from pydantic import Field

from dcrb_ros.bearing.frequencies import HIGHEST_ORDER, LOWEST_ORDER, Orders, characteristic_orders
from dcrb_ros.bearing.order_check import order_mistake
from dcrb_ros.schema.fields import LENGTH_REMEDY, Group
from dcrb_ros.schema.refusal import Refusal

LARGEST_PITCH = 5.0
"""Largest pitch diameter [m]: beyond it a length is in millimetres."""


class Geometry(Group):
    """Number and size of the balls or rollers, and the contact angle, if there is one."""

    rollers_per_row: int | None = Field(None, ge=3, le=200)
    rollers: int | None = Field(None, ge=3, le=200)
    """In one row."""
    balls: int | None = Field(None, ge=3, le=200)
    """In one row."""
    roller_radius: float | None = Field(None, gt=0.0)
    """[m]"""
    pitch_radius: float | None = Field(None, gt=0.0)
    """[m]"""
    diameter: float | None = Field(None, gt=0.0)
    """Of a ball or roller, at its middle if it tapers [m]."""
    pitch_diameter: float | None = Field(None, gt=0.0)
    """Of the circle of the centres [m]."""
    contact_angle_deg: float = Field(0.0, ge=0.0, le=75.0)
    """Between the lines of contact and the plane of rotation [degrees]."""

    def orders(self, source: str) -> Orders:
        """Return the characteristic orders [-].

        Raises:
            Refusal: a dimension is missing or given twice, or the balls or rollers do not fit.
        """
        number = _single(source, "number", {"balls": self.balls, "rollers": self.rollers, "rollers_per_row": self.rollers_per_row})
        size = _single(source, "size", {"diameter": _half(self.diameter), "roller_radius": self.roller_radius})
        pitch = _single(source, "pitch circle", {"pitch_diameter": _half(self.pitch_diameter), "pitch_radius": self.pitch_radius})
        if 2.0 * pitch > LARGEST_PITCH:
            raise Refusal(f"{source}: a pitch circle of {2.0 * pitch:g} m is too large: {LENGTH_REMEDY}")
        if size >= pitch:
            raise Refusal(f"{source}.roller_radius = {size:g} m must be below pitch_radius = {pitch:g} m; so must the diameters")
        if number * math.asin(size / pitch) > math.pi:
            most = math.floor(math.pi / math.asin(size / pitch))
            raise Refusal(f"{source}: {number:g} elements of {2e3 * size:g} mm do not fit on {2e3 * pitch:g} mm: at most {most} do")
        try:
            return characteristic_orders(_Rollers(int(number), size, pitch, math.radians(self.contact_angle_deg)))
        except Refusal as refusal:
            raise Refusal(f"{source}: {refusal}") from None


class _Rollers:
    """Number and radii, as `characteristic_orders` takes them."""

    def __init__(self, rollers_per_row: int, radius: float, pitch_radius: float, contact_angle: float) -> None:
        self.rollers_per_row, self.roller_radius = rollers_per_row, radius * math.cos(contact_angle)
        self.pitch_radius, self.contact_angle = pitch_radius, contact_angle


def _half(diameter: float | None) -> float | None:
    return None if diameter is None else 0.5 * diameter


def _single(source: str, quantity: str, values: dict[str, float | int | None]) -> float:
    """Return the one value that is given."""
    given = {name: value for name, value in values.items() if value is not None}
    if len(given) != 1:
        mistake = f"gives {' and '.join(given)}" if given else "is missing"
        raise Refusal(f"{source}: the {quantity} of the balls or rollers {mistake}: give one of {', '.join(values)}")
    return float(next(iter(given.values())))


class GivenOrders(Group):
    """Characteristic frequencies as multiples of the shaft frequency [-]."""

    FTF: float = Field(ge=LOWEST_ORDER, le=HIGHEST_ORDER)
    BPFO: float = Field(ge=LOWEST_ORDER, le=HIGHEST_ORDER)
    BPFI: float = Field(ge=LOWEST_ORDER, le=HIGHEST_ORDER)
    BSF: float = Field(ge=LOWEST_ORDER, le=HIGHEST_ORDER)


def fault_orders(bearing: Geometry | None, orders: GivenOrders | None, source: Path | str) -> Orders:
    """Return the characteristic orders of a bearing that is given by either [-].

    Raises:
        Refusal: neither or both are given, or they are impossible.
    """
    if (bearing is None) == (orders is None):
        mistake = "neither bearing nor" if bearing is None else "both bearing and"
        raise Refusal(f"{source} has {mistake} orders: give the geometry, or the orders FTF, BPFO, BPFI and BSF")
    if bearing is not None:
        return bearing.orders(f"{source}: bearing")
    given = Orders.from_dict(orders.model_dump() if orders is not None else {})
    mistake = order_mistake(given)
    if mistake:
        raise Refusal(f"{source}: orders: {mistake}")
    return given
