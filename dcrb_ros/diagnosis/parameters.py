"""What the user may tune of the fault detector: every threshold, with its unit and where it comes from."""

from __future__ import annotations

from typing import Literal

from dcrb_ros.schema.fields import Group, choice, quantity


class DetectorParameters(Group):
    """Window, bands, thresholds; the defaults were learned on the default bench, see `docs/detector.md`."""

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

    outer_limit: float = quantity(
        38.0, "m/s^2", "BPFO lines in the whole band from which an outer-ring defect is named, at 20 Hz; healthy up to 26", 0.0, 1e6
    )
    outer_limit_high: float = quantity(
        12.0,
        "m/s^2",
        "BPFO lines in the band's upper quarter from which it is named, at 20 Hz; healthy up to 5, 10 by a mount that rings",
        0.0,
        1e6,
    )
    speed_exponent: float = quantity(1.0, "-", "Exponent of the shaft frequency over 20 Hz in both limits", 0.0, 4.0)
    outer_depth: float = quantity(
        0.3, "-", "Share of the mean squared envelope that BPFO lines of a defect must have; noise has 0.05", 0.0, 2.0
    )
    learn: float = quantity(
        0.0,
        "s",
        "Time from the first judgement over which the bearing is taken for healthy and raises the outer limits; 0 for none",
        0.0,
        1e5,
    )
    learn_margin: float = quantity(4.0, "dB", "Margin over the largest BPFO lines that were learned", 0.0, 40.0)

    inner_depth: float = quantity(
        0.08, "-", "Share of the mean squared envelope that BPFI lines with sidebands must have; healthy up to 0.06", 0.0, 2.0
    )
    inner_level: float = quantity(7.0, "dB", "BPFI lines with sidebands over their background; healthy up to 3", 0.0, 60.0)
    roller_depth: float = quantity(
        0.2, "-", "Share of the mean squared envelope that 2 BSF lines with cage sidebands must have; healthy up to 0.07", 0.0, 2.0
    )
    roller_level: float = quantity(7.0, "dB", "2 BSF lines with cage sidebands over their background; healthy up to 3", 0.0, 60.0)
    cage_depth: float = quantity(
        0.08, "-", "Share of the mean squared envelope that the comb at k FTF must have; healthy up to 0.06", 0.0, 2.0
    )
    cage_level: float = quantity(6.0, "dB", "Comb at k FTF over its background; healthy up to 3", 0.0, 60.0)
    shadow: float = quantity(
        2.0,
        "-",
        "Ratio of depths from which BPFI or 2 BSF lines explain a fault's that are found beside them, in the same band",
        0.1,
        100.0,
    )
    comb_shadow: float = quantity(
        0.7, "-", "The same for the comb at k FTF, whose teeth stand near every line; real ones rise well above it", 0.1, 100.0
    )

    most_senseless: float = quantity(0.01, "-", "Share of a hop that may be no finite numbers before the sensor is blamed", 0.0, 1.0)
    stuck_time: float = quantity(0.001, "s", "Time for which one value must stand to count as stuck", 1e-5, 1.0)
    stuck_share: float = quantity(0.03, "-", "Share of a hop that may be stuck before the sensor is blamed", 0.0, 1.0)
    most_clipped: float = quantity(
        0.15, "-", "Share of a hop at the ends of the range before the sensor is blamed; strikes of a defect reach 0.1", 0.0, 1.0
    )
    least_clipped: float = quantity(0.0005, "-", "Share of a hop at a limit below the range before the sensor is blamed", 0.0, 1.0)
    range_share: float = quantity(0.9, "-", "Limit over the sensor's range below which it is a fault", 0.0, 1.0)
    dead_level: float = quantity(
        6.0, "dB", "Power density from 200 to 2000 Hz over that near the Nyquist frequency; a turning bearing has 12 and more", 0.0, 60.0
    )
    dead_kurtosis: float = quantity(
        4.0, "-", "Kurtosis below which a flat spectrum is noise, which has 3; impacts have 6 and more", 3.0, 100.0
    )
    spike_height: float = quantity(25.0, "-", "Jump within a sample over the median size of the samples that may be a spike", 5.0, 1e4)
    spike_quiet: float = quantity(0.12, "-", "Share of a spike's height that the samples before it reach; a blow has a rise", 0.0, 1.0)
    spike_front: float = quantity(0.9, "-", "Share of a spike's height that it reaches within one sample; a shock takes several", 0.0, 1.0)
    spike_swing: float = quantity(0.15, "-", "Share of a spike's height by which it swings to the other side; a blow rings", 0.0, 1.0)
    spike_time: float = quantity(0.001, "s", "Time within which a blow on the bearing swings back and a spike does not", 1e-5, 0.1)
    most_spikes: int = quantity(3, "spikes", "Spikes in a window from which the cable is blamed", 1, 100000)
    silence: float = quantity(
        1e-3, "m/s^2", "RMS that some band must reach at 20 Hz, or the sensor is dead; the softest healthy bearing has 0.2", 0.0, 10.0
    )
    gain_drop: float = quantity(3.0, "dB", "Fall of all bands at the same speed from which the sensor's gain is blamed", 0.5, 60.0)
    gain_spread: float = quantity(
        0.25, "-", "Largest difference between the bands' falls over their mean; a gain has 0.2, a change of load 0.3 and more", 0.01, 10.0
    )
    loose_level: float = quantity(
        -23.0,
        "dB",
        "Power of the band's third quarter over that of the band below it, under which a mounting may be loose; healthy down to -22",
        -120.0,
        0.0,
    )
    loose_drop: float = quantity(8.0, "dB", "Fall of that level since it was highest from which the mounting is loose", 1.0, 60.0)
    firm_level: float = quantity(
        -60.0, "dB", "That level of a firm sensor, where the first seconds must not decide; a rigid mount has -10", -120.0, 60.0
    )

    confirm: int = quantity(2, "judgements", "Judgements in a row that name a fault, or clear the bearing at the beginning", 1, 100)
    release: int = quantity(4, "judgements", "Judgements in a row without a fault that clear it", 1, 1000)
    release_margin: float = quantity(1.0, "dB", "How far below its threshold the evidence must fall to count as gone", 0.0, 20.0)
    trend_time: float = quantity(60.0, "s", "Time over which the trend of the severity is fitted", 1.0, 1e6)
