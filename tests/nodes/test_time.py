"""Simulated time through the node: pause, step, reset, record, /clock, and the same samples at any speed."""

from __future__ import annotations

import functools
import itertools
import re
import signal
import time
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

pytest.importorskip("rclpy", reason="the nodes need ROS 2; everything else is tested without")

from node_arguments import parameters
from ros_bench import PATIENCE, GraphClient, domain, environment, graph_client, node

from dcrb_ros.messages.plain import decode_clock
from dcrb_ros.messages.points import decode_vibration
from dcrb_ros.messages.statuses import decode_diagnostics, decode_truth
from dcrb_ros.messages.topics import BENCH_DIAGNOSTICS, CLOCK, GROUND_TRUTH, VIBRATION
from dcrb_ros.nodes.ros import installed
from dcrb_ros.nodes.simulation_interfaces import PACKAGE
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.schema.simulated_time import nanoseconds
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.simulation.scenario import read_scenario
from dcrb_ros.stream.events import SpeedCommand

pytestmark = pytest.mark.node

SCENARIO = """
timeline:
  - {at: 0.03, set: {operating.speed: 120.0}}
  - {at: 0.05, set: {faults.outer_1.width: 0.002, faults.broken_bars: row1/bar3}}
  - {at: 0.06, over: 0.1, set: {faults.outer_1.width: 0.003, sensor.noise_density: 0.1}}
"""


LEAD_NS = 1_000_000
"""Simulated time by which the model is ahead of the samples, at most: the delay of the sensor's filters."""

_index = functools.lru_cache(maxsize=None)(lambda data: decode_vibration(data).first_index(51200))


def indices(client: GraphClient) -> list[int]:
    """Return the index of the first sample of every received block; each is decoded once."""
    return [_index(data) for data in client.received[VIBRATION]]


def pause(client: GraphClient) -> list[int]:
    """Pause the bench; return the index of the first sample of every block once the last one that was sent has arrived."""
    from std_srvs.srv import SetBool

    answer = client.ask(SetBool, "pause", data=True)
    assert answer.success
    end = float(re.fullmatch(r"paused at (\S+) s of simulated time", answer.message)[1])  # type: ignore[index]
    client.until(lambda: indices(client)[-1] + 1024 == round(end * 51200), "the last block before the pause")
    client.until(lambda: client.status.get("model") == "paused", "the pause in /diagnostics")
    return indices(client)


def waveform(recording: Recording, count: int) -> npt.NDArray[np.float32]:
    """Return the first ``count`` blocks of a recording."""
    return np.concatenate([v.acceleration for v in itertools.islice(recording.vibrations(), count)])


@pytest.mark.parametrize(("scale", "size"), [(0.1, 1024), (1.0, 700), (0.0, 64)])
def test_same_samples_at_any_time_scale_and_block_size(scale: float, size: int, tmp_path: Path) -> None:
    scenario, bag = tmp_path / "scenario.yaml", tmp_path / "bag"
    scenario.write_text(SCENARIO)
    configuration = Configuration()
    blocks = list(Simulation(configuration, read_scenario(scenario, configuration)).blocks(0.2))
    arguments = ["--duration", "0.2", "--scenario", str(scenario)]
    arguments += parameters(recording__path=bag, time_scale=scale, publishing__block_size=size)
    with node("simulator", arguments, environment(domain()), tmp_path / "log") as simulator:
        assert simulator.process.wait(PATIENCE) == 0, simulator.output
    recorded = np.concatenate([v.acceleration for v in Recording(bag).vibrations()])
    assert np.array_equal(recorded, np.concatenate([block.acceleration for block in blocks]))
    truths = [decode_truth(m.data) for m in Recording(bag).messages((GROUND_TRUTH,))]
    expected = [truth for block in blocks for truth in block.truths]
    assert [(t.time_ns, t.event, t.faults) for t in truths] == [(t.time_ns, t.event, t.faults) for t in expected]


