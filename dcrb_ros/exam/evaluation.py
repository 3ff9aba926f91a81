"""Evaluation of a detector: its diagnoses of scenarios with known truth, scored and put together in a report."""

from __future__ import annotations

import secrets
from collections.abc import Callable, Iterable, Mapping, Sequence, Sized
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Generic, Protocol, TypeVar

from dcrb_ros.exam.criteria import Criteria
from dcrb_ros.exam.expectation import Expectation
from dcrb_ros.exam.report import Report
from dcrb_ros.exam.scoring import ScenarioResult, score_scenario
from dcrb_ros.messages.received_diagnosis import ReceivedDiagnosis
from dcrb_ros.runtime.processes import in_processes
from dcrb_ros.schema.refusal import Refusal

Value = TypeVar("Value")
Signal = TypeVar("Signal")
Evaluated = TypeVar("Evaluated", contravariant=True)
OnDone = Callable[[str], None]
"""Called with the name of every scenario that is done."""
Progress = Callable[[str, int], AbstractContextManager[OnDone]]
"""Called with an activity and its number of scenarios; shows how far it is."""


class NoDiagnosis(RuntimeError):
    """The detector published no diagnosis in the first scenario; the others are not tried."""


class CandidateRefusal(Refusal):
    """A refusal of the candidate itself, which no scenario has caused."""


@dataclass
class Outcome:
    """What a candidate did in one scenario."""

    received: list[ReceivedDiagnosis] = field(default_factory=list)
    """Its diagnoses."""
    failure: str = ""
    """Why it failed; empty if it did not. The other scenarios are evaluated all the same."""


class AnyOutcome(Protocol):
    """What a candidate did: an `Outcome`, or the diagnoses of several boxes."""

    @property
    def received(self) -> Sized:
        """Its diagnoses."""

    failure: str
    """Why it failed; empty if it did not."""


class Candidate(Protocol[Evaluated]):
    """Whatever can be evaluated: a detector in this process, a node, or the diagnoses that a recording contains."""

    @property
    def name(self) -> str:
        """Name in the report."""

    @property
    def parallel(self) -> bool:
        """Whether scenarios are evaluated in processes of their own, to which the candidate is pickled."""

    def diagnose(self, signal: Evaluated, /) -> AnyOutcome:
        """Return the outcome for the signal of one scenario; the truth is not part of it.

        Raises:
            Refusal: the signal cannot be read, or the detector returns something invalid.
        """


@dataclass(frozen=True)
class Scenario(Generic[Signal]):
    """A signal, and the results of what a candidate did with it."""

    name: str
    signal: Callable[[], Signal]
    """Returns the signal, also in another process; simulates it if it is missing."""
    results: Callable[[Any, Criteria], list[ScenarioResult]]
    """Returns the result for each bearing, of an outcome of a candidate for this signal."""
    recorded: Callable[[], bool] | None = None
    """Returns whether the signal has been simulated; None if it never is."""
    group: str = ""
    """Scenarios of one group are evaluated one after another, because their simulations have parts in common."""


def bearing_scenario(
    expectation: Expectation, signal: Callable[[], Signal], recorded: Callable[[], bool] | None = None
) -> Scenario[Signal]:
    """Return the scenario of a bearing from what is expected of its diagnosis."""

    def results(outcome: Outcome, criteria: Criteria) -> list[ScenarioResult]:
        return [score_scenario(expectation, outcome.received, criteria, failure=outcome.failure)]

    return Scenario(expectation.name, signal, results, recorded)


@dataclass(frozen=True)
class ScenarioSet(Generic[Signal]):
    """Scenarios that are evaluated together."""

    name: str
    criteria: Criteria
    scenarios: Sequence[Scenario[Signal]]
    digest: str = ""
    """SHA-256 of the scenarios; empty if they are recordings."""
    seal: str = ""
    """Hash that was published before a sealed exam; empty if it was not sealed."""
    seeds: tuple[int, ...] = ()
    """Seeds of the simulations; none for recordings."""


