"""How good the fault detector is on benches it has not seen, and how fast.

`python benchmarks/detector.py untuned` judges drawn scenarios: every kind of defect, 600 to 1800 rpm, 50 to 150 kN, 1 to 5 mm, both joints,
rows in phase and staggered. The detector's thresholds were set on `tuned`; `untuned` are other draws. Waveforms are kept in the folder
--data, so that a changed detector is judged within a minute. `onset` puts a faulty waveform behind a healthy one and tells the delay,
`healthy` runs a sound bearing over changing speeds and loads for so many simulated minutes, `speed` measures the real-time factor.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from dcrb_ros.bearing.kinematics import characteristic_orders
from dcrb_ros.diagnosis.detector import DEFAULTS, Diagnosis, FaultDetector
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.simulation.batch import simulate_batch
from dcrb_ros.simulation.loop import Simulation

SEEDS = {"tuned": 11, "untuned": 22}
KINDS = ("healthy", "outer_ring", "inner_ring", "roller", "cage", "healthy", "outer_ring", "inner_ring", "roller")
SECONDS = 5.0
BLOCK = 1024
DELAY_LIMIT = {"cage": 20.0}
"""Longest delay after the onset [s]; 5 for what is not here."""
ROUNDS = 7


class Scenario(NamedTuple):
    """A bench and what is wrong with it."""

    name: str
    kind: str
    configuration: Configuration


def scenarios(design: str, count: int) -> Iterator[Scenario]:
    """Yield drawn scenarios; the first ones do not depend on the count."""
    random = np.random.default_rng(SEEDS[design])
    for number in range(count):
        kind = KINDS[number % len(KINDS)]
        notch = {
            "width": float(random.choice([0.001, 0.001, 0.0015, 0.002, 0.003, 0.005])),
            "row": int(random.integers(0, 3)),
            "azimuth": float(random.uniform(-0.35, 0.35)),
        }
        row, bar = max(1, int(notch["row"])), int(random.integers(1, 17))
        faults: dict[str, dict[str, Any]] = {
            "healthy": {},
            "outer_ring": {"outer_1": notch},
            "inner_ring": {"inner_1": notch},
            "roller": {"roller_1": {**notch, "row": row, "roller": bar}},
            "cage": {"broken_bars": f"row{row}/bar{bar}"},
        }
        groups = {
            "operating": {"speed": float(random.uniform(62.8, 188.5)), "load": float(random.uniform(50e3, 150e3))},
            "cage": {"joint": str(random.choice(["pocket", "pocket", "pocket", "revolute"]))},
            "bearing": {"row_phase": float(random.choice([0.0, 0.0, 0.01, 0.5, 0.27]))},
            "simulation": {"seed": int(random.integers(1, 10000))},
            "faults": faults[kind],
        }
        yield Scenario(f"{design}-{number:03d}", kind, Configuration.model_validate(groups))


Stream = tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]


def waveforms(asked: list[Scenario], data: Path) -> Iterator[tuple[Scenario, Stream]]:
    """Yield the scenarios with their waveforms, simulated where the folder has none yet."""
    absent = [scenario for scenario in asked if not (data / f"{scenario.name}.npz").exists()]
    for place, found in simulate_batch([scenario.configuration for scenario in absent], SECONDS):
        np.savez(data / f"{absent[place].name}.npz", acceleration=found.acceleration, shaft_angle=found.shaft_angle)
    for scenario in asked:
        with np.load(data / f"{scenario.name}.npz") as kept:
            yield scenario, (kept["acceleration"], kept["shaft_angle"])


def watch(detector: FaultDetector, stream: Stream, first: int = 0) -> list[Diagnosis]:
    """Feed a stream in blocks; return the diagnoses."""
    acceleration, angle = stream
    found = [detector.update(first + k, acceleration[k : k + BLOCK], angle[k : k + BLOCK]) for k in range(0, len(angle), BLOCK)]
    return [diagnosis for diagnosis in found if diagnosis is not None]


def detector_of(scenario: Scenario, parameters: DetectorParameters = DEFAULTS) -> FaultDetector:
    """Return a fresh detector for a scenario's bearing."""
    sensor = scenario.configuration.sensor
    orders = characteristic_orders(scenario.configuration.bearing)
    return FaultDetector(orders, sensor.sampling_rate, parameters, sensor_range=sensor.range)


def judge(design: str, count: int, data: Path) -> int:
    """Print the confusion and what was wrong; return how many were."""
    confusion: Counter[tuple[str, str]] = Counter()
    for scenario, stream in waveforms(list(scenarios(design, count)), data):
        said = {d.verdict for d in watch(detector_of(scenario), stream)} - {"waiting"}
        verdict = said.pop() if len(said) == 1 else "/".join(sorted(said)) or "waiting"
        confusion[scenario.kind, verdict] += 1
        if verdict != scenario.kind:
            print(f"{scenario.name}: {scenario.kind} is called {verdict}: {scenario.configuration.model_dump(exclude_defaults=True)}")
    for (kind, verdict), times in sorted(confusion.items()):
        print(f"{kind:12s} called {verdict:24s} {times:4d}")
    return sum(times for (kind, verdict), times in confusion.items() if kind != verdict)


