"""Simulated time through the node: pause, step, reset, record, /clock, and the same samples at any speed."""

from __future__ import annotations

import functools
import itertools
import signal
import time
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

pytest.importorskip("rclpy", reason="the nodes need ROS 2; everything else is tested without")

from node_arguments import parameters
from ros_bench import PATIENCE, Listener, domain, environment, listener, node

from dcrb_ros.messages.plain import decode_clock
from dcrb_ros.messages.points import decode_vibration
from dcrb_ros.messages.statuses import decode_truth
from dcrb_ros.messages.topics import BENCH_DIAGNOSTICS, CLOCK, GROUND_TRUTH, VIBRATION
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.runtime.simulated_time import nanoseconds
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.simulation.scenario import read_scenario
from dcrb_ros.stream.events import SpeedCommand

pytestmark = pytest.mark.node

STORY = """
timeline:
  - {at: 0.03, set: {operating.speed: 120.0}}
  - {at: 0.05, set: {faults.outer_1.width: 0.002, faults.broken_bars: row1/bar3}}
  - {at: 0.06, over: 0.1, set: {faults.outer_1.width: 0.003, sensor.noise_density: 0.1}}
"""


LEAD_NS = 1_000_000
"""Simulated time by which the model is ahead of the samples, at most: the delay of the sensor's filters."""

_index = functools.lru_cache(maxsize=None)(lambda data: decode_vibration(data).first_index(51200))


def indices(heard: Listener) -> list[int]:
    """Return the index of the first sample of every block heard; each is decoded once."""
    return [_index(data) for data in heard.heard[VIBRATION]]


def waveform(recording: Recording, count: int) -> npt.NDArray[np.float32]:
    """Return the first ``count`` blocks of a recording."""
    return np.concatenate([v.acceleration for v in itertools.islice(recording.vibrations(), count)])


@pytest.mark.parametrize(("scale", "size"), [(0.1, 1024), (1.0, 700), (0.0, 64)])
def test_same_samples_at_any_time_scale_and_block_size(scale: float, size: int, tmp_path: Path) -> None:
    story, bag = tmp_path / "story.yaml", tmp_path / "bag"
    story.write_text(STORY)
    configuration = Configuration()
    blocks = list(Simulation(configuration, read_scenario(story, configuration)).blocks(0.2))
    arguments = ["--duration", "0.2", "--scenario", str(story)]
    arguments += parameters(recording__path=bag, time_scale=scale, publishing__block_size=size)
    with node("simulator", arguments, environment(domain()), tmp_path / "log") as simulator:
        assert simulator.process.wait(PATIENCE) == 0, simulator.words
    recorded = np.concatenate([v.acceleration for v in Recording(bag).vibrations()])
    assert np.array_equal(recorded, np.concatenate([block.acceleration for block in blocks]))
    said = [decode_truth(m.data) for m in Recording(bag).messages((GROUND_TRUTH,))]
    expected = [truth for block in blocks for truth in block.truths]
    assert [(t.time_ns, t.event, t.faults) for t in said] == [(t.time_ns, t.event, t.faults) for t in expected]


def test_pause_holds_and_steps_go_one_block(tmp_path: Path) -> None:
    from std_srvs.srv import SetBool, Trigger

    number = domain()
    with listener(number) as heard, node("simulator", parameters(), environment(number), tmp_path / "log") as simulator:
        heard.until(lambda: len(heard.heard[VIBRATION]) > 5, "blocks")
        refused = heard.ask(Trigger, "step")
        assert (refused.success, refused.message) == (False, "step: the bench runs; pause it first (service pause, data: true)")
        answer = heard.ask(SetBool, "pause", data=True)
        assert answer.success
        assert answer.message.startswith("paused at ")
        heard.until(lambda: heard.status.get("model") == "paused", "the pause in /diagnostics")
        # What was on its way has come by then: a report later.
        held = indices(heard)
        for count in (1, 2, 3):
            assert heard.ask(Trigger, "step").success
            heard.until(lambda c=count: len(indices(heard)) == len(held) + c, "one block")
        reports = len(heard.heard[BENCH_DIAGNOSTICS])
        heard.until(lambda: len(heard.heard[BENCH_DIAGNOSTICS]) >= reports + 2, "two reports")
        assert len(indices(heard)) == len(held) + 3
        assert heard.ask(SetBool, "pause", data=False).success
        heard.until(lambda: len(indices(heard)) > len(held) + 30, "blocks after the pause")
        assert np.all(np.diff(indices(heard)) == 1024)  # nothing is lost, nothing twice
        heard.until(lambda: heard.status["model"] == "running", "running in /diagnostics")
        assert "Traceback" not in simulator.words


def test_reset_gives_the_same_samples_and_a_new_recording(tmp_path: Path) -> None:
    from std_srvs.srv import Trigger

    number, bag = domain(), tmp_path / "bag"
    with (
        listener(number) as heard,
        node("simulator", parameters(recording__path=bag), environment(number), tmp_path / "log") as simulator,
    ):
        heard.until(lambda: len(heard.heard[VIBRATION]) > 25, "blocks")
        assert heard.set(faults__outer_1__width=0.002, sensor__range=2000.0) == (True, "")
        heard.until(lambda: any("outer_1" in decode_truth(t).faults for t in heard.heard[GROUND_TRUTH]), "the defect")
        reset_at = len(indices(heard))
        answer = heard.ask(Trigger, "reset")
        assert answer.success, answer.message
        heard.until(lambda: 0 in indices(heard)[reset_at:], "the first block again")
        begun_at = indices(heard).index(0, reset_at)
        heard.until(lambda: len(indices(heard)) > begun_at + 25, "blocks from the start")
        assert np.all(np.diff(indices(heard)[indices(heard).index(0, reset_at) :]) == 1024)
        assert heard.set(faults__outer_2__width=0.002) == (True, "")  # where outer_1 was: it is gone
        heard.until(lambda: set(decode_truth(heard.heard[GROUND_TRUTH][-1]).faults) == {"outer_2"}, "the other defect")
        assert heard.ask(Trigger, "reset").success
        heard.until(lambda: heard.status["recording"] == f"{bag}-3", "the third recording")
        assert simulator.end(2) == 0, simulator.words
    first, second = Recording(bag), Recording(tmp_path / "bag-2")
    for recording in (first, second):
        stamps = [v.stamp_ns for v in recording.vibrations()]
        assert recording.complete
        assert stamps[0] == 0
        assert stamps == sorted(stamps)
    assert np.array_equal(*(waveform(recording, 20) for recording in (first, second)))


