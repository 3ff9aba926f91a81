"""Many bearings at once."""

from __future__ import annotations

import numpy as np
import pytest

from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.simulation.batch import simulate_many, waveform


@pytest.mark.parametrize("workers", [1, 2])
def test_samples_do_not_depend_on_the_workers(workers: int) -> None:
    groups = [{"simulation": {"seed": seed}, "faults": {"outer_1": {"width": 1e-3 * seed}}} for seed in range(3)]
    configurations = [Configuration.model_validate(group) for group in groups]
    found = dict(simulate_many(configurations, 0.03, workers=workers))
    assert sorted(found) == [0, 1, 2]
    for place, configuration in enumerate(configurations):
        alone = waveform(configuration, 0.03)
        assert np.array_equal(found[place].acceleration, alone.acceleration)
        assert np.array_equal(found[place].shaft_angle, alone.shaft_angle)


def test_nothing_to_simulate() -> None:
    assert list(simulate_many([], 1.0)) == []


def test_what_fails_in_a_process_is_told() -> None:
    bad = Configuration.model_construct()
    with pytest.raises((AttributeError, TypeError, ValueError)):
        list(simulate_many([bad], -1.0, workers=1))
