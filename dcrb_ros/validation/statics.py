"""Comparisons that need no simulation in time: static forces, characteristic frequencies, degrees of freedom."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from dcrb_ros.bearing.equilibrium import roller_forces, static_equilibrium
from dcrb_ros.bearing.frequencies import characteristic_orders
from dcrb_ros.bearing.payload import build_payload, degrees_of_freedom
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.validation.report_row import ReportRow, within
from dcrb_ros.validation.runs import BENCH, JOINTS

LOAD = np.array([0.0, -100e3])
"""Load on the inner ring, Figs. 9 and 10 [N]."""
UNDER = 30251.0, 10708.0
"""Forces of the roller on the load line and of each of its neighbours [N].

Static equilibrium of 100 kN and the weight of the inner ring, from Eq. 4 and Table 1; `shared_forces` in
`tests/bearing/test_equilibrium.py` solves it independently of the model.
"""
STRADDLING = 25508.0
"""Force of each of the two rollers beside the load line, if no roller is on it [N]; same source."""
FREQUENCIES = {"FTF": 8.404, "BPFO": 134.47, "BPFI": 185.53, "BSF": 61.07}
"""Eqs. 43 to 45 with Table 1 at 20 Hz, and BSF [Hz]; the paper prints 8.4, 134.5, 185.5."""


def static_forces(joint: str, phase: float) -> Floats:
    """Return the mean of inner and outer normal force of each roller in the first row, shape (rollers,) [N].

    The rollers are turned by ``phase`` pitches from the load line.
    """
    payload = build_payload(load_configuration(BENCH[joint]))
    turn = np.exp(2j * np.pi * phase / payload.free.shape[1])
    turned = (payload.pocket_tangent[..., 0] + 1j * payload.pocket_tangent[..., 1]) * turn
    payload = payload._replace(pocket_tangent=np.stack([turned.real, turned.imag], axis=-1))
    equilibrium = static_equilibrium(payload, LOAD)
    vectors = roller_forces(payload, equilibrium.outer, equilibrium.inner, equilibrium.rollers)
    forces = [np.linalg.norm(force, axis=-1)[0] for force in vectors]
    return np.asarray(0.5 * (forces[0] + forces[1]))


def static_rows() -> Iterator[ReportRow]:
    """Yield the comparisons of the static roller forces under 100 kN."""
    for joint in JOINTS:
        under, straddling = static_forces(joint, 0.0)[[0, 1, -1]], static_forces(joint, 0.5)[[0, -1]]
        expected = UNDER[0], UNDER[1], UNDER[1]
        yield ReportRow(
            "Static forces per row, one roller on the load line",
            joint,
            "-",
            ", ".join(f"{force:.0f}" for force in under) + " N",
            "30 251 and 2 x 10 708 N, 0.1 %",
            all(within(*pair, 1e-3) for pair in zip(under, expected, strict=True)),
        )
        yield ReportRow(
            "Static forces per row, two rollers beside the load line",
            joint,
            "-",
            ", ".join(f"{force:.0f}" for force in straddling) + " N",
            "2 x 25 508 N, 0.1 %",
            all(within(force, STRADDLING, 1e-3) for force in straddling),
        )


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
