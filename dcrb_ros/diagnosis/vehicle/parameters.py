"""The parameters of the comparing detector."""

from __future__ import annotations

from dcrb_ros.schema.fields import Group, quantity


class VehicleDetectorParameters(Group):
    """Thresholds by which boxes are compared; those of a single box are the fault detector's."""

    patience: float = quantity(
        1.0, "s", "How far the signal of a box may be behind or ahead of the others before it is left out", 0.1, 60.0
    )
    contrast: float = quantity(
        6.0,
        "dB",
        "By how much the lines of a bearing must be larger in one box of a vehicle than in another one, in the median of bands",
        0.0,
        40.0,
    )
    relief: float = quantity(
        8.0,
        "dB",
        "By how much fainter than in a box by itself the lines of a bearing may be if no other box has them, or only later",
        0.0,
        10.0,
    )
    rare: float = quantity(
        0.02, "-", "Share of the time in which the envelopes of a bearing are limited, because kinks of the rail are rare", 0.0, 0.2
    )
    wheel_low: float = quantity(500.0, "Hz", "Lower edge of the band of flats", 200.0, 10e3)
    wheel_high: float = quantity(3000.0, "Hz", "Upper edge of that band", 500.0, 20e3)
    kink_low: float = quantity(6000.0, "Hz", "Lower edge of the band of kinks of the rail", 500.0, 50e3)
    kink_high: float = quantity(20000.0, "Hz", "Upper edge of that band; at most 0.45 of the sampling rate is used", 1e3, 100e3)
    flat: float = quantity(
        8.0, "dB", "Squared envelope at one angle of the wheel over its median around the wheel that indicates a flat", 1.0, 40.0
    )
    polygon: float = quantity(
        15.0, "dB", "Prominence of an order of the wheel over that of its neighbours that indicates a polygon", 1.0, 60.0
    )
    gear: float = quantity(8.0, "dB", "Prominence of the order of the mesh over that of its neighbours in both boxes", 1.0, 60.0)
    corrugation: float = quantity(
        15.0, "dB", "Prominence of a line in all boxes of one side, at no whole order, that indicates a corrugated rail", 1.0, 60.0
    )
    motor: float = quantity(
        15.0, "dB", "Prominence of a line in both boxes of a driven wheelset, at no whole order, that indicates its motor", 1.0, 60.0
    )
    event: float = quantity(
        6.0, "dB", "Squared envelope over the one exceeded in 2 % of the time that indicates a kink of the rail", 1.0, 40.0
    )
    lag_tolerance: float = quantity(
        0.004, "s", "Departure from the lag of the wheelsets up to which two impacts are those of one kink", 1e-4, 0.1
    )
    silence: float = quantity(20.0, "dB", "Level below the quietest other box at which a sensor does not measure the rail", 6.0, 60.0)
    clock: float = quantity(20.0, "ppm", "Difference of the clocks of two boxes of a wheelset that is reported", 1.0, 1e5)
