"""From the blocks of a recording to the arrays that the viewer shows."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from dcrb_ros.block import Block, Layout, Samples, nanoseconds
from dcrb_ros.parameters import Bearing
from dcrb_ros.refusal import Refusal
from dcrb_ros.viewer.content import Content, Motion, Series, Times, Waveform

FEATURES = ("rms", "peak", "crest", "kurtosis")


def content_of(title: str, bearing: Bearing, blocks: Iterable[Block]) -> Content:
    """Return what is shown of ``blocks``; refuse when they hold no sample."""
    held = [block for block in blocks if len(block.acceleration)]
    if not held:
        raise Refusal(f"{title} has no waveform: the viewer needs at least one block on outer_ring/vibration; record one with dcrb simulate")
    return Content(
        title=title,
        bearing=bearing,
        layout=Layout(bearing.rows, bearing.rollers_per_row),
        waveform=waveform_of(held),
        motion=motion_of(held),
        truths=tuple(truth for block in held for truth in block.truths),
        features=features_of(held),
    )


def waveform_of(blocks: list[Block]) -> Waveform:
    """Return the samples of all blocks end to end."""
    return Waveform(
        time_ns=np.concatenate([sample_times(block) for block in blocks]),
        acceleration=np.concatenate([block.acceleration for block in blocks]),
        shaft_angle=np.concatenate([block.shaft_angle for block in blocks]),
        rate=blocks[0].rate,
    )


def sample_times(block: Block) -> Times:
    """Return the simulated time of each sample [ns], by the rule of `nanoseconds`."""
    whole, rest = divmod(block.index, block.rate)
    ticks = rest + np.arange(len(block.acceleration), dtype=np.int64)
    return np.asarray(whole * 1_000_000_000 + nanoseconds_of(ticks, block.rate), np.int64)
