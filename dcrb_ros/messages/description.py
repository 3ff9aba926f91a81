"""The description of the sensor in JSON: what is needed to interpret the waveform."""

from __future__ import annotations

import json
import math

from dcrb_ros.bearing.kinematics import Orders, characteristic_orders
from dcrb_ros.messages.plain import decode_text
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration

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
        "bearing": configuration.bearing.model_dump(),
        "orders": orders.as_dict(),
        "first_sample_index": "round(stamp * sampling_rate); sample k is taken at k / sampling_rate of simulated time",
    }
    publishing = configuration.publishing
    if publishing.burst_period > 0.0:
        about |= {"burst_length": publishing.burst_length, "burst_period": publishing.burst_period, "burst_unit": "s"}
    return json.dumps(about, sort_keys=True)


def decode_sensor(data: bytes) -> tuple[int, Orders]:
    """Return sampling rate [Hz] and characteristic orders from a description.

    Raises:
        Refusal: the message is not a description.
    """
    text = decode_text(data)
    try:
        about = json.loads(text)
        orders = Orders.from_dict(about["orders"])
        rate = int(about["sampling_rate"])
    except (ValueError, KeyError, TypeError, OverflowError, RecursionError) as error:
        raise Refusal(
            f"the sensor's description cannot be decoded ({type(error).__name__}): it must be JSON with sampling_rate and orders"
        ) from None
    if rate <= 0 or not all(math.isfinite(order) and order > 0.0 for order in orders.as_dict().values()):
        raise Refusal(f"the sensor's description gives {rate} Hz and orders {orders.as_dict()}: all must be positive and finite")
    return rate, orders


def decode_range(data: bytes) -> float:
    """Return the range from a description [m/s^2], 0 if it is not given."""
    text = decode_text(data)
    try:
        found = float(json.loads(text).get("range", 0.0))
    except (ValueError, TypeError, AttributeError, OverflowError, RecursionError):
        return 0.0
    return found if math.isfinite(found) and found > 0.0 else 0.0
