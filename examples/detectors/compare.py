"""Run the published member of every family of example detectors and the shipped one in an exam, and write the leaderboard:
python compare.py EXAM OUTPUT.

With --measured DIR they also run on measured recordings, and the leaderboard states the rank correlation between both. If the exam is a
replica, --longest is its longest part of a recording, so that the task is the same.
"""

import argparse
import re
import subprocess
import sys
import time
from pathlib import Path

from dcrb_ros.exam.family_process import class_and_variants

HERE = Path(__file__).resolve().parent
SHIPPED = "shipped detector"
SHIPPED_CLASS = "dcrb_ros.exam.shipped_family:ShippedDetector"
DCRB = [sys.executable, "-m", "dcrb_ros.cli.program"]


def families() -> dict[str, str]:
    """Return file and class of every family by the name of its published member."""
    about = {file.name: class_and_variants(str(file)) for file in sorted(HERE.glob("*.py"))}
    return {next(iter(one["variants"]), Path(name).stem): f"{name}:{one['class']}" for name, one in about.items() if one["class"]}


def main() -> None:
    """Evaluate the detectors one after another; the first one simulates the scenarios."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("exam", help="a shipped exam or a YAML file")
    parser.add_argument("output", type=Path, help="folder for the entries and the leaderboard")
    parser.add_argument("--recordings", help="folder that keeps the recordings")
    parser.add_argument("--measured", help="folder with measured recordings, as dcrb score --measured takes it")
    parser.add_argument("--longest", default="60", help="longest part of a measured recording [s]")
    parser.add_argument("--workers", default="0", help="number of parallel runs; 0 for one per core")
    given = parser.parse_args()
    failed = evaluate([given.exam, *(["--recordings", given.recordings] if given.recordings else [])], given.output, given.workers)
    measured = given.output / "measured"
    if given.measured:
        failed += evaluate(["--measured", given.measured, "--longest", given.longest], measured, given.workers)
    subprocess.run([*DCRB, "exam", "table", str(given.output), *(["--measured", str(measured)] if given.measured else [])], check=True)
    if failed:
        sys.exit(f"without an entry: {'; '.join(failed)}")


def evaluate(what: list[str], output: Path, workers: str) -> list[str]:
    """Write an entry of every detector into a folder; return those that failed, and their exit status."""
    failed = []
    output.mkdir(parents=True, exist_ok=True)
    for name, place in {**{name: str(HERE / file) for name, file in families().items()}, SHIPPED: SHIPPED_CLASS}.items():
        began = time.monotonic()
        entry = output / f"{'-'.join(re.findall('[a-z0-9]+', name.lower()))}.json"
        entry.unlink(missing_ok=True)
        command = [*DCRB, "score", *what, "--python", place, "--name", name, "--entry", str(entry), "--quiet", "--workers", workers]
        done = subprocess.run(command, stdout=subprocess.DEVNULL, check=False)
        if done.returncode not in (0, 1) or not entry.is_file():
            failed.append(f"{name} ended with status {done.returncode}")
        print(f"{name}: {time.monotonic() - began:.0f} s", flush=True)
    return failed


if __name__ == "__main__":
    main()
