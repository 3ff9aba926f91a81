"""A law is one file and one line of the registry: those of the how-to page, added to a copy of the package."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
PAGE = ROOT / "docs" / "how-to" / "add-a-law.md"
REGISTRY = "dcrb_ros/core/laws/__init__.py"

RUN = """
import sys

import numpy as np

from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.settings.files import load_configuration

simulation = Simulation(load_configuration("healthy", sys.argv[1:]))
samples = np.concatenate([block.clean for block in simulation.blocks(0.02)])
assert np.isfinite(samples).all()
state = simulation._state
inner = state.rollers[0].inner
deflection, deepest = state.of_rollers(inner.traction.deflection), state.of_rollers(inner.normal.deepest)
assert not deflection[state.inner_force == 0.0].any()
print(np.count_nonzero(deflection), np.abs(deflection).max(), np.count_nonzero(deepest), deepest.max())
"""
SETTINGS = ("friction.law=dahl", "friction.dahl_coefficient=0.04", "contact.law=spring")


def blocks() -> dict[str, str]:
    """Return the code blocks of the page that belong into files of the package, by file."""
    return dict(re.findall(r'```python title="(dcrb_ros/[^"]+)"\n(.*?)```', PAGE.read_text(), flags=re.DOTALL))


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a copy of the package and the laws of the page."""
    folder, code = tmp_path_factory.mktemp("extended"), blocks()
    shutil.copytree(ROOT / "dcrb_ros", folder / "dcrb_ros", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(ROOT / "config", folder / "config")
    registry, line = folder / REGISTRY, code.pop(REGISTRY)
    assert line == '    "dahl",\n'
    assert set(code) == {"dcrb_ros/core/laws/dahl.py", "dcrb_ros/core/laws/spring.py"}
    known = registry.read_text()
    registry.write_text(known.replace('    "lugre",\n', '    "lugre",\n' + line + line.replace("dahl", "spring")))
    for file, text in code.items():
        (folder / file).write_text(text)
    return folder


def run(package: Path, code: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run some code with the extended package."""
    command, environment = [sys.executable, "-c", code, *arguments], {**os.environ, "PYTHONPATH": str(package)}
    return subprocess.run(command, env=environment, cwd=package, capture_output=True, text=True, timeout=280, check=False)


def test_laws_with_memories_are_a_file_and_a_line_each(package: Path) -> None:
    done = run(package, RUN, *SETTINGS)
    assert done.returncode == 0, done.stderr
    slipping, largest_deflection, closed, deepest = (float(number) for number in done.stdout.split())
    assert slipping > 0
    assert closed > 0
    assert largest_deflection <= 0.04 / 1e5 * (1.0 + 1e-9)  # mu/sigma
    assert deepest == pytest.approx(30e3 / 1.5e9, rel=0.2)  # 30 kN on the loaded roller, docs/physics.md


def test_parameters_of_a_new_law_are_checked_like_all_others(package: Path) -> None:
    code = "from dcrb_ros.cli.app import main; main()"
    done = run(package, code, "config", "check", "healthy", "--set", "friction.dahl_stiffness=0.1")
    assert done.returncode == 2
    assert "friction.dahl_stiffness = 0.1 1/m" in done.stderr
