"""A law is one file and one line of the registry: those of the how-to page, added to a copy of the package."""

from __future__ import annotations

import pytest
from how_to import ROOT, copied_package, effort, run

PAGE = ROOT / "docs" / "how-to" / "add-a-law.md"

RUN = """
import numpy as np

from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.settings.files import load_configuration

simulation = Simulation(load_configuration("dry", ["friction.law=dahl", "friction.dahl_coefficient=0.04", "contact.law=spring"]))
samples = np.concatenate([block.clean for block in simulation.blocks(0.02)])
assert np.isfinite(samples).all()
state = simulation._state
inner = state.rollers[0].inner
deflection, deepest = state.of_rollers(inner.traction.deflection), state.of_rollers(inner.normal.deepest)
assert not deflection[state.inner_force == 0.0].any()
print(np.count_nonzero(deflection), np.abs(deflection).max(), np.count_nonzero(deepest), deepest.max())
"""
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


def test_laws_with_memories_run_and_keep_them(environment: dict[str, str]) -> None:
    slipping, largest_deflection, closed, deepest = (float(number) for number in run(environment, RUN).split())
    assert slipping > 0
    assert closed > 0
    assert largest_deflection <= 0.04 / 1e5 * (1.0 + 1e-9)  # mu/sigma
    assert deepest == pytest.approx(30e3 / 1.5e9, rel=0.2)  # the loaded roller bears 30 kN, see tests/bearing/test_equilibrium.py


def test_parameters_of_a_new_law_are_checked_like_all_others(environment: dict[str, str]) -> None:
    assert "friction.dahl_stiffness = 0.1 1/m" in run(environment, REFUSED)
