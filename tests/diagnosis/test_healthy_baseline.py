"""Baselines: learned from a healthy recording, saved, loaded, refused for another bearing, and named by the diagnosis."""

from __future__ import annotations

import dataclasses
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from jittered_impacts import Floats, Machine
from same_process import dcrb
from synthetic_bearing import ORDERS, synthetic

import dcrb_ros
from dcrb_ros.bearing.waveform import signal_of
from dcrb_ros.diagnosis.detection import DetectionResult, detect, learn_baseline
from dcrb_ros.diagnosis.detector import FaultDetector
from dcrb_ros.diagnosis.healthy_baseline import DIGEST, SOURCES, HealthyBaseline, read_baseline
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.exchange.importing import WaveformImport
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.json import digest_of

pytestmark = pytest.mark.slow

SOURCE_FOLDER = Path(dcrb_ros.__file__).parent / "diagnosis"
RATE, SECONDS = 12000, 8.0


def angle(signal: Floats, speed: float = 25.0) -> Floats:
    return np.mod(2.0 * np.pi * speed / RATE * np.arange(len(signal)), 2.0 * np.pi)


def loud(seed: int, defect: float = 0.0) -> Floats:
    """A healthy bearing with deep lines at BPFO, of one machine, and a defect of the outer ring."""
    one = Machine(seed)
    healthy = one.healthy(SECONDS, compliance=0.7)
    return healthy + defect * one.impacts(SECONDS, "outer_ring")


def judged(signal: Floats, known: HealthyBaseline | None = None, **parameters: Any) -> DetectionResult:
    chosen = DetectorParameters(**parameters)
    return detect(signal, RATE, shaft_angle=angle(signal), bearing=Machine(1).orders, parameters=chosen, baseline=known)


def learned(signal: Floats, **parameters: Any) -> HealthyBaseline:
    return learn_baseline(
        signal, RATE, name="calm", shaft_angle=angle(signal), bearing=Machine(1).orders, parameters=DetectorParameters(**parameters)
    )


@pytest.fixture(scope="module")
def baseline() -> HealthyBaseline:
    return learned(loud(1))


def test_a_baseline_raises_the_limit_of_a_bearing_with_deep_lines(baseline: HealthyBaseline) -> None:
    assert judged(loud(2)).verdict == "outer_ring"
    found = judged(loud(2), baseline)
    assert found.verdict == "healthy", found.reason
    assert judged(loud(2, defect=4.0), baseline).verdict == "outer_ring"


def test_a_baseline_lowers_the_limit_of_a_quiet_bearing() -> None:
    calm = Machine(4).healthy(SECONDS)
    one = Machine(4)
    signal = one.healthy(SECONDS) + 0.055 * one.impacts(SECONDS, "outer_ring")
    assert judged(signal).verdict == "healthy"
    found = judged(signal, learned(calm))
    assert found.verdict == "outer_ring", found.reason
    assert judged(calm, learned(calm)).verdict == "healthy"


def test_the_gain_of_both_recordings_does_not_matter(baseline: HealthyBaseline) -> None:
    small = learned(0.01 * loud(1))
    for signal in (loud(2), loud(2, defect=4.0)):
        assert judged(0.01 * signal, small).verdict == judged(signal, baseline).verdict


def test_the_diagnosis_says_which_baseline_was_used(baseline: HealthyBaseline) -> None:
    used = judged(loud(2), baseline).last
    assert used.baseline.startswith("lines are compared with a baseline of 8.0 s of calm")
    assert "itself is diagnosed as outer_ring, and taken as healthy" in used.baseline
    assert used.baseline in used.remarks
    assert judged(loud(2)).last.baseline == ""


def test_another_speed_makes_sizes_uncertain(baseline: HealthyBaseline) -> None:
    signal = loud(2)
    found = detect(signal, RATE, shaft_angle=angle(signal, 40.0), bearing=Machine(1).orders, baseline=baseline)
    assert "it was learned at 25.0 to 25.0 Hz, so that sizes are uncertain" in found.last.baseline


