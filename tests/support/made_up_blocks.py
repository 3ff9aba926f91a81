"""Blocks of noise, made without the model, for tests of encoders and recordings."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from dcrb_ros.messages.encoder import BlockEncoder
from dcrb_ros.messages.topics import MANIFEST, NAMESPACE, Message
from dcrb_ros.recordings.manifest import OUTCOME, opening, record_text
from dcrb_ros.recordings.recorder import Recorder, channel_of
from dcrb_ros.recordings.splitting import Bag
from dcrb_ros.schema.simulated_time import nanoseconds
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.parameters import Recording as Settings
from dcrb_ros.stream.block import Block, Truth
from dcrb_ros.stream.events import Event, Start
from dcrb_ros.stream.states import BodyNames

BODIES = BodyNames(2, 16)
FREQUENCIES = {"FTF": 8.4, "BPFO": 134.5, "BPFI": 185.5, "BSF": 61.1}


def blocks(count: int, *, size: int = 1024, rate: int = 51200, events: Mapping[int, Event] | None = None) -> Iterator[Block]:
    """Yield blocks of noise; ``events`` gives the event at the first sample of a block by the number of the block."""
    random = np.random.default_rng(5)
    for number in range(count):
        index = number * size
        acceleration = random.normal(0.0, 10.0, (size, 2)).astype(np.float32)
        angle = np.mod(125.0 * (index + np.arange(size)) / rate, 2.0 * np.pi).astype(np.float32)
        event = (events or {}).get(number, Start() if number == 0 else None)
        truths = (Truth(nanoseconds(index, rate), 125.0, (0.0, -1e5), FREQUENCIES, {}, event),)
        yield Block(index, rate, acceleration, angle, acceleration, truths=truths)


def recorded(path: Path, count: int, *, events: Mapping[int, Event] | None = None, **recording: object) -> Path:
    """Record blocks of noise with some keys of the group ``recording``."""
    configuration = Configuration.model_validate({"recording": recording})
    with Recorder(path, configuration, BODIES) as recorder:
        for block in blocks(count, events=events):
            recorder.write(block)
    return path


def encoded(count: int, *, events: Mapping[int, Event] | None = None) -> list[Message]:
    """Return the messages of blocks of noise."""
    encoder = BlockEncoder(Configuration(), BODIES)
    return [message for block in blocks(count, events=events) for message in encoder.encode(block)]


def written(
    path: Path, messages: Iterable[Message], *, outcome: Mapping[str, object] | None, below: str = NAMESPACE, **changes: object
) -> Path:
    """Write messages in the namespace ``below``, with an ``outcome`` if one is given, and with the manifest of a bench.

    Some of its entries differ by ``changes``; None removes an entry.
    """
    about = json.loads(opening(Configuration(), BODIES, NAMESPACE)[MANIFEST]["manifest"]) | changes
    manifest = record_text({key: value for key, value in about.items() if value is not None})
    end = {} if outcome is None else {OUTCOME: {"outcome": json.dumps(outcome)}}
    records = {MANIFEST: {"manifest": manifest}, "other": {"a": "1"}}
    bag = Bag(path, opening=records, closing=lambda: end, settings=Settings(compression="lz4"))
    bag.write((channel_of(message.topic, below), message.time_ns, message.data) for message in messages)
    bag.close()
    return path


def narrowed(path: Path, count: int, *, at: int, limit: float, **recording: object) -> Path:
    """Record blocks of dull noise, 10 m/s^2 rms, whose sensor has a smaller range from block ``at`` on, at which it clips now and then."""
    with Recorder(path, Configuration.model_validate({"recording": recording}), BODIES) as recorder:
        for number, block in enumerate(blocks(count)):
            dull = np.stack([np.convolve(column, np.full(16, 0.25), "same") for column in block.acceleration.T], axis=1)
            span = limit if number >= at else 5000.0
            recorder.write(replace(block, acceleration=np.clip(dull, -span, span).astype(np.float32), range=span))
    return path
