"""The first compilation, shared between two processes."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from pathlib import Path

import numba
import pytest

from dcrb_ros.bearing.payload import build_payload, initial_state
from dcrb_ros.core import compilation
from dcrb_ros.core.layout.workspace import workspace
from dcrb_ros.settings.configuration import Configuration

PATIENCE = 60.0


def test_the_other_process_ends_with_the_one_that_started_it(tmp_path: Path) -> None:
    configuration = Configuration()
    payload = build_payload(configuration)
    wanted = [numba.typeof(part) for part in (payload, initial_state(configuration, payload), workspace(payload))]
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    with subprocess.Popen([sys.executable, "-m", compilation.MODULE], stdin=subprocess.PIPE, env=environment) as other:
        other.communicate(pickle.dumps(wanted), PATIENCE)  # and closes the pipe, as the end of a process does
    assert other.returncode == 1
    assert not list(tmp_path.rglob("*linearize_raceways-*.nbc"))  # it had ten seconds to go


def test_nothing_is_started_where_the_loop_lies_compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    configuration = Configuration()
    payload = build_payload(configuration)

    def start(*arguments: object, **options: object) -> None:
        raise AssertionError("a process was started")

    monkeypatch.setattr(compilation.subprocess, "Popen", start)
    monkeypatch.setattr(compilation, "compiled", lambda: True)
    compilation.compile_ahead(payload, initial_state(configuration, payload), workspace(payload))


def test_without_a_second_process_the_kernels_are_compiled_here(monkeypatch: pytest.MonkeyPatch) -> None:
    configuration, found = Configuration(), []
    payload = build_payload(configuration)
    monkeypatch.setattr(compilation, "compiled", lambda: False)
    monkeypatch.setattr(compilation, "MODULE", "dcrb_ros.no_such_module")
    monkeypatch.setattr(compilation, "compile_pieces", lambda pieces, arguments: found.append(pieces))
    compilation.compile_ahead(payload, initial_state(configuration, payload), workspace(payload))
    assert found in ([compilation.HERE], [])  # none where its pipe broke at once: then all is compiled when it is needed
