"""Mutation testing: change one operator or number at a time and see whether the tests of that package notice.

``make mutants`` draws a sample of the mutants of each package with a fixed seed, because all of them would take days: each one runs
the tests that mirror its package. It works on a copy of the repository and prints every mutant that survived, so that a test can be
written for it, or a reason be given in `EQUIVALENT` why no test can notice it.
"""

from __future__ import annotations

import argparse
import os
import random
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

ROOT = Path(__file__).parents[2]
REASONS = ROOT / "tests" / "mutants" / "equivalent.yaml"
TIMEOUT = 300.0
"""Time after which the tests of a mutant count as failed [s]."""

BINARY = ("Add_Sub", "Sub_Add", "Mul_Div", "Div_Mul", "FloorDiv_Div", "Mod_FloorDiv", "Pow_Mul")
COMPARISON = ("Eq_NotEq", "NotEq_Eq", "Lt_LtE", "LtE_Lt", "Gt_GtE", "GtE_Gt", "Lt_Gt", "Gt_Lt", "LtE_GtE", "GtE_LtE")
UNARY = ("USub_UAdd", "Delete_USub", "Delete_Not")
LOGIC = ("AddNot", "ReplaceAndWithOr", "ReplaceOrWithAnd", "ReplaceTrueWithFalse", "ReplaceFalseWithTrue", "ReplaceBreakWithContinue")
OPERATORS = {
    *(f"core/ReplaceBinaryOperator_{name}" for name in BINARY),
    *(f"core/ReplaceComparisonOperator_{name}" for name in COMPARISON),
    *(f"core/ReplaceUnaryOperator_{name}" for name in UNARY),
    *(f"core/{name}" for name in (*LOGIC, "NumberReplacer")),
}
"""Mutations that a programmer's slip looks like; most others, such as a float shifted by bits, fail at once."""


@dataclass(frozen=True)
class Target:
    """Sources to mutate and the commands of which one must fail."""

    sources: tuple[str, ...]
    tests: tuple[str, ...]
    """Arguments of pytest, one string per run, the fastest first."""
    without_compiler: bool = False
    """Whether the first run has numba's compiler switched off."""


def _files(folder: str, *names: str) -> str:
    """Return the paths of test files."""
    return " ".join(f"tests/{folder}/test_{name}.py" for name in names)


TARGETS = {
    "core": Target(("dcrb_ros/core",), ("tests/core -m kernel", "tests/core tests/bearing"), without_compiler=True),
    "measurement": Target(("dcrb_ros/measurement",), ("tests/measurement",)),
    "diagnosis": Target(("dcrb_ros/diagnosis",), ("tests/diagnosis",)),
    "exam": Target(("dcrb_ros/exam",), ("tests/exam",)),
    # Without the shipped recordings, which check the model, and hostile files, which take minutes.
    "recordings": Target(
        ("dcrb_ros/recordings",),
        (
            _files("recordings", "arrays", "manifest", "rosbag2", "mcap_writer", "mcap_reader", "replay", "recorder_thread", "reader"),
            _files("recordings", "recovery", "recorder", "reproduction"),
        ),
    ),
    "pacing": Target(
        ("dcrb_ros/nodes/pacing.py", "dcrb_ros/nodes/gate.py", "dcrb_ros/nodes/engine.py"),
        (_files("nodes", "pacing", "gate", "engine"),),
    ),
}


def copied(folder: Path) -> Path:
    """Return a copy of the tracked files of the repository."""
    names = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split("\n")
    for name in filter(None, names):
        if (ROOT / name).is_file():
            target = folder / name
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, target)
    return folder


def command(target: Target) -> str:
    """Return the shell command that fails when one of the test runs fails."""
    runs = [f"{sys.executable} -m pytest -x -q -p no:cacheprovider {tests}" for tests in target.tests]
    if target.without_compiler:
        runs[0] = f"env NUMBA_DISABLE_JIT=1 {runs[0]}"
    return f"sh -c '{' && '.join(runs)}'"


def mutants(copy: Path, source: str, target: Target) -> Path:
    """Write a session of all mutants of a source file or folder; return its path."""
    name = source.replace("/", "_")
    configuration, session = copy / f"{name}.toml", copy / f"{name}.sqlite"
    configuration.write_text(
        f'[cosmic-ray]\nmodule-path = "{source}"\ntimeout = {TIMEOUT}\nexcluded-modules = []\n'
        f'test-command = "{command(target)}"\n\n[cosmic-ray.distributor]\nname = "local"\n'
    )
    subprocess.run([sys.executable, "-m", "cosmic_ray.cli", "init", configuration.name, session.name], cwd=copy, check=True)
    return session


