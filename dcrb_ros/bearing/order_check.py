"""Mistakes in stated characteristic orders, found from the relations that hold for every rolling bearing with a fixed outer ring."""

from __future__ import annotations

import math

from dcrb_ros.bearing.frequencies import Orders

TOLERANCE = 0.02
"""Relative error of stated orders that is accepted [-]: rounded to three digits they have 0.005."""


def order_mistake(orders: Orders) -> str:
    """Return what is wrong with characteristic orders, with the likely cause, or nothing.

    BPFO = n FTF and BPFO + BPFI = n for n rolling elements; the contact ratio c = 1 - 2 FTF gives BSF = (1 - c^2) / (2 c).
    """
    if orders.ftf >= 0.5:
        cause = "frequencies in Hz: divide them by the speed of the shaft" if orders.ftf > 1.0 else "orders of a rotating outer ring"
        return f"FTF = {orders.ftf:g} is not below 0.5 orders of the shaft; these may be {cause}"
    if orders.bpfo >= orders.bpfi:
        return f"BPFO = {orders.bpfo:g} is not below BPFI = {orders.bpfi:g}: they may be swapped"
    total = orders.bpfo + orders.bpfi
    if not math.isclose(total, max(3, round(total)), rel_tol=TOLERANCE):
        return f"BPFO + BPFI = {total:g} is not the number of rolling elements, an integer: check both"
    expected = round(total) * orders.ftf
    if not math.isclose(orders.bpfo, expected, rel_tol=TOLERANCE):
        return f"BPFO = {orders.bpfo:g} is not {round(total)} FTF = {expected:.4g}, as {round(total)} rolling elements require: check FTF"
    ratio = 1.0 - 2.0 * orders.ftf
    spin = (1.0 - ratio**2) / (2.0 * ratio)
    if math.isclose(orders.bsf, 2.0 * spin, rel_tol=0.1):
        return f"BSF = {orders.bsf:g} is twice {spin:.4g}, the spin that FTF requires: it may be the ball defect frequency, so halve it"
    return ""
