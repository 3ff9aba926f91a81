"""What the temperature sensors at outer ring and axle box and in the air read."""

from __future__ import annotations

from functools import partial

from dcrb_ros.messages.plain import TEMPERATURE, decode_temperature, encode_temperature
from dcrb_ros.messages.topic import Encoded, EncodedBench, SimulatedTopic
from dcrb_ros.stream.block import Block


def _encode(place: str, block: Block, source: EncodedBench) -> Encoded:
    noise = source.configuration.thermal.sensor_noise
    for reading in block.temperatures:
        yield reading.time_ns, encode_temperature(reading.time_ns, getattr(reading, place), noise, source.frame)


def _topic(place: str, content: str) -> SimulatedTopic:
    """Return the topic of a sensor at a place, an attribute of `dcrb_ros.stream.states.TemperatureReading`."""
    return SimulatedTopic(
        f"{place}/temperature",
        TEMPERATURE,
        f"{content} [deg C]; 1 Hz, only with `thermal.law: network`",
        decode=decode_temperature,
        encode=partial(_encode, place),
        enabled=lambda configuration: configuration.thermal.law != "none",
    )


OUTER_RING_TEMPERATURE = _topic("outer_ring", "temperature of the outer ring of the last row, without lag")
BOX_TEMPERATURE = _topic("box", "temperature in the housing over the load zone, with the lag of `thermal.sensor_lag`")
AMBIENT_TEMPERATURE = _topic("ambient", "temperature of the air")