def sampled(session: Path, count: int, seed: int) -> int:
    """Leave ``count`` of a session's mutants to run, chosen at random; return how many there were to choose from."""
    from cosmic_ray.work_db import WorkDB, use_db
    from cosmic_ray.work_item import WorkerOutcome, WorkResult

    with use_db(str(session), WorkDB.Mode.open) as database:
        items = sorted(database.work_items, key=lambda item: [repr(m) for m in item.mutations])
        wanted = [item for item in items if all(m.operator_name in OPERATORS for m in item.mutations)]
        chosen = {item.job_id for item in random.Random(seed).sample(wanted, min(count, len(wanted)))}
        skipped = WorkResult(worker_outcome=WorkerOutcome.SKIPPED)
        database.set_multiple_results([item.job_id for item in items if item.job_id not in chosen], skipped)
    return len(wanted)


def outcomes(session: Path) -> list[tuple[str, Any]]:
    """Return where each mutant that ran is and its result."""
    from cosmic_ray.work_db import WorkDB, use_db
    from cosmic_ray.work_item import WorkerOutcome

    with use_db(str(session), WorkDB.Mode.open) as database:
        return [
            (f"{m.module_path}:{m.start_pos[0]} {m.operator_name.removeprefix('core/')}", result)
            for item, result in database.completed_work_items
            if result.worker_outcome != WorkerOutcome.SKIPPED
            for m in item.mutations
        ]


def examine(name: str, count: int, seed: int, copy: Path) -> tuple[int, int]:
    """Run a sample of the mutants of a package; return how many were killed or are equivalent, and how many ran."""
    from cosmic_ray.work_item import TestOutcome

    target = TARGETS[name]
    subprocess.run(command(target), shell=True, cwd=copy, check=True, stdout=subprocess.DEVNULL)
    reasons: dict[str, list[dict[str, str]]] = yaml.safe_load(REASONS.read_text()) if REASONS.exists() else {}
    killed = ran = 0
    for source in target.sources:
        session = mutants(copy, source, target)
        share = max(count // len(target.sources), 1)
        of = sampled(session, share, seed)
        subprocess.run([sys.executable, "-m", "cosmic_ray.cli", "exec", f"{session.stem}.toml", session.name], cwd=copy, check=True)
        for place, result in outcomes(session):
            ran += 1
            module = place.split(":")[0]
            reason = next((r["why"] for r in reasons.get(module, []) if r["line"] in _mutated_line(result)), "")
            if result.test_outcome == TestOutcome.SURVIVED and not reason:
                print(f"survived: {place}\n{result.diff}\n", flush=True)
            else:
                killed += 1
        print(f"{source}: a sample of {min(share, of)} of {of} mutants", flush=True)
    return killed, ran


def _mutated_line(result: Any) -> str:
    """Return the line that the mutation removed, without its leading blanks."""
    lines = [line[1:].strip() for line in (result.diff or "").split("\n") if line.startswith("-") and not line.startswith("---")]
    return " ".join(lines)


def main() -> int:
    """Examine the packages asked for; return 0 where at least the share asked for was killed in each."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("packages", nargs="*", default=[], help=f"of {', '.join(TARGETS)}; all without any")
    parser.add_argument("--sample", type=int, default=50, help="mutants of each package")
    parser.add_argument("--seed", type=int, default=1, help="seed of the sample")
    parser.add_argument("--least", type=float, default=0.9, help="share that must be killed")
    options = parser.parse_args()
    unknown = set(options.packages) - set(TARGETS)
    if unknown:
        parser.error(f"unknown package {sorted(unknown)[0]!r}; give some of {', '.join(TARGETS)}")
    failed = False
    with tempfile.TemporaryDirectory() as folder:
        copy = copied(Path(folder))
        os.environ["PYTHONPATH"] = str(copy)
        for name in options.packages or TARGETS:
            killed, ran = examine(name, options.sample, options.seed, copy)
            failed |= killed < options.least * ran
            print(f"{name}: {killed} of {ran} mutants killed or equivalent", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
