"""How well an exam predicts the field: marks, intervals, ceilings, families, and answers that are kept."""

from __future__ import annotations

import json
import math
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from attacked_files import ATTACKS
from full_disk import files_of_at_most
from same_process import dcrb
from waiting import runs, wait_for

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.exam import predictivity_marks, predictivity_report
from dcrb_ros.exam.detector_families import families_of, shipped_members
from dcrb_ros.exam.evaluation import no_progress
from dcrb_ros.exam.exam_file import ReplicaOrigin, read_exam
from dcrb_ros.exam.leaderboard_entry import Entry, read_entry
from dcrb_ros.exam.limits import Limits
from dcrb_ros.exam.marking import VerdictMarking
from dcrb_ros.exam.measured import led_scenarios, read_measured, whole_scenarios
from dcrb_ros.exam.plugin import load_plugin
from dcrb_ros.exam.predictivity import SPLITS, Compared, Marks, drawn_bearings, drawn_families, halves, predictivities, scopes
from dcrb_ros.exam.predictivity_marks import answers_of, run_member
from dcrb_ros.exam.predictivity_report import Comparison, as_json, cell, compare_entries, markdown
from dcrb_ros.exam.predictivity_task import measured_tasks
from dcrb_ros.exam.statistics import class_mean
from dcrb_ros.exam.verification import differences
from dcrb_ros.schema.refusal import Refusal

pytestmark = pytest.mark.slow

ORDERS = Orders(0.4, 3.6, 5.4, 2.4)
CLASSES = ("healthy", "outer_ring", "inner_ring")


