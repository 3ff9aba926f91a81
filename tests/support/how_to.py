"""How-to pages, followed literally: their code blocks are applied to a copy of the package.

A fenced block with ``title="dcrb_ros/..."`` names the file it belongs to. A block in the language ``diff`` changes a file of the
package; any other block is the whole content of a new file.

After you have followed a page in your own copy, its blocks are in the package already. Then they are not applied again: the tests of the
page run on the package as it is.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
FENCE = re.compile(r'^```(?P<language>\w+) title="(?P<path>dcrb_ros/[^"]+)".*?\n(?P<code>.*?)^```$', re.MULTILINE | re.DOTALL)


class Block(NamedTuple):
    """A titled block of a page."""

    language: str
    path: str
    """File of the package, relative to the root."""
    code: str

    @property
    def changes(self) -> bool:
        """Whether it changes a file, rather than being the content of a new one."""
        return self.language == "diff"

    def in_package(self, root: Path) -> bool:
        """Return whether the package has the file, with any content, or the lines that the block adds."""
        path = root / self.path
        if not (self.changes and path.exists()):
            return path.exists()
        lines = path.read_text(encoding="utf-8").splitlines()
        return all(line[1:] in lines for line in self.code.splitlines() if line.startswith("+"))


def blocks(page: Path) -> list[Block]:
    """Return the titled blocks of a page.

    Raises:
        ValueError: the page has no such block, or two for one file.
    """
    titled = [Block(*fields) for fields in FENCE.findall(page.read_text(encoding="utf-8"))]
    if not titled or len({block.path for block in titled}) < len(titled):
        raise ValueError(f"{page} has {len(titled)} titled blocks; give each file one block")
    return titled


def patched(text: str, diff: str) -> str:
    """Return a text after a diff: ``+`` adds a line, ``-`` removes one, other lines must be in the text; ``@@`` begins another hunk.

    The lines behind the last change of a hunk need not follow at once: another extension may have been added there.

    Raises:
        ValueError: a hunk does not match the text exactly once.
    """
    for hunk in re.split(r"^@@.*\n", diff, flags=re.MULTILINE):
        lines = hunk.splitlines(keepends=True)
        changed = 1 + max(number for number, line in enumerate(lines) if line[0] in "+-")
        before, after = ("".join(line[1:] or "\n" for line in lines[:changed] if line[0] != skipped) for skipped in "+-")
        if text.count(before) != 1:
            raise ValueError(f"the text contains {text.count(before)} times, instead of once, the lines:\n{before}")
        head, rest = text.split(before)
        following = rest.splitlines(keepends=True)
        for line in lines[changed:]:
            if (line[1:] or "\n") not in following:
                raise ValueError(f"the text does not contain, behind the change, the line:\n{line[1:]}")
        text = head + after + rest
    return text


def followed(page: Path, root: Path = ROOT) -> bool:
    """Return whether the package has the files and lines of a page already.

    Raises:
        ValueError: it has some of them only.
    """
    present = [block for block in blocks(page) if block.in_package(root)]
    missing = [block for block in blocks(page) if block not in present]
    if present and missing:
        raise ValueError(
            f"{page.name} is followed in part: the package has {_named(present)} and lacks {_named(missing)}. "
            "Add what is missing, or remove the rest; without any of it, the tests apply the page to a copy"
        )
    return not missing


def _named(chosen: list[Block]) -> str:
    return ", ".join(f"the line in {block.path}" if block.changes else block.path for block in chosen)


def copied_package(folder: Path, page: Path, root: Path = ROOT) -> dict[str, str]:
    """Copy the package into a folder, apply the blocks of a page unless it has them, and return the environment that imports the copy.

    Raises:
        ValueError: the package has a part of the page only.
    """
    shutil.copytree(root / "dcrb_ros", folder / "dcrb_ros", ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("config", "package.xml"):
        (folder / name).symlink_to(ROOT / name)
    if followed(page, root):
        print(f"{page.name}: the package has this extension already; it is tested as it is")
    else:
        for block in blocks(page):
            path = folder / block.path
            path.write_text(patched(path.read_text(encoding="utf-8"), block.code) if block.changes else block.code, encoding="utf-8")
    return {**os.environ, "PYTHONPATH": str(folder), "NUMBA_CACHE_DIR": str(folder / "kernels")}


def run(environment: Mapping[str, str], code: str) -> str:
    """Run a script in such an environment and return what it prints."""
    folder = environment["PYTHONPATH"]
    command = [sys.executable, "-c", code]
    result = subprocess.run(command, env=dict(environment), cwd=folder, capture_output=True, text=True, timeout=600.0, check=False)
    assert result.returncode == 0, result.stderr
    return result.stdout


def effort(page: Path) -> tuple[int, int]:
    """Return how many files a page creates and how many lines it adds to existing files."""
    changes = [block.code for block in blocks(page) if block.changes]
    return len(blocks(page)) - len(changes), sum(line.startswith("+") for code in changes for line in code.splitlines())
