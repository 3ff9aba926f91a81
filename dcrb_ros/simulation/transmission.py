"""Transmission of blocks: some are lost at random, and a sensor in burst mode sends only some."""

from __future__ import annotations

from dcrb_ros.measurement.random_streams import random_stream
from dcrb_ros.settings.configuration import Configuration


class Transmission:
    """Decides for each block, in order, whether its waveform is transmitted."""

    def __init__(self, configuration: Configuration) -> None:
        publishing = configuration.publishing
        self._probability = publishing.loss_probability
        rate = configuration.sensor.sampling_rate
        self._length, self._period = round(publishing.burst_length * rate), round(publishing.burst_period * rate)
        self._random = random_stream(configuration.simulation.seed, "transmission")

    def between_bursts(self, first: int) -> bool:
        """Return whether a block whose first sample has the index ``first`` lies between two bursts."""
        return self._period > 0 and first % self._period >= self._length

    def next_is_lost(self) -> bool:
        """Return whether the next block is lost."""
        return self._probability > 0.0 and float(self._random.random()) < self._probability
