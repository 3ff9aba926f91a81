"""The ground truth: the faults that a detector should find."""

from __future__ import annotations

from dcrb_ros.messages.cdr import DIAGNOSTICS
from dcrb_ros.messages.statuses import decode_truth, encode_truth
from dcrb_ros.messages.topic import Encoded, EncodedBench, SimulatedTopic
from dcrb_ros.stream.block import Block


def _encode(block: Block, source: EncodedBench) -> Encoded:
    return ((truth.time_ns, encode_truth(truth, source.frame)) for truth in block.truths)


GROUND_TRUTH = SimulatedTopic(
    "ground_truth",
    DIAGNOSTICS,
    "every fault of bearing and sensor with its size, as a status `faults.outer_1`, `faults.broken_bars.row1/bar15`, "
    "`faults.sensor.stuck`; background, speed, load, FTF, BPFO, BPFI, BSF; 10 Hz and at every change",
    decode=decode_truth,
    encode=_encode,
)
