"""Mutation testing: change one operator or number at a time and see whether the tests of that package notice.

``make mutants`` draws a sample of the mutants of each package with a fixed seed, because all of them would take days: each one runs
the tests that mirror its package, those that name the changed module first. It works on a copy of the repository and prints every
mutant that survived, so that a test can be written for it, or a reason be given in ``equivalent.yaml`` why no test can notice it.
A run that was interrupted goes on with ``--skip``, the number of mutants that it had examined.
"""

from __future__ import annotations

import argparse
import ast
import difflib
import itertools
import os
import random
import resource
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import hypothesis  # noqa: F401 - imported before the forks, like the next ones
import matplotlib.figure  # noqa: F401
import numba
import pydantic  # noqa: F401
import pytest
import scipy.signal
import scipy.stats  # noqa: F401
import yaml

ROOT = Path(__file__).parents[2]
REASONS = ROOT / "tests" / "mutants" / "equivalent.yaml"
LONGEST = 3600
"""Limit of the processor time of the tests without a mutation [s]; those of a mutant may take twice as long as they did."""

BINARY = ("Add_Sub", "Sub_Add", "Mul_Div", "Div_Mul", "FloorDiv_Div", "Mod_FloorDiv", "Pow_Mul")
COMPARISON = ("Eq_NotEq", "NotEq_Eq", "Lt_LtE", "LtE_Lt", "Gt_GtE", "GtE_Gt", "Lt_Gt", "Gt_Lt", "LtE_GtE", "GtE_LtE")
UNARY = ("USub_UAdd", "Delete_USub", "Delete_Not")
LOGIC = ("AddNot", "ReplaceAndWithOr", "ReplaceOrWithAnd", "ReplaceTrueWithFalse", "ReplaceFalseWithTrue", "ReplaceBreakWithContinue")
OPERATORS = (
    *(f"core/ReplaceBinaryOperator_{name}" for name in BINARY),
    *(f"core/ReplaceComparisonOperator_{name}" for name in COMPARISON),
    *(f"core/ReplaceUnaryOperator_{name}" for name in UNARY),
    *(f"core/{name}" for name in (*LOGIC, "NumberReplacer")),
)
"""Mutations that a programmer's slip looks like; most others, such as a float shifted by bits, fail at once."""


@dataclass(frozen=True)
class Target:
    """Sources to mutate and the tests of which one must fail."""

    sources: tuple[str, ...]
    tests: tuple[str, ...]
    """Files or folders with the tests, in the order in which they run; what an earlier one has named is left out of a folder."""
    kernels: bool = False
    """Whether those marked as tests of kernels first run without numba's compiler, which takes longer than they do."""


def _files(folder: str, *names: str) -> tuple[str, ...]:
    """Return the paths of test files."""
    return tuple(f"tests/{folder}/test_{name}.py" for name in names)


TARGETS = {
    # Those of the default laws come first: they are compiled once, and each further combination of laws takes half a minute.
    "core": Target(
        ("dcrb_ros/core",),
        ("tests/core/contacts", "tests/core/solver", "tests/validation/reference", "tests/bearing", "tests/core"),
        kernels=True,
    ),
    "measurement": Target(("dcrb_ros/measurement",), ("tests/measurement",)),
    "diagnosis": Target(("dcrb_ros/diagnosis",), ("tests/diagnosis", "tests/api/test_detect.py", "tests/api/test_envelope_spectrum.py")),
    "exam": Target(("dcrb_ros/exam",), ("tests/exam", "tests/api/test_score.py")),
    # Without the shipped recordings, which check the model, and hostile files, which take minutes.
    "recordings": Target(
        ("dcrb_ros/recordings",),
        (
            *_files("recordings", "arrays", "manifest", "rosbag2", "mcap_writer", "mcap_reader", "replay", "recorder_thread", "reader"),
            *_files("recordings", "recovery", "recorder", "reproduction"),
        ),
    ),
    "pacing": Target(
        ("dcrb_ros/nodes/pacing.py", "dcrb_ros/nodes/gate.py", "dcrb_ros/nodes/engine.py"), _files("nodes", "pacing", "gate", "engine")
    ),
}


