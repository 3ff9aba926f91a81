"""The range in which losses are within 40 % of SKF's model, as docs/explanation/lubrication.md and docs/results/realism.md state it."""

from __future__ import annotations

import pytest
from friction import ratio

pytestmark = pytest.mark.slow

DOCUMENTED = 0.02
"""Half of the last documented digits, and what another processor may change [-]."""


@pytest.mark.parametrize("temperature", [50.0, 90.0])
@pytest.mark.parametrize("load", [5e4, 2e5])
@pytest.mark.parametrize("rpm", [600.0, 1800.0])
def test_losses_are_within_40_per_cent_at_the_corners_of_the_documented_range(rpm: float, load: float, temperature: float) -> None:
    assert 0.66 - DOCUMENTED < ratio("grease", rpm, load, temperature) < 1.23 + DOCUMENTED


@pytest.mark.parametrize(("rpm", "load", "temperature", "documented"), [(150.0, 1e5, 50.0, 0.56), (2500.0, 2e4, 70.0, 1.60)])
def test_losses_outside_of_it_are_as_far_off_as_documented(rpm: float, load: float, temperature: float, documented: float) -> None:
    assert ratio("grease", rpm, load, temperature) == pytest.approx(documented, abs=DOCUMENTED)
