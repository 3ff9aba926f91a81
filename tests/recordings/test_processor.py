"""The processor in the manifest: what of it changes samples, and how a difference is named."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from made_up_blocks import recorded

from dcrb_ros.recordings.processor import described, processor, processor_difference
from dcrb_ros.recordings.reader import Recording

WITH: dict[str, Any] = {"target": "znver4", "features": ["fma", "avx2"]}
WITHOUT: dict[str, Any] = {"target": "generic", "features": []}
GENERIC = "generic (none of fma, avx, avx2, avx512f)"


def test_the_manifest_names_the_processor(tmp_path: Path) -> None:
    assert Recording(recorded(tmp_path / "bag", 1)).manifest["processor"] == processor()


@pytest.mark.skipif(sys.platform != "linux", reason="numba's target is a host processor")
@pytest.mark.parametrize(
    ("settings", "expected"),
    [
        ({"NUMBA_CPU_NAME": "generic"}, {"target": "generic", "features": []}),
        ({"NUMBA_CPU_NAME": "haswell", "NUMBA_CPU_FEATURES": "+avx,+avx2,+fma"}, {"target": "haswell", "features": ["fma", "avx", "avx2"]}),
        ({"NUMBA_DISABLE_JIT": "1"}, {"target": "none, the kernels are not compiled", "features": []}),
    ],
)
def test_the_processor_is_the_one_that_numba_compiles_for(settings: dict[str, str], expected: dict[str, Any]) -> None:
    code = "import json; from dcrb_ros.recordings.processor import processor; print(json.dumps(processor()))"
    done = subprocess.run(
        [sys.executable, "-c", code], env={**os.environ, **settings}, capture_output=True, text=True, timeout=400, check=True
    )
    assert json.loads(done.stdout) == expected


@pytest.mark.parametrize(
    ("recorded", "present", "words"),
    [
        (WITH, WITH, ""),
        (
            WITH,
            {"target": "haswell", "features": ["fma"]},
            "its kernels were compiled for znver4 (fma, avx2), and the present ones for haswell (fma), for which the compiler may fuse "
            "other products",
        ),
        (WITHOUT, {"target": "sandybridge", "features": ["avx"]}, ""),
        (None, WITH, ""),
        (
            None,
            WITHOUT,
            f"its processor is not recorded, and this one, {GENERIC}, has no fused multiply-add",
        ),
        (
            WITH,
            WITHOUT,
            f"its kernels were compiled with fused multiply-add, for znver4 (fma, avx2), and the present ones without it, for {GENERIC}",
        ),
        (
            WITHOUT,
            WITH,
            f"its kernels were compiled without fused multiply-add, for {GENERIC}, and the present ones with it, for znver4 (fma, avx2)",
        ),
    ],
)
def test_only_fused_multiply_adds_are_a_difference(recorded: dict[str, Any] | None, present: dict[str, Any], words: str) -> None:
    assert processor_difference(recorded, present) == words


def test_a_damaged_entry_is_described_nevertheless() -> None:
    assert described({"features": "fma"}) == "unknown (none of fma, avx, avx2, avx512f)"
    assert described({"target": 3, "features": [None]}) == "3 (None)"
