"""The parameters of the comparing detector."""

from __future__ import annotations

from dcrb_ros.schema.fields import Group, quantity


class VehicleDetectorParameters(Group):
    """Thresholds by which boxes are compared; those of a single box are the fault detector's."""

    patience: float = quantity(1.0, "s", "How far the signal of a box may be behind the others before it counts as missing", 0.1, 60.0)
    contrast: float = quantity(
        6.0,
        "dB",
        "By how much the lines of a bearing must be larger in one box of a vehicle than in another one, in the median of bands",
        0.0,
        40.0,
    )
