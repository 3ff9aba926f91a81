"""Random streams of the stages, and times of a Poisson process."""

from __future__ import annotations

import hashlib
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dcrb_ros.measurement.random_streams import PoissonTimes, random_stream


def test_the_key_of_a_stream_is_the_first_half_of_a_hash_of_seed_and_stage() -> None:
    key = int.from_bytes(hashlib.sha256(b"7/hum").digest()[:16], "little")
    expected = np.random.Generator(np.random.Philox(key=key)).random(5)
    assert random_stream(7, "hum").random(5).tolist() == expected.tolist()
    assert random_stream(8, "hum").random() != expected[0]
    assert random_stream(7, "bias").random() != expected[0]


@given(cuts=st.lists(st.integers(1, 200), min_size=1, max_size=8))
def test_times_of_a_poisson_process_do_not_depend_on_the_split(cuts: list[int]) -> None:
    """Gaps are -ln(1 - u) / rate with u from 0 to 1; each time takes one number for its gap and one that it carries."""
    random, expected, at = np.random.default_rng(3), [], 0.0
    while (at := at - math.log1p(-random.random()) / 0.05) < sum(cuts):
        expected.append((at, random.random()))
    times, first, found = PoissonTimes(np.random.default_rng(3)), 0, []
    for count in cuts:
        found += list(times.within(first, count, 0.05))
        first += count
    assert np.array(found).ravel() == pytest.approx(np.array(expected).ravel())


def test_after_a_pause_times_begin_anew() -> None:
    times = PoissonTimes(np.random.default_rng(3))
    assert list(times.within(0, 100, 0.5))
    found = [at for at, _ in times.within(5000, 100, 0.5)]
    assert len(found) == pytest.approx(50, abs=20)
    assert min(found) > 5000.0
    assert max(found) < 5100.0


def test_times_follow_a_change_of_their_rate() -> None:
    """The first interval of a rare process is 1e6 ticks long in the mean."""
    times = PoissonTimes(np.random.default_rng(3))
    assert not list(times.within(0, 100, 1e-6))
    found = [at for at, _ in times.within(100, 10000, 0.05)]
    assert len(found) == pytest.approx(500, abs=100)
    assert min(found) < 300.0
