"""The exam of detectors that run as processes: the one of the tutorial, a poor one and several that fail."""

from __future__ import annotations

import ast
import json
import re
import shlex
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
import yaml

pytest.importorskip("rclpy", reason="the nodes need ROS 2; everything else is tested without")

from ros_bench import PATIENCE, environment
from same_process import dcrb
from waiting import runs, wait_for

from dcrb_ros.messages.bundle import Bundle
from dcrb_ros.messages.statuses import Status, encode_diagnostics
from dcrb_ros.nodes import detector_answers, external_detector
from dcrb_ros.nodes.detector_answers import Diagnoses
from dcrb_ros.nodes.external_detector import ExternalDetector
from dcrb_ros.nodes.pacing import Pacer
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.simulation.loop import Simulation

pytestmark = [pytest.mark.node, pytest.mark.slow]

ROOT = Path(__file__).parents[2]
SHORT = {
    "exam": "short",
    "duration": 4.3,
    "onset": 2.2,
    "criteria": {"delay": {"outer_ring": 2.1}},
    "scenarios": [
        {
            "name": "outer",
            "verdict": "outer_ring",
            "set": {"cage.joint": "revolute"},  # twice as fast to simulate
            "fault": {"faults.outer_1.width": 0.002},
        }
    ],
}


@pytest.fixture
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Wait long for diagnoses, as on a machine that is not busy: a late one would count as issued late, or be missed."""
    monkeypatch.setattr(detector_answers, "PROMPT", PATIENCE)
    monkeypatch.setattr(external_detector, "DIAGNOSIS_TIMEOUT", PATIENCE)


def python(*words: str) -> str:
    return shlex.join([sys.executable, *words])


@pytest.fixture(scope="module")
def short(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    folder = tmp_path_factory.mktemp("exam")
    (folder / "short.yaml").write_text(yaml.safe_dump(SHORT), encoding="utf-8")
    return ["score", str(folder / "short.yaml"), "--recordings", str(folder / "kept"), "--workers", "1"]


def report(capsys: pytest.CaptureFixture[str]) -> tuple[dict[str, Any], dict[str, str]]:
    document = json.loads(capsys.readouterr().out)
    return document, {scenario["name"]: scenario["answer"] for scenario in document["scenarios"]}


@pytest.mark.usefixtures("patient")
def test_the_detector_of_the_tutorial_passes_and_the_naive_one_fails(short: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert dcrb(*short, "--json", "--node", python(str(ROOT / "examples/my_detector.py"))) == 0
    document, found = report(capsys)
    assert found == {"outer": "outer_ring", "twin": "healthy"}
    assert document["roc"]["area"] == 1.0
    assert dcrb(*short, "--json", "--node", python(str(ROOT / "examples/naive_detector.py"))) == 1
    document, found = report(capsys)
    assert found == {"outer": "outer_ring", "twin": "outer_ring"}
    assert document["false_alarms"]["count"] >= 1
    assert [check["holds"] for check in document["checks"]] == [False, False, True]


@pytest.mark.usefixtures("patient")
def test_the_shipped_node_and_the_detector_in_this_process_give_the_same_diagnoses(capsys: pytest.CaptureFixture[str]) -> None:
    bag = str(ROOT / "bags/inner_ring_defect")
    found = []
    for options in (["--reference"], ["--node", python("-m", "dcrb_ros.nodes.fault_detector")]):
        assert dcrb("score", bag, "--json", "--workers", "1", *options) == 0
        scenario = json.loads(capsys.readouterr().out)["scenarios"][0]
        found.append({key: scenario[key] for key in ("answer", "delay", "score", "opinions")})
    assert found[0] == found[1]


SUBSCRIBER = """
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from sensor_msgs.msg import PointCloud2
rclpy.init()
node = rclpy.create_node("candidate", namespace="dcrb")
publisher = node.create_publisher(DiagnosticArray, "diagnosis", 10)
def on_block(message):
    {}
