"""What the user may tune of the fault detector."""

from __future__ import annotations

from dcrb_ros.parameters import Group, quantity


class DetectorParameters(Group):
    """Window, band and thresholds; the defaults were learned on the default bench.

    Learned means: 3 s runs of the healthy bench and of 1 mm and 2 mm defects in one row and in both, at 40 to 600 rad/s,
    50 to 120 kN and 0 to 0.01 m/s^2/sqrt(Hz) of noise, every roller free between the cage's bars. The healthy BPFO line grew
    with about the power 1.2 of the speed and with the load, and stayed below 28 m/s^2 x (shaft frequency / 20 Hz)^1.2; its BPFI
    lines stayed below 3.5. The smallest defect gave 98 and 45 at 20 Hz. It fades with the speed: 1 mm of the outer raceway is
    lost from 250 rad/s on in one row and at 600 rad/s in both. Another bearing or another sensor mount wants its own
    `outer_baseline` and `inner_baseline`: run it healthy and take the largest line shown.
    """

    window: float = quantity(2.0, "s", "Signal that one verdict is drawn from", 0.5, 60.0)
    hop: float = quantity(0.5, "s", "Signal between two verdicts", 0.05, 60.0)
    band_low: float = quantity(
        2000.0, "Hz", "Lower edge of the envelope's band", 100.0, 90e3, remedy="keep it above the housing mode of 500 Hz"
    )
    band_high: float = quantity(
        20000.0, "Hz", "Upper edge of the envelope's band; lowered to 0.45 of the sampling rate where that is less", 200.0, 100e3
    )
    least_turns: float = quantity(12.0, "-", "Turns of the shaft that a window must hold; a verdict waits for them", 4.0, 1000.0)
    slip: float = quantity(0.015, "-", "Largest departure from the kinematic orders that is searched, relative", 0.0, 0.05)
    outer_baseline: float = quantity(
        28.0, "m/s^2", "BPFO line of the healthy bearing at 20 Hz of shaft frequency, its variable compliance", 0.0, 1e5
    )
    inner_baseline: float = quantity(3.5, "m/s^2", "BPFI lines of the healthy bearing at 20 Hz of shaft frequency", 0.0, 1e5)
    speed_exponent: float = quantity(1.2, "-", "Exponent of the shaft frequency in both baselines", 0.0, 4.0)
    outer_margin: float = quantity(3.0, "dB", "BPFO line over its baseline from which an outer-ring defect is named", 0.0, 60.0)
    inner_margin: float = quantity(5.0, "dB", "BPFI lines over their baseline from which an inner-ring defect is named", 0.0, 60.0)
    outer_level: float = quantity(9.5, "dB", "BPFO line over its background that an outer-ring defect must have", 0.0, 60.0)
    inner_level: float = quantity(
        3.8, "dB", "BPFI lines and sidebands over their background that an inner-ring defect must have", 0.0, 60.0
    )
    inner_depth: float = quantity(
        0.015, "-", "Share of the mean squared envelope that BPFI lines and sidebands of a defect must have", 0.0, 2.0
    )
