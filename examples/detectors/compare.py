"""Run all example detectors and the shipped one in an exam, and write the leaderboard: python compare.py EXAM OUTPUT.

With --measured DIR they also run on measured recordings, and the rank correlation between both is printed.
"""

import argparse
import subprocess
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
DETECTORS = {
    "zero rule": "zero_rule.py:ZeroRule",
    "rms and kurtosis": "rms_kurtosis.py:RmsKurtosis",
    "ISO 20816 band alarm": "iso_band.py:IsoBand",
    "naive BPFO": "naive_bpfo.py:NaiveBpfo",
    "squared envelope, fixed band": "squared_envelope.py:SquaredEnvelope",
    "fast kurtogram": "kurtogram.py:Kurtogram",
    "autogram": "autogram.py:Autogram",
    "MOMEDA": "momeda.py:Momeda",
    "CYCBD": "cycbd.py:Cycbd",
    "classifier": "classifier.py:Classifier",
    "shipped detector": "",
}
"""File and class of every detector by its name; none for the shipped one."""
DCRB = [sys.executable, "-c", "from dcrb_ros.cli.app import main; main()"]


def main() -> None:
    """Evaluate the detectors one after another; the first one simulates the scenarios."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("exam", help="a shipped exam or a YAML file")
    parser.add_argument("output", type=Path, help="folder for the entries and the leaderboard")
    parser.add_argument("--recordings", help="folder that keeps the recordings")
    parser.add_argument("--measured", help="folder with measured recordings, as dcrb score --measured takes it")
    parser.add_argument("--workers", default="0", help="number of parallel runs; 0 for one per core")
    given = parser.parse_args()
    evaluate([given.exam, *(["--recordings", given.recordings] if given.recordings else [])], given.output, given.workers)
    subprocess.run([*DCRB, "exam", "table", str(given.output)], check=True)
    if given.measured:
        measured = given.output / "measured"
        evaluate(["--measured", given.measured], measured, given.workers)
        subprocess.run([*DCRB, "exam", "agreement", str(given.output), str(measured)], check=True)


def evaluate(what: list[str], output: Path, workers: str) -> None:
    """Write an entry of every detector into a folder."""
    output.mkdir(parents=True, exist_ok=True)
    for name, place in DETECTORS.items():
        began = time.monotonic()
        entry = output / f"{name.lower().replace(' ', '-').replace(',', '')}.json"
        entry.unlink(missing_ok=True)
        python = ["--python", str(HERE / place)] if place else []
        command = [*DCRB, "score", *what, *python, "--name", name, "--entry", str(entry), "--quiet", "--workers", workers]
        done = subprocess.run(command, stdout=subprocess.DEVNULL, check=False)
        if done.returncode not in (0, 1) or not entry.is_file():
            sys.exit(f"{name} ended with status {done.returncode}")
        print(f"{name}: {time.monotonic() - began:.0f} s", flush=True)


if __name__ == "__main__":
    main()
