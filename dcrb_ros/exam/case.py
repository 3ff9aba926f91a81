"""A run that the exam simulates itself: resolved to the last parameter, so that it has a name, a hash and a recording."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from dcrb_ros.exam.question import Question
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.parameters import rpm


@dataclass(frozen=True)
class Run:
    """What is simulated."""

    configuration: Configuration
    story: Mapping[str, Any] | None
    """A scenario as YAML gives it, or none."""
    duration: float
    """Simulated time [s]."""

    def described(self) -> dict[str, Any]:
        """Return everything that the samples depend on."""
        return {"configuration": self.configuration.model_dump(), "scenario": self.story, "duration": self.duration}


@dataclass(frozen=True)
class Case:
    """A scenario of the exam."""

    question: Question
    run: Run


def canonical(tree: Any) -> str:
    """Return a tree as JSON that is the same for the same content."""
    return json.dumps(tree, sort_keys=True, separators=(",", ":"), ensure_ascii=True, allow_nan=False)


def scenarios_hash(cases: Iterable[Case]) -> str:
    """Return the SHA-256 of all scenarios: configurations, timelines, durations and right verdicts, whatever their names and order."""
    found = [
        canonical(
            {"verdict": c.question.verdict, "onset": c.question.onset, "required": c.question.required, "run": c.run.described()},
        )
        for c in cases
    ]
    return hashlib.sha256(canonical(sorted(found)).encode()).hexdigest()


def described(configuration: Configuration, changes: Mapping[str, Any]) -> dict[str, str | float]:
    """Return the tags that follow from a configuration and what changes in it: speed, load, width of the largest defect."""
    operating = configuration.operating
    widths = [fields["width"] for fields in configuration.faults.described().values() if "width" in fields]
    told = (value for key, value in changes.items() if key.startswith("faults.") and key.endswith(".width"))
    widths += [value for value in told if isinstance(value, float)]
    tags: dict[str, str | float] = {
        "speed": operating.speed,
        "speed_rpm": round(rpm(operating.speed), 1),
        "load": math.hypot(operating.load, operating.lateral_load),
        "joint": configuration.cage.joint,
    }
    return tags | ({"width": max(widths)} if widths else {})
