"""Batches of configurations, simulated in parallel."""

from __future__ import annotations

import numpy as np
import pytest

from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.parameters import Housing
from dcrb_ros.simulation.batch import simulate_batch, waveform
from dcrb_ros.simulation.failure import ModelFailure


@pytest.mark.parametrize("workers", [1, 2])
def test_samples_do_not_depend_on_the_number_of_workers(workers: int) -> None:
    groups = [{"simulation": {"seed": seed}, "faults": {"outer_1": {"width": 1e-3 * seed}}} for seed in range(3)]
    configurations = [Configuration.model_validate(group) for group in groups]
    found = dict(simulate_batch(configurations, 0.03, workers=workers))
    assert sorted(found) == [0, 1, 2]
    for index, configuration in enumerate(configurations):
        alone = waveform(configuration, 0.03)
        assert np.array_equal(found[index].acceleration, alone.acceleration)
        assert np.array_equal(found[index].shaft_angle, alone.shaft_angle)


def test_an_empty_batch_yields_nothing() -> None:
    assert list(simulate_batch([], 1.0)) == []


def test_a_failure_in_a_worker_is_raised_with_its_type_and_message() -> None:
    # A housing as soft as this is refused by the configuration; a copy is not checked.
    overloaded = Configuration().model_copy(update={"housing": Housing(stiffness=1e3)})
    with pytest.raises(ModelFailure, match=r"outer ring is .* m off its seat"):
        list(simulate_batch([overloaded], 0.1, workers=1))
