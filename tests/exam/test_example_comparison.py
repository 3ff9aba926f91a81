"""The comparison of the example detectors."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

COMPARE = Path(__file__).parents[2] / "examples" / "detectors" / "compare.py"
COMMAND = """
import pathlib, sys
if "score" in sys.argv:
    if "second" in sys.argv:
        sys.exit(2)
    pathlib.Path(sys.argv[sys.argv.index("--entry") + 1]).touch()
else:
    pathlib.Path(sys.argv[-1], "table").touch()
"""


def test_the_other_detectors_are_compared_if_one_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    compare = SimpleNamespace(**runpy.run_path(str(COMPARE)))
    compare.main.__globals__.update(
        families=lambda: {"first": "first.py:First", "second": "second.py:Second", "third": "third.py:Third"},
        DCRB=[sys.executable, "-c", COMMAND],
    )
    monkeypatch.setattr(sys, "argv", ["compare.py", "smoke", str(tmp_path)])
    with pytest.raises(SystemExit, match="without an entry: second ended with status 2"):
        compare.main()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["first.json", "shipped-detector.json", "table", "third.json"]
    assert "third" in capsys.readouterr().out