def onsets(design: str, count: int, data: Path) -> int:
    """Print the delay after a fault that appears under way; return how many came late or by another name."""
    found = list(waveforms(list(scenarios(design, count)), data))
    healthy = [stream for scenario, stream in found if scenario.kind == "healthy"]
    delays: dict[str, list[float]] = {}
    late = 0
    for scenario, stream in found:
        if scenario.kind == "healthy":
            continue
        detector, before = detector_of(scenario), healthy[len(delays.get(scenario.kind, [])) % len(healthy)]
        watch(detector, before)
        said = watch(detector, (stream[0], _turned_on(before[1], stream[1])), len(before[1]))
        delay = next((d.time - len(before[1]) / detector.rate for d in said if d.verdict == scenario.kind), np.inf)
        wrong = {d.verdict for d in said} - {"waiting", "healthy", scenario.kind}
        delays.setdefault(scenario.kind, []).append(delay)
        if delay > DELAY_LIMIT.get(scenario.kind, 5.0) or wrong:
            late += 1
            print(f"{scenario.name}: {scenario.kind} after {delay:.1f} s, called {sorted(wrong) or 'nothing'} else")
    for kind, own in delays.items():
        print(f"{kind:12s} {len(own):3d} onsets, found after {statistics.median(own):.1f} s (median), {max(own):.1f} s at most")
    return late


def _turned_on(before: npt.NDArray[np.float32], angle: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Return the angles as a shaft has them that comes from the end of ``before`` [rad]."""
    step = float(np.mod(before[-1] - before[-2], 2.0 * np.pi))
    return np.mod(angle.astype(np.float64) - angle[0] + before[-1] + step, 2.0 * np.pi).astype(np.float32)


def healthy_minutes(minutes: float, seed: int) -> int:
    """Run sound bearings over changing speeds and loads; return the judgements that were no 'healthy'."""
    random, alarms, done = np.random.default_rng(seed), 0, 0.0
    while done < minutes:
        groups = {
            "operating": {"speed": float(random.uniform(62.8, 188.5)), "load": float(random.uniform(50e3, 150e3)), "speed_ramp": 20.0},
            "cage": {"joint": str(random.choice(["pocket", "revolute"]))},
            "bearing": {"row_phase": float(random.choice([0.0, 0.01, 0.5]))},
            "simulation": {"seed": int(random.integers(1, 10000))},
        }
        configuration = Configuration.model_validate(groups)
        simulation = Simulation(configuration)
        detector = FaultDetector(characteristic_orders(configuration.bearing), configuration.sensor.sampling_rate)
        for number, block in enumerate(simulation.blocks(60.0)):
            diagnosis = detector.update(block.index, block.acceleration, block.shaft_angle)
            if diagnosis is not None and diagnosis.verdict not in ("healthy", "waiting"):
                alarms += 1
                print(f"after {done:.0f} min, {diagnosis.time:.1f} s: {diagnosis.verdict}, {diagnosis.reason} ({groups})", flush=True)
            if number % 500 == 499:  # every 10 s
                simulation.command_speed(float(random.uniform(62.8, 188.5)))
                simulation.command_load(0.0, -float(random.uniform(50e3, 150e3)))
        done += 1.0
        print(f"{done:.0f} min healthy, {alarms} alarms", flush=True)
    return alarms


def speed() -> int:
    """Print the detector's real-time factor on one core, with a verdict at every hop."""
    random, seconds = np.random.default_rng(1), 20.0
    rate, orders, factors = Configuration().sensor.sampling_rate, characteristic_orders(Configuration().bearing), []
    turns = 20.0 * np.arange(round(seconds * rate)) / rate
    # Bursts: even noise is called a dead sensor, of which nothing is judged.
    loudness = np.where(np.mod(orders.bpfo * turns, 1.0) < 0.1, 60.0, 10.0)
    stream = (
        (loudness[:, None] * random.normal(size=(len(turns), 2))).astype(np.float32),
        (2.0 * np.pi * np.mod(turns, 1.0)).astype(np.float32),
    )
    for _ in range(ROUNDS):
        begin = time.process_time()
        watch(FaultDetector(orders, rate), stream)
        factors.append(seconds / (time.process_time() - begin))
    print(f"{statistics.median(factors):.0f} times real time on one core, {min(factors):.0f} to {max(factors):.0f} in {ROUNDS} rounds")
    return int(statistics.median(factors) < 20.0)


def main() -> int:
    """Run what is asked for; return 1 where something was wrong."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["tuned", "untuned", "onset", "healthy", "speed"])
    parser.add_argument("--count", type=int, default=90, help="scenarios")
    parser.add_argument("--minutes", type=float, default=20.0, help="simulated minutes of healthy bearings")
    parser.add_argument("--seed", type=int, default=33, help="seed of the healthy bearings")
    parser.add_argument("--data", type=Path, default=Path(tempfile.gettempdir()) / "dcrb_detector", help="folder of the waveforms")
    given = parser.parse_args()
    given.data.mkdir(parents=True, exist_ok=True)
    if given.what == "speed":
        return speed()
    if given.what == "healthy":
        return int(healthy_minutes(given.minutes, given.seed) > 0)
    wrong = onsets("untuned", given.count, given.data) if given.what == "onset" else judge(given.what, given.count, given.data)
    return int(wrong > 0)


if __name__ == "__main__":
    raise SystemExit(main())
