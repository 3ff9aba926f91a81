"""Characteristic frequencies of a bearing at a speed."""

from __future__ import annotations

import math

from dcrb_ros.bearing.fault_lines import BearingLike, orders_of
from dcrb_ros.schema.numbers import finite_number
from dcrb_ros.settings.files import load_configuration


def characteristic_frequencies(bearing: BearingLike | str, speed: float) -> dict[str, float]:
    """Return the frequencies at which the parts of a bearing pass each other, for pure rolling.

    Parameters
    ----------
    bearing
        Geometry (`dcrb_ros.Bearing`), a configuration, orders, or the name or file of a configuration such as ``"healthy"``.
    speed
        Speed of the inner ring [rad/s]; its sign does not matter.

    Returns
    -------
    dict
        FTF (cage), BPFO (outer ring), BPFI (inner ring) and BSF (roller spin) by name [Hz]. A roller defect strikes at twice BSF.

    Raises
    ------
    Refusal
        A speed that is not finite, or an unknown configuration.

    Examples
    --------
    >>> frequencies = characteristic_frequencies("healthy", 125.664)
    >>> {name: round(value, 1) for name, value in frequencies.items()}
    {'FTF': 8.4, 'BPFO': 134.5, 'BPFI': 185.5, 'BSF': 61.1}
    """
    source = load_configuration(bearing) if isinstance(bearing, str) else bearing
    return orders_of(source).frequencies(finite_number("speed =", speed, "rad/s") / (2.0 * math.pi))
