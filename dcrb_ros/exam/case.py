"""A scenario that the exam simulates itself, with every parameter resolved so that it has a name, a hash and a recording."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from dcrb_ros.exam.expectation import Expectation
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.parameters import rpm

INEFFECTIVE = ("time_scale", "recording")
"""Groups and parameters of the nodes, which have no effect in an exam."""


@dataclass(frozen=True)
class CaseSimulation:
    """The simulation of a case."""

    configuration: Configuration
    scenario: Mapping[str, Any] | None
    """Timeline of speed, load and faults as read from YAML, because it is hashed; None without one. Each run plans its changes anew."""
    duration: float
    """Simulated time [s]."""

    def described(self) -> dict[str, Any]:
        """Return everything that the samples depend on."""
        return {"configuration": self.configuration.model_dump(), "scenario": self.scenario, "duration": self.duration}


@dataclass(frozen=True)
class Case:
    """A scenario of the exam: its simulation and the expected diagnosis."""

    expectation: Expectation
    simulation: CaseSimulation

    @property
    def name(self) -> str:
        """Name of the scenario."""
        return self.expectation.name


def refuse_ineffective(keys: Iterable[str], where: str) -> None:
    """Refuse dotted keys of parameters that have no effect in an exam."""
    key = next((key for key in keys if key.partition(".")[0] in INEFFECTIVE), None)
    if key is not None:
        raise Refusal(f"{where}: {key} has no effect in an exam, which is simulated as fast as possible and records nothing: leave it out")


def canonical(tree: Any) -> str:
    """Return a tree as JSON in a canonical form: equal content gives equal text."""
    return json.dumps(tree, sort_keys=True, separators=(",", ":"), ensure_ascii=True, allow_nan=False)


def scenarios_hash(cases: Iterable[Case], tags: Sequence[str] = (), **task: float) -> str:
    """Return the SHA-256 of a task and all scenarios: configurations, timelines, durations, expected verdicts and values of some ``tags``.

    Names and order do not enter the hash.
    """
    scenarios = [
        canonical(
            {
                "verdict": c.expectation.verdict,
                "onset": c.expectation.onset,
                "required": c.expectation.required,
                "run": c.simulation.described(),
                **{tag: c.expectation.tags.get(tag) for tag in tags},
                **task,
            },
        )
        for c in cases
    ]
    return hashlib.sha256(canonical(sorted(scenarios)).encode()).hexdigest()


def simulation_seeds(cases: Iterable[Case]) -> tuple[int, ...]:
    """Return the different seeds of the simulations in increasing order."""
    return tuple(sorted({case.simulation.configuration.simulation.seed for case in cases}))


def derived_tags(configuration: Configuration, changes: Mapping[str, Any]) -> dict[str, str | float]:
    """Return the tags derived from a configuration and its changes: speed, load, joint and width of the largest defect."""
    operating = configuration.operating
    widths = [fields["width"] for fields in configuration.faults.described().values() if "width" in fields]
    changed = (value for key, value in changes.items() if key.startswith("faults.") and key.endswith(".width"))
    widths += [value for value in changed if isinstance(value, float)]
    tags: dict[str, str | float] = {
        "speed": operating.speed,
        "speed_rpm": round(rpm(operating.speed), 1),
        "load": math.hypot(operating.load, operating.lateral_load),
        "joint": configuration.cage.joint,
    }
    return tags | ({"width": max(widths)} if widths else {})
