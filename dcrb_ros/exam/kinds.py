"""The kinds of exams: of a bearing (`exam_file`) and of a vehicle (`vehicle.exam_file`). Recordings and measured signals need no file.

`evaluation.evaluate` takes the scenarios of all of them, which are made by `exam_scenarios.scenarios_of`, `vehicle_scenarios` in
`vehicle.evaluation`, `recorded_case.recorded_scenarios` and `measured.whole_scenarios`.
"""

from __future__ import annotations

import dataclasses
import fnmatch
from collections.abc import Mapping
from pathlib import Path
from typing import TypeAlias

from dcrb_ros.exam.exam_file import LARGEST_EXAM, MACHINE_TAG, Exam, exam_of
from dcrb_ros.exam.vehicle.exam_file import VehicleExam, vehicle_exam_of
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.shipped import find_shipped
from dcrb_ros.text.yaml import read_yaml

AnyExam: TypeAlias = Exam | VehicleExam


def read_any_exam(source: str | Path) -> AnyExam:
    """Return the exam of either kind given by a file or by a shipped name.

    Raises:
        Refusal: see `exam_file.read_exam` and `vehicle.exam_file.read_vehicle_exam`.
    """
    tree = read_yaml(find_shipped("exam", source), LARGEST_EXAM)
    of_vehicle = isinstance(tree, Mapping) and "vehicle" in tree
    return vehicle_exam_of(tree, str(source)) if of_vehicle else exam_of(tree, str(source))


def matching(exam: AnyExam, pattern: str) -> AnyExam:
    """Return an exam with the scenarios whose names match a pattern, such as ``outer/*``; an empty one matches all.

    Twins and, in a replica, the healthy recordings of the same machines are kept with them.

    Raises:
        Refusal: it matches none.
    """
    if not pattern:
        return exam
    name = f"{exam.name} (only {pattern})"
    kept = {case.name for case in exam.cases if fnmatch.fnmatchcase(case.name, pattern)}
    if not kept:
        raise Refusal(f"--only '{pattern}' matches no scenario of {exam.name}: --list shows their names")
    if isinstance(exam, VehicleExam):
        return dataclasses.replace(exam, name=name, cases=tuple(case for case in exam.cases if case.name in kept))
    kept |= {case.expectation.twin for case in exam.cases if case.name in kept}
    if exam.replica is not None:  # a healthy run of the machine precedes each
        machines = {case.expectation.tags.get(MACHINE_TAG) for case in exam.cases if case.name in kept}
        kept |= {case.name for case in exam.cases if not case.expectation.faulty and case.expectation.tags.get(MACHINE_TAG) in machines}
    return dataclasses.replace(exam, name=name, cases=tuple(case for case in exam.cases if case.name in kept))
