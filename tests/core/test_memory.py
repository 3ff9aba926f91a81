"""Memory that a later step reads."""

from __future__ import annotations

import numpy as np
import pytest

from dcrb_ros.core.jit import loop
from dcrb_ros.core.layout.records import Integers
from dcrb_ros.core.memory import prefetch

pytestmark = pytest.mark.kernel


@loop
def first_after_prefetch(array: Integers, index: int) -> int:
    """Return the first element of an array after an element was prefetched."""
    prefetch(array, index)
    first: int = array[0]
    return first


@pytest.mark.parametrize("index", [0, -8, 3, 10**9])
def test_a_prefetch_may_lie_anywhere_and_changes_nothing(index: int) -> None:
    array = np.arange(7, 11)
    assert first_after_prefetch(array, index) == 7
    assert np.array_equal(array, np.arange(7, 11))
