"""The exam with detectors as real processes: the tutorial's, a bad one, and such as do not work."""

from __future__ import annotations

import json
import shlex
import sys
import time
from pathlib import Path
from typing import Any

import pytest
import yaml

pytest.importorskip("rclpy", reason="the nodes need ROS 2; everything else is tested without")

from own_process import dcrb

from dcrb_ros.messages.statuses import Status, encode_diagnostics
from dcrb_ros.nodes.examinee import Answers, Examinee

pytestmark = pytest.mark.node

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


def python(*words: str) -> str:
    return shlex.join([sys.executable, *words])


@pytest.fixture(scope="module")
def short(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    folder = tmp_path_factory.mktemp("exam")
    (folder / "short.yaml").write_text(yaml.safe_dump(SHORT), encoding="utf-8")
    return ["score", str(folder / "short.yaml"), "--recordings", str(folder / "kept"), "--workers", "1"]


def answers(capsys: pytest.CaptureFixture[str]) -> tuple[dict[str, Any], dict[str, str]]:
    about = json.loads(capsys.readouterr().out)
    return about, {found["name"]: found["answer"] for found in about["scenarios"]}


def test_the_tutorials_detector_passes_and_the_naive_one_fails(short: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert dcrb(*short, "--json", "--node", python(str(ROOT / "examples/my_detector.py"))) == 0
    about, found = answers(capsys)
    assert found == {"outer": "outer_ring", "twin": "healthy"}
    assert about["roc"]["area"] == 1.0
    assert dcrb(*short, "--json", "--node", python(str(ROOT / "examples/naive_detector.py"))) == 1
    about, found = answers(capsys)
    assert found == {"outer": "outer_ring", "twin": "outer_ring"}
    assert about["false_alarms"]["count"] >= 1
    assert [check["holds"] for check in about["checks"]] == [False, False, True]


def test_our_node_says_what_our_detector_says_in_process(capsys: pytest.CaptureFixture[str]) -> None:
    bag = str(ROOT / "bags/inner_ring_defect")
    found = []
    for how in (["--reference"], ["--node", python("-m", "dcrb_ros.nodes.fault_detector")]):
        assert dcrb("score", bag, "--json", "--workers", "1", *how) == 0
        mark = json.loads(capsys.readouterr().out)["scenarios"][0]
        found.append({key: mark[key] for key in ("answer", "delay", "score", "opinions")})
    assert found[0] == found[1]


SPEAKING = """
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from sensor_msgs.msg import PointCloud2
rclpy.init()
node = rclpy.create_node("examinee", namespace="dcrb")
publisher = node.create_publisher(DiagnosticArray, "diagnosis", 10)
def on_block(message):
    {}
node.create_subscription(PointCloud2, "outer_ring/vibration", on_block, 200)
rclpy.spin(node)
"""
WORDS = "publisher.publish(DiagnosticArray(status=[DiagnosticStatus(values=[KeyValue(key='verdict', value='broken')])]))"


@pytest.mark.parametrize(
    ("command", "sentence"),
    [
        (
            python("-c", "import sys; sys.exit('no such sensor')"),
            "it ended with status 1 before it listened; its last words:\n    no such sensor",
        ),
        (python("-c", "import time; time.sleep(60)"), "it did not subscribe to /dcrb/outer_ring/vibration within 2 s"),
        (python("-c", SPEAKING.format("pass")), "it published nothing on /dcrb/diagnosis"),
        (python("-c", SPEAKING.format("1 / 0")), "s of the signal; its last words:"),
        (
            python("-c", SPEAKING.format(WORDS)),
            "messages on diagnosis were not understood, the first because the verdict 'broken' is unknown: give one of",
        ),
    ],
    ids=["ended", "deaf", "mute", "dying", "babbling"],
)
def test_a_detector_that_does_not_work_is_told(command: str, sentence: str, capsys: pytest.CaptureFixture[str]) -> None:
    patience = "2" if "sleep" in command else "60"
    assert dcrb("score", str(ROOT / "bags/healthy"), "--node", command, "--patience", patience) == 1
    said = capsys.readouterr().err
    assert sentence in said
    assert "failed on the first scenario (healthy)" in said


def test_a_detector_that_cannot_be_started_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    for command, sentence in (("", "--node is empty"), ("'", "--node ''' is no command"), ("no-such-program", "cannot be started")):
        assert dcrb("score", str(ROOT / "bags/healthy"), "--node", command) == 2
        assert sentence in capsys.readouterr().err


def heard(*moments: tuple[float, float], pace: float = 1.0, begin: float = 0.0) -> Answers:
    """Return the answers to 10 s of signal sent at a pace, of stamps [s] that came at wall times [s] from its beginning on."""
    answers, ends = Answers(begin=begin), (0.02 * number for number in range(1, 501))
    events = sorted([(wall, "said", stamp) for stamp, wall in moments] + [(end / pace, "sent", begin + end) for end in ends])
    for wall, what, moment in events:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("dcrb_ros.nodes.examinee.time.monotonic", lambda wall=wall: wall)
            if what == "sent":
                answers.send(moment)
            else:
                answers.hear(encode_diagnostics(round(moment * 1e9), [Status("mine", 0, "", {"verdict": "healthy"})]))
    return answers


@pytest.mark.parametrize(
    ("moments", "pace", "given"),
    [
        ([(0.5, 0.6), (1.0, 1.1)], 1.0, [0.5, 1.0]),
        ([(0.5, 2.4), (1.0, 2.9), (1.5, 3.4)], 1.0, [0.5, 1.0, 1.5]),  # slow, but not by more than the exam waits at the end
        ([(2.5, 0.13), (5.0, 0.26)], 20.0, [2.5, 5.0]),  # fed as fast as it answers
        ([(4.5, 10.1), (5.0, 10.1), (9.5, 10.1)], 1.0, [10.0, 10.0, 9.5]),  # it had heard everything
        ([(9.5, 0.5), (4.5, 0.6)], 20.0, [9.5, 9.5]),  # it had judged what came after
    ],
)
def test_stamps_are_believed_that_come_in_time(moments: list[tuple[float, float]], pace: float, given: list[float]) -> None:
    answers = heard(*moments, pace=pace)
    assert not answers.refused
    assert [opinion.issued_at for opinion in answers.opinions] == pytest.approx(given)


def test_nobody_judges_what_has_not_been_sent() -> None:
    answers = heard((1.0, 1.1), (9.0, 2.01))
    assert len(answers.opinions) == 1
    assert "stamped 9.00 s when the signal had been sent up to 2.00 s" in answers.refused[0]


def test_the_period_counts_from_the_beginning_of_the_signal() -> None:
    answers = heard((7.5, 0.6), (8.0, 1.1), begin=7.0)
    assert (answers.latest, answers.period) == pytest.approx((8.0, 0.5))


HINDSIGHT = """
    global stamps
    stamps = [*globals().get("stamps", []), message.header.stamp]
    if len(stamps) == 140:
        for stamp in stamps[::25]:
            array = DiagnosticArray(status=[DiagnosticStatus(values=[KeyValue(key="verdict", value="outer_ring")])])
            array.header.stamp = stamp
            publisher.publish(array)
"""


def test_who_has_heard_everything_is_not_believed_to_have_known_at_once() -> None:
    answers = Examinee(python("-c", SPEAKING.format(HINDSIGHT.strip()))).examine(ROOT / "bags/outer_ring_defect")
    assert not answers.failure
    assert len(answers.opinions) == 6
    early = [opinion for opinion in answers.opinions if opinion.time < 1.0]
    assert len(early) == 2
    assert all(opinion.issued_at > 2.5 for opinion in early)


def test_a_rate_is_kept(capsys: pytest.CaptureFixture[str]) -> None:
    began = time.monotonic()
    answers = Examinee(python("-m", "dcrb_ros.nodes.fault_detector"), rate=0.5).examine(ROOT / "bags/outer_ring_defect")
    assert time.monotonic() - began > 5.5  # of three seconds
    assert not answers.failure
    assert answers.opinions[-1].verdict == "outer_ring"
