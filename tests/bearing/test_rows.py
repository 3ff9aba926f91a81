"""Two rows of rollers, one behind the other or staggered."""

from __future__ import annotations

import math

import numpy as np
import pytest

from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.simulation.loop import Simulation


@pytest.mark.parametrize("phase", [0.0, 0.25, 0.8])
def test_the_second_row_keeps_its_phase_as_the_bearing_turns(phase: float) -> None:
    staggered = Configuration.model_validate({"cage": {"joint": "revolute"}, "bearing": {"row_phase": phase}})
    states = [state for block in Simulation(staggered).blocks(0.03) for state in block.states]
    pitch = 2.0 * math.pi / 16.0
    assert len(states) >= 2
    for state in (states[0], states[-1]):
        ahead = np.exp(1j * (state.azimuth[16:32] - state.azimuth[:16]))
        # Both cages are driven alike; their angles drift apart by a few hundredths of a pitch.
        assert np.angle(ahead * np.exp(-1j * phase * pitch)) == pytest.approx(np.zeros(16), abs=0.05 * pitch)