@dataclass(frozen=True, order=True)
class Mutant:
    """The occurrence of an operator in a module, by its number."""

    module: str
    operator: str
    number: int

    def code(self) -> str | None:
        """Return the module with the mutation; None if it does not compile or differs in type annotations only."""
        from cosmic_ray.mutating import mutate_code
        from cosmic_ray.plugins import get_operator

        source = Path(self.module).read_text(encoding="utf-8")
        code: str = mutate_code(source, get_operator(self.operator)(), self.number)
        try:
            return None if _without_annotations(code) == _without_annotations(source) else code
        except SyntaxError:
            return None

    def diff(self, code: str) -> list[str]:
        """Return the lines that the mutation removes and adds."""
        source = Path(self.module).read_text(encoding="utf-8").split("\n")
        return [line for line in difflib.ndiff(source, code.split("\n")) if line.startswith(("-", "+"))]


def _without_annotations(code: str) -> str:
    tree = ast.parse(code)
    for node in ast.walk(tree):
        for field in ("annotation", "returns"):
            if getattr(node, field, None) is not None:
                setattr(node, field, None if field == "returns" or isinstance(node, ast.arg) else ast.Constant(0))
    return ast.dump(tree)


def copied(folder: Path) -> Path:
    """Return a copy of the tracked files of the repository."""
    names = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split("\n")
    for name in filter(None, names):
        if (ROOT / name).is_file():
            target = folder / name
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, target)
    return folder


def test_files(target: Target, module: str) -> list[str]:
    """Return the test files of a target; those that name the module come first, those of the how-to pages, which are slow, last."""
    found = [file for test in map(Path, target.tests) for file in ([test] if test.is_file() else sorted(test.rglob("test_*.py")))]
    files = list(dict.fromkeys(found))
    name = module.removesuffix(".py").replace("/", ".").removesuffix(".__init__")
    files.sort(key=lambda file: ("how_to" in (text := file.read_text(encoding="utf-8")), name not in text))
    return [str(file) for file in files]


def passes(arguments: Sequence[str], limit: int, *, compiled: bool = True) -> bool:
    """Return whether pytest passes in a fork of this process, which spares it the imports, within a limit of processor time [s]."""
    pid = os.fork()
    if pid == 0:
        status = 1
        try:
            resource.setrlimit(resource.RLIMIT_CPU, (limit, limit))
            null = os.open(os.devnull, os.O_RDWR)
            for stream in (0, 1, 2):
                os.dup2(null, stream)
            if not compiled:
                os.environ["NUMBA_DISABLE_JIT"] = "1"
                numba.config.reload_config()
            status = int(pytest.main(["-x", "-q", "-p", "no:cacheprovider", *arguments]))
        finally:
            os._exit(status)
    return os.waitpid(pid, 0)[1] == 0


def stages(target: Target, module: str = "") -> list[tuple[list[str], bool]]:
    """Return the arguments of pytest for each run of the tests of a target, and whether the kernels are compiled for it."""
    files = test_files(target, module)
    return [([*files, "-m", "kernel"], False), (files, True)] if target.kernels else [(files, True)]


def needed(target: Target) -> list[int]:
    """Return the processor time that each run of the tests takes without a mutation [s]."""
    times = []
    for arguments, compiled in stages(target):
        began = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        if not passes(arguments, LONGEST, compiled=compiled):
            raise SystemExit(f"the tests fail without any mutation: pytest {' '.join(arguments)}")
        times.append(round(resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - began))
    return times


def survives(target: Target, limits: Sequence[int], module: str) -> bool:
    """Return whether all tests of a target pass, each run within its limit of processor time [s]; stop at the first that fails."""
    runs = zip(stages(target, module), limits, strict=True)
    return all(passes(arguments, limit, compiled=compiled) for (arguments, compiled), limit in runs)


