"""The names that ``import dcrb_ros`` gives, and what importing it loads."""

from __future__ import annotations

import ast
import doctest
import importlib
import inspect
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import matplotlib as mpl
import pytest

import dcrb_ros

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
DOCUMENTED = sorted({inspect.getmodule(getattr(dcrb_ros, name)).__name__ for name in dcrb_ros.__all__ if name != "__version__"})  # type: ignore[union-attr]


def loaded_by(code: str, modules: set[str]) -> list[str]:
    """Return which modules a fresh interpreter has loaded after some code."""
    script = f"import sys; {code}; print(sorted({modules} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=400, check=True)
    return list(ast.literal_eval(done.stdout))


def test_import_loads_nothing_heavy() -> None:
    heavy = {"numpy", "numba", "rclpy", "scipy", "pydantic", "matplotlib", "pandas", "rerun", "rosbags", "mcap"}
    assert loaded_by("import dcrb_ros", heavy) == []


def test_frequencies_and_detector_load_neither_ros_nor_plots() -> None:
    use = "import dcrb_ros; dcrb_ros.characteristic_frequencies('healthy', 100.0); dcrb_ros.FaultDetector"
    assert loaded_by(use, {"rclpy", "matplotlib", "pandas", "rerun"}) == []


@pytest.mark.parametrize("name", dcrb_ros.__all__)
def test_every_public_name_resolves_and_is_documented(name: str) -> None:
    value = getattr(dcrb_ros, name)
    assert name in dir(dcrb_ros)
    assert name == "__version__" or (value.__doc__ and value.__name__ == name)


def test_type_checkers_and_the_interpreter_see_the_same_names() -> None:
    tree = ast.parse(Path(dcrb_ros.__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    seen = [(alias.name, alias.asname) for node in tree.body if isinstance(node, ast.ImportFrom) for alias in node.names]
    assert sorted(seen) == [(name, name) for name in dcrb_ros.__all__]


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="has no attribute 'simulat'"):
        _ = dcrb_ros.simulat  # type: ignore[attr-defined]


@pytest.mark.timeout(900)  # a calibration takes some minutes on busy processors
@pytest.mark.parametrize("name", DOCUMENTED)
def test_examples_in_docstrings_run(name: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(ROOT)
    mpl.use("Agg")
    module: ModuleType = importlib.import_module(name)
    done = doctest.testmod(module, optionflags=doctest.NORMALIZE_WHITESPACE)
    assert done.failed == 0


def test_functions_have_an_example() -> None:
    functions = [value for name in dcrb_ros.__all__ if inspect.isfunction(value := getattr(dcrb_ros, name))]
    assert len(functions) >= 9
    assert [function.__name__ for function in functions if ">>>" not in (function.__doc__ or "")] == []
