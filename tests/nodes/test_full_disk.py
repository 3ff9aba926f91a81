"""A disk that is full ends the recording, not the bench."""

from __future__ import annotations

import resource
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="the nodes need ROS 2; everything else is tested without")

from node_arguments import parameters
from ros_bench import domain, environment, listener, node

from dcrb_ros.messages.statuses import ERROR, decode_diagnostics
from dcrb_ros.messages.topics import BENCH_DIAGNOSTICS, VIBRATION
from dcrb_ros.recordings.reader import Recording

pytestmark = pytest.mark.node


def test_a_full_disk_is_reported_and_the_topics_stay_alive(tmp_path: Path) -> None:
    number, bag = domain(), tmp_path / "bag"
    given = parameters(recording__path=str(bag))
    with listener(number) as heard, node("simulator", given, environment(number), tmp_path / "log") as simulator:
        heard.until(lambda: heard.status.get("recorder"), "the recorder in /diagnostics")
        assert heard.status["recorder"] == "recording"
        resource.prlimit(simulator.process.pid, resource.RLIMIT_FSIZE, (800_000, 800_000))
        heard.until(lambda: "File too large" in heard.status["recorder"], "the error in /diagnostics")
        assert decode_diagnostics(heard.heard[BENCH_DIAGNOSTICS][-1])[1][0].level == ERROR
        blocks = len(heard.heard[VIBRATION])
        heard.until(lambda: len(heard.heard[VIBRATION]) > blocks + 50, "more of the waveform")
        assert simulator.words.count("File too large") == 1
    recording = Recording(bag)
    assert sum(1 for _ in recording.vibrations()) > 10
    assert not recording.complete


def test_a_recording_that_cannot_begin_is_answered_and_reported(tmp_path: Path) -> None:
    from std_srvs.srv import SetBool, Trigger

    number, bag = domain(), tmp_path / "bag"
    (tmp_path / "bag-2").symlink_to("nowhere")  # a name that seems free and cannot be had
    given = parameters(recording__path=str(bag))
    with listener(number) as heard, node("simulator", given, environment(number), tmp_path / "log") as simulator:
        heard.until(lambda: len(heard.heard[VIBRATION]) > 5, "blocks")
        assert heard.ask(Trigger, "reset").success
        heard.until(lambda: "bag-2 cannot be created" in heard.status["recorder"], "the error in /diagnostics")
        assert decode_diagnostics(heard.heard[BENCH_DIAGNOSTICS][-1])[1][0].level == ERROR
        (tmp_path / "bag-2").unlink()
        resource.prlimit(simulator.process.pid, resource.RLIMIT_FSIZE, (6000, 6000))  # the manifest has room, the first message has not
        answer = heard.ask(SetBool, "record", data=True)
        assert (answer.success, "File too large; make room" in answer.message) == (False, True), answer
        blocks = len(heard.heard[VIBRATION])
        heard.until(lambda: len(heard.heard[VIBRATION]) > blocks + 50, "more of the waveform")
    assert Recording(bag).complete
    assert not (tmp_path / "bag-2").exists()
