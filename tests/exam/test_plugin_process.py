"""Detectors in a process of their own: whatever they do ends their scenario only, and the truth is not in reach."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from made_up_blocks import recorded
from separate_process import dcrb
from waiting import PATIENCE, runs, wait_for

from dcrb_ros.exam import plugin_process
from dcrb_ros.exam.detector_run import PythonDetector
from dcrb_ros.exam.limits import Limits
from dcrb_ros.exam.plugin import load_plugin
from dcrb_ros.exam.plugin_process import MIB, MOST_OUTPUT, DetectorProcess, ProcessDetector
from dcrb_ros.messages.received_diagnosis import ReceivedDiagnosis
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.runtime import child_output
from dcrb_ros.schema.refusal import Refusal

SOURCE = """
import gc, os, signal, sys, threading, time

class Well:
    calls = 0

    def __init__(self, orders, rate):
        self.blocks = 0

    def update(self, index, acceleration, shaft_angle):
        self.blocks += 1
        print("block", self.blocks)
        if self.blocks == 3:
            self.misbehave()
        return "healthy"

    def misbehave(self):
        pass

class Exit(Well):
    def misbehave(self):
        sys.exit(0)

class OsExit(Well):
    def misbehave(self):
        os._exit(0)

class Killed(Well):
    def misbehave(self):
        os.kill(os.getpid(), signal.SIGSEGV)

class Group(Well):
    def misbehave(self):
        os.killpg(0, signal.SIGKILL)

class Asleep(Well):
    def misbehave(self):
        time.sleep(1e3)

class Busy(Well):
    def misbehave(self):
        signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())
        while True:
            pass

class Stopped(Well):
    def misbehave(self):
        os.kill(os.getpid(), signal.SIGSTOP)

class Endless(Well):
    def misbehave(self):
        threading.Thread(target=time.sleep, args=(1e3,), name="endless").start()

class Loud(Well):
    def misbehave(self):
        while True:
            print("x" * 100_000)

class Large(Well):
    def misbehave(self):
        self.large = [bytearray(64 << 20) for _ in range(1000)]

class Wrong(Well):
    def misbehave(self):
        raise ValueError("\\x1b[2Jwrong")

class Invalid(Well):
    def update(self, index, acceleration, shaft_angle):
        from dcrb_ros import Diagnosis
        return super().update(index, acceleration, shaft_angle) if self.blocks < 2 else Diagnosis(index, "now", "healthy", "block 3")

class Future(Well):
    def update(self, index, acceleration, shaft_angle):
        from dcrb_ros import Diagnosis
        time = 4.0 if self.blocks == 2 else (index + len(shaft_angle)) / 51200
        super().update(index, acceleration, shaft_angle)
        return Diagnosis(index, time, "cage", "")

class Scored(Well):
    def update(self, index, acceleration, shaft_angle):
        from dcrb_ros import Diagnosis
        verdict = super().update(index, acceleration, shaft_angle)
        score = float("nan" if self.blocks == 3 else self.blocks)
        return Diagnosis(index, index / 51200, verdict, "", scores={"outer_ring": 1.0, "cage": score})

class Hindsight(Well):
    def update(self, index, acceleration, shaft_angle):
        from dcrb_ros import Diagnosis
        return Diagnosis(index, 0.01, super().update(index, acceleration, shaft_angle), "")

class Wordy(Well):
    def misbehave(self):
        raise ValueError("word " * (20 << 20))

class Made(Well):
    def __init__(self, orders, rate):
        sys.exit("not made")

class Closing(Well):
    def misbehave(self):
        os.closerange(3, 100)

class Background(Well):
    def misbehave(self):
        threading.Thread(target=time.sleep, args=(1e3,), daemon=True).start()