def recordings(count: int = 36) -> tuple[Compared, ...]:
    """Return recordings of two machines, two of each bearing; the second machine has no healthy reference."""
    return tuple(Compared(f"r{k}", f"m{k % 2}", CLASSES[k // 2 % 3], f"b{k // 12}", k % 2 == 0) for k in range(count))


def marks(families: int = 8, members: int = 2, noise: float = 0.0) -> Marks:
    """Return marks of detectors of different skill; ``noise`` exchanges marks of the exam by chance."""
    random, compared = np.random.default_rng(4), recordings()
    skill = np.repeat(np.linspace(0.1, 0.95, families), members)
    field = (np.linspace(0.02, 0.98, len(compared))[random.permutation(len(compared))] < skill[:, None]).astype(float)
    exam = np.where(random.uniform(size=field.shape) < noise, random.integers(0, 2, field.shape), field)
    count = families * members
    return Marks(
        tuple(f"d{k}" for k in range(count)),
        tuple(f"f{k // members}" for k in range(count)),
        tuple(k % members == 0 for k in range(count)),
        compared,
        field,
        exam,
    )


def test_an_exam_with_the_marks_of_the_field_predicts_it() -> None:
    whole = next(iter(predictivities(marks())))
    assert whole.scope == "all"
    assert [whole.statistics[name].value for name in ("srcc", "rho", "tau_b", "mmrv")] == pytest.approx([1.0, 1.0, 1.0, 0.0])
    assert whole.statistics["tau_b"].ceiling.value < 1.0
    assert whole.statistics["tau_b"].bearings.low == pytest.approx(1.0)


def test_a_noisy_exam_predicts_less_and_has_wide_intervals() -> None:
    noisy = next(iter(predictivities(marks(noise=0.9)))).statistics["tau_b"]
    assert noisy.value < 0.8
    assert noisy.bearings.high - noisy.bearings.low > 0.1
    assert noisy.families.low <= noisy.value <= noisy.families.high


def test_families_are_drawn_with_all_of_their_members() -> None:
    families = ("a", "b", "b", "b", "c")
    for sample in drawn_families(families)[:100]:
        times = np.bincount(sample, minlength=5)
        assert times[1] == times[2] == times[3]
        assert times[0] + times[1] + times[4] == 3


def test_recordings_of_one_bearing_are_drawn_together() -> None:
    compared = recordings()
    weights = drawn_bearings(compared)
    for k, first in enumerate(compared):
        for j, second in enumerate(compared):
            if first[1:4] == second[1:4]:
                assert (weights[k] == weights[j]).all()
    for machine in ("m0", "m1"):
        for truth in CLASSES:
            members = [k for k, one in enumerate(compared) if (one.machine, one.truth) == (machine, truth)]
            assert (weights[members].sum(axis=0) == len(members)).all()
    first_half, second_half = halves(compared)
    assert (first_half + second_half == 1.0).all()
    assert 0.3 < first_half.mean() < 0.7
    for k, first in enumerate(compared):
        same = [j for j, second in enumerate(compared) if first[1:4] == second[1:4]]
        assert (first_half[same] == first_half[k]).all()


def test_a_class_that_one_half_lacks_counts_in_neither() -> None:
    """A single healthy bearing is in one half only, which would have another task than the other half."""
    names = [("calm", "healthy")] + [(f"{truth}_{k}", truth) for truth in CLASSES[1:] for k in range(8)]
    compared = [Compared(name, "m", truth, name, led=True) for name, truth in names]
    first, second = halves(compared)
    assert first.shape == second.shape == (17, SPLITS)
    assert not first[0].any()
    assert not second[0].any()
    assert (first[1:] + second[1:] == 1.0).all()
    perfect = np.repeat(np.linspace(0.0, 1.0, 9)[:, None] > np.linspace(0.05, 0.95, 8), 2, axis=1).astype(float)
    field = np.column_stack([np.arange(9) % 2, perfect])
    made = Marks(tuple("abcdefghi"), tuple("abcdefghi"), (True,) * 9, tuple(compared), field, field)
    by_scope = {one.scope: one.statistics["tau_b"].ceiling for one in predictivities(made)}
    assert by_scope["all"].value > 0.7
    assert math.isnan(by_scope["class healthy"].value)
    assert cell(predictivities(made)[-3], "tau_b").endswith(", –")


@pytest.mark.parametrize(("count", "bearing"), [(1, "one"), (2, "own"), (5, "own"), (5, "one")])
def test_as_many_bearings_are_drawn_as_there_are(count: int, bearing: str) -> None:
    """The variance of the mean is (n - 1)/n of the unbiased one; recordings of a single bearing are drawn themselves."""
    compared = [Compared(f"r{k}", "m", "healthy", f"b{k}" if bearing == "own" else "b", led=True) for k in range(count)]
    weights, values = drawn_bearings(compared), np.arange(float(count))
    assert (weights.sum(axis=0) == count).all()
    unbiased = float(np.var(values, ddof=1)) / count if count > 1 else 0.0
    assert np.var(values @ weights / count) == pytest.approx(unbiased * (count - 1) / count, rel=0.15)


def test_marks_are_the_mean_over_the_classes() -> None:
    mean = class_mean(np.array([[1.0, 0.0, 0.0, 1.0]]), ("a", "a", "a", "b"), np.array([[1.0, 1.0], [1.0, 0.0], [1.0, 0.0], [1.0, 0.0]]))
    assert mean[0] == pytest.approx([(1.0 / 3.0 + 1.0) / 2.0, 1.0])


def test_scopes_are_all_machines_and_classes() -> None:
    names = [name for name, _ in scopes(recordings())]
    assert names == ["all", "machines with a healthy reference", "m0", "m1", "class healthy", "class inner_ring", "class outer_ring"]


def test_representatives_are_those_with_published_settings() -> None:
    assert marks().representatives.detectors == tuple(f"d{k}" for k in range(0, 16, 2))
    with pytest.raises(Refusal, match="2 families of detectors are left"):
        predictivities(marks(families=2))


def folder_of_detectors(folder: Path) -> Path:
    folder.mkdir()
    (folder / "shared_code.py").write_text("ANSWER = 'healthy'\n")
    (folder / "abstract_one.py").write_text(
        "from abc import ABC, abstractmethod\n"
        "class Base(ABC):\n    @abstractmethod\n    def features(self): pass\n    def update(self, *block): pass\n"
    )
    (folder / "calm.py").write_text(
        "from pathlib import Path\nfrom shared_code import ANSWER\n"
        "VARIANTS = {'published': {}, 'other': {'answer': 'outer_ring'}}\n"
        "class Calm:\n"
        "    def __init__(self, orders, rate, answer=ANSWER):\n"
        "        self.answer = answer\n"
        "        with Path(__file__).with_suffix('.runs').open('a') as stream: stream.write('.')\n"
        "    def update(self, *block): return self.answer\n"
    )
    (folder / "failing.py").write_text(
        "class Failing:\n    def __init__(self, orders, rate): pass\n    def update(self, *block): raise ValueError('no such filter')\n"
    )
    (folder / "broken.py").write_text("raise RuntimeError('not today')\n")
    return folder


def test_families_are_files_with_a_complete_detector(tmp_path: Path) -> None:
    members, broken = families_of(folder_of_detectors(tmp_path / "detectors"))
    assert [(one.name, one.family, one.published) for one in members] == [
        ("published", "calm", True),
        ("other", "calm", False),
        ("failing", "failing", True),
    ]
    assert [one.name for one in broken] == ["broken"]
    assert "not today" in broken[0].reason
    made = load_plugin(members[1].given)(ORDERS, 12000)
    assert made.update(0, np.zeros((1, 2)), np.zeros(1)) == "outer_ring"
    with pytest.raises(Refusal, match="no member 'loud'"):
        load_plugin(f"{tmp_path / 'detectors' / 'calm.py'}:Calm[loud]")
    with pytest.raises(Refusal, match="there is no folder"):
        families_of(tmp_path / "none")
    (tmp_path / "empty").mkdir()
    with pytest.raises(Refusal, match="has no detector: give files"):
        families_of(tmp_path / "empty")
    (tmp_path / "empty" / "alone.py").write_text("import helper_elsewhere\n")
    with pytest.raises(Refusal, match=r"no detector that can be used: \S*alone.py cannot be imported: .*'helper_elsewhere'"):
        families_of(tmp_path / "empty")


def test_a_changed_file_in_a_subfolder_is_another_detector(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "detectors"
    (folder / "weights").mkdir(parents=True)
    (folder / "one.py").write_text(FAMILY)
    (folder / "weights" / "first.bin").write_bytes(b"1")
    digests = {families_of(folder)[0][0].digest}
    (folder / "weights" / "first.bin").write_bytes(b"2")
    digests.add(families_of(folder)[0][0].digest)
    (folder / "weights" / "first.bin").rename(folder / "weights" / "second.bin")
    digests.add(families_of(folder)[0][0].digest)
    assert len(digests) == 3
    (folder / ".git").mkdir()
    (folder / ".git" / "index").write_bytes(b"3")
    assert families_of(folder)[0][0].digest in digests
    usual = Path.open

    def denied(path: Path, *given: Any) -> Any:
        if path.name == "second.bin":
            raise PermissionError(13, "Permission denied")
        return usual(path, *given)

    monkeypatch.setattr(Path, "open", denied)
    with pytest.raises(Refusal, match=r"second.bin cannot be read \(Permission denied\): make it readable, or move it out of"):
        families_of(folder)


FAMILY = "class Detector:\n    def __init__(self, orders, rate): pass\n    def update(self, *block): return 'healthy'\n"
IMPORTS = {
    "exits": ("import os; os._exit(7)", "its process ended with exit status 7 while it was imported"),
    "interrupted": ("raise KeyboardInterrupt", "cannot be imported: KeyboardInterrupt"),
    "asking": ("input()", "cannot be imported: EOFError"),
    "large": ("memory = bytearray(8 << 30)", "cannot be imported: MemoryError"),
    "loud": ("while True: print('x' * 100_000)", "it printed more than 16 MiB while it was imported"),
    "listed": ("VARIANTS = ['fast']", "VARIANTS is ['fast']: give a mapping from the name of each member"),
    "numbered": ("VARIANTS = {'fast': 3}", "VARIANTS is {'fast': 3}: give a mapping"),
}


@pytest.mark.parametrize("name", IMPORTS)
def test_a_family_that_cannot_be_imported_is_left_out_with_the_reason(name: str, tmp_path: Path) -> None:
    source, reason = IMPORTS[name]
    (tmp_path / f"{name}.py").write_text(f"{source}\n{FAMILY}")
    (tmp_path / "sound.py").write_text(FAMILY)
    members, (broken,) = families_of(tmp_path)
    assert [one.name for one in members] == ["sound"]
    assert broken.name == name
    assert reason in broken.reason
    assert broken.reason.startswith(f"{tmp_path / name}.py")


def test_what_a_family_starts_or_prints_at_its_import_does_not_hinder_it(tmp_path: Path) -> None:
    noted = tmp_path / "process"
    start = f"import atexit, subprocess\nopen({str(noted)!r}, 'w').write(str(subprocess.Popen(['sleep', '1000']).pid))\n"
    (tmp_path / "starting.py").write_text(f"{start}atexit.register(print, '\\nbye')\n{FAMILY}")
    members, broken = families_of(tmp_path)
    assert [one.name for one in members] == ["starting"]
    assert not broken
    wait_for(lambda: not runs(int(noted.read_text())))


def test_what_is_named_like_a_source_but_is_none_is_left_out(tmp_path: Path) -> None:
    (tmp_path / "folder.py").mkdir()
    (tmp_path / "sound.py").write_text(FAMILY)
    members, broken = families_of(tmp_path)
    assert [one.name for one in members] == ["sound"]
    assert [(one.name, "is not a file that can be read" in one.reason) for one in broken] == [("folder", True)]


def test_two_detectors_of_one_name_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder, detectors = measured_folder(tmp_path / "measured"), folder_of_detectors(tmp_path / "detectors")
    (detectors / "other.py").write_text(FAMILY)
    made, kept = tmp_path / "replica.yaml", tmp_path / "kept"
    assert dcrb("exam", "replica", str(folder), "--without", "background", "-o", str(made)) == 0
    given = ("--replica", str(made), "--detectors", str(detectors), "--recordings", str(kept), "--workers", "1", "--quiet")
    assert dcrb("exam", "predictivity", str(folder), *given) == 2
    assert "the name 'other' is that of detectors in calm and other: give each another name" in capsys.readouterr().err


def test_a_table_that_is_not_there_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    given = ("--replica", str(Path(__file__).parents[2] / "examples" / "detectors" / "exam.yaml"))
    assert dcrb("exam", "predictivity", str(tmp_path / "none.csv"), *given) == 2
    assert capsys.readouterr().err == f"dcrb: {tmp_path / 'none.csv'} cannot be read: No such file or directory\n"


def test_a_limit_without_an_option_names_none(tmp_path: Path) -> None:
    (tmp_path / "slow.py").write_text(FAMILY.replace("return 'healthy'", "__import__('time').sleep(1e3)"))
    tasks = measured_tasks(read_measured(measured_folder(tmp_path / "measured")), 1.0)
    reason = run_member(f"{tmp_path / 'slow.py'}:Detector", tasks, Limits(block=1.0, options=False))
    assert reason == "it failed on calm_1: a block took longer than 1 s at 0.00 s of the signal"
    (tmp_path / "slow.py").write_text("while True: pass\n")
    reason = run_member(f"{tmp_path / 'slow.py'}:Detector", tasks, Limits(scenario=3.0, options=False))
    assert reason == f"{tmp_path / 'slow.py'}:Detector cannot be used: its import took longer than 3 s"


def test_a_changed_file_or_helper_is_another_detector(tmp_path: Path) -> None:
    folder = folder_of_detectors(tmp_path / "detectors")

    def digests() -> dict[str, str]:
        return {one.name: one.digest for one in families_of(folder, tmp_path)[0]}

    first = digests()
    assert len(list(tmp_path.glob("family-*"))) == 4
    assert digests() == first
    kept = next(path for path in tmp_path.glob("family-*") if b"published" in path.read_bytes())
    content = kept.read_bytes()
    for change in (lambda: kept.write_bytes(content.replace(b"published", b"unheardof")), *(partial(do, kept) for do in ATTACKS.values())):
        change()
        assert digests() == first
        assert kept.read_bytes() == content
    assert len(set(first.values())) == 3
    (folder / "shared_code.py").write_text("ANSWER = 'inner_ring'\n")
    second = digests()
    assert first["published"] != second["published"]
    assert first["failing"] == second["failing"]


def test_a_changed_module_of_a_package_beside_it_is_another_detector(tmp_path: Path) -> None:
    folder = folder_of_detectors(tmp_path / "detectors")
    (folder / "filters").mkdir()
    (folder / "filters" / "__init__.py").write_text("")
    (folder / "filters" / "bands.py").write_text("ANSWER = 'healthy'\n")
    source = folder / "calm.py"
    source.write_text(source.read_text().replace("from shared_code", "from filters.bands"))
    first = {one.name: one.digest for one in families_of(folder)[0]}
    (folder / "filters" / "bands.py").write_text("ANSWER = 'inner_ring'\n")
    second = {one.name: one.digest for one in families_of(folder)[0]}
    assert [first[name] != second[name] for name in ("published", "failing")] == [True, False]


def test_a_family_may_have_the_name_of_a_module_of_the_standard_library(tmp_path: Path) -> None:
    folder = folder_of_detectors(tmp_path / "detectors")
    (folder / "calm.py").rename(folder / "json.py")
    assert [one.name for one in families_of(folder)[0]] == ["failing", "published", "other"]


def test_what_cannot_be_kept_is_no_broken_family(tmp_path: Path) -> None:
    with pytest.raises(Refusal, match=r"cannot be written: .* or give another folder with --recordings"):
        families_of(folder_of_detectors(tmp_path / "detectors"), tmp_path / "absent")


def test_the_shipped_detector_is_a_family() -> None:
    members = shipped_members()
    assert members[0].name == "shipped detector"
    assert [one.published for one in members].count(True) == 1
    for one in members:
        assert load_plugin(one.given)(ORDERS, 12000).update(0, np.zeros((10, 2)), np.zeros(10)) is None


def measured_folder(folder: Path) -> Path:
    (folder / "recordings").mkdir(parents=True)
    orders = "0.4,3.6,5.4,2.4"
    lines = ["name,rig,truth,sampling_rate,unit,speed_rpm_documented,speed_rpm_from_lines,FTF,BPFO,BPFI,BSF"]
    for number, (name, truth) in enumerate((("calm_1", "healthy"), ("struck_1", "outer_ring"))):
        np.savez(folder / "recordings" / f"{name}.npz", a=np.random.default_rng(number).normal(size=2000).astype(np.float32))
        lines.append(f"{name},rig,{truth},2000,g,600,600,{orders}")
    (folder / "recordings.csv").write_text("\n".join(lines) + "\n")
    return folder


def test_answers_are_kept_and_a_detector_that_fails_is_left_out(tmp_path: Path) -> None:
    folder = folder_of_detectors(tmp_path / "detectors")
    tasks = measured_tasks(read_measured(measured_folder(tmp_path / "measured")), 1.0)
    runs = folder / "calm.runs"
    members = families_of(folder)[0]
    # Each task of the two members that do not fail makes a detector; the file itself is data of the folder, so its digest is taken before.
    for expected in (4, 4):
        answers, (broken,) = answers_of(members, tasks, tmp_path, Limits(), 1, no_progress("judged", 3))
        assert len(runs.read_text()) == expected
        assert set(answers) == {"published", "other"}
        assert broken.name == "failing"
        assert "no such filter" in broken.reason
    assert sorted(answers["other"].values()) == ["outer_ring", "outer_ring"]
    np.savez(tmp_path / "measured" / "recordings" / "struck_1.npz", a=np.arange(2000, dtype=np.float32))
    again = measured_tasks(read_measured(tmp_path / "measured"), 1.0)
    assert [one.digest == two.digest for one, two in zip(tasks, again, strict=True)] == [True, False]
    answers_of(members, again, tmp_path, Limits(), 1, no_progress("judged", 3))
    assert len(runs.read_text()) == 6


def test_answers_on_a_full_disk_name_the_option(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder, tasks = folder_of_detectors(tmp_path / "detectors"), measured_tasks(read_measured(measured_folder(tmp_path / "measured")), 1.0)
    members = families_of(folder)[0]
    monkeypatch.setattr(predictivity_marks, "in_processes", lambda calls, workers: [(member, {}) for member in calls])
    refusal = r"\.answers cannot be written: File too large; free some space or give another folder with --recordings$"
    with files_of_at_most(10), pytest.raises(Refusal, match=refusal):
        answers_of(members, tasks, tmp_path, Limits(), 1, no_progress("judged", 3))
    assert not list((tmp_path / "answers").iterdir())


@pytest.mark.parametrize("attack", ATTACKS)
@pytest.mark.timeout(60)  # a pipe would be waited for
def test_answers_that_are_not_as_they_were_written_are_made_again(attack: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    members = families_of(folder_of_detectors(tmp_path / "detectors"))[0][:1]
    tasks = measured_tasks(read_measured(measured_folder(tmp_path / "measured")), 1.0)
    first = answers_of(members, tasks, tmp_path, Limits(), 1, no_progress("judged", 1))
    (kept,) = (tmp_path / "answers").iterdir()
    content = kept.read_bytes()
    ATTACKS[attack](kept)
    assert answers_of(members, tasks, tmp_path, Limits(), 1, no_progress("judged", 1)) == first
    assert f"; {members[0].name} judges the recordings again" in capsys.readouterr().err
    assert (kept.is_symlink(), kept.read_bytes()) == (False, content)


def test_the_answers_of_another_detector_are_not_taken(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    members = families_of(folder_of_detectors(tmp_path / "detectors"))[0][:2]
    tasks = measured_tasks(read_measured(measured_folder(tmp_path / "measured")), 1.0)
    first = answers_of(members, tasks, tmp_path, Limits(), 1, no_progress("judged", 2))
    one, other = (tmp_path / "answers").iterdir()
    contents = one.read_bytes(), other.read_bytes()
    assert contents[0] != contents[1]
    other.write_bytes(contents[0])
    one.write_bytes(contents[1])
    assert answers_of(members, tasks, tmp_path, Limits(), 1, no_progress("judged", 2)) == first
    assert capsys.readouterr().err.count("is damaged, or was written under another name") == 2


def test_the_unit_of_the_healthy_recording_is_part_of_the_task(tmp_path: Path) -> None:
    table = measured_folder(tmp_path / "measured") / "recordings.csv"
    first = measured_tasks(read_measured(tmp_path / "measured"), 1.0)
    table.write_text(table.read_text().replace("calm_1,rig,healthy,2000,g", "calm_1,rig,healthy,2000,m/s^2"))
    second = measured_tasks(read_measured(tmp_path / "measured"), 1.0)
    assert [one.original.name for one in first] == ["calm_1", "struck_1"]
    assert all(one.digest != two.digest for one, two in zip(first, second, strict=True))


def test_a_recording_that_is_not_there_is_refused(tmp_path: Path) -> None:
    folder = measured_folder(tmp_path / "measured")
    (folder / "recordings" / "struck_1.npz").unlink()
    with pytest.raises(Refusal, match="is not there: restore this recording, or leave struck_1 out"):
        measured_tasks(read_measured(folder), 1.0)


@pytest.mark.timeout(1800)  # kernels may have to be compiled
def test_a_replica_is_compared_on_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "measured"
    (folder / "recordings").mkdir(parents=True)
    lines = ["name,rig,truth,sampling_rate,unit,speed_rpm_documented,speed_rpm_from_lines,FTF,BPFO,BPFI,BSF,seconds"]
    for number, (name, truth) in enumerate((("calm_1", "healthy"), ("calm_2", "healthy"), ("outer_1", "outer_ring"))):
        np.savez(folder / "recordings" / f"{name}.npz", a=np.random.default_rng(number).normal(size=12000).astype(np.float32))
        lines.append(f"{name},rig,{truth},12000,g,1800,1800,0.39828,3.5848,5.4152,2.35695,1")
    (folder / "recordings.csv").write_text("\n".join(lines) + "\n")
    detectors = folder_of_detectors(tmp_path / "detectors")
    (detectors / "loud.py").write_text(
        "class Loud:\n    def __init__(self, orders, rate): pass\n    def update(self, *block): return 'inner_ring'\n"
    )
    made, drawing = str(tmp_path / "replica.yaml"), tmp_path / "scatter.png"
    options = ("--machines", "1", "--counterparts", "1", "--longest", "1", "--without", "path", "--without", "impacts", "-o", made)
    assert dcrb("exam", "replica", str(folder), *options) == 0
    capsys.readouterr()
    common = ("--replica", made, "--detectors", str(detectors), "--recordings", str(tmp_path / "kept"), "--workers", "1", "--quiet")
    # Two of the files cannot be used, so the status is 1; the others are compared all the same.
    assert dcrb("exam", "predictivity", str(folder), *common, "--json", "--figure", str(drawing)) == 1
    out, err = capsys.readouterr()
    about = json.loads(out)
    marks = {one["name"]: (one["exam"], one["field"]) for one in about["detectors"]}
    assert (marks["published"], marks["other"], marks["loud"]) == ((0.5, 0.5), (0.5, 0.5), (0.0, 0.0))
    assert about["recordings"] == about["counterparts"] == 3
    assert {one["name"] for one in about["left_out"]} == {"broken", "failing"}
    assert "failing is left out" in err
    assert drawing.stat().st_size > 1000
    runs = (detectors / "calm.runs").read_text()
    (detectors / "broken.py").unlink()
    (detectors / "failing.py").unlink()
    (detectors / "calm.runs").rename(tmp_path / "calm.runs")
    assert dcrb("exam", "predictivity", str(folder), *common) == 0
    assert len(runs) == 12
    assert "| all (3) |" in capsys.readouterr().out
    # Scored as an exam, each recording follows a healthy one as well.
    (detectors / "second.py").write_text(
        "class Second:\n    def __init__(self, orders, rate): self.rate = rate\n"
        "    def update(self, index, *block): return 'outer_ring' if index >= 2.5 * self.rate else 'healthy'\n"
    )
    entry, scored = tmp_path / "entry.json", ("--recordings", str(tmp_path / "kept"), "--workers", "1", "--quiet")
    assert dcrb("score", made, "--python", f"{detectors / 'second.py'}:Second", *scored, "--entry", str(entry)) == 1
    written = read_entry(entry)
    assert {s.name: s.answer for s in written.scenarios} == dict.fromkeys(("calm_1/1", "calm_2/1", "outer_1/1"), "outer_ring")
    assert (written.last_verdict, VerdictMarking().mark(written), written.false_alarms) == (True, 50.0, 2)
    assert list(differences(written, read_exam(made))) == []
    _compare_entries(tmp_path, folder, made, written, capsys)
    capsys.readouterr()
    assert dcrb("score", made, "--node", "true", *scored) == 2
    assert "--node true cannot be evaluated by a replica, whose signals have one axis" in capsys.readouterr().err
    (folder / "recordings.csv").write_text("\n".join(lines[:3]) + "\n")
    assert dcrb("exam", "predictivity", str(folder), *common) == 2
    assert "was made from another table" in capsys.readouterr().err


def _compare_entries(folder: Path, measured: Path, replica: str, second: Entry, capsys: pytest.CaptureFixture[str]) -> None:
    """Compare entries of three detectors of a replica with entries on measured recordings."""

    def entries(names: str) -> list[Entry]:
        answers = ("healthy", "healthy", "outer_ring"), ("healthy",) * 3, ("outer_ring",) * 3
        recordings = [names.format(name) for name in ("calm_1", "calm_2", "outer_1")]
        given = [zip(second.scenarios, recordings, each, strict=True) for each in answers]
        scenarios = [[one.model_copy(update={"name": name, "answer": answer}) for one, name, answer in rows] for rows in given]
        return [second.model_copy(update={"detector": f"d{k}", "scenarios": rows}) for k, rows in enumerate(scenarios)]

    table, exam = measured / "recordings.csv", read_exam(replica)
    digest = led_scenarios(read_measured(measured), "lines", 1.0).digest
    field = [one.model_copy(update={"scenarios_sha256": digest}) for one in entries("{}")]
    about = as_json(compare_entries(table, exam, entries("{}/1"), field))
    assert [(one["exam"], one["field"]) for one in about["detectors"]] == [(1.0, 1.0), (0.5, 0.5), (0.5, 0.5)]
    assert (about["families"][0]["tau_b"]["value"], about["counterparts"]) == (1.0, 3)
    single = [*field[:2], field[2].model_copy(update={"detector": "d9"}), field[2].model_copy(update={"detector": "d8"})]
    both = [*entries("{}/1"), entries("{}/1")[2].model_copy(update={"detector": "d8"})]
    compared = compare_entries(table, exam, both, single)
    assert [one.name for one in compared.broken] == ["d2", "d9"]
    assert "Left out: d2, it has no entry of this name on the measured recordings" in markdown(compared)
    assert "Left out: d9, it has no entry of this name in the exam" in markdown(compared)
    renamed = [one.model_copy(update={"scenarios_sha256": digest}) for one in entries("{}/1")]
    with pytest.raises(Refusal, match=r"the entry 'd0' on measured recordings lacks calm_1: make it with all recordings of"):
        compare_entries(table, exam, entries("{}/1"), renamed)
    with pytest.raises(Refusal, match=r"the entry 'd0' lacks calm_1/1: make it with all recordings of replica of measured"):
        compare_entries(table, exam, entries("{}"), field)
    swapped = [one.model_copy(update={"scenarios": [s.model_copy(update={"family": "roller"}) for s in one.scenarios]}) for one in field]
    with pytest.raises(Refusal, match=r"on measured recordings takes calm_1 as roller, but it is healthy in .*recordings.csv"):
        compare_entries(table, exam, entries("{}/1"), swapped)
    other = [one.model_copy(update={"scenarios_sha256": "0" * 64}) for one in entries("{}/1")]
    with pytest.raises(Refusal, match=r"the entry 'd0' was made with another exam than 'replica of measured'"):
        compare_entries(table, exam, other, field)
    assert exam.replica is not None
    for task in (led_scenarios(read_measured(measured), "lines", 5.0), whole_scenarios(read_measured(measured), "lines", 1.0)):
        elsewhere = [one.model_copy(update={"scenarios_sha256": task.digest}) for one in field]
        with pytest.raises(Refusal, match=r"was made with another task .* than the replica: .* --speed lines --longest 1 --python CLASS"):
            compare_entries(table, exam, entries("{}/1"), elsewhere)
    command = ("exam", "predictivity", str(measured), "--replica", replica, "--entries", str(folder))
    for options, sentence in (
        ((), "--entries and --measured belong together"),
        (("--measured", str(folder), "--workers", "2"), "--workers runs detectors, but entries are compared"),
        (("--measured", str(folder)), "1 family of detectors is left, but an order takes 3"),
    ):
        assert dcrb(*command, *options) == 2
        assert sentence in capsys.readouterr().err


def test_too_few_families_are_refused_with_the_reason_before_anything_is_simulated(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder, made, kept = measured_folder(tmp_path / "measured"), tmp_path / "replica.yaml", tmp_path / "kept"
    assert dcrb("exam", "replica", str(folder), "--without", "background", "-o", str(made)) == 0
    assert capsys.readouterr().out.endswith(f"--replica {made} --detectors FOLDER\n")  # without detectors it would be refused, see below
    detectors = folder_of_detectors(tmp_path / "detectors")
    (detectors / "failing.py").unlink()
    command = ("exam", "predictivity", str(folder), "--replica", str(made), "--recordings", str(kept), "--workers", "1", "--quiet")
    assert dcrb(*command, "--detectors", str(detectors)) == 2
    err = capsys.readouterr().err
    assert "2 families of detectors are left (1 left out, such as broken: " in err
    assert "not today" in err
    assert err.count("\n") == 1
    assert not [path for path in kept.iterdir() if not path.name.startswith("family-")]
    assert dcrb(*command) == 2
    assert "1 family of detectors is left, but an order takes 3" in capsys.readouterr().err


def made_up_comparison() -> Comparison:
    origin = ReplicaOrigin(
        table_sha256="", speed="lines", seed=1, machines=1, counterparts=1, longest=5.0, lead=2.5, without=[], dcrb_ros=""
    )
    found = marks(noise=0.3)
    return Comparison(found, tuple(predictivities(found)), tuple(predictivities(found.representatives)), (), origin, 36)


@pytest.mark.parametrize(("option", "name", "size"), [("--output", "new.md", 1000), ("--figure", "new.png", 3000)])
def test_a_full_disk_fails_and_leaves_no_file(
    option: str, name: str, size: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder, made = measured_folder(tmp_path / "measured"), tmp_path / "replica.yaml"
    assert dcrb("exam", "replica", str(folder), "--without", "background", "-o", str(made)) == 0
    monkeypatch.setattr(predictivity_report, "compare_with_field", lambda *_: made_up_comparison())
    kept = ("--recordings", str(tmp_path / "kept"), "--workers", "1", "--quiet")
    command = ("exam", "predictivity", str(folder), "--replica", str(made), *kept, option)
    with files_of_at_most(size):
        assert dcrb(*command, str(tmp_path / name)) == 2
    out, err = capsys.readouterr()
    assert "| all (36) |" in out
    assert err.count("File too large") == 1
    assert {path.name for path in tmp_path.iterdir()} == {"measured", "replica.yaml", "kept"}
    assert dcrb(*command, str(tmp_path / "absent" / name)) == 2
    assert "there is no folder" in capsys.readouterr().err


def test_a_family_whose_published_member_is_left_out_has_no_representative(tmp_path: Path) -> None:
    folder = folder_of_detectors(tmp_path / "detectors")
    tasks = measured_tasks(read_measured(measured_folder(tmp_path / "measured")), 1.0)
    members = [member for member in families_of(folder)[0] if member.name in ("other", "failing")]
    answers = {member.name: {task.digest: "healthy" for task in tasks} for member in members}
    found = predictivity_report._marks(members, answers, tasks, tasks)
    assert found.detectors == ("other", "failing")
    assert found.representatives.detectors == ("failing",)


def test_the_json_has_every_figure() -> None:
    comparison = made_up_comparison()
    about = json.loads(json.dumps(as_json(comparison)))
    assert about["families"][0]["detectors"] == 8
    assert about["members"][0]["detectors"] == 16
    assert set(about["members"][0]) == {"scope", "detectors", "recordings", "srcc", "rho", "tau_b", "mmrv"}
    text = markdown(comparison)
    assert f"{about['families'][0]['tau_b']['value']:.2f} [" in text
