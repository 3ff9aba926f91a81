"""A full disk ends the recording, not the bench, whose exit status says so."""

from __future__ import annotations

import resource
import signal
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="the nodes need ROS 2; everything else is tested without")

from full_disk import files_of_at_most
from node_arguments import parameters
from ros_bench import PATIENCE, domain, environment, graph_client, node
from waiting import wait_for

from dcrb_ros.messages.statuses import ERROR, decode_diagnostics
from dcrb_ros.messages.topics import BENCH_DIAGNOSTICS, VIBRATION
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.simulation.loop import Simulation

pytestmark = [pytest.mark.node, pytest.mark.slow]

BAG = Path(__file__).parents[2] / "bags" / "outer_ring_defect"


def test_a_full_disk_is_reported_and_publishing_continues(tmp_path: Path) -> None:
    number, bag = domain(), tmp_path / "bag"
    given = parameters(recording__path=str(bag))
    with graph_client(number) as client, node("simulator", given, environment(number), tmp_path / "log") as simulator:
        client.until(lambda: client.status.get("recorder", "off") != "off", "the recorder in /diagnostics")
        assert client.status["recorder"] == "recording"
        resource.prlimit(simulator.process.pid, resource.RLIMIT_FSIZE, (800_000, 800_000))
        client.until(lambda: "File too large" in client.status["recorder"], "the error in /diagnostics")
        assert decode_diagnostics(client.received[BENCH_DIAGNOSTICS][-1])[1][0].level == ERROR
        blocks = len(client.received[VIBRATION])
        client.until(lambda: len(client.received[VIBRATION]) > blocks + 50, "more of the waveform")
        assert simulator.output.count("File too large") == 1
        assert simulator.end(signal.SIGINT) == 1, simulator.output
    recording = Recording(bag)
    assert sum(1 for _ in recording.vibrations()) > 10
    assert not recording.complete


def test_a_recording_that_cannot_be_created_is_refused_and_reported(tmp_path: Path) -> None:
    from std_srvs.srv import SetBool, Trigger

    number, bag = domain(), tmp_path / "bag"
    (tmp_path / "bag-2").symlink_to("nowhere")  # seems free but cannot be created
    given = parameters(recording__path=str(bag))
    with graph_client(number) as client, node("simulator", given, environment(number), tmp_path / "log") as simulator:
        client.until(lambda: len(client.received[VIBRATION]) > 5, "blocks")
        assert client.ask(Trigger, "reset").success
        client.until(lambda: "bag-2 cannot be created" in client.status["recorder"], "the error in /diagnostics")
        assert decode_diagnostics(client.received[BENCH_DIAGNOSTICS][-1])[1][0].level == ERROR
        (tmp_path / "bag-2").unlink()
        resource.prlimit(simulator.process.pid, resource.RLIMIT_FSIZE, (6000, 6000))  # enough for the manifest, not for the first message
        answer = client.ask(SetBool, "record", data=True)
        assert (answer.success, "File too large; free some space" in answer.message) == (False, True), answer
        blocks = len(client.received[VIBRATION])
        client.until(lambda: len(client.received[VIBRATION]) > blocks + 50, "more of the waveform")
    assert Recording(bag).complete
    assert not (tmp_path / "bag-2").exists()


def test_a_viewer_names_its_file_that_cannot_be_written(tmp_path: Path) -> None:
    number, document = domain(), tmp_path / "live.rrd"
    with node("viewer", ["--save", str(document)], environment(number), tmp_path / "viewer.log") as viewer:
        resource.prlimit(viewer.process.pid, resource.RLIMIT_FSIZE, (50_000, 50_000))
        given = parameters(bag=str(BAG), rate=0.0, listeners=1, wait=PATIENCE)
        with node("replayer", given, environment(number), tmp_path / "replayer.log") as replayer:
            assert replayer.process.wait(PATIENCE) == 0, replayer.output
        wait_for(lambda: document.exists() and document.stat().st_size == 50_000, PATIENCE)
        assert viewer.end(signal.SIGINT) == 1, viewer.output
    assert viewer.output.count(f"viewer: {document} is incomplete, it cannot be written") == 1, viewer.output
    assert "free some space or give another file" in viewer.output


def test_the_bench_shows_the_verdict_and_fails(tmp_path: Path) -> None:
    next(iter(Simulation(load_configuration("dry")).blocks(0.02)))  # the compiled kernels are larger than the limit
    bag = tmp_path / "bag"
    command = [sys.executable, "-m", "dcrb_ros.cli.program", "bench", "dry", "--duration", "5", "--time-scale", "0", "--record", str(bag)]
    with files_of_at_most(1_500_000):
        done = subprocess.run(command, env=environment(domain()), capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert done.returncode == 1, done.stderr
    assert done.stderr.count("File too large") == 1, done.stderr
    assert "verdict: " in done.stdout
    assert "recording: " not in done.stdout
    assert not Recording(bag).complete


def test_a_stopped_bench_whose_recording_failed_fails(tmp_path: Path) -> None:
    next(iter(Simulation(load_configuration("dry")).blocks(0.02)))  # the compiled kernels are larger than the limit
    command = [sys.executable, "-m", "dcrb_ros.cli.program", "bench", "dry", "--duration", "1000", "--record", str(tmp_path / "bag")]
    log = tmp_path / "log"
    with log.open("wb") as output, files_of_at_most(1_500_000):
        bench = subprocess.Popen(command, env=environment(domain()), stdout=output, stderr=subprocess.STDOUT)
    try:
        wait_for(lambda: b"File too large" in log.read_bytes() or bench.poll() is not None, PATIENCE)
        assert bench.poll() is None, log.read_text()
        bench.send_signal(signal.SIGINT)
        assert bench.wait(PATIENCE) == 1, log.read_text()
    finally:
        if bench.poll() is None:
            bench.kill()
            bench.wait(PATIENCE)
    assert "Traceback" not in log.read_text()
    assert "recording: " not in log.read_text()
    assert not Recording(tmp_path / "bag").complete
