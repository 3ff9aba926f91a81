"""How-to pages, followed literally: their code blocks are applied to a copy of the package.

A fenced block with ``title="dcrb_ros/..."`` names the file it belongs to. A block in the language ``diff`` changes a file of the
package; any other block is the whole content of a new file.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

ROOT = Path(__file__).parents[2]
FENCE = re.compile(r'^```(?P<language>\w+) title="(?P<path>dcrb_ros/[^"]+)".*?\n(?P<code>.*?)^```$', re.MULTILINE | re.DOTALL)


def blocks(page: Path) -> dict[str, str]:
    """Return the code of a page's titled blocks by the path in their title.

    Raises:
        ValueError: the page has no such block, or two for one file.
    """
    found = FENCE.findall(page.read_text(encoding="utf-8"))
    code = {path: text for _, path, text in found}
    if not found or len(code) < len(found):
        raise ValueError(f"{page} has {len(found)} titled blocks for {len(code)} files; give each file one block")
    return code


def patched(text: str, diff: str) -> str:
    """Return a text after a diff: ``+`` adds a line, ``-`` removes one, other lines must be in the text; ``@@`` begins another hunk.

    Raises:
        ValueError: a hunk does not match the text exactly once.
    """
    for hunk in re.split(r"^@@.*\n", diff, flags=re.MULTILINE):
        lines = hunk.splitlines(keepends=True)
        before, after = ("".join(line[1:] or "\n" for line in lines if line[0] != skipped) for skipped in "+-")
        if text.count(before) != 1:
            raise ValueError(f"the text contains {text.count(before)} times, instead of once, the lines:\n{before}")
        text = text.replace(before, after)
    return text


def copied_package(folder: Path, page: Path) -> dict[str, str]:
    """Copy the package into a folder, apply the blocks of a page, and return the environment in which Python imports the copy."""
    shutil.copytree(ROOT / "dcrb_ros", folder / "dcrb_ros", ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("config", "package.xml"):
        (folder / name).symlink_to(ROOT / name)
    for name, code in blocks(page).items():
        path = folder / name
        path.write_text(patched(path.read_text(encoding="utf-8"), code) if path.exists() else code, encoding="utf-8")
    return {**os.environ, "PYTHONPATH": str(folder), "NUMBA_CACHE_DIR": str(folder / "kernels")}


def run(environment: Mapping[str, str], code: str) -> str:
    """Run a script in such an environment and return what it prints."""
    folder = environment["PYTHONPATH"]
    command = [sys.executable, "-c", code]
    result = subprocess.run(command, env=dict(environment), cwd=folder, capture_output=True, text=True, timeout=200.0, check=False)
    assert result.returncode == 0, result.stderr
    return result.stdout


def effort(page: Path) -> tuple[int, int]:
    """Return how many files a page creates and how many lines it adds to existing files."""
    new = [name for name in blocks(page) if not (ROOT / name).exists()]
    changed = [code for name, code in blocks(page).items() if name not in new]
    return len(new), sum(line.startswith("+") for code in changed for line in code.splitlines())
