"""Which rollers lie beside which bars."""

from __future__ import annotations

import pytest

from dcrb_ros.bearing.payload import build_payload
from dcrb_ros.core.jit import loop
from dcrb_ros.core.payload import Payload
from dcrb_ros.core.solver.classification import bar_at
from dcrb_ros.settings.configuration import Configuration

pytestmark = pytest.mark.kernel


@loop
def barred(payload: Payload, row: int, i: int, ahead: bool) -> bool:
    """Return whether there is a bar ahead of a roller, or behind it."""
    return bar_at(payload, row, i, ahead)


@pytest.mark.parametrize(("bar", "behind", "ahead"), [(15, 14, 15), (16, 15, 0)])
def test_only_the_rollers_on_either_side_miss_a_broken_bar(bar: int, behind: int, ahead: int) -> None:
    payload = build_payload(Configuration.model_validate({"faults": {"broken_bars": f"row2/bar{bar}"}}))
    missing = {(row, i, way) for row in (0, 1) for i in range(16) for way in (True, False) if not barred(payload, row, i, way)}
    assert missing == {(1, behind, True), (1, ahead, False)}