node.create_subscription(PointCloud2, "outer_ring/vibration", on_block, 200)
rclpy.spin(node)
"""
INVALID = "publisher.publish(DiagnosticArray(status=[DiagnosticStatus(values=[KeyValue(key='verdict', value='broken')])]))"


@pytest.mark.parametrize(
    ("command", "sentence"),
    [
        (
            python("-c", "import sys; sys.exit('no such sensor')"),
            "it ended with status 1 before it subscribed; its last output:\n    no such sensor",
        ),
        (python("-c", "class Detector: ..."), "it ended with status 0 before it subscribed; a class is given with --python FILE:CLASS"),
        (python("-c", "import time; time.sleep(60)"), "it did not subscribe to /dcrb/outer_ring/vibration within 2 s"),
        (python("-c", SUBSCRIBER.format("pass")), "it published nothing on /dcrb/diagnosis"),
        (python("-c", SUBSCRIBER.format("1 / 0")), "s of the signal; its last output:"),
        (
            python("-c", SUBSCRIBER.format(INVALID)),
            "messages on diagnosis are invalid, the first because the verdict 'broken' is unknown",
        ),
    ],
    ids=["ends", "is a class", "does not subscribe", "publishes nothing", "fails", "publishes an unknown verdict"],
)
def test_the_failure_of_a_detector_is_explained(command: str, sentence: str, capsys: pytest.CaptureFixture[str]) -> None:
    patience = "2" if "sleep" in command else "600"
    rate = ["--rate", "0.05"] if "1 / 0" in command else []  # its process takes some time to end, and the signal must not end before it
    assert dcrb("score", str(ROOT / "bags/healthy"), "--node", command, "--patience", patience, *rate) == 1
    said = capsys.readouterr().err
    assert sentence in said
    assert "failed on the first scenario (healthy)" in said


DAEMON = """
import subprocess, sys, time
child = subprocess.Popen(["sleep", "300"], start_new_session=True)
open(sys.argv[1], "w").write(str(child.pid))
time.sleep(300)
"""


@pytest.mark.parametrize("start", ["exec sleep 300", "trap '' INT; sleep 300; sleep 300"], ids=["ends on SIGINT", "ignores SIGINT"])
def test_no_detector_outlives_a_killed_exam(start: str, tmp_path: Path) -> None:
    pid = tmp_path / "pid"
    node = shlex.join(["sh", "-c", f"echo $$ > {shlex.quote(str(pid))}.new; mv {pid}.new {pid}; {start}"])
    command = [sys.executable, "-m", "dcrb_ros.cli.program", "score", str(ROOT / "bags/healthy"), "--node", node, "--patience", "300"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as exam:
        wait_for(pid.exists)
        detector = int(pid.read_text())
        assert runs(detector)
        exam.kill()
        exam.wait(60.0)
    wait_for(lambda: not runs(detector))


def test_a_process_in_a_session_of_its_own_ends_with_the_detector(tmp_path: Path) -> None:
    pid = tmp_path / "pid"
    node = shlex.join([sys.executable, "-c", DAEMON, str(pid)])
    assert dcrb("score", str(ROOT / "bags/healthy"), "--node", node, "--patience", "1") == 1
    wait_for(lambda: not runs(int(pid.read_text())))


def test_a_detector_that_cannot_be_started_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    sentences = {"": "--node is empty", "'": "--node ''' is not a valid command", "no-such-program": "cannot be started"}
    for command, sentence in sentences.items():
        assert dcrb("score", str(ROOT / "bags/healthy"), "--node", command) == 2
        assert sentence in capsys.readouterr().err


def diagnoses_of(*received: tuple[float, float], pace: float = 1.0, begin: float = 0.0, rate: float = 0.0) -> Diagnoses:
    """Return the diagnoses for 10 s of signal sent at a pace; each is given by its stamp [s] and the wall time since the start [s]."""
    diagnoses, ends = Diagnoses(begin=begin, rate=rate), (0.02 * number for number in range(1, 501))
    events = sorted([(wall, "received", stamp) for stamp, wall in received] + [(end / pace, "sent", begin + end) for end in ends])
    for wall, kind, moment in events:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("dcrb_ros.nodes.detector_answers.time.monotonic", lambda wall=wall: wall)
            if kind == "sent":
                diagnoses.signal_sent(moment)
            else:
                diagnoses.receive(encode_diagnostics(round(moment * 1e9), [Status("mine", 0, "", {"verdict": "healthy"})]))
    return diagnoses


@pytest.mark.parametrize(
    ("received", "pace", "issued"),
    [
        ([(0.5, 0.6), (1.0, 1.1)], 1.0, [0.5, 1.0]),
        ([(0.5, 2.4), (1.0, 2.9), (1.5, 3.4)], 1.0, [0.5, 1.0, 1.5]),  # slow, but within the time for which the exam waits at the end
        ([(2.5, 0.13), (5.0, 0.26)], 20.0, [2.5, 5.0]),  # sent as fast as it answers
        ([(4.5, 10.1), (5.0, 10.1), (9.5, 10.1)], 1.0, [10.0, 10.0, 9.5]),  # after the whole signal was received
        ([(9.5, 0.5), (8.5, 0.6)], 20.0, [9.5, 9.5]),  # after a diagnosis of later signal
    ],
)
def test_a_diagnosis_counts_as_issued_at_its_stamp_if_it_is_prompt(
    received: list[tuple[float, float]], pace: float, issued: list[float]
) -> None:
    diagnoses = diagnoses_of(*received, pace=pace)
    assert not diagnoses.refused
    assert [diagnosis.issued_at for diagnosis in diagnoses.received] == pytest.approx(issued)


def test_signal_that_was_sent_early_gives_no_more_hindsight_than_the_recorded_pace() -> None:
    """A node that publishes every 5 s of signal is sent the next 5 s within a moment."""
    diagnoses = diagnoses_of((1.0, 0.05), (3.0, 0.15), (3.0, 0.301), pace=20.0)
    assert [diagnosis.issued_at for diagnosis in diagnoses.received] == pytest.approx([1.0, 3.0, 6.0])
    diagnoses = diagnoses_of((1.0, 0.05), (3.0, 0.3), pace=20.0, rate=20.0)
    assert [diagnosis.issued_at for diagnosis in diagnoses.received] == pytest.approx([1.0, 3.0])


@pytest.mark.parametrize(("stamps", "ahead"), [([0.5, 1.0], 1.0), ([5.0], 2.0), ([5.0, 5.5], 2.0)])
def test_no_more_signal_is_sent_early_than_a_prompt_diagnosis_may_be_behind(stamps: list[float], ahead: float) -> None:
    node, answers = ExternalDetector("true"), Diagnoses()
    for stamp in stamps:
        answers.signal_sent(stamp)
        answers.receive(encode_diagnostics(round(stamp * 1e9), [Status("mine", 0, "", {"verdict": "healthy"})]))
    waited = []
    for after in (ahead - 0.01, ahead + 0.01):
        end = round((stamps[-1] + after) * 1e9)
        spun: list[float] = []
        node._wait(Bundle(end - 20_000_000, end, ()), Pacer(0.0, time.monotonic), answers, spun.append)
        waited.append(len(spun) > 1)
    assert waited == [False, True]


def test_a_stamp_later_than_the_signal_sent_is_refused() -> None:
    diagnoses = diagnoses_of((1.0, 1.1), (9.0, 2.01))
    assert len(diagnoses.received) == 1
    assert "stamped 9.00 s when the signal had been sent up to 2.00 s" in diagnoses.refused[0]


def test_the_period_counts_from_the_start_of_the_signal() -> None:
    diagnoses = diagnoses_of((7.5, 0.6), (8.0, 1.1), (7.8, 1.2), begin=7.0)
    assert (diagnoses.latest, diagnoses.period, diagnoses.valid) == pytest.approx((8.0, 0.5, 3))


HINDSIGHT = """
    global stamps
    stamps = [*globals().get("stamps", []), message.header.stamp]
    if len(stamps) == 140:
        for stamp in stamps[::25]:
            array = DiagnosticArray(status=[DiagnosticStatus(values=[KeyValue(key="verdict", value="outer_ring")])])
            array.header.stamp = stamp
            publisher.publish(array)
