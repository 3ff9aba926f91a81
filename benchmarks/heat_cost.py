"""Cost of the thermal network, the temperature topics and a tacho, as processor time against the same bench without them.

Two tables. Pairs: two simulations in one process take turns, one with heat and tacho, the other without but with the oil and the
clearance of the first one's start; simulation and encoding are timed. Parts: the functions that heat and tacho add are timed by themselves
within a simulation. `node.py` measures whole nodes.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections import Counter, defaultdict
from collections.abc import Callable
from typing import Any

from dcrb_ros.measurement.toothed_wheel import ToothedWheel
from dcrb_ros.messages.encoder import BlockEncoder
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.simulation.heating import Heating
from dcrb_ros.simulation.loop import Simulation

HEAT = ("thermal.law=network", "tacho.pulses_per_turn=60")
"""The settings that are switched on; a tacho of 60 pulses is a common toothed wheel of a wheel-slide protection."""
PIECE = 0.2
"""Simulated time between two turns [s]; the sensors of the temperatures are read in every fifth."""
WARM_UP = 1.0
"""Simulated time before a measurement [s]."""


def turns(*, heated: bool) -> Callable[[], float]:
    """Return a function that simulates and encodes a piece and returns its processor time [s].

    The bench that is not ``heated`` begins with the same oil and clearance and keeps them.
    """
    configuration, plain = load_configuration("healthy", HEAT), load_configuration("healthy")
    simulation = Simulation(configuration)
    if not heated:
        simulation._heating, simulation._tacho = Heating(plain), None
    encoder = BlockEncoder(configuration if heated else plain, simulation.bodies)

    def run() -> float:
        begin = time.thread_time()
        for block in simulation.blocks(PIECE):
            encoder.encode(block)
        return time.thread_time() - begin

    for _ in range(round(WARM_UP / PIECE)):
        run()
    return run


def pairs(count: int) -> None:
    """Print the processor time of blocks with and without heat, in pairs of alternating order."""
    both, ratios = (turns(heated=True), turns(heated=False)), list[float]()
    times: tuple[list[float], list[float]] = ([], [])
    for number in range(count):
        first = number % 2
        for which in (first, 1 - first):
            times[which].append(both[which]())
        ratios.append(times[0][-1] / times[1][-1])
    per_block = [1e3 * statistics.median(times_of_part) * 20e-3 / PIECE for times_of_part in times]
    low, middle, high = statistics.quantiles(ratios, n=4)
    print(f"| {count} pairs of {PIECE:g} s | with | without | ratio: quartiles |\n|---|---|---|---|")
    print(f"| processor time of 20 ms [ms] | {per_block[0]:.2f} | {per_block[1]:.2f} | {low:.3f}, {middle:.3f}, {high:.3f} |\n", flush=True)


def parts(seconds: float) -> None:
    """Print the processor time of the functions that heat and tacho add, timed within a simulation of a duration [s]."""
    used, calls = defaultdict[str, float](float), Counter[str]()

    def timed(owner: Any, name: str, title: str) -> None:
        original = getattr(owner, name)
        get: Any = original.fget if isinstance(original, property) else original

        def run(*arguments: Any) -> Any:
            begin = time.thread_time()
            try:
                return get(*arguments)
            finally:
                used[title] += time.thread_time() - begin
                calls[title] += 1

        setattr(owner, name, property(run) if isinstance(original, property) else run)

    for name, title in (("update", "network"), ("reading", "sensors"), ("present", "states"), ("truth", "truth")):
        timed(Heating, name, title)
    timed(ToothedWheel, "pulses", "tacho")
    warm = load_configuration("healthy", HEAT)
    simulation = Simulation(warm)
    encoder = BlockEncoder(warm, simulation.bodies)
    extra = [number for number, topic in enumerate(encoder._topics) if topic.name.endswith("temperature") or topic.name == "shaft/tacho"]
    for number in extra:
        encode = encoder._encoders[number]

        def run(block: Any, source: Any, encode: Any = encode) -> Any:
            begin = time.thread_time()
            messages = list(encode(block, source))
            used["messages"] += time.thread_time() - begin
            calls["messages"] += 1
            return messages

        encoder._encoders[number] = run
    for block in simulation.blocks(WARM_UP):
        encoder.encode(block)
    used.clear()
    calls.clear()
    begin = time.thread_time()
    for block in simulation.blocks(seconds):
        encoder.encode(block)
    total = time.thread_time() - begin
    print("| part | calls per second | us per call | of the block's processor time | of a core at real time |\n|---|---|---|---|---|")
    rows = [*used.items(), ("all", sum(used.values()))]
    for title, spent in rows:
        count = calls[title] or sum(calls.values())
        each = f"{count / seconds:.0f} | {1e6 * spent / count:.0f}"
        print(f"| {title} | {each} | {100 * spent / total:.2f} % | {100 * spent / seconds:.2f} % |")
    print(flush=True)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", type=int, default=100)
    parser.add_argument("--parts", type=float, default=20.0, help="simulated time in which the parts are timed [s]")
    options = parser.parse_args()
    pairs(options.pairs)
    parts(options.parts)


if __name__ == "__main__":
    main()
