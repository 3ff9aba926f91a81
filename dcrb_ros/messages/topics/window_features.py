"""Features of windows of a second, as `dcrb_ros.extract_features` computes them."""

from __future__ import annotations

from collections.abc import Callable

from dcrb_ros.bearing.frequencies import characteristic_orders
from dcrb_ros.messages.cdr import JOINT_STATE
from dcrb_ros.messages.joints import decode_joints, encode_joints
from dcrb_ros.messages.topic import Encoded, EncodedBench, SimulatedTopic
from dcrb_ros.schema.simulated_time import nanoseconds
from dcrb_ros.stream.block import Block


def _begin(source: EncodedBench) -> Callable[[Block, EncodedBench], Encoded]:
    """Return the encoder of a run, which keeps the samples of the present window."""
    from dcrb_ros.diagnosis.features.extraction import FeatureExtractor  # scipy is for those who publish features

    rate = source.configuration.sensor.sampling_rate
    extractor = FeatureExtractor(characteristic_orders(source.configuration.bearing), rate)

    def encode(block: Block, source: EncodedBench) -> Encoded:
        if block.lost:
            return
        table = extractor.update(block.index, block.acceleration, block.shaft_angle)
        for end, values in zip(table.time, table.values, strict=True):
            end_ns = nanoseconds(round(end * rate), rate)
            yield end_ns, encode_joints(end_ns, extractor.names, values, frame=source.frame)

    return encode


WINDOW_FEATURES = SimulatedTopic(
    "outer_ring/window_features",
    JOINT_STATE,
    "the features of `dcrb_ros.extract_features` in `position`, of a window of a second every half second, stamped with its end; NaN where "
    "the shaft turns too little; off by default (`publishing.features`)",
    decode=decode_joints,
    begin=_begin,
    enabled=lambda configuration: configuration.publishing.features,
)
