"""The measured parts of docs/results/performance.md: ``python benchmarks/performance.py [PART ...]``, without names all of them.

Each part is what a script of this folder prints, between two marks of the page, under a line that says when, at which commit and on which
machine it was made.
"""

from __future__ import annotations

import argparse
import os
import platform
import subprocess
import sys

import llvmlite.binding
import numba
from result_pages import ROOT, commit, replace_part, today

PAGE = ROOT / "docs" / "results" / "performance.md"
BAGS = ("healthy", "outer_ring_defect", "run_up")
PARTS = {
    "speed": ("real_time.py",),
    "start": ("start.py",),
    "scaling": ("scaling.py",),
    "recording": ("recording.py",),
    "detector": ("detector.py", *(f"bags/{bag}" for bag in BAGS)),
    "sweep": ("sweep.py",),
    "node": ("node.py",),
    "vehicle": ("vehicle_levels.py", "cost", "3"),
}
"""Script and arguments by part of the page."""


def measured(part: str) -> str:
    """Return what the script of a part prints."""
    script, *arguments = PARTS[part]
    command = [sys.executable, str(ROOT / "benchmarks" / script), *arguments]
    return subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True).stdout


def about() -> str:
    """Return the line above a part."""
    machine = f"{os.cpu_count()} cores ({llvmlite.binding.get_host_cpu_name()}), {os.getloadavg()[1]:.0f} running processes in the mean"
    return f"*{today()}, commit `{commit()}`, {machine}, Python {platform.python_version()}, numba {numba.__version__}.*"


def main() -> None:
    """Measure parts and rewrite them in the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("parts", nargs="*", metavar="PART", help=", ".join(PARTS))
    options = parser.parse_args()
    if unknown := set(options.parts) - set(PARTS):
        parser.error(f"there is no part {', '.join(sorted(unknown))}: give {', '.join(PARTS)}")
    for part in options.parts or PARTS:
        text = measured(part)
        replace_part(PAGE, f"<!-- measured: {part} -->", f"<!-- end: {part} -->", f"{about()}\n\n{text.strip()}")
        print(f"{part}: written", flush=True)


if __name__ == "__main__":
    main()
