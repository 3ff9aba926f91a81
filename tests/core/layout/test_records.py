"""The tables of rollers and contacts, and the views of the state."""

from __future__ import annotations

import re

import numba
import numpy as np
import numpy.typing as npt
import pytest

from dcrb_ros.bearing.payload import build_payload
from dcrb_ros.core.jit import COMPILED
from dcrb_ros.core.layout.contacts import ConformalContacts
from dcrb_ros.core.layout.records import CACHE_LINE, WIDTH, dtype_of, empty_record
from dcrb_ros.core.layout.rollers import BoundRollers, Rollers, RollerStep
from dcrb_ros.core.layout.state import copy_of, empty_state
from dcrb_ros.core.payload import arrays_by_law
from dcrb_ros.settings.configuration import Configuration

pytestmark = pytest.mark.kernel

PAYLOAD = build_payload(Configuration())
BY_LAW = arrays_by_law(PAYLOAD)


@pytest.mark.parametrize("table", [Rollers, RollerStep, BoundRollers, ConformalContacts])
def test_every_array_begins_at_a_cache_line(table: type) -> None:
    record = empty_record(table, BY_LAW)[0]
    for name in dtype_of(table, BY_LAW).names or ():
        part = getattr(record, name)
        address = part.ctypes.data if isinstance(part, np.ndarray) else np.asarray(part).ctypes.data
        assert address % CACHE_LINE == 0


def test_a_table_has_one_numpy_type() -> None:
    # Numba's dispatch recognises the type by its address.
    assert dtype_of(Rollers, BY_LAW) is dtype_of(Rollers, BY_LAW)
    assert empty_record(Rollers, BY_LAW)[0].dtype is dtype_of(Rollers, BY_LAW)  # type: ignore[attr-defined]


def test_views_of_the_state_lie_where_the_kernels_look() -> None:
    state = empty_state(PAYLOAD)
    state.roller_position[1, 3] = 5.0, 6.0
    state.roller_velocity[1, 3] = 1.0, 2.0, 3.0
    state.roller_change[1, 3] = 7.0, 8.0, 9.0
    state.outer_force[1, 3] = 4.0
    rollers, k = state.rollers[0], 16 + 3
    assert (rollers.x[k], rollers.y[k], rollers.vx[k], rollers.vy[k], rollers.spin[k]) == (5.0, 6.0, 1.0, 2.0, 3.0)
    assert (rollers.change_vx[k], rollers.change_vy[k], rollers.change_spin[k], rollers.outer.force[k]) == (7.0, 8.0, 9.0, 4.0)
    values = np.asarray(state.rollers).view(np.float64)
    assert np.count_nonzero(values) == 9


def test_copy_of_a_state_has_a_life_of_its_own() -> None:
    state = empty_state(PAYLOAD)
    state.inner_force[0, 2] = 5.0
    state.load[1] = -7.0
    copy = copy_of(state)
    state.inner_force[0, 2] = state.load[1] = 0.0
    assert (copy.inner_force[0, 2], copy.load[1]) == (5.0, -7.0)


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="needs the compiler")
def test_the_width_is_that_of_the_compilers_vectors() -> None:
    def square_roots(x: npt.NDArray[np.float64], y: npt.NDArray[np.float64]) -> None:
        for k in range(x.shape[0]):
            y[k] = np.sqrt(x[k])

    compiled = numba.njit("(float64[::1], float64[::1])", **COMPILED)(square_roots)
    (assembly,) = compiled.inspect_asm().values()
    assert re.search("vsqrtpd.*zmm" if WIDTH == 8 else "v?sqrtpd.*[xy]mm", assembly)
    assert WIDTH == 8 or not re.search("vsqrtpd.*zmm", assembly)