def test_a_pause_holds_the_blocks_and_a_step_sends_one(tmp_path: Path) -> None:
    from std_srvs.srv import SetBool, Trigger

    number = domain()
    with graph_client(number) as client, node("simulator", parameters(), environment(number), tmp_path / "log") as simulator:
        client.until(lambda: len(client.received[VIBRATION]) > 5, "blocks")
        refused = client.ask(Trigger, "step")
        assert (refused.success, refused.message) == (False, "step: the bench runs; pause it first (service pause, data: true)")
        held = pause(client)
        assert client.status["simulation_interfaces"] == ("offered" if installed(PACKAGE) else "not installed")
        for count in (1, 2, 3):
            assert client.ask(Trigger, "step").success
            client.until(lambda c=count: len(indices(client)) == len(held) + c, "one block")
        client.reports(2)
        assert len(indices(client)) == len(held) + 3
        assert client.ask(SetBool, "pause", data=False).success
        client.until(lambda: len(indices(client)) > len(held) + 30, "blocks after the pause")
        assert np.all(np.diff(indices(client)) == 1024)  # no block is lost or repeated
        client.until(lambda: client.status["model"] == "running", "running in /diagnostics")
        assert "Traceback" not in simulator.output


def test_a_reset_leads_to_the_same_samples_in_a_new_recording(tmp_path: Path) -> None:
    from std_srvs.srv import Trigger

    number, bag = domain(), tmp_path / "bag"
    with (
        graph_client(number) as client,
        node("simulator", parameters(recording__path=bag), environment(number), tmp_path / "log") as simulator,
    ):
        client.until(lambda: len(client.received[VIBRATION]) > 25, "blocks")
        assert client.set(faults__outer_1__width=0.002, sensor__range=2000.0) == (True, "")
        client.until(lambda: any("outer_1" in decode_truth(t).faults for t in client.received[GROUND_TRUTH]), "the defect")
        reset_at = len(indices(client))
        answer = client.ask(Trigger, "reset")
        assert answer.success, answer.message
        client.until(lambda: 0 in indices(client)[reset_at:], "the first block again")
        restarted_at = indices(client).index(0, reset_at)
        client.until(lambda: len(indices(client)) > restarted_at + 25, "blocks from the start")
        assert np.all(np.diff(indices(client)[indices(client).index(0, reset_at) :]) == 1024)
        assert client.set(faults__outer_2__width=0.002) == (True, "")  # where outer_1 was, which is gone
        client.until(lambda: set(decode_truth(client.received[GROUND_TRUTH][-1]).faults) == {"outer_2"}, "the other defect")
        assert client.ask(Trigger, "reset").success
        client.until(lambda: client.status["recording"] == f"{bag}-3", "the third recording")
        assert simulator.end(2) == 0, simulator.output
    first, second = Recording(bag), Recording(tmp_path / "bag-2")
    for recording in (first, second):
        stamps = [v.stamp_ns for v in recording.vibrations()]
        assert recording.complete
        assert stamps[0] == 0
        assert stamps == sorted(stamps)
    assert np.array_equal(*(waveform(recording, 20) for recording in (first, second)))


def test_the_service_record_begins_and_ends_recordings(tmp_path: Path) -> None:
    from std_srvs.srv import SetBool

    number, bag = domain(), tmp_path / "bag"
    with graph_client(number) as client, node("simulator", parameters(recording__path=bag), environment(number), tmp_path / "log"):
        client.until(lambda: len(client.received[VIBRATION]) > 5, "blocks")
        assert client.ask(SetBool, "record", data=True).message == f"recording to {bag}"
        assert client.ask(SetBool, "record", data=False).message.startswith(f"{bag} is finished at")
        assert client.ask(SetBool, "record", data=False).message == "no recording runs"
        blocks = len(client.received[VIBRATION])
        client.until(lambda: len(client.received[VIBRATION]) > blocks + 10, "blocks")
        assert client.ask(SetBool, "record", data=True).message == f"recording to {bag}-2"
        client.until(lambda: client.status["recording"] == f"{bag}-2", "the recording in /diagnostics")
        assert client.ask(SetBool, "record", data=False).success
    assert Recording(bag).complete
    later = Recording(tmp_path / "bag-2")
    assert later.complete
    assert min(message.time_ns for message in later.messages()) > 10 * 1024 * 1e9 / 51200  # it does not begin at zero