"""


def test_diagnoses_published_in_hindsight_count_as_issued_late(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(external_detector, "DIAGNOSIS_TIMEOUT", PATIENCE)
    detector = ExternalDetector(python("-c", SUBSCRIBER.format(HINDSIGHT.strip())))
    diagnoses = detector.diagnose(Recording(ROOT / "bags/outer_ring_defect"))
    assert not diagnoses.failure
    assert len(diagnoses.received) == 6
    early = [diagnosis for diagnosis in diagnoses.received if diagnosis.time < 1.0]
    assert len(early) == 2
    assert all(diagnosis.issued_at > 2.5 for diagnosis in early)


THERMOMETERS = """
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from sensor_msgs.msg import PointCloud2, Temperature
rclpy.init()
node = rclpy.create_node("candidate", namespace="dcrb")
publisher = node.create_publisher(DiagnosticArray, "diagnosis", 200)
read, blocks = {}, []
def on_temperature(place):
    def keep(message):
        read.setdefault(place, []).append(message)
        answer()
    node.create_subscription(Temperature, place + "/temperature", keep, 10)
def on_block(message):
    blocks.append(message)
    answer()
def answer():
    # Topics are not ordered among one another: the last block may come before the last reading.
    while blocks and all(len(read.get(place, [])) >= {READINGS} for place in PLACES):
        publish(blocks.pop(0))
def publish(message):
    topics = sorted(name for name, _ in node.get_topic_names_and_types() if name.startswith("/dcrb/"))
    said = {"verdict": "overheating", "reason": repr([[one.temperature for one in read.get(place, [])] for place in PLACES] + [topics])}
    array = DiagnosticArray(status=[DiagnosticStatus(values=[KeyValue(key=key, value=value) for key, value in said.items()])])
    array.header.stamp = message.header.stamp
    publisher.publish(array)
PLACES = ("outer_ring", "box", "ambient")
for place in PLACES:
    on_temperature(place)