def no_progress(_activity: str, _total: int) -> AbstractContextManager[OnDone]:
    """Show nothing."""
    return nullcontext(lambda _: None)


def evaluate(
    candidate: Candidate[Signal], scenario_set: ScenarioSet[Signal], *, workers: int = 1, progress: Progress = no_progress
) -> Report:
    """Return the report of a candidate.

    Raises:
        Refusal: a signal cannot be read, or the candidate cannot be evaluated.
        NoDiagnosis: a node failed in the first scenario and published no diagnosis.
        RuntimeError: a detector in Python raised an exception.
    """
    if not candidate.parallel:
        signals = {s.name: (s.recorded, partial(_record, s.name, s.signal)) for s in scenario_set.scenarios if s.recorded is not None}
        simulate_missing(signals, workers, progress)
    calls = {scenario.name: partial(_outcome, candidate, scenario.name, scenario.signal) for scenario in _order(scenario_set)}
    outcomes: dict[str, AnyOutcome] = {}
    with progress("evaluated", len(calls)) as on_done:
        for name, outcome in _results(calls, workers, apart=candidate.parallel):
            if outcome.failure and not (candidate.parallel or outcome.received or outcomes):
                raise NoDiagnosis(f"the detector '{candidate.name}' failed on the first scenario ({name}): {outcome.failure}")
            outcomes[name] = outcome
            on_done(name)
    return report_of(scenario_set, candidate.name, outcomes)


def report_of(scenario_set: ScenarioSet[Any], detector: str, outcomes: Mapping[str, AnyOutcome]) -> Report:
    """Return the report of a detector from its outcome in each scenario by name."""
    criteria = scenario_set.criteria
    results = tuple(result for scenario in scenario_set.scenarios for result in scenario.results(outcomes[scenario.name], criteria))
    return Report(scenario_set.name, detector, criteria, scenario_set.digest, results, scenario_set.seal, scenario_set.seeds)


def _order(scenario_set: ScenarioSet[Signal]) -> list[Scenario[Signal]]:
    """Return the scenarios as they are evaluated: those of a sealed exam in a random order, which identifies none."""
    scenarios = list(scenario_set.scenarios)
    if scenario_set.seal:
        secrets.SystemRandom().shuffle(scenarios)
        groups = list(dict.fromkeys(scenario.group for scenario in scenarios))
        scenarios.sort(key=lambda scenario: groups.index(scenario.group))
    return scenarios


def _outcome(candidate: Candidate[Signal], name: str, signal: Callable[[], Signal]) -> AnyOutcome:
    return named(name, lambda: candidate.diagnose(signal()))


def _record(name: str, signal: Callable[[], object]) -> None:
    """Simulate a signal; it is not returned, so that another process need not send it."""
    named(name, signal)


def simulate_missing(signals: Mapping[str, tuple[Callable[[], bool], Callable[[], object]]], workers: int, progress: Progress) -> None:
    """Simulate the signals that are missing, with more than one worker in processes of their own.

    Of each by name, a function returns whether it has been simulated, and another one simulates it.
    """
    if not signals:
        return
    with progress("simulated", len(signals)) as on_done:
        missing = {}
        for name, (recorded, simulate) in signals.items():
            if recorded():
                on_done(name)
            else:
                missing[name] = simulate
        for name, _ in _results(missing, workers, apart=workers > 1):
            on_done(name)


def _results(calls: Mapping[str, Callable[[], Value]], workers: int, *, apart: bool) -> Iterable[tuple[str, Value]]:
    """Return name and result of each call, made in processes of its own if ``apart``."""
    if apart and calls:
        return in_processes(calls, min(workers, len(calls)))
    return ((name, call()) for name, call in calls.items())


def named(name: str, call: Callable[[], Value]) -> Value:
    """Return the result of a call; an exception is raised again with the scenario's name in its message."""
    try:
        return call()
    except CandidateRefusal:
        raise
    except Refusal as refusal:
        raise Refusal(f"scenario '{name}': {refusal}") from None
    except Exception as error:
        raise RuntimeError(f"scenario '{name}' could not be evaluated: {str(error) or type(error).__name__}") from error