def test_record_starts_and_ends_recordings(tmp_path: Path) -> None:
    from std_srvs.srv import SetBool

    number, bag = domain(), tmp_path / "bag"
    with listener(number) as heard, node("simulator", parameters(recording__path=bag), environment(number), tmp_path / "log"):
        heard.until(lambda: len(heard.heard[VIBRATION]) > 5, "blocks")
        assert heard.ask(SetBool, "record", data=True).message == f"recording to {bag}"
        assert heard.ask(SetBool, "record", data=False).message.startswith(f"{bag} is finished at")
        assert heard.ask(SetBool, "record", data=False).message == "no recording runs"
        blocks = len(heard.heard[VIBRATION])
        heard.until(lambda: len(heard.heard[VIBRATION]) > blocks + 10, "blocks")
        assert heard.ask(SetBool, "record", data=True).message == f"recording to {bag}-2"
        heard.until(lambda: heard.status["recording"] == f"{bag}-2", "the recording in /diagnostics")
        assert heard.ask(SetBool, "record", data=False).success
    assert Recording(bag).complete
    later = Recording(tmp_path / "bag-2")
    assert later.complete
    assert min(message.time_ns for message in later.messages()) > 10 * 1024 * 1e9 / 51200  # not from zero: it began later


def test_clock_is_simulated_time_and_rare(tmp_path: Path) -> None:
    number = domain()
    values = {"publishing__clock": True, "time_scale": 0.0, "publishing__block_size": 256}
    with listener(number) as heard, node("simulator", parameters(**values), environment(number), tmp_path / "log"):
        heard.until(lambda: heard.heard[CLOCK], "the clock")
        began, first = time.monotonic(), len(heard.heard[CLOCK])
        heard.until(lambda: time.monotonic() > began + 2.0, "two seconds")
        clocks = [decode_clock(data) for data in heard.heard[CLOCK]]
        assert 10 < len(clocks) - first <= 230  # 100 Hz of wall time at most; the throttle and the listener count apart
        assert clocks == sorted(clocks)
        heard.until(lambda: decode_vibration(heard.heard[VIBRATION][-1]).stamp_ns >= clocks[-1], "the block of that time")


def test_no_clock_unless_asked_for(tmp_path: Path) -> None:
    number = domain()
    with listener(number) as heard, node("simulator", parameters(), environment(number), tmp_path / "log"):
        heard.until(lambda: len(heard.heard[BENCH_DIAGNOSTICS]) >= 2, "two reports")
        assert not heard.heard[CLOCK]
        assert heard.node.count_publishers("/clock") == 0


def test_a_whole_number_will_do(tmp_path: Path) -> None:
    number = domain()
    with listener(number) as heard, node("simulator", parameters(), environment(number), tmp_path / "log") as simulator:
        heard.until(lambda: heard.heard[VIBRATION], "the first block")
        assert heard.set(time_scale=2) == (True, "")  # as of `ros2 param set /dcrb/simulator time_scale 2`
        heard.until(lambda: heard.status.get("time_scale") == "2", "the time scale in the status")
        assert not heard.set(publishing__block_size=2.0)[0]
        assert simulator.end(signal.SIGINT) == 0, simulator.words


def test_a_command_takes_effect_within_two_blocks(tmp_path: Path) -> None:
    from std_msgs.msg import Float64
    from std_srvs.srv import SetBool, Trigger

    number = domain()
    with listener(number) as heard, node("simulator", parameters(), environment(number), tmp_path / "log"):
        speed = heard.node.create_publisher(Float64, "command/speed", 10)
        heard.until(lambda: heard.heard[VIBRATION], "the first block")
        heard.meet(speed)
        assert heard.ask(SetBool, "pause", data=True).success
        heard.until(lambda: heard.status.get("model") == "paused", "the pause in /diagnostics")
        for count in (1, 2, 3):
            sent = indices(heard)
            speed.publish(Float64(data=100.0 + count))
            speed.publish(Float64(data=float("nan")))  # its refusal shows that the command before it has arrived
            heard.until(lambda n=count: heard.status["rejected_commands"] == str(n), "the refusal of the second command")
            for _ in range(2):  # the block that was simulated before the pause, and the next one
                assert heard.ask(Trigger, "step").success
            command = SpeedCommand(100.0 + count)
            heard.until(lambda c=command: command_times(heard, c), "the command in the ground truth")
            heard.until(lambda known=sent: len(indices(heard)) == len(known) + 2, "both blocks")
            end, latest = (nanoseconds(sent[-1] + 1024 * blocks, 51200) for blocks in (1, 2))
            (time_ns,) = command_times(heard, command)
            assert end <= time_ns <= latest + LEAD_NS


def command_times(heard: Listener, command: SpeedCommand) -> list[int]:
    """Return the times [ns] at which a command took effect according to the ground truth."""
    return [truth.time_ns for truth in map(decode_truth, heard.heard[GROUND_TRUTH]) if truth.event == command]
