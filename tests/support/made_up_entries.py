"""Entries of a leaderboard of which only the right answers matter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from dcrb_ros.exam.leaderboard_entry import FORMAT, Entry, EntryScenario, StoredDiagnoses
from dcrb_ros.exam.profile import PROFILES


def scenario(name: str, family: str, *, right: bool, required: bool = True) -> EntryScenario:
    faulty = family != "healthy"
    return EntryScenario.model_validate(
        {
            **{"name": name, "family": family, "stratum": "wide" if faulty else None, "required": required},
            **{"answer": family if right else "roller", "found": faulty and right, "delay_turns": 1.0 if faulty and right else None},
            **{"evidence": None, "credit": {profile.name: float(right) for profile in PROFILES} if faulty else {}},
            **{"periods": 1, "spoiled": 0, "silent": 0.0, "diagnoses": StoredDiagnoses.of([])},
        }
    )


def entry(right: Mapping[str, Sequence[bool]], *more: EntryScenario, detector: str = "d", last_verdict: bool = True) -> Entry:
    """Return an entry whose scenarios of each class have a right answer or not."""
    scenarios = [scenario(f"{family}{k:02}", family, right=one) for family, each in right.items() for k, one in enumerate(each)]
    about = {
        "format": FORMAT,
        "detector": detector,
        "exam": "replica",
        "scenarios_sha256": "",
        "sealed_sha256": "",
        "dcrb_ros": "",
        "model": "",
    }
    numbers = {"software": {}, "passed": False, "exam_score": {}, "area": None, "false_alarms": 0, "healthy_hours": 0.0}
    return Entry.model_validate({**about, **numbers, "scenarios": [*scenarios, *more], "last_verdict": last_verdict})
