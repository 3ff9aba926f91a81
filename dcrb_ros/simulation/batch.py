"""Waveforms of many configurations, simulated in parallel processes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

from dcrb_ros.bearing.waveform import Waveform
from dcrb_ros.runtime.processes import cores, in_processes
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.simulation.run import waveform_of


def waveform(configuration: Configuration, duration: float) -> Waveform:
    """Return the waveform of a bearing from its settled start over ``duration`` [s].

    Raises:
        ModelFailure: the model leaves its domain.
    """
    return waveform_of(list(Simulation(configuration, waveform_only=True).blocks(duration)), configuration)


def simulate_batch(
    configurations: Sequence[Configuration], duration: float, *, workers: int | None = None
) -> Iterator[tuple[int, Waveform]]:
    """Yield the index in ``configurations`` and the waveform of each bearing, in the order of completion.

    Each worker is a process; by default there is one per core. The samples equal those of `waveform` for any number of workers.

    Raises:
        ModelFailure: one of the models leaves its domain; the others are stopped.
    """
    calls = {index: partial(waveform, configuration, duration) for index, configuration in enumerate(configurations)}
    return in_processes(calls, min(workers or cores(), max(len(calls), 1)))