def test_the_clock_is_simulated_time_and_throttled(tmp_path: Path) -> None:
    number = domain()
    values = {"publishing__clock": True, "time_scale": 0.0, "publishing__block_size": 256}
    with graph_client(number) as client, node("simulator", parameters(**values), environment(number), tmp_path / "log"):
        client.until(lambda: len(client.received[CLOCK]) > 50, "the clock")
        clocks = [decode_clock(data) for data in client.received[CLOCK]]
        published = client.published[CLOCK][: len(clocks)]
        # At most 100 Hz of wall time; a message is published some time after the throttle has looked at its clock.
        assert len(clocks) - 1 <= 115.0 * (published[-1] - published[0])
        assert clocks == sorted(clocks)
        client.until(lambda: decode_vibration(client.received[VIBRATION][-1]).stamp_ns >= clocks[-1], "the block of that time")


@pytest.mark.parametrize("simulated", [False, True])
def test_reports_are_stamped_with_the_wall_clock_unless_simulated_time_is_used(simulated: bool, tmp_path: Path) -> None:
    number, began = domain(), time.time_ns()
    with graph_client(number) as client, node("simulator", parameters(use_sim_time=simulated), environment(number), tmp_path / "log"):
        client.until(lambda: client.status["model"] == "running", "a report of the running bench")
        stamp_ns, (status,) = decode_diagnostics(client.received[BENCH_DIAGNOSTICS][-1])
        assert client.node.count_publishers("/clock") == 0
    assert not client.received[CLOCK]  # by default
    if simulated:
        assert stamp_ns == pytest.approx(float(status.values["simulated [s]"]) * 1e9, abs=1e6)
    else:
        assert began <= stamp_ns <= time.time_ns()


def test_the_time_scale_changes_while_running_and_accepts_an_integer(tmp_path: Path) -> None:
    number = domain()
    with graph_client(number) as client, node("simulator", parameters(), environment(number), tmp_path / "log") as simulator:
        client.until(lambda: client.received[VIBRATION], "the first block")
        assert not client.set(time_scale=-1.0)[0]
        assert client.set(time_scale=0.5) == (True, "")
        client.until(lambda: client.status["time_scale"] == "0.5", "the new time scale in /diagnostics")
        assert client.set(time_scale=2) == (True, "")  # as of `ros2 param set /dcrb/simulator time_scale 2`
        client.until(lambda: client.status.get("time_scale") == "2", "the time scale in the status")
        assert not client.set(publishing__block_size=2.0)[0]
        assert simulator.end(signal.SIGINT) == 0, simulator.output


def test_a_command_takes_effect_within_two_blocks(tmp_path: Path) -> None:
    from std_msgs.msg import Float64
    from std_srvs.srv import Trigger

    number = domain()
    with graph_client(number) as client, node("simulator", parameters(), environment(number), tmp_path / "log"):
        speed = client.node.create_publisher(Float64, "command/speed", 10)
        client.until(lambda: client.received[VIBRATION], "the first block")
        client.connect(speed)
        pause(client)
        for count in (1, 2, 3):
            sent = indices(client)
            speed.publish(Float64(data=100.0 + count))
            speed.publish(Float64(data=float("nan")))  # its refusal shows that the command before it has arrived
            client.until(lambda n=count: client.status["rejected_commands"] == str(n), "the refusal of the second command")
            for _ in range(2):  # the block that was simulated before the pause, and the next one
                assert client.ask(Trigger, "step").success
            command = SpeedCommand(100.0 + count)
            client.until(lambda c=command: command_times(client, c), "the command in the ground truth")
            client.until(lambda known=sent: len(indices(client)) == len(known) + 2, "both blocks")
            end, latest = (nanoseconds(sent[-1] + 1024 * blocks, 51200) for blocks in (1, 2))
            (time_ns,) = command_times(client, command)
            assert end <= time_ns <= latest + LEAD_NS


def command_times(client: GraphClient, command: SpeedCommand) -> list[int]:
    """Return the times [ns] at which a command took effect according to the ground truth."""
    return [truth.time_ns for truth in map(decode_truth, client.received[GROUND_TRUTH]) if truth.event == command]
