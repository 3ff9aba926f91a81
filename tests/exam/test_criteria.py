"""Defaults and ranges of the criteria and of an exam file."""

from __future__ import annotations

from dcrb_ros.exam.criteria import Criteria, DelayLimits
from dcrb_ros.exam.exam_file import ExamFile, ScenarioEntry
from dcrb_ros.schema.verdicts import FAULT_CLASSES
from dcrb_ros.settings.files import parameter_fields

PUBLISHED: dict[str, tuple[float, float, float]] = {
    "delay.outer_ring": (5.0, 0.0, 1000000.0),
    "delay.inner_ring": (5.0, 0.0, 1000000.0),
    "delay.roller": (5.0, 0.0, 1000000.0),
    "delay.cage": (20.0, 0.0, 1000000.0),
    "delay.lubrication": (20.0, 0.0, 1000000.0),
    "delay.overheating": (20.0, 0.0, 1000000.0),
    "delay.compound": (5.0, 0.0, 1000000.0),
    "delay.sensor": (5.0, 0.0, 1000000.0),
    "found": (1.0, 0.0, 1.0),
    "smallest_width": (0.001, 0.0, 0.05),
    "false_alarms": (0, 0, 1000000),
    "silence": (5.0, 0.0, 1000000.0),
}
"""Default, least and largest value by key: exam files depend on them."""


def test_defaults_and_ranges_are_those_published() -> None:
    found = {field.key: (field.default, field.low, field.high) for field in parameter_fields(Criteria) if field.low is not None}
    assert {key: found.get(key) for key in PUBLISHED} == PUBLISHED
    assert Criteria().name_right is True


def test_every_fault_has_a_limit_of_its_own() -> None:
    faults = [verdict for verdict in FAULT_CLASSES if verdict != "healthy"]
    limits = DelayLimits(**{verdict: float(number) for number, verdict in enumerate(faults)})
    assert [limits.of(verdict) for verdict in faults] == [float(number) for number in range(len(faults))]


def test_an_exam_file_needs_a_name_and_scenarios_only() -> None:
    file = ExamFile.model_validate({"exam": "tiny", "scenarios": [{"name": "well", "verdict": "healthy"}]})
    assert (file.duration, file.onset, file.seeds, file.base, file.points) == (10.0, 4.0, [1], "healthy", {})
    (entry,) = file.scenarios
    assert (entry.required, entry.twin, entry.points, entry.seeds, entry.duration, entry.onset) == (True, True, None, None, None, None)


def test_durations_and_onsets_have_their_ranges() -> None:
    for model in (ScenarioEntry, ExamFile):
        limits = {name: sorted(repr(limit) for limit in model.model_fields[name].metadata) for name in ("duration", "onset")}
        assert limits == {"duration": ["Ge(ge=0.1)", "Le(le=100000.0)"], "onset": ["Ge(ge=0.0)", "Le(le=100000.0)"]}
