"""Speed of the fault detector on recordings, in seconds of signal per second of processor time of one core.

``OMP_NUM_THREADS=1 python benchmarks/detector.py RECORDING... [--runs N]``; the first run of each recording does not count.
"""

from __future__ import annotations

import argparse
import statistics
import time
from pathlib import Path

from dcrb_ros.diagnosis.detector import FaultDetector
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.runtime.memory import keep_freed_memory


def processor_time(recording: Recording) -> tuple[float, float]:
    """Return the length of a recording and the processor time that the detector takes for it [s]."""
    pieces = list(recording.pieces())
    detector = FaultDetector(recording.orders, recording.sampling_rate)
    detector.take_bearing(recording.bearing)
    begin = time.process_time()
    for piece in pieces:
        detector.sensor_range = piece.sensor_range
        detector.update(piece.first_index, piece.acceleration, piece.shaft_angle)
    taken = time.process_time() - begin
    return sum(len(piece.shaft_angle) for piece in pieces) / recording.sampling_rate, taken


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("recordings", nargs="+", type=Path)
    parser.add_argument("--runs", type=int, default=5)
    options = parser.parse_args()
    keep_freed_memory()  # as the programs do
    print("| recording | signal [s] | x real time, median | slowest | fastest |\n|---|---|---|---|---|")
    total = spent = 0.0
    for path in options.recordings:
        recording = Recording(path)
        seconds, _ = processor_time(recording)
        taken = [processor_time(recording)[1] for _ in range(options.runs)]
        total, spent = total + seconds, spent + statistics.median(taken)
        rates = [seconds / time_taken for time_taken in (statistics.median(taken), max(taken), min(taken))]
        print(f"| {path.name} | {seconds:.1f} | " + " | ".join(f"{rate:.1f}" for rate in rates) + " |", flush=True)
    print(f"| together | {total:.1f} | {total / spent:.1f} | | |")


if __name__ == "__main__":
    main()
