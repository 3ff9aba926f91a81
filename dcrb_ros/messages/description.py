"""The description of the sensor in JSON: what is needed to interpret the waveform."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Any

from dcrb_ros.bearing.frequencies import Orders, characteristic_orders
from dcrb_ros.messages.cdr import FRAME
from dcrb_ros.messages.plain import decode_text
from dcrb_ros.schema.numbers import sampling_rate
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.json import parsed_json

if TYPE_CHECKING:
    from dcrb_ros.settings.configuration import Configuration

SOURCE = "the sensor's description"
LARGEST_DESCRIPTION = 100_000
"""Longest description that is read [characters]; that of the bench has some 1500."""
PULSES_PER_TURN = "tacho_pulses_per_turn"
"""Entry of a description with the pulses of the tacho per turn of the shaft; there is none without a tacho."""
INDICATORS = ("BPFO", "BPFI", "BSF", "FTF")


def sensor_text(configuration: Configuration) -> str:
    """Return the description in JSON: sampling rate, units, axes, bearing, characteristic orders, numbering of the samples."""
    orders = characteristic_orders(configuration.bearing)
    about = {
        "sampling_rate": configuration.sensor.sampling_rate,
        "sampling_rate_unit": "Hz",
        "acceleration_unit": "m/s^2",
        "axes": {"ax": "X, right", "ay": "Y, up"},
        "shaft_angle_unit": "rad",
        "range": configuration.sensor.range,
        "block_size": configuration.publishing.block_size,
        "frame": configuration.publishing.frame,
        "bearing": {key: value for key, value in configuration.bearing.model_dump().items() if key != "contact_angle" or value},
        "orders": orders.as_dict(),
        "first_sample_index": "round(stamp * sampling_rate); sample k is taken at k / sampling_rate of simulated time",
    }
    publishing, pulses_per_turn = configuration.publishing, configuration.tacho.pulses_per_turn
    if pulses_per_turn:
        about[PULSES_PER_TURN] = pulses_per_turn
    if publishing.burst_period > 0.0:
        about |= {"burst_length": publishing.burst_length, "burst_period": publishing.burst_period, "burst_unit": "s"}
    return json.dumps(about, sort_keys=True)


def decode_sensor(data: bytes) -> tuple[int, Orders]:
    """Return sampling rate [Hz] and characteristic orders from a description.

    Raises:
        Refusal: the message is not a description.
    """
    try:
        about = parsed_json(decode_text(data), SOURCE, LARGEST_DESCRIPTION)
        orders = Orders.from_dict(about["orders"])
        rate = sampling_rate(about["sampling_rate"], SOURCE)
    except Refusal:
        raise
    except (ValueError, KeyError, TypeError) as error:
        raise Refusal(f"{SOURCE} cannot be decoded ({type(error).__name__}): it must be JSON with sampling_rate and orders") from None
    return rate, orders


def decode_range(data: bytes) -> float:
    """Return the range from a description [m/s^2], 0 if it is not given."""
    try:
        limit = float(decode_entry(data, "range"))
    except (ValueError, TypeError, OverflowError):
        return 0.0
    return limit if math.isfinite(limit) and limit > 0.0 else 0.0


def decode_pulses_per_turn(data: bytes) -> int:
    """Return the pulses of the tacho per turn from a description; 0 if there are none."""
    pulses = decode_entry(data, PULSES_PER_TURN)
    return pulses if isinstance(pulses, int) and pulses > 0 else 0


def decode_frame(data: bytes) -> str:
    """Return the frame id from a description, that of the shipped configurations if it is not given."""
    frame = decode_entry(data, "frame")
    return frame if isinstance(frame, str) and frame else FRAME


def decode_entry(data: bytes, key: str) -> Any:
    """Return an entry of a description in any form, such as its ``bearing``; None if it is not given."""
    try:
        return parsed_json(decode_text(data), SOURCE, LARGEST_DESCRIPTION).get(key)
    except (ValueError, AttributeError):
        return None
