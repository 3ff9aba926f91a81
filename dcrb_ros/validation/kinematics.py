"""Comparisons with the paper that need no simulation: characteristic frequencies and degrees of freedom."""

from __future__ import annotations

from collections.abc import Iterator

from dcrb_ros.bearing.frequencies import characteristic_orders
from dcrb_ros.bearing.payload import degrees_of_freedom
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.validation.report_row import ReportRow, within
from dcrb_ros.validation.runs import BENCH

FREQUENCIES = {"FTF": 8.404, "BPFO": 134.47, "BPFI": 185.53, "BSF": 61.07}
"""Eqs. 43 to 45 with Table 1 at 20 Hz, and BSF [Hz]; the paper prints 8.4, 134.5, 185.5."""


def frequency_row() -> ReportRow:
    """Return the comparison of the characteristic frequencies."""
    frequencies = characteristic_orders(load_configuration("paper").bearing).frequencies(20.0)
    return ReportRow(
        "FTF, BPFO, BPFI, BSF at 20 Hz",
        "both",
        "8.4, 134.5, 185.5 Hz, - (section 3.2)",
        ", ".join(f"{frequencies[name]:.3f}" for name in FREQUENCIES) + " Hz",
        "8.404, 134.47, 185.53, 61.07 Hz, 0.01 %",
        all(within(frequencies[name], FREQUENCIES[name], 1e-4) for name in FREQUENCIES),
    )


def freedom_rows() -> Iterator[ReportRow]:
    """Yield the comparison of the degrees of freedom for each joint."""
    bars = ("", "row1/bar15", "row1/bar15, row2/bar15")
    for joint, expected in (("revolute", (42, 46, 50)), ("pocket", (106, 106, 106))):
        freedoms = tuple(degrees_of_freedom(load_configuration(BENCH[joint], [f"faults.broken_bars={text}"])) for text in bars)
        yield ReportRow(
            "Degrees of freedom: healthy, one bar broken in one row, one in both rows",
            joint,
            "10 + nr, 14 + nr; 18 + nr with four free rollers (section 2.2.2)" if joint == "revolute" else "-",
            ", ".join(map(str, freedoms)),
            ", ".join(map(str, expected)),
            freedoms == expected,
        )