def test_learning_stops_at_an_alarm() -> None:
    one = Machine(5)
    calm, struck = one.healthy(SECONDS), one.healthy(SECONDS) + 2.0 * one.impacts(SECONDS, "outer_ring")
    found = learned(np.concatenate([calm, struck]))
    assert 4.0 < found.seconds <= 8.0
    assert found.remark == f"that recording raises an alarm at {found.seconds + 4.0:.1f} s, and what its window contains was not used"
    whole = learned(calm)
    assert max(one.size for one in found.lines) < 2.0 * max(one.size for one in whole.lines)


def test_the_length_that_was_learned_does_not_depend_on_when_the_recording_begins() -> None:
    one = Machine(5)
    signal = np.concatenate([one.healthy(SECONDS), one.healthy(SECONDS) + 2.0 * one.impacts(SECONDS, "outer_ring")])
    waveform = signal_of(signal, RATE, shaft_angle=angle(signal), bearing=one.orders).waveform()
    late = dataclasses.replace(waveform, index=waveform.index + 3600 * RATE)
    assert learn_baseline(late).seconds == pytest.approx(learn_baseline(waveform).seconds, abs=1e-6)


def test_a_faulty_sensor_teaches_nothing() -> None:
    signal = np.clip(5.0 * loud(1), -1.0, 1.0)
    with pytest.raises(Refusal, match=r"calm gives no baseline: .*; give a longer recording"):
        learned(signal)


def test_a_second_is_enough_to_learn_from() -> None:
    found = learned(loud(3)[: round(1.2 * RATE)])
    assert (found.axes, found.seconds) == (1, 1.2)
    assert judged(loud(2), found).verdict == "healthy"


def test_a_saved_baseline_gives_the_same_diagnoses(baseline: HealthyBaseline, tmp_path: Path) -> None:
    baseline.save(tmp_path / "mine.yaml")
    assert read_baseline(tmp_path / "mine.yaml") == baseline
    found, again = judged(loud(2), baseline), judged(loud(2), baseline=str(tmp_path / "mine.yaml"))
    assert [one.scores for one in again.history] == [one.scores for one in found.history]


