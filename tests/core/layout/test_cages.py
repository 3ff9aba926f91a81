"""Each roller takes the motion of the cage of its own row."""

from __future__ import annotations

import numpy as np
import pytest

from dcrb_ros.core.layout.cages import headings_of, of_cages, of_row
from dcrb_ros.core.layout.state import CAGE

pytestmark = pytest.mark.kernel


def test_a_roller_takes_the_cage_of_its_row() -> None:
    bodies = np.arange(12.0).reshape(4, 3)  # outer ring, inner ring, two cages
    heading = np.array([[0.6, 0.8], [0.0, 1.0]])
    for row in (0, 1):
        assert of_row(of_cages(bodies), float(row)) == tuple(bodies[CAGE + row])
        assert of_row(headings_of(heading), float(row)) == (*heading[row], 0.0)


def test_a_single_cage_counts_for_both_rows() -> None:
    bodies = np.arange(9.0).reshape(3, 3)
    assert of_row(of_cages(bodies), 0.0) == of_row(of_cages(bodies), 1.0) == tuple(bodies[CAGE])
