"""The viewer as a process: its failures are one sentence with the remedy."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace

import pytest
from waiting import runs, wait_for

from dcrb_ros.viewer import window

NO_SCREEN = "import sys; print('a note'); sys.exit('Error: winit EventLoopError: cannot open display')"


@pytest.mark.skipif(sys.platform != "linux", reason="other systems always have a display")
def test_a_missing_display_is_refused_with_the_remedy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in window.DISPLAYS:
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(window.ViewerFailure, match=r"there is no display: use the browser \(--web\), or .*--save FILE\.rrd"):
        window.open_window(tmp_path / "none.rrd")


def test_an_error_of_the_viewer_is_quoted_with_the_remedy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("DISPLAY", ":77")
    monkeypatch.setattr(window, "_command", lambda: [sys.executable, "-c", NO_SCREEN])
    with pytest.raises(window.ViewerFailure, match=r"the viewer failed \(winit EventLoopError: cannot open display\): use the browser"):
        window.open_window(tmp_path / "none.rrd")
    assert capfd.readouterr() == ("", "")


def test_a_closed_window_is_no_failure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DISPLAY", ":77")
    monkeypatch.setattr(window, "_command", lambda: [sys.executable, "-c", ""])
    wait = subprocess.Popen.wait

    def bounded(viewer: subprocess.Popen[bytes], timeout: float | None = None) -> int:
        assert timeout is not None  # a signal just before a wait without end would be noticed after it only
        return wait(viewer, timeout)

    monkeypatch.setattr(subprocess.Popen, "wait", bounded)
    assert window.open_window(tmp_path / "none.rrd") == 0


STARTS_A_CHILD = """
import pathlib, subprocess, sys
with subprocess.Popen([sys.executable, "-c", "import time; time.sleep(1000)"]) as child:
    pathlib.Path(sys.argv[-1], "child").write_text(f"{child.pid}\\n")
"""


def test_a_window_ends_with_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DISPLAY", ":77")
    monkeypatch.setattr(window, "_command", lambda: [sys.executable, "-c", STARTS_A_CHILD])
    children = list[int]()

    def interrupt() -> None:
        wait_for(lambda: (tmp_path / "child").exists() and (tmp_path / "child").read_text().endswith("\n"))
        children.append(int((tmp_path / "child").read_text()))
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    thread.start()
    try:
        assert window.open_window(tmp_path) == 0
    finally:
        thread.join()
    wait_for(lambda: not runs(children[0]))


@pytest.mark.parametrize(("summaries", "written"), [((), True), (("too many points",), False)])
def test_an_incomplete_picture_does_not_replace_the_old_one(
    summaries: tuple[str, ...], written: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("rerun.experimental")
    view = SimpleNamespace(name="waveform", reports=[SimpleNamespace(summary=summary) for summary in summaries])
    client = SimpleNamespace(set_time=lambda *_, **__: None, get_state=lambda: SimpleNamespace(views=[view]))
    answers = {"load the recording": client, "draw a stable picture": b"a picture"}
    picture = tmp_path / "old.png"
    picture.write_bytes(b"the old one")
    monkeypatch.setattr("rerun.experimental.ViewerClient", SimpleNamespace(get_state=None))
    monkeypatch.setattr(window, "_running", lambda *_: nullcontext())
    monkeypatch.setattr(window, "_wait_for", lambda _, purpose, __: answers.get(purpose))
    monkeypatch.setattr(window, "_save_cropped", lambda png, path: path.write_bytes(png))
    monkeypatch.setattr(window, "NOTICE_TIME", 0.0)
    refused = pytest.raises(
        window.ViewerFailure, match=r"old\.png was not written, .* could not draw everything: waveform: too many points"
    )
    with nullcontext() if written else refused:
        window.save_screenshot(tmp_path / "document.rrd", picture, at_ns=0)
    assert picture.read_bytes() == (b"a picture" if written else b"the old one")


def test_the_viewer_logs_errors_only_and_no_escape_codes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("RUST_LOG", raising=False)
    assert {"RUST_LOG": "error", "NO_COLOR": "1"}.items() <= window._environment(tmp_path).items()
    monkeypatch.setenv("RUST_LOG", "debug")
    assert window._environment(tmp_path)["RUST_LOG"] == "debug"


def test_a_viewer_that_is_killed_leaves_its_files_beside_the_document(tmp_path: Path) -> None:
    environment = window._environment(tmp_path)
    assert environment["TMPDIR"] == str(tmp_path)
    command = [sys.executable, "-c", "import tempfile, time; tempfile.mkdtemp(prefix='viewer-'); time.sleep(1000)"]
    with window._running(command, environment):
        wait_for(lambda: any(tmp_path.glob("viewer-*")))  # Python first tries the folder with a file of another name
    assert [path.name.startswith("viewer-") for path in tmp_path.iterdir()] == [True]