def test_another_number_in_a_saved_baseline_is_found(baseline: HealthyBaseline, tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    baseline.save(path)
    tree = yaml.safe_load(path.read_text())
    tree["lines"][0]["size"] *= 10.0
    path.write_text(yaml.safe_dump(tree))
    with pytest.raises(Refusal, match="was changed: its digest does not match; learn the baseline again"):
        read_baseline(path)


@pytest.mark.parametrize("left", [{}, {DIGEST: None}], ids=["removed", "null"])
def test_a_baseline_without_its_digest_is_refused(left: dict[str, None], baseline: HealthyBaseline, tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump(baseline.model_dump(mode="json") | left))
    with pytest.raises(Refusal, match=r"mine\.yaml has no sha256, so that a change would not be found: learn the baseline again"):
        read_baseline(path)


def test_a_baseline_signed_with_fewer_fields_is_read(baseline: HealthyBaseline, tmp_path: Path) -> None:
    """A version that knew no remark signed the other fields; an edit of one is found nevertheless."""
    path, tree = tmp_path / "mine.yaml", baseline.model_dump(mode="json", exclude={"remark"})
    signed = tree | {DIGEST: digest_of(tree, DIGEST)}
    path.write_text(yaml.safe_dump(signed))
    assert read_baseline(path) == baseline.model_copy(update={"remark": ""})
    path.write_text(yaml.safe_dump(signed | {"remark": "the sensor was exchanged"}))
    with pytest.raises(Refusal, match="was changed: its digest does not match"):
        read_baseline(path)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"sampling_rate": 25600}, "has 25600 Hz, but the signal has 12000 Hz: learn the baseline again"),
        ({"orders": {"FTF": 0.4, "BPFO": 3.6, "BPFI": 5.5, "BSF": 2.4}}, r"is of a bearing with BPFI = 5\.5, not 5\.4 orders"),
        ({"parameters": {}}, "was learned with band_low = unknown, but the detector has 2000"),
        ({"rules": "0" * 12}, "was learned by other rules"),
        ({"axes": 2}, "has axes: 2, but the signal has 1"),
        ({"axes": 4}, "is not a baseline: axes: input should be less"),
        ({"lines": 3}, "is not a baseline: lines"),
        ({"more": 3}, "is not a baseline"),
    ],
)
def test_a_baseline_of_something_else_is_refused(changes: dict[str, Any], sentence: str, baseline: HealthyBaseline, tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    tree = baseline.model_dump(mode="json") | changes
    path.write_text(yaml.safe_dump(tree | {DIGEST: digest_of(tree, DIGEST)}))
    with pytest.raises(Refusal, match=sentence):
        judged(loud(2)[: 3 * RATE], baseline=str(path))


@pytest.mark.parametrize(
    "given", [{"band_low": 1500.0}, {"band": "fixed"}, {"speed_exponent": 2.0}, {"whitening": 0.0}, {"slip": 0.01}, {"window": 2.0}]
)
def test_a_baseline_of_a_detector_with_other_parameters_is_refused(given: dict[str, Any], baseline: HealthyBaseline) -> None:
    with pytest.raises(Refusal, match=f"was learned with {next(iter(given))} = .*, but the detector has {next(iter(given.values()))}"):
        FaultDetector(Machine(1).orders, RATE, DetectorParameters(**given), baseline=baseline)


def test_a_baseline_depends_on_every_module_that_finds_lines() -> None:
    imports = {
        name
        for source in SOURCES
        for name in re.findall(r"^from dcrb_ros\.diagnosis\.(\w+) import", (SOURCE_FOLDER / f"{source}.py").read_text(), re.MULTILINE)
    }
    assert imports - set(SOURCES) == {"healthy_baseline", "hysteresis"}  # which decide on the lines that were found


@pytest.mark.parametrize("given", ["outer_limit", "outer_limit_high", "learn"])
def test_two_baselines_are_refused(given: str, baseline: HealthyBaseline) -> None:
    with pytest.raises(Refusal, match=f"{given} = 1 and a baseline are given"):
        FaultDetector(Machine(1).orders, RATE, DetectorParameters(**{given: 1.0}), baseline=baseline)


def test_two_axes_of_the_simulated_bearing_are_compared() -> None:
    (healthy, turned), (faulty, _) = synthetic(), synthetic(outer=600.0)
    known = learn_baseline(healthy, 51200, shaft_angle=turned, bearing=ORDERS)
    assert known.axes == 2
    assert detect(faulty, 51200, shaft_angle=turned, bearing=ORDERS, baseline=known).verdict == "outer_ring"
    with pytest.raises(Refusal, match="has axes: 2, but the signal has 1: learn it from the same sensor"):
        detect(faulty[:, 0], 51200, shaft_angle=turned, bearing=ORDERS, baseline=known)


def recorded(folder: Path, name: str, signal: Floats) -> Path:
    np.savez(folder / f"{name}.npz", a=signal)
    about = {"channels": {"ax": "a"}, "unit": "g", "sampling_rate": RATE, "speed_rpm": 1500.0, "orders": Machine(1).orders.as_dict()}
    (folder / "about.yaml").write_text(yaml.safe_dump(about))
    WaveformImport(folder / f"{name}.npz", folder / "about.yaml").write(folder / name)
    return folder / name


def test_the_command_learns_saves_and_loads(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    calm, other = recorded(tmp_path, "calm", loud(1)), recorded(tmp_path, "other", loud(2))
    saved = str(tmp_path / "mine.yaml")
    answers = []
    for options in ((), ("--healthy", str(calm), "--save-baseline", saved), ("--baseline", saved)):
        assert dcrb("detect", str(other), "--json", *options) == 0
        answers.append(json.loads(capsys.readouterr().out))
    assert [one["verdict"] for one in answers] == ["outer_ring", "healthy", "healthy"]
    assert answers[0]["baseline"] is None
    assert "8.0 s of calm" in answers[1]["baseline"]
    assert answers[2]["scores"] == answers[1]["scores"]
    for options, sentence in (
        (("--save-baseline", saved), "--save-baseline needs --healthy"),
        (("--healthy", str(calm), "--baseline", saved), "both give a baseline"),
        (("--healthy", str(calm), "--save-baseline", saved), "exists: give another name, or --force"),
        (("--baseline", str(tmp_path / "none.yaml")), "none.yaml"),
    ):
        assert dcrb("detect", str(other), *options) == 2
        error = capsys.readouterr().err
        assert sentence in error
        assert error.count("\n") == 1