class Spy(Well):
    def misbehave(self):
        kinds = {type(thing).__name__ for thing in gc.get_objects()}
        kinds &= {"Expectation", "Case", "Scenario", "ScenarioSet", "Exam", "Recording", "RecordedCase", "Piece"}
        frame, texts = sys._getframe(), []
        while frame is not None:
            texts += [f"{name} = {value!r:.200}" for name, value in frame.f_locals.items() if name != "texts"]
            frame = frame.f_back
        texts += sys.argv + list(os.environ.values()) + open("/proc/self/cmdline").read().split("\\0")
        texts += [os.readlink(f"/proc/self/fd/{name}") for name in os.listdir("/proc/self/fd") if os.path.exists(f"/proc/self/fd/{name}")]
        telling = [text for text in texts if "telling" in text]
        raise ValueError(f"{sorted(kinds)} {telling}")
"""
BLOCKS = 5


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded(tmp_path_factory.mktemp("bags") / "telling_name", BLOCKS)


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("detector") / "bad_detectors.py"
    file.write_text(SOURCE, encoding="utf-8")
    return file


def close_processes() -> None:
    for process in plugin_process._PROCESSES.values():
        process.close()
    plugin_process._PROCESSES.clear()


@pytest.fixture(autouse=True)
def only_processes_of_this_test(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setattr(child_output, "PATIENCE", PATIENCE)  # the rest of an output is read later on a busy machine
    close_processes()  # those of tests in other files
    yield
    close_processes()


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("Exit", "update failed at sample 2048: SystemExit: 0"),
        ("OsExit", "its process ended with exit status 0 at 0.04 s of the signal"),
        ("Killed", "its process was ended by SIGSEGV at 0.04 s"),
        ("Group", "its process was ended by SIGKILL at 0.04 s"),
        ("Asleep", "a block took longer than 4 s at 0.04 s of the signal (--block-limit)"),
        pytest.param("Busy", "a block took longer than 4 s at 0.04 s", marks=pytest.mark.slow),
        pytest.param("Stopped", "a block took longer than 4 s at 0.04 s", marks=pytest.mark.slow),
        ("Endless", "1 threads still run 2 s after the last block (endless)"),
        ("Loud", "it printed more than 16 MiB at 0.04 s"),
        ("Large", "update failed at sample 2048: MemoryError; it may use 1024 MiB (--memory-limit)"),
        ("Wrong", "update failed at sample 2048: ValueError: \\x1b[2Jwrong"),
        ("Invalid", "update returned a diagnosis with an invalid value: "),
        ("Future", "update returned a diagnosis stamped 4.000 s after 0.060 s of the signal: give the time"),
        ("Scored", "a diagnosis has score = 'nan': it must be a finite number"),
        ("Wordy", "update failed at sample 2048: ValueError: word word"),
        ("Made", "its class failed: SystemExit: not made"),
        ("Closing", "at 0.04 s of the signal"),
    ],
)
def test_whatever_a_detector_does_fails_its_scenario_with_the_cause(
    name: str, sentence: str, source: Path, bag: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    limits = Limits(block=4.0 if "--block" in sentence or "a block" in sentence else 30.0, scenario=100.0, memory=1024)
    candidate = ProcessDetector(name, f"{source}:{name}", limits)
    outcome = candidate.diagnose(Recording(bag))
    assert sentence in outcome.failure
    assert len(outcome.received) == (0 if name == "Made" else BLOCKS if name == "Endless" else 2)
    assert "\x1b" not in outcome.failure
    if name not in ("Made", "Loud", "Invalid"):
        assert "its last output:\n    block 1\n    block 2\n    block 3" in outcome.failure
    assert len(outcome.failure) < (3000 if name == "Wordy" else 1000)
    assert capfd.readouterr() == ("", "")
    assert not plugin_process._PROCESSES


def test_a_diagnosis_of_former_blocks_counts_as_issued_with_the_present_one(source: Path, bag: Path) -> None:
    factory = load_plugin(f"{source}:Hindsight")
    there, here = ProcessDetector("there", f"{source}:Hindsight"), PythonDetector("here", factory)
    for candidate in (there, here):
        received = candidate.diagnose(Recording(bag)).received
        assert [diagnosis.time for diagnosis in received] == [0.01] * BLOCKS
        assert [diagnosis.signal_received for diagnosis in received] == [None, *((1024 * k - 1) / 51200 for k in range(2, BLOCKS + 1))]


def test_a_process_is_reused_with_a_new_detector_and_gives_the_same_diagnoses(source: Path, bag: Path) -> None:
    candidate = ProcessDetector("well", f"{source}:Well")
    wanted = [ReceivedDiagnosis((1024 * k - 1) / 51200, "healthy") for k in range(1, BLOCKS + 1)]
    processes = []
    for _ in range(2):
        assert candidate.diagnose(Recording(bag)).received == wanted
        (process,) = plugin_process._PROCESSES.values()
        processes.append(process)
    assert processes[0] is processes[1]
    wrong = ProcessDetector("wrong", f"{source}:Wrong")
    assert wrong.diagnose(Recording(bag)).failure
    assert wrong.diagnose(Recording(bag)).failure  # in another process


def test_a_process_with_a_thread_in_the_background_is_not_reused(source: Path, bag: Path) -> None:
    outcome = ProcessDetector("background", f"{source}:Background").diagnose(Recording(bag))
    assert (len(outcome.received), outcome.failure) == (BLOCKS, "")
    assert all(process.closed for process in plugin_process._PROCESSES.values())


def test_neither_the_truth_nor_the_name_of_the_scenario_is_in_the_process(source: Path, bag: Path) -> None:
    assert "ValueError: [] []" in ProcessDetector("spy", f"{source}:Spy").diagnose(Recording(bag)).failure


def test_the_shipped_detector_gives_the_same_diagnoses_in_both_processes(tmp_path: Path) -> None:
    recording = Recording(recorded(tmp_path / "bag", 150))
    here = PythonDetector("here", load_plugin("dcrb_ros:FaultDetector")).diagnose(recording)
    there = ProcessDetector("there", "dcrb_ros:FaultDetector").diagnose(recording)
    assert there.received == here.received != []
    assert (there.failure, here.failure) == ("", "")


def test_a_scenario_has_a_limit_beyond_its_recorded_time(source: Path, bag: Path) -> None:
    process = DetectorProcess(f"{source}:Asleep", Limits())
    process._limits = Limits(block=50.0, scenario=1.0)
    assert "the scenario took 1 s longer than its recorded time (--scenario-limit)" in process.diagnose(Recording(bag)).failure


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("import sys; sys.exit(0)", "cannot be imported: SystemExit: 0"),
        ("import os; os._exit(0)", "its process ended with exit status 0 while it was imported"),
        ("print('no\\nlicence', flush=True); import os; os._exit(1)", "while it was imported; its last output is 'licence'"),
        ("raise KeyboardInterrupt", "cannot be imported: KeyboardInterrupt"),
        ("raise MemoryError", "cannot be imported: MemoryError"),
        pytest.param("while True: pass", "its import took longer than 4 s (--scenario-limit)", marks=pytest.mark.slow),
    ],
)
def test_an_import_that_ends_or_hangs_is_refused(text: str, sentence: str, tmp_path: Path) -> None:
    (tmp_path / "ends.py").write_text(text, encoding="utf-8")
    limits = Limits(scenario=4.0 if "limit" in sentence else 100.0)
    with pytest.raises(Refusal) as refused:
        DetectorProcess(f"{tmp_path / 'ends.py'}:Detector", limits)
    assert sentence in str(refused.value)
    assert str(refused.value).startswith("--python ")


def test_an_import_that_is_interrupted_ends_the_process(source: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    started: list[int] = []

    def interrupted(process: DetectorProcess, *_: object) -> None:
        started.append(process._process.pid)
        raise KeyboardInterrupt

    monkeypatch.setattr(DetectorProcess, "_answered", interrupted)
    with pytest.raises(KeyboardInterrupt) as kept:  # the exception keeps the guard of the process from being collected
        DetectorProcess(f"{source}:Well", Limits())
    assert not runs(started[0])
    del kept


def test_a_detector_that_ends_its_process_fails_one_scenario_and_the_others_are_scored(tmp_path: Path) -> None:
    (tmp_path / "ends.py").write_text(
        "import os, sys\n"
        "class Ends:\n"
        "    def __init__(self, orders, rate):\n"
        "        print('{made}')\n"
        "    def update(self, index, acceleration, shaft_angle):\n"
        "        print('{', file=sys.stderr)\n"
        "        return os._exit(0) if index >= 4 * 1024 else 'healthy'\n",
        encoding="utf-8",
    )
    bags = [recorded(tmp_path / name, count) for name, count in (("long", 8), ("short", 4), ("longer", 9))]
    done = dcrb("score", *map(str, bags), "--python", f"{tmp_path / 'ends.py'}:Ends", "--json", "--workers", "1", "--quiet")
    assert done.returncode == 1, done.stderr
    scenarios = {scenario["name"]: scenario for scenario in json.loads(done.stdout)["scenarios"]}
    ended = "its process ended with exit status 0"
    assert {name: scenario["flaw"].startswith(ended) for name, scenario in scenarios.items()} == {
        "long": True,
        "short": False,
        "longer": True,
    }
    assert scenarios["short"]["passed"]


def test_a_detector_that_ends_before_any_diagnosis_still_gives_a_report(tmp_path: Path, source: Path) -> None:
    bag = recorded(tmp_path / "bag", 2)
    done = dcrb("score", str(bag), "--python", f"{source}:Made", "--json", "--workers", "1", "--quiet")
    assert done.returncode == 1
    (scenario,) = json.loads(done.stdout)["scenarios"]
    assert scenario["flaw"].startswith("its class failed: SystemExit")


def test_a_detector_in_this_process_that_exits_is_an_error_with_its_sample(source: Path, bag: Path) -> None:
    with pytest.raises(RuntimeError, match="update failed at sample 2048: SystemExit: 0"):
        PythonDetector("exit", load_plugin(f"{source}:Exit")).diagnose(Recording(bag))


def test_the_children_of_a_detector_end_with_it(source: Path, bag: Path, tmp_path: Path) -> None:
    file, noted = tmp_path / "parents.py", tmp_path / "pid"
    file.write_text(
        f"import subprocess\nclass Parent:\n    def __init__(self, orders, rate):\n"
        f"        open({str(noted)!r}, 'w').write(str(subprocess.Popen(['sleep', '1000']).pid))\n"
        "    def update(self, *_):\n        raise ValueError\n",
        encoding="utf-8",
    )
    assert ProcessDetector("parent", f"{file}:Parent").diagnose(Recording(bag)).failure
    wait_for(lambda: not runs(int(noted.read_text())))  # a killed process is gone some moments later
    assert int(noted.read_text()) != os.getpid()


@pytest.mark.parametrize("last", ["raise ValueError", "return 'healthy'"])
def test_a_process_in_a_session_of_its_own_ends_with_the_exam(last: str, tmp_path: Path) -> None:
    file, noted = tmp_path / "daemon.py", tmp_path / "pid"
    file.write_text(
        f"import subprocess\nclass Daemon:\n    def __init__(self, orders, rate):\n"
        f"        child = subprocess.Popen(['sleep', '1000'], start_new_session=True)\n"
        f"        open({str(noted)!r}, 'w').write(str(child.pid))\n"
        f"    def update(self, *_):\n        {last}\n",
        encoding="utf-8",
    )
    bag = recorded(tmp_path / "bag", 2)
    done = dcrb("score", str(bag), "--python", f"{file}:Daemon", "--json", "--workers", "1", "--quiet")
    assert json.loads(done.stdout)["scenarios"][0]["answer"] == ("nothing" if "raise" in last else "healthy")
    wait_for(lambda: not runs(int(noted.read_text())))


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--block-limit", "0"], "--block-limit 0.0 s is outside 0 .. 3600 s"),
        (["--scenario-limit", "nan"], "--scenario-limit nan s is outside"),
        (["--memory-limit", "1"], "--memory-limit 1 MiB is outside 256"),
    ],
)
def test_limits_outside_their_range_are_refused(options: list[str], sentence: str) -> None:
    done = dcrb("score", "smoke", "--python", "dcrb_ros:FaultDetector", *options)
    assert done.returncode == 2
    assert sentence in done.stderr


def test_the_output_limit_is_said_in_whole_mebibytes() -> None:
    assert MOST_OUTPUT % MIB == 0
