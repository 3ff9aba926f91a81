"""What the machine allows: the loop over free rollers against the same in C, and the step against what others would take.

The C is compiled with -O3 for this very processor. Medians of several rounds in one process.
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
from dcrb_ros.core import lanes as at
from dcrb_ros.core.jit import loop
from dcrb_ros.core.payload import Floats, Payload
from dcrb_ros.core.rolling import roll_free
from dcrb_ros.core.state import OUTER, State, copy_of
from dcrb_ros.core.step import advance
from dcrb_ros.core.work import Workspace, workspace
from dcrb_ros.settings.files import load_configuration

FIELDS = """
    X Y VX VY SPIN CHANGE_X CHANGE_Y CHANGE_SPIN OUTER_BRISTLE OUTER_FORCE OUTER_FRICTION OUTER_SLIP FRICTION_LOSS CONTACT_LOSS
    NOTCH_LOSS SINK CUT BOUND ON_OUTER_X ON_OUTER_Y
"""
OPTIONS = """
    -O3 -march=native -ffinite-math-only -ffp-contract=fast -fno-math-errno -fno-trapping-math -fno-signed-zeros -freciprocal-math
"""
TIMES, ROUNDS = 20000, 15


@loop
def roll_often(payload: Payload, state: State, work: Workspace, times: int) -> None:
    """Roll the free rollers again and again."""
    for _ in range(times):
        roll_free(payload, state, work, True)


def compiled_c(folder: Path) -> ctypes.CDLL:
    """Return the C library, built in a folder."""
    library = folder / "roll_free.so"
    places = [f"-D{name}={getattr(at, name)}" for name in FIELDS.split()]
    subprocess.run(
        ["cc", *OPTIONS.split(), *places, "-shared", "-fPIC", "-o", library, Path(__file__).with_name("roll_free.c"), "-lm"], check=True
    )
    return ctypes.CDLL(str(library))


def constants(payload: Payload, state: State, work: Workspace) -> Floats:
    """Return the constants of the C loop, in its order."""
    p, h, radius = payload, payload.step, payload.roller_radius
    by_mass, by_inertia = 0.5 * h / p.roller_mass, 0.5 * h * radius * radius / p.roller_inertia
    places = (*state.outer_position, *work.mean[OUTER, :2], *state.outer_velocity)
    motion = (h, radius, by_mass, by_inertia, 0.5 * h * p.gravity, p.outer_raceway_radius - radius, *places)
    contact = (p.contact_modulus, p.outer_scale, p.loss_time, p.contact_damping, p.kinetic_coefficient, p.static_coefficient)
    bristles = (
        1.0 / p.stribeck_speed,
        p.bristle_stiffness,
        p.bristle_damping,
        p.viscous,
        p.convection,
        p.outer_width,
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
    payload = build_payload(load_configuration("healthy", []))
    start, work = initial_state(load_configuration("healthy", []), payload), workspace(payload)
    advance(payload, start, work, np.empty((2000, 2)), np.empty(2000))
    ours, theirs, known, count = (
        copy_of(start),
        copy_of(start),
        constants(payload, start, work),
        -(-payload.free.size // at.VECTOR) * at.VECTOR,
    )
    light = work.light.copy()
    with tempfile.TemporaryDirectory() as folder:
        library = compiled_c(Path(folder))
        pointer = ctypes.POINTER(ctypes.c_double)
        own, other, numbers = (values.ctypes.data_as(pointer) for values in (theirs.lanes, light, known))

        def in_c(times: int = TIMES) -> None:
            library.roll_often(own, other, ctypes.c_int64(count), numbers, ctypes.c_int64(times))

        def in_numba(times: int = TIMES) -> None:
            roll_often(payload, ours, work, times)

        in_numba(1)
        in_c(1)
        apart = float(np.abs(ours.roller_velocity - theirs.roller_velocity).max())
        pairs = [(timed(in_numba), timed(in_c)) for _ in range(ROUNDS)]
    numba, c = (1e6 * statistics.median(column) / TIMES for column in zip(*pairs, strict=True))
    ratio = statistics.median(mine / other for mine, other in pairs)
    print("| loop over free rollers | us per pass | against C |\n|---|---|---|")
    print(f"| ours | {numba:.3f} | {ratio:.2f} |\n| C, {' '.join(OPTIONS.split()[:2])} | {c:.3f} | 1 |")
    print(f"\nAfter one pass their velocities differ by {apart:.1e} at most.")


if __name__ == "__main__":
    main()