def mutants(source: str) -> Iterator[Mutant]:
    """Yield all mutants of a source file or of the modules in a folder."""
    from cosmic_ray.ast import ast_nodes, get_ast
    from cosmic_ray.plugins import get_operator

    for path in [Path(source)] if source.endswith(".py") else sorted(Path(source).rglob("*.py")):
        nodes = list(ast_nodes(get_ast(path.read_text(encoding="utf-8"))))
        for name in OPERATORS:
            operator = get_operator(name)()
            for number in range(sum(len(list(operator.mutation_positions(node))) for node in nodes)):
                yield Mutant(str(path), name, number)


def equivalent(mutant: Mutant, diff: Sequence[str], reasons: Sequence[dict[str, str]]) -> bool:
    """Return whether one of the reasons why no test can notice a mutant applies to it."""
    removed, added = (" ".join(line[1:].strip() for line in diff if line.startswith(sign)) for sign in ("-", "+"))
    return any(
        reason["line"] in removed and reason.get("becomes", "") in added and reason.get("operator", "") in mutant.operator
        for reason in reasons
    )


def examine(name: str, count: int, seed: int, skip: int) -> tuple[int, int]:
    """Run a sample of the mutants of a package, without the first to ``skip``; return how many died or are equivalent, and how many ran."""
    target = TARGETS[name]
    limits = [10 + 2 * time for time in needed(target)]
    sys.dont_write_bytecode = True  # that of a mutant could be taken for that of the module
    reasons: dict[str, list[dict[str, str]]] = yaml.safe_load(REASONS.read_text(encoding="utf-8")) if REASONS.exists() else {}
    population = sorted(mutant for source in target.sources for mutant in mutants(source))
    random.Random(seed).shuffle(population)
    valid = ((mutant, code) for mutant in population if (code := mutant.code()) is not None)
    killed = ran = 0
    for mutant, code in itertools.islice(valid, skip, count):
        ran += 1
        diff, path = mutant.diff(code), Path(mutant.module)
        given = [reason for place, listed in reasons.items() if mutant.module.startswith(place) for reason in listed]
        survived = not equivalent(mutant, diff, given) and _survives_mutated(target, limits, path, code)
        killed += not survived
        print(f"{name}: {killed} of {ran}", end="\r", file=sys.stderr, flush=True)
        if survived:
            print(f"survived: {mutant.module} {mutant.operator.removeprefix('core/')}", *diff, "", sep="\n", flush=True)
    print(f"{name}: a sample of {ran} of some {len(population)} mutants", flush=True)
    return killed, ran


def _survives_mutated(target: Target, limits: Sequence[int], path: Path, code: str) -> bool:
    """Return whether the tests pass with another text of a module, which is put back afterwards."""
    source, times = path.read_text(encoding="utf-8"), path.stat()
    path.write_text(code, encoding="utf-8")
    try:
        return survives(target, limits, str(path))
    finally:
        path.write_text(source, encoding="utf-8")
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))


def main() -> int:
    """Examine the packages asked for; return 0 where at least the share asked for was killed in each."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("packages", nargs="*", default=[], help=f"of {', '.join(TARGETS)}; all without any")
    parser.add_argument("--sample", type=int, default=50, help="mutants of each package")
    parser.add_argument("--seed", type=int, default=1, help="seed of the sample")
    parser.add_argument("--skip", type=int, default=0, help="mutants at the beginning of the sample that are not examined again")
    parser.add_argument("--least", type=float, default=0.9, help="share that must be killed")
    options = parser.parse_args()
    unknown = set(options.packages) - set(TARGETS)
    if unknown:
        parser.error(f"unknown package {sorted(unknown)[0]!r}; give some of {', '.join(TARGETS)}")
    failed = False
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(copied(Path(folder)))
        # The compiled kernels and cached filters go there, too: those of a mutant are of no use later.
        os.environ |= {"PYTHONPATH": folder, "XDG_CACHE_HOME": f"{folder}/.cache"}
        sys.path.insert(0, folder)
        for name in options.packages or TARGETS:
            killed, ran = examine(name, options.sample, options.seed, options.skip)
            failed |= killed < options.least * ran
            print(f"{name}: {killed} of {ran} mutants killed or equivalent", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
