"""The loop over free rollers compared with the same loop in C.

The C code is compiled with -O3 for the processor of this machine. Medians of several rounds in one process.
"""

from __future__ import annotations

import ctypes
import statistics
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from dcrb_ros.bearing.payload import build_payload, initial_state
from dcrb_ros.core.jit import loop
from dcrb_ros.core.layout.records import VECTOR, Floats
from dcrb_ros.core.layout.state import OUTER, State, copy_of
from dcrb_ros.core.layout.workspace import Workspace, workspace
from dcrb_ros.core.payload import Payload
from dcrb_ros.core.solver.free import advance_free
from dcrb_ros.core.solver.step import advance
from dcrb_ros.settings.files import load_configuration

STATE_FIELDS = """
    x y vx vy spin change_vx change_vy change_spin
    outer.traction.bristle outer.force outer.friction outer.slip friction_loss contact_loss notch_loss
"""
STEP_FIELDS = "sink_speed notch_depth bound force_on_outer_x force_on_outer_y"
OPTIONS = """
    -O3 -march=native -ffinite-math-only -ffp-contract=fast -fno-math-errno -fno-trapping-math -fno-signed-zeros -freciprocal-math
"""
TIMES, ROUNDS = 20000, 15


@loop
def advance_often(payload: Payload, state: State, work: Workspace, times: int) -> None:
    """Advance the free rollers ``times`` times."""
    for _ in range(times):
        advance_free(payload, state, work)


def definitions(table: object, fields: str) -> list[str]:
    """Return C macros with the offsets of the fields of a table, in doubles."""

    def offset(name: str) -> int:
        dtype, found = np.asarray(table).dtype, 0
        for part in name.split("."):
            if dtype.fields is None:
                raise KeyError(name)
            dtype, begin = dtype.fields[part][:2]
            found += begin // 8
        return found

    return [f"-D{name.replace('.', '_').upper()}={offset(name)}" for name in fields.split()]


def compiled_c(folder: Path, state: State, work: Workspace) -> ctypes.CDLL:
    """Return the C library, built in a folder."""
    library = folder / "advance_free.so"
    places = definitions(state.rollers, STATE_FIELDS) + definitions(work.rollers, STEP_FIELDS)
    subprocess.run(
        ["cc", *OPTIONS.split(), *places, "-shared", "-fPIC", "-o", library, Path(__file__).with_name("advance_free.c"), "-lm"], check=True
    )
    return ctypes.CDLL(str(library))


def constants(payload: Payload, state: State, work: Workspace) -> Floats:
    """Return the constants of the C loop in its order."""
    p, h, radius = payload, payload.step, payload.roller_radius
    by_mass, by_inertia = 0.5 * h / p.roller_mass, 0.5 * h * radius * radius / p.roller_inertia
    places = (*state.outer_position, *work.mean_velocity[OUTER, :2], *state.outer_velocity)
    motion = (h, radius, by_mass, by_inertia, 0.5 * h * p.gravity, p.outer_raceway_radius - radius, *places)
    law = p.traction_law
    contact = (p.normal_law.modulus, p.outer.scale, p.loss_time, p.contact_damping, law.kinetic_coefficient, law.static_coefficient)
    bristles = (
        1.0 / law.stribeck_speed,
        law.bristle_stiffness,
        law.bristle_damping,
        law.viscous,
        law.convection,
        p.outer.width,
        p.outer_raceway_radius,
    )
    return np.array([*motion, *contact, *bristles])


def timed(run: Callable[[], None]) -> float:
    """Return the time of a call [s]."""
    begin = time.perf_counter()
    run()
    return time.perf_counter() - begin


def main() -> None:
    """Print the comparison."""
    payload = build_payload(load_configuration("dry"))
    start, work = initial_state(load_configuration("dry"), payload), workspace(payload)
    advance(payload, start, work, np.empty((2000, 2)), np.empty(2000))
    ours, theirs, known, count = (
        copy_of(start),
        copy_of(start),
        constants(payload, start, work),
        -(-payload.free.size // VECTOR) * VECTOR,
    )
    rollers = np.asarray(work.rollers).view(np.float64).copy()
    with tempfile.TemporaryDirectory() as folder:
        library = compiled_c(Path(folder), start, work)
        pointer = ctypes.POINTER(ctypes.c_double)
        own, other, numbers = (values.ctypes.data_as(pointer) for values in (np.asarray(theirs.rollers).view(np.float64), rollers, known))

        def in_c(times: int = TIMES) -> None:
            library.advance_often(own, other, ctypes.c_int64(count), numbers, ctypes.c_int64(times))

        def in_numba(times: int = TIMES) -> None:
            advance_often(payload, ours, work, times)

        in_numba(1)
        in_c(1)
        apart = float(np.abs(ours.roller_velocity - theirs.roller_velocity).max())
        pairs = [(timed(in_numba), timed(in_c)) for _ in range(ROUNDS)]
    numba, c = (1e6 * statistics.median(column) / TIMES for column in zip(*pairs, strict=True))
    ratio = statistics.median(mine / other for mine, other in pairs)
    print("| loop over free rollers | us per pass | relative to C |\n|---|---|---|")
    print(f"| numba | {numba:.3f} | {ratio:.2f} |\n| C, {' '.join(OPTIONS.split()[:2])} | {c:.3f} | 1 |")
    print(f"\nAfter one pass, the velocities differ by at most {apart:.1e} m/s.")


if __name__ == "__main__":
    main()
