"""The parameters of the fault detector. Each rule declares its own thresholds; the fields here concern all of them."""

from __future__ import annotations

from typing import Literal

from dcrb_ros.diagnosis.registry import RULES
from dcrb_ros.schema.composition import with_fields_of
from dcrb_ros.schema.fields import Group, choice, quantity


@with_fields_of(rule.parameters for rule in RULES)
class DetectorParameters(Group):
    """Window, bands and thresholds of the fault detector; none of the thresholds for the bearing has a unit."""

    window: float = quantity(4.0, "s", "Length of the window from which a verdict is derived", 0.5, 60.0)
    least_window: float = quantity(2.0, "s", "Length of signal required for the first verdict", 0.5, 60.0)
    hop: float = quantity(0.5, "s", "Interval between two verdicts", 0.05, 60.0)
    least_turns: float = quantity(12.0, "-", "Shaft revolutions required in a window", 4.0, 1000.0)
    longest_gap: float = quantity(
        0.25,
        "s",
        "Longest gap in the signal that is bridged, at most half a hop, and excluded from averages; a longer one starts a new window",
        0.0,
        10.0,
    )
    most_missing: float = quantity(0.3, "-", "Largest share of a window that may be missing for a verdict", 0.0, 0.9)

    band: Literal["kurtogram", "fixed"] = choice(
        "kurtogram",
        "Bands for demodulation: kurtogram, the band, its halves, thirds and quarters, the best for each fault; fixed, the band only",
    )
    band_low: float = quantity(
        2000.0, "Hz", "Lower edge of the band for demodulation", 100.0, 90e3, remedy="keep it above the housing mode of 500 Hz"
    )
    band_high: float = quantity(
        20000.0, "Hz", "Upper edge of the band for demodulation; at most 0.45 of the sampling rate is used", 200.0, 100e3
    )
    whitening: float = quantity(
        500.0,
        "Hz",
        "Width over which the power of the signal is made equal before bands are demodulated: several fault lines, narrower than modes; "
        "0 for not at all",
        0.0,
        1e5,
    )
    slip: float = quantity(0.02, "-", "Largest relative deviation of lines from the kinematic orders that is searched", 0.0, 0.05)
    slowest: float = quantity(2.0, "Hz", "Lowest shaft frequency for estimation from the signal, without a shaft angle", 0.5, 500.0)
    fastest: float = quantity(
        70.0, "Hz", "Highest shaft frequency for estimation from the signal, without a shaft angle", 1.0, 500.0, remedy="70 Hz is 4200 rpm"
    )
    speed_score: float = quantity(
        40.0,
        "dB",
        "Score required of an estimated speed: the sum of the levels of the lines it explains over the square root of their number",
        0.0,
        500.0,
    )
    speed_rival: float = quantity(0.86, "-", "Largest score of any other speed relative to that of the estimated speed", 0.0, 1.0)

    speed_exponent: float = quantity(
        1.0, "-", "Exponent of the speed dependence of the limits of the outer ring, relative to 20 Hz", 0.0, 4.0
    )

    baseline: str = choice("", "File of a saved baseline of the healthy bearing, as dcrb detect --save-baseline writes it; empty for none")

    confirm: int = quantity(
        2, "hops", "Consecutive hops with evidence that confirm a fault, or without evidence that make the first verdict healthy", 1, 100
    )
    release: int = quantity(4, "hops", "Consecutive hops without evidence that clear a fault", 1, 1000)
    release_margin: float = quantity(1.0, "dB", "How far below its threshold the evidence must be to clear a fault", 0.0, 20.0)
    alarm_evidence: float = quantity(
        2.8,
        "dB",
        "Evidence above its threshold that raises an alarm while a bearing is watched, from which nine of ten alarms are right; "
        "a recording judged once, as a whole, is named from the threshold on",
        0.0,
        20.0,
    )
    trend_time: float = quantity(60.0, "s", "Time over which the trend of the severity is fitted", 1.0, 1e6)

    @property
    def hops(self) -> int:
        """Hops in a window."""
        return max(1, round(self.window / self.hop))

    @property
    def persist(self) -> int:
        """Judgements for which evidence at the threshold must last: those of a window, or one if a single one confirms a fault."""
        return self.hops if self.confirm > 1 else 1

    def hop_samples(self, rate: int) -> int:
        """Return the samples of a hop at a ``rate`` [Hz]."""
        return max(1, round(self.hop * rate))

    def gap_samples(self, rate: int) -> int:
        """Return the samples of the longest gap that is bridged, at a ``rate`` [Hz]."""
        return round(min(self.longest_gap, 0.5 * self.hop) * rate)
