"""Rows that need no run in time: static forces, frequencies, degrees of freedom, and the two solvers against each other."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from dcrb_ros.bearing.equilibrium import roller_forces, static_equilibrium
from dcrb_ros.bearing.kinematics import characteristic_orders
from dcrb_ros.bearing.payload import build_payload, degrees_of_freedom
from dcrb_ros.runtime.arrays import Floats
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.validation.comparison import Comparison, within
from dcrb_ros.validation.formulation import Agreement
from dcrb_ros.validation.runs import BENCH, JOINTS

LOAD = np.array([0.0, -100e3])
UNDER = 30251.0, 10708.0
"""Roller forces with one roller under the load: there, and at its neighbours (computed independently) [N]."""
STRADDLING = 25508.0
"""Each of the two rollers beside the load line [N]."""
FREQUENCIES = {"FTF": 8.404, "BPFO": 134.47, "BPFI": 185.53, "BSF": 61.07}
"""At 20 Hz, from r_R / r_M [Hz]; the paper prints 8.4, 134.5, 185.5."""


def static_forces(joint: str, phase: float) -> Floats:
    """Return the means of inner and outer normal force of the first row's rollers, turned by ``phase`` pitches [N]."""
    payload = build_payload(load_configuration(BENCH[joint]))
    turn = np.exp(2j * np.pi * phase / payload.free.shape[1])
    turned = (payload.pocket_tangent[..., 0] + 1j * payload.pocket_tangent[..., 1]) * turn
    payload = payload._replace(pocket_tangent=np.stack([turned.real, turned.imag], axis=-1))
    rest = static_equilibrium(payload, LOAD)
    forces = [np.linalg.norm(force, axis=-1)[0] for force in roller_forces(payload, rest.outer, rest.inner, rest.rollers)]
    return np.asarray(0.5 * (forces[0] + forces[1]))


def static_comparisons() -> Iterator[Comparison]:
    """Static roller forces under 100 kN."""
    for joint in JOINTS:
        under, straddling = static_forces(joint, 0.0)[[0, 1, -1]], static_forces(joint, 0.5)[[0, -1]]
        expected = UNDER[0], UNDER[1], UNDER[1]
        yield Comparison(
            "Static forces per row, a roller under the load",
            joint,
            "-",
            ", ".join(f"{force:.0f}" for force in under) + " N",
            "30 251 and 2 x 10 708 N, 0.1 %",
            all(within(*pair, 1e-3) for pair in zip(under, expected, strict=True)),
        )
        yield Comparison(
            "Static forces per row, two rollers beside the load",
            joint,
            "-",
            ", ".join(f"{force:.0f}" for force in straddling) + " N",
            "2 x 25 508 N, 0.1 %",
            all(within(force, STRADDLING, 1e-3) for force in straddling),
        )


def frequency_comparison() -> Iterator[Comparison]:
    """Characteristic frequencies."""
    found = characteristic_orders(load_configuration("paper").bearing).frequencies(20.0)
    yield Comparison(
        "FTF, BPFO, BPFI, BSF at 20 Hz",
        "both",
        "8.4, 134.5, 185.5 Hz, - (section 3.2)",
        ", ".join(f"{found[name]:.3f}" for name in FREQUENCIES) + " Hz",
        "8.404, 134.47, 185.53, 61.07 Hz, 0.01 %",
        all(within(found[name], FREQUENCIES[name], 1e-4) for name in FREQUENCIES),
    )


def freedom_comparisons() -> Iterator[Comparison]:
    """Degrees of freedom."""
    bars = ("", "row1/bar15", "row1/bar15, row2/bar15")
    for joint, expected in (("revolute", (42, 46, 50)), ("pocket", (106, 106, 106))):
        found = tuple(degrees_of_freedom(load_configuration(BENCH[joint], [f"faults.broken_bars={text}"])) for text in bars)
        yield Comparison(
            "Degrees of freedom: healthy, a bar broken in one row, in both",
            joint,
            "10 + nr, 14 + nr; four freed rollers make 18 + nr (section 2.2.2)" if joint == "revolute" else "-",
            ", ".join(map(str, found)),
            ", ".join(map(str, expected)),
            found == expected,
        )


WINDOWS = {
    "healthy": ("", 1e-3, 1e-3),
    "outer ring defect": ("faults.outer_1.width=0.002", 1.5e-3, 1e-2),
    "one broken bar": ("faults.broken_bars=row1/bar15", 3e-3, 2e-2),
}
"""What the two solvers are compared on: the fault, the window [s], the deviation of the acceleration that is accepted [-]."""
LARGEST_DRIFT = 1e-12
"""Violation of the constraints that is accepted [m or rad]."""


def formulation_comparisons(found: dict[str, Agreement]) -> Iterator[Comparison]:
    """The production solver against the paper's formulation."""
    for name, (_, window, most) in WINDOWS.items():
        agreement = found[name]
        drift = float(agreement.history.drift.max())
        yield Comparison(
            f"Motion by the paper's formulation (111 coordinates, multipliers), {name}, {window * 1e3:g} ms",
            "revolute",
            "Eqs. 31-40",
            f"acceleration {agreement.acceleration:.1e}, normal forces {agreement.normal:.1e}, constraint drift {drift:.0e} m",
            f"relative RMS {most:.0e}, 1e-3; drift {LARGEST_DRIFT:.0e} m",
            agreement.acceleration <= most and agreement.normal <= 1e-3 and drift <= LARGEST_DRIFT,
        )
