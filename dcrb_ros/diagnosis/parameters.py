"""The parameters of the fault detector. Each rule declares its own thresholds; the fields here concern all of them."""

from __future__ import annotations

from typing import Literal

from dcrb_ros.diagnosis.registry import RULES
from dcrb_ros.schema.composition import with_fields_of
from dcrb_ros.schema.fields import Group, choice, quantity


@with_fields_of(rule.parameters for rule in RULES)
class DetectorParameters(Group):
    """Window, bands, thresholds; the defaults were tuned on the default bench, see `docs/explanation/detector.md`."""

    window: float = quantity(4.0, "s", "Longest signal that one verdict is drawn from", 0.5, 60.0)
    least_window: float = quantity(2.0, "s", "Signal without which there is no verdict", 0.5, 60.0)
    hop: float = quantity(0.5, "s", "Signal between two verdicts", 0.05, 60.0)
    least_turns: float = quantity(12.0, "-", "Turns of the shaft that a window must hold; a verdict waits for them", 4.0, 1000.0)
    longest_gap: float = quantity(
        0.25,
        "s",
        "Longest gap in the stream that is bridged, at most half a hop, and left out of the averages; a longer one starts a new window",
        0.0,
        10.0,
    )
    most_missing: float = quantity(0.3, "-", "Share of a window that may be missing; a verdict waits for more", 0.0, 0.9)

    band: Literal["kurtogram", "fixed"] = choice(
        "kurtogram", "Bands looked at: kurtogram, the band, its halves and quarters, each fault in the best of them; fixed, the band only"
    )
    band_low: float = quantity(
        2000.0, "Hz", "Lower edge of the envelope's band", 100.0, 90e3, remedy="keep it above the housing mode of 500 Hz"
    )
    band_high: float = quantity(
        20000.0, "Hz", "Upper edge of the envelope's band; lowered to 0.45 of the sampling rate where that is less", 200.0, 100e3
    )
    slip: float = quantity(0.004, "-", "Largest departure from the kinematic orders that is searched, relative", 0.0, 0.05)
    slowest: float = quantity(2.0, "Hz", "Lowest shaft frequency that is looked for where there is no shaft angle", 0.5, 500.0)
    fastest: float = quantity(
        70.0, "Hz", "Highest shaft frequency that is looked for where there is no shaft angle", 1.0, 500.0, remedy="70 Hz is 4200 rpm"
    )
    speed_score: float = quantity(
        40.0, "dB", "Lines that a speed must explain where there is no shaft angle: their levels over the root of their number", 0.0, 500.0
    )
    speed_rival: float = quantity(0.86, "-", "Share of that which no other speed may explain", 0.0, 1.0)

    speed_exponent: float = quantity(1.0, "-", "Exponent of the shaft frequency over 20 Hz in both limits", 0.0, 4.0)

    confirm: int = quantity(2, "judgements", "Judgements in a row that name a fault, or clear the bearing at the beginning", 1, 100)
    release: int = quantity(4, "judgements", "Judgements in a row without a fault that clear it", 1, 1000)
    release_margin: float = quantity(1.0, "dB", "How far below its threshold the evidence must fall to count as gone", 0.0, 20.0)
    trend_time: float = quantity(60.0, "s", "Time over which the trend of the severity is fitted", 1.0, 1e6)
