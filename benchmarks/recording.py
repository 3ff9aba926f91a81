"""Recordings in numbers: how fast they are written, read, replayed into bundles and made into a Rerun file, and how large they are.

Blocks of one simulated run are written again and again, so the model's speed does not count; run it on a machine that does nothing else.
"""

from __future__ import annotations

import argparse
import dataclasses
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from dcrb_ros.block import Block
from dcrb_ros.configuration import Configuration
from dcrb_ros.configuration_file import load_configuration
from dcrb_ros.messages import BlockEncoder
from dcrb_ros.recording import Recording
from dcrb_ros.simulation import Simulation
from dcrb_ros.sinks.recorder import Recorder
from dcrb_ros.topics import VIBRATION, Message

RAW = 12
"""Bytes of a sample: ax, ay and shaft angle as single floats."""


def repeated(blocks: list[Block], seconds: float) -> Iterator[Block]:
    """Yield blocks that follow each other in time, as many as ``seconds`` hold."""
    rate, index = blocks[0].rate, 0
    while index < seconds * rate:
        for block in blocks:
            shift = (index - block.index) * 1_000_000_000 // rate
            yield dataclasses.replace(
                block,
                index=index,
                preview_ns=tuple(at + shift for at in block.preview_ns),
                states=tuple(dataclasses.replace(states, time_ns=states.time_ns + shift) for states in block.states),
                truths=tuple(dataclasses.replace(truth, time_ns=truth.time_ns + shift, changed="") for truth in block.truths),
            )
            index += len(block.shaft_angle)


def timed(work: Callable[[], object]) -> float:
    """Return the wall time of some work [s]."""
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin


def written(path: Path, configuration: Configuration, simulation: Simulation, blocks: list[list[Message]]) -> None:
    """Record messages that are encoded already, as the node does."""
    with Recorder(path, configuration, simulation.layout) as recorder:
        for messages in blocks:
            recorder.write_messages(messages)


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--duration", type=float, default=30.0, help="recorded time [s]")
    parser.add_argument("--view", type=float, default=30.0, help="recorded time that is made into a Rerun file [s]; 0 for none")
    options = parser.parse_args()
    simulation = Simulation(load_configuration("outer_ring_defect"))
    blocks = list(simulation.blocks(1.0))
    heads = (
        "compression",
        "blocks/s",
        "MB/s",
        "x real time",
        "bytes per simulated second",
        "of raw samples",
        "of all messages",
        "read back",
    )
    print(f"| {' | '.join(heads)} |\n{'|---' * len(heads)}|")
    with tempfile.TemporaryDirectory() as folder:
        for compression in ("zstd", "lz4", "none"):
            configuration = load_configuration("outer_ring_defect", [f"recording.compression={compression}"])
            encoder = BlockEncoder(configuration, simulation.layout)
            encoded = [encoder.encode(block) for block in repeated(blocks, options.duration)]
            data = sum(len(message.data) for messages in encoded for message in messages)
            path = Path(folder) / compression
            took = timed(lambda path=path, c=configuration, e=encoded: written(path, c, simulation, e))  # type: ignore[misc]
            size = sum(file.stat().st_size for file in path.iterdir())
            back = timed(lambda path=path: sum(1 for _ in Recording(path).vibrations()))  # type: ignore[misc]
            raw = options.duration * configuration.sensor.sampling_rate * RAW
            print(
                f"| {compression} | {len(encoded) / took:.0f} | {data / took / 1e6:.1f} | {options.duration / took:.0f} | "
                f"{size / options.duration:.0f} | {size / raw:.2f} | {size / data:.2f} | {options.duration / back:.0f} x real time |",
                flush=True,
            )
        if options.view:
            from dcrb_ros.viewer.show import view_recording

            bag, file = Path(folder) / "view", Path(folder) / "view.rrd"
            configuration = load_configuration("outer_ring_defect")
            encoder = BlockEncoder(configuration, simulation.layout)
            written(bag, configuration, simulation, [encoder.encode(block) for block in repeated(blocks, options.view)])
            view_recording(bag, save=file, screenshot=None, web=False)  # imports, once
            file.unlink()
            took = timed(lambda: view_recording(bag, save=file, screenshot=None, web=False))
            print(
                f"\n`dcrb view --save`: {options.view / took:.1f} x real time, {file.stat().st_size / options.view / 1e6:.2f} MB a second"
            )
        messages = sum(1 for _ in Recording(Path(folder) / "zstd").messages((VIBRATION,)))
        assert messages == len(encoded)


if __name__ == "__main__":
    main()