node.create_subscription(PointCloud2, "outer_ring/vibration", on_block, 200)
rclpy.spin(node)
"""


@pytest.mark.usefixtures("patient")
def test_a_detector_reads_the_thermometers_of_a_bench_that_has_them_and_not_the_truth(tmp_path: Path) -> None:
    configuration = load_configuration("healthy", {"thermal.law": "network", "cage.joint": "revolute"})
    simulation = Simulation(configuration)
    with Recorder(tmp_path / "bag", configuration, simulation.bodies) as recorder:
        for block in simulation.blocks(1.2):
            recorder.write(block)
    # The topics of the exam, and those to which the detector itself subscribes.
    topics = [
        "diagnosis",
        "outer_ring/sensor",
        "outer_ring/vibration",
        *(f"{place}/temperature" for place in ("outer_ring", "box", "ambient")),
    ]
    readings = Recording(tmp_path / "bag").temperatures()
    assert len(readings) == 2
    for bag, expected in (
        (tmp_path / "bag", [readings.outer_ring.tolist(), readings.box.tolist(), readings.ambient.tolist()]),
        (ROOT / "bags/healthy", [[], [], []]),
    ):
        candidate = python("-c", THERMOMETERS.replace("{READINGS}", str(len(expected[0]))))
        found = ExternalDetector(candidate, patience=PATIENCE).diagnose(Recording(bag))
        assert not found.failure
        *read, seen = ast.literal_eval(found.received[-1].reason)
        assert read == expected
        assert sorted(seen) == sorted(f"/dcrb/{topic}" for topic in topics)


PUBLISHER = """
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import PointCloud2
rclpy.init()
node = rclpy.create_node("examiner", namespace="dcrb")
node.create_publisher({}, "{}", 10)
print("publishes", flush=True)
rclpy.spin(node)
"""


@pytest.mark.parametrize(("kind", "topic"), [("PointCloud2", "outer_ring/vibration"), ("DiagnosticArray", "diagnosis")])
def test_a_domain_with_another_publisher_is_left(kind: str, topic: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(external_detector, "LISTENING_TIME", 5.0)  # a busy machine discovers late
    detector = ExternalDetector(python("-c", "pass"))
    used, command = detector.domain, [sys.executable, "-c", PUBLISHER.format(kind, topic)]
    with subprocess.Popen(command, env=environment(used), stdout=subprocess.PIPE) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == b"publishes\n"
        try:
            assert "it ended with status 0 before it subscribed" in detector.diagnose(Recording(ROOT / "bags/outer_ring_defect")).failure
            assert detector.domain != used
            monkeypatch.setattr(external_detector, "MOST_DOMAINS", 1)
            detector._reservations.pop()
            found = detector.diagnose(Recording(ROOT / "bags/outer_ring_defect"))
            assert found.received == []
            assert re.match(rf"ROS domain {used} of the exam is used by .*publishes on /dcrb/{topic}.*was not started", found.failure)
        finally:
            other.kill()


def test_a_publisher_that_appears_during_the_run_fails_its_scenario() -> None:
    """The detector starts it, as a second exam would appear."""
    healthy = "[DiagnosticStatus(values=[KeyValue(key='verdict', value='healthy')])]"
    answer = f"publisher.publish(DiagnosticArray(header=message.header, status={healthy}))"
    intruder = "'other' in globals() or globals().update(other=node.create_publisher(PointCloud2, 'outer_ring/vibration', 10))"
    detector = ExternalDetector(python("-c", SUBSCRIBER.format(f"{answer}; {intruder}")), patience=PATIENCE)
    found = detector.diagnose(Recording(ROOT / "bags/outer_ring_defect"))
    assert (found.refused, found.received) == ([], [])
    assert f"ROS domain {detector.domain} of the exam is used by another program: /dcrb/candidate also publishes on" in found.failure


def test_a_node_that_prints_without_end_fails_its_scenario(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(external_detector, "MOST_OUTPUT", 1 << 20)
    detector = ExternalDetector(python("-c", "while True: print('x' * 1000)"), patience=PATIENCE)
    failure = detector.diagnose(Recording(ROOT / "bags/outer_ring_defect")).failure
    assert "it ended with status -9 before it subscribed; it printed more than 1 MiB; its last output:" in failure


@pytest.mark.usefixtures("patient")
def test_a_rate_is_kept(capsys: pytest.CaptureFixture[str]) -> None:
    began = time.monotonic()
    diagnoses = ExternalDetector(python("-m", "dcrb_ros.nodes.fault_detector"), rate=0.5).diagnose(
        Recording(ROOT / "bags/outer_ring_defect")
    )
    assert time.monotonic() - began > 5.5  # of three seconds
    assert not diagnoses.failure
    assert diagnoses.received[-1].verdict == "outer_ring"
