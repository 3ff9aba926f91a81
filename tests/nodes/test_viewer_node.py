"""The viewer node as a process, with a replay: everything that is published is in the Rerun file."""

from __future__ import annotations

import signal
import subprocess
import sys
import warnings
from collections import Counter
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="the nodes need ROS 2; everything else is tested without")

from node_arguments import parameters
from rerun_documents import rows
from ros_bench import PATIENCE, domain, environment, node
from waiting import wait_for

from dcrb_ros.recordings.reader import Recording

pytestmark = [pytest.mark.node, pytest.mark.slow]

BAG = Path(__file__).parents[2] / "bags" / "outer_ring_defect"


def test_the_viewer_shows_everything_that_is_published(tmp_path: Path) -> None:
    number, document, recorded = domain(), tmp_path / "live.rrd", Recording(BAG).counts()
    expected = {
        "/waveform": 1024 * recorded["/dcrb/outer_ring/vibration"],
        "/forces/row1": recorded["/dcrb/roller_states"],
        "/bearing/row2/rollers": recorded["/dcrb/roller_states"],
        "/features/rms": recorded["/dcrb/outer_ring/features"],
        "/operating": recorded["/dcrb/ground_truth"],
    }
    with node("viewer", ["--save", str(document)], environment(number), tmp_path / "viewer.log") as viewer:
        given = parameters(bag=str(BAG), rate=1.0, listeners=1, wait=PATIENCE)
        with node("replayer", given, environment(number), tmp_path / "replayer.log") as replayer:
            assert replayer.process.wait(PATIENCE) == 0, replayer.output
        # What has been delivered is shown some time later.
        wait_for(lambda: shown(document).items() >= expected.items() or viewer.process.poll() is not None, PATIENCE)
        assert viewer.end(signal.SIGINT) == 0, viewer.output
    assert "not shown" not in viewer.output
    assert {name: rows(document)[name] for name in expected} == expected


def shown(document: Path) -> Counter[str]:
    """Return the rows in a document that is being written, whose end may be half a message; none where it cannot be read."""
    with warnings.catch_warnings(action="ignore"):
        try:
            return rows(document)
        except (OSError, RuntimeError, ValueError):
            return Counter()


@pytest.mark.parametrize(
    ("arguments", "status", "sentence"),
    [
        (["--save", "view.png"], 2, "--save view.png does not end in .rrd"),
        (["--save", "view.rrd", "--connect", "rerun+http://127.0.0.1:9876/proxy"], 2, "exclude each other"),
        ([], 1, "it needs a display; without one, save the view to a file"),
    ],
)
def test_the_viewer_refuses_invalid_arguments(
    arguments: list[str], status: int, sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    command = [sys.executable, "-m", "dcrb_ros.nodes", "viewer", *arguments]
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"):
        monkeypatch.delenv(name, raising=False)
    done = subprocess.run(command, env=environment(domain()), cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert done.returncode == status, done.stderr
    assert sentence in done.stderr
    assert "Traceback" not in done.stderr


def test_the_file_of_a_run_after_a_reset_replaces_no_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import rclpy

    from dcrb_ros.nodes.viewer import ViewerNode

    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")
    kept = tmp_path / "live-2.rrd"
    kept.write_text("of an earlier session")
    rclpy.init(args=[])
    node = ViewerNode(tmp_path / "live.rrd")
    try:
        for run in (1, 2, 3):
            node._stream(run).disconnect()
        assert kept.read_text() == "of an earlier session"
        assert sorted(path.name for path in tmp_path.iterdir()) == ["live-2.rrd", "live-3.rrd", "live-4.rrd", "live.rrd"]
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
