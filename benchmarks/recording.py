"""Speed of writing, reading and converting recordings, in recorded seconds per second of processor time, and their size.

The blocks of one simulated run are written repeatedly, so the speed of the model has no influence.
"""

from __future__ import annotations

import dataclasses
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

from start import cost

from dcrb_ros.messages.encoder import BlockEncoder
from dcrb_ros.messages.topics import Message
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.stream.block import Block

RAW = 12
"""Size of a sample, ax, ay and shaft angle as single floats [B]."""
DURATION = 30.0
"""Recorded time, and time converted to a Rerun file [s]."""


def repeated(blocks: list[Block], seconds: float) -> Iterator[Block]:
    """Yield ``seconds`` of consecutive blocks, made by repeating the given ones with shifted times [s]."""
    rate, index = blocks[0].rate, 0
    while index < seconds * rate:
        for block in blocks:
            shift = (index - block.index) * 1_000_000_000 // rate
            yield dataclasses.replace(
                block,
                index=index,
                preview_ns=tuple(at + shift for at in block.preview_ns),
                states=tuple(dataclasses.replace(states, time_ns=states.time_ns + shift) for states in block.states),
                truths=tuple(dataclasses.replace(truth, time_ns=truth.time_ns + shift, event=None) for truth in block.truths),
            )
            index += len(block.shaft_angle)


def timed(work: Callable[[], object]) -> float:
    """Return the processor time of a call, all threads together [s]."""
    begin = time.process_time()
    work()
    return time.process_time() - begin


def written(path: Path, configuration: Configuration, simulation: Simulation, blocks: list[list[Message]]) -> None:
    """Record encoded messages as the node does."""
    with Recorder(path, configuration, simulation.bodies) as recorder:
        for messages in blocks:
            recorder.write_messages(messages)


def read(path: Path, blocks: int) -> None:
    """Read the waveform of a recording, which has a number of blocks."""
    assert sum(1 for _ in Recording(path).vibrations()) == blocks


def converted(bag: Path, file: Path) -> float:
    """Return the processor time of the conversion in a process that has imported everything [s]."""
    from dcrb_ros.viewer.show import view_recording

    file.unlink(missing_ok=True)
    return timed(lambda: view_recording(bag, save=file, screenshot=None, web=False))


def commanded(bag: Path, file: Path) -> float:
    """Return the processor time of the whole command, including the start of Python and all imports [s]."""
    file.unlink(missing_ok=True)
    return cost([sys.executable, "-m", "dcrb_ros.cli.program", "view", str(bag), "--save", str(file)]).processor


def print_view(folder: Path, simulation: Simulation, blocks: list[Block]) -> None:
    """Print the cost of converting a recording to a Rerun file: the median of seven runs."""
    bag, file = folder / "view", folder / "view.rrd"
    configuration = load_configuration("outer_ring_defect")
    encoder = BlockEncoder(configuration, simulation.bodies)
    written(bag, configuration, simulation, [encoder.encode(block) for block in repeated(blocks, DURATION)])
    converted(bag, file)  # import everything
    print(f"\n| `dcrb view --save` of {DURATION:g} s | recorded seconds per second | processor time [s] |\n|---|---|---|")
    for name, work in (("conversion", converted), ("whole command", commanded)):
        taken = statistics.median(work(bag, file) for _ in range(7))
        print(f"| {name}, median of 7 | {DURATION / taken:.0f} | {taken:.2f} |", flush=True)
    print(f"\nThe Rerun file has {file.stat().st_size / DURATION / 1e6:.2f} MB per recorded second.")


def main() -> None:
    """Print tables."""
    simulation = Simulation(load_configuration("outer_ring_defect"))
    blocks = list(simulation.blocks(1.0))
    print(
        "| compression | blocks per second | MB per second | recorded seconds per second | MB for a second | size over that of the samples "
        f"| size over that of all messages | seconds read per second |\n{'|---' * 8}|"
    )
    with tempfile.TemporaryDirectory() as folder:
        for compression in ("zstd", "lz4", "none"):
            configuration = load_configuration("outer_ring_defect", [f"recording.compression={compression}"])
            encoder = BlockEncoder(configuration, simulation.bodies)
            encoded = [encoder.encode(block) for block in repeated(blocks, DURATION)]
            data = sum(len(message.data) for messages in encoded for message in messages)
            path = Path(folder) / compression
            took = timed(partial(written, path, configuration, simulation, encoded))
            size = sum(file.stat().st_size for file in path.iterdir())
            back = timed(partial(read, path, len(encoded)))
            raw = DURATION * configuration.sensor.sampling_rate * RAW
            print(
                f"| {compression} | {len(encoded) / took:.0f} | {data / took / 1e6:.1f} | {DURATION / took:.0f} | "
                f"{size / DURATION / 1e6:.2f} | {size / raw:.2f} | {size / data:.2f} | {DURATION / back:.0f} |",
                flush=True,
            )
        print_view(Path(folder), simulation, blocks)


if __name__ == "__main__":
    main()
