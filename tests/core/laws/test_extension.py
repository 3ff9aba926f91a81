"""A law is one file and one line of the registry: those of the how-to page, added to a copy of the package."""

from __future__ import annotations

import numpy as np
import pytest
from how_to import ROOT, copied_package, effort, run

PAGE = ROOT / "docs" / "how-to" / "add-a-law.md"

BENCH = """
from dcrb_ros.settings.files import load_configuration

configuration = load_configuration("dry", ["friction.law=dahl", "friction.dahl_coefficient=0.04", "contact.law=spring"])
"""
RUN = (
    BENCH
    + """
import numpy as np

from dcrb_ros.bearing.payload import build_payload, initial_state
from dcrb_ros.core.layout.workspace import workspace
from dcrb_ros.core.solver.step import advance

payload = build_payload(configuration)
state, acceleration = initial_state(configuration, payload), np.empty((40, 2))
advance(payload, state, workspace(payload), acceleration, np.empty(40))
assert np.isfinite(acceleration).all()
inner = state.rollers[0].inner
deflection, deepest = state.of_rollers(inner.traction.deflection), state.of_rollers(inner.normal.deepest)
assert not deflection[state.inner_force == 0.0].any()
print(np.count_nonzero(deflection), np.abs(deflection).max(), np.count_nonzero(deepest), deepest.max())
"""
)
COMPILED = (
    BENCH
    + """
import numpy as np
from numba import njit

from dcrb_ros.bearing.payload import build_payload, initial_state
from dcrb_ros.core.jit import COMPILED
from dcrb_ros.core.laws.calls import (
    load_kept, load_memory, normal_energy, normal_force, normal_update, store_kept, store_memory, traction_line, traction_update
)
from dcrb_ros.core.layout.state import copy_of
from dcrb_ros.core.layout.workspace import workspace

payload = build_payload(configuration)
state, work = initial_state(configuration, payload), workspace(payload)

def contact(normal, traction, state, work, site, penetration, slip, step, k):
    table, kept = state.rollers[0].inner, work.bound[0].inner.kept
    force, _ = normal_force(normal, load_memory(normal, table.normal, k), penetration, site)
    energy = normal_energy(normal, load_memory(normal, table.normal, k), penetration, force)
    store_memory(normal, table.normal, k, normal_update(normal, load_memory(normal, table.normal, k), penetration, 0.0, step))
    offset, slope, one = traction_line(traction, load_memory(traction, table.traction, k), slip, 0.0, force, site, step)
    store_kept(traction, kept, k, one)
    after = traction_update(traction, load_memory(traction, table.traction, k), load_kept(traction, kept, k), slip, force > 0.0, step)
    store_memory(traction, table.traction, k, after)
    return force, energy, offset, slope, table.traction.deflection[k], table.normal.deepest[k]

for call in (njit(**COMPILED)(contact), contact):
    own, found = copy_of(state), []
    for depth in (1e-5, 2e-5, 1.5e-5):
        found += call(payload.normal_law, payload.traction_law, own, work, payload.inner, depth, 0.01, payload.step, 3)
    print(*found)
"""
)
REFUSED = """
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.files import load_configuration

try:
    load_configuration("dry", ["friction.dahl_stiffness=0.1"])
except Refusal as refusal:
    print(refusal)
"""


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Return the environment of a copy of the package with the laws of the page."""
    return copied_package(tmp_path_factory.mktemp("extended"), PAGE)


def test_the_page_adds_a_file_and_a_line_per_law() -> None:
    assert effort(PAGE) == (2, 2)


@pytest.mark.slow
def test_laws_with_memories_run_and_keep_them(environment: dict[str, str]) -> None:
    # The property needs no speed, and the compiler takes longer for a further combination of laws than Python for 40 steps.
    slipping, largest_deflection, closed, deepest = (float(number) for number in run(environment | {"NUMBA_DISABLE_JIT": "1"}, RUN).split())
    assert slipping > 0
    assert closed > 0
    assert largest_deflection <= 0.04 / 1e5 * (1.0 + 1e-9)  # mu/sigma
    assert deepest == pytest.approx(30e3 / 1.5e9, rel=0.2)  # the loaded roller bears 30 kN, see tests/bearing/test_equilibrium.py


@pytest.mark.slow
def test_compiled_laws_are_those_of_python(environment: dict[str, str]) -> None:
    compiled, expected = (np.array(line.split(), float).reshape(3, 6) for line in run(environment, COMPILED).splitlines())
    assert compiled == pytest.approx(expected, rel=1e-12)
    assert np.all(np.diff(compiled[:, 4]) > 0.0)  # the deflection grows with the way that has slipped
    assert list(compiled[:, 5]) == [1e-5, 2e-5, 2e-5]


def test_parameters_of_a_new_law_are_checked_like_all_others(environment: dict[str, str]) -> None:
    assert "friction.dahl_stiffness = 0.1 1/m" in run(environment, REFUSED)
