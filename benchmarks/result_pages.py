"""The parts of the pages in docs/results that programs write."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def today() -> str:
    """Return the date, such as 3 June 2026."""
    return time.strftime("%d %B %Y", time.gmtime()).lstrip("0")


def commit() -> str:
    """Return the abbreviated hash of the present commit."""
    return subprocess.run(["git", "rev-parse", "--short=8", "HEAD"], cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True).stdout.strip()


def replace_part(page: Path, begin: str, end: str, text: str) -> None:
    """Replace the text between two marks of a page.

    Raises:
        SystemExit: the page does not have the first mark once and the second one after it.
    """
    head, *parts = page.read_text(encoding="utf-8").split(f"{begin}\n")
    _, mark, tail = parts[0].partition(end) if len(parts) == 1 else ("", "", "")
    if not mark:
        sys.exit(f"{page} needs the mark {begin} once, and {end} after it")
    page.write_text(f"{head}{begin}\n{text}\n{end}{tail}", encoding="utf-8")
