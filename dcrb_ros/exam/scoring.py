"""Scoring of one scenario: the diagnoses of a detector compared with the expected one."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

from dcrb_ros.exam.credit import Credit, credit
from dcrb_ros.exam.criteria import Criteria
from dcrb_ros.exam.expectation import Expectation
from dcrb_ros.messages.received_diagnosis import ReceivedDiagnosis
from dcrb_ros.schema.verdicts import BEARING_FAULTS

WAITING = "waiting"
NO_ANSWER = "nothing"
"""Answer of a detector that published no diagnosis."""


@dataclass(frozen=True)
class FalseAlarm:
    """An alarm without a corresponding fault; it counts once, however long it lasts."""

    time: float
    """Time at which it was raised [s]."""
    verdict: str
    reason: str = ""
    """Reason given by the detector."""


@dataclass(frozen=True)
class ScenarioResult:
    """The result of one scenario."""

    expectation: Expectation
    answer: str
    """Most frequent verdict after the delay limit; in a healthy scenario, over the whole signal. See `Expectation.last_verdict`."""
    delay: float | None
    """Detection delay: time from the onset to the correct verdict [s]; None if it was late or missing, or nothing is to be detected."""
    alarm_delay: float | None
    """Time from the onset to the first alarm with any verdict [s]."""
    false_alarms: tuple[FalseAlarm, ...]
    healthy_time: float
    """Time during which an alarm is false [s]; the part before the onset is omitted if the twin contains the same samples."""
    score: float | None
    """Largest evidence for a fault from the onset on."""
    diagnoses: int
    """Number of diagnoses [-]."""
    flaw: str
    """Why the scenario failed; empty if it passed."""
    broken: bool = False
    """Whether the detector failed, stopped publishing or never reached a verdict."""
    credit: Credit = field(default_factory=Credit)
    """Contribution to the exam score."""
    delay_revolutions: float | None = None
    """Detection delay in shaft revolutions [-]; None if `delay` is."""
    healthy_revolutions: float = 0.0
    """Shaft revolutions during `healthy_time` [-]."""
    received: tuple[ReceivedDiagnosis, ...] = ()
    """The diagnoses, from which all of this follows."""
    failure: str = ""
    """Why the detector stopped early; empty if it did not."""

    @property
    def passed(self) -> bool:
        """Whether the scenario passed."""
        return not self.flaw

    @property
    def excused(self) -> bool:
        """Whether only a detection is missing, and not required; false alarms and silence count in every scenario."""
        return bool(self.flaw) and not self.expectation.required and not self.false_alarms and not self.broken

    @property
    def counted_alarms(self) -> int:
        """False alarms that enter the rate; those before the onset are counted in the twin, which contains the same samples."""
        return sum(alarm.time >= self.expectation.onset or not self.expectation.twin for alarm in self.false_alarms)

    @property
    def found(self) -> bool:
        """Whether the fault was detected in time with the correct verdict."""
        return self.delay is not None and self.answer == self.expectation.verdict

    @property
    def right(self) -> bool:
        """Whether the answer is the correct verdict, and the detector did not fail after it."""
        return self.answer == self.expectation.verdict and not self.failure

    def described(self) -> dict[str, Any]:
        """Return the result as a tree for JSON."""
        expectation = self.expectation
        return {
            "name": expectation.name,
            "verdict": expectation.verdict,
            "answer": self.answer,
            "passed": self.passed,
            "required": expectation.required,
            "flaw": self.flaw,
            "onset": expectation.onset if expectation.faulty else None,
            "begin": expectation.begin,
            "duration": expectation.duration,
            "delay": self.delay,
            "delay_turns": self.delay_revolutions if expectation.speed_known else None,
            "alarm_delay": self.alarm_delay,
            "credit": dict(self.credit.detection) or None,
            "healthy_periods": self.credit.periods,
            "spoiled_periods": self.credit.failed,
            "silent": self.credit.silent,
            "false_alarms": [vars(alarm) for alarm in self.false_alarms],
            "score": self.score,
            "opinions": self.diagnoses,
            "twin": expectation.twin or None,
            "tags": dict(expectation.tags),
        }


def score_scenario(
    expectation: Expectation, diagnoses: Sequence[ReceivedDiagnosis], criteria: Criteria, *, failure: str = ""
) -> ScenarioResult:
    """Return the result of a scenario; ``failure`` says why the detector stopped early, if it did."""
    ordered = sorted(diagnoses, key=lambda diagnosis: diagnosis.time)
    onset = expectation.onset if expectation.faulty else expectation.end
    limit = criteria.delay.of(expectation.verdict) if expectation.faulty else 0.0
    alarms = tuple(_false_alarms(expectation, ordered))
    correct = _correct_verdicts(expectation, criteria)
    delay = _delay(ordered, correct, onset, limit) if expectation.faulty else None
    last = _last_verdict(expectation, ordered) if expectation.last_verdict else _after_limit(expectation, ordered, onset + limit)
    # All correct verdicts count as one answer, so that together they can outvote a wrong one.
    answer = _answer([replace(d, verdict=expectation.verdict) if d.verdict in correct else d for d in last])
    scores = [d.score for d in ordered if d.score is not None and (d.time >= onset or not expectation.faulty)]
    broken = failure or _silence(expectation, ordered, criteria)
    flaw = broken or _flaw(expectation, answer, delay, limit, alarms)
    healthy_from, healthy_until = expectation.healthy_span
    return ScenarioResult(
        expectation,
        answer,
        delay,
        _delay(ordered, frozenset(BEARING_FAULTS) | {"sensor"}, onset, expectation.duration) if expectation.faulty else None,
        alarms,
        healthy_until - healthy_from,
        max(scores, default=None),
        len(ordered),
        flaw,
        bool(broken) or not _answered(expectation, answer),
        credit(expectation, ordered, criteria),
        None if delay is None else expectation.revolutions(onset, onset + delay),
        expectation.revolutions(healthy_from, healthy_until),
        tuple(ordered),
        failure,
    )


def _after_limit(expectation: Expectation, diagnoses: Sequence[ReceivedDiagnosis], limit: float) -> Sequence[ReceivedDiagnosis]:
    """Return the diagnoses from the delay limit on [s], or the last one; all of them if the bearing is healthy."""
    return [d for d in diagnoses if not expectation.faulty or d.time >= limit] or diagnoses[-1:]


def _last_verdict(expectation: Expectation, diagnoses: Sequence[ReceivedDiagnosis]) -> Sequence[ReceivedDiagnosis]:
    """Return the last diagnosis from the onset on that is not "waiting"; the last one of all if there is none, or nothing."""
    judged = [d for d in diagnoses if d.time >= expectation.onset]
    return [d for d in judged if d.verdict != WAITING][-1:] or judged[-1:]


def _correct_verdicts(expectation: Expectation, criteria: Criteria) -> frozenset[str]:
    """Return the verdicts that count as correct."""
    any_bearing_fault = not criteria.name_right and expectation.verdict in BEARING_FAULTS
    return frozenset(BEARING_FAULTS) if any_bearing_fault else frozenset({expectation.verdict})


def _false_alarms(expectation: Expectation, diagnoses: Sequence[ReceivedDiagnosis]) -> Iterator[FalseAlarm]:
    """Yield the alarms raised before the onset, and bearing alarms while only the sensor is faulty."""
    current = ""
    for diagnosis in diagnoses:
        clean_until = expectation.bearing_clean_until if diagnosis.verdict in BEARING_FAULTS else expectation.clean_until
        healthy = diagnosis.time < clean_until or clean_until >= expectation.end
        if healthy and diagnosis.alarm and diagnosis.verdict != current:
            yield FalseAlarm(diagnosis.time, diagnosis.verdict, diagnosis.reason)
        if diagnosis.verdict != WAITING:
            current = diagnosis.verdict if diagnosis.alarm else ""


def _delay(diagnoses: Sequence[ReceivedDiagnosis], wanted: frozenset[str], onset: float, limit: float) -> float | None:
    """Return the time from the onset to the first wanted verdict [s]; None if it is later than ``limit`` or missing.

    A wanted verdict that was already current before the onset does not count: it cannot be a detection.
    """
    current = ""
    for diagnosis in diagnoses:
        if diagnosis.time >= onset and diagnosis.verdict in wanted and current not in wanted:
            return diagnosis.issued_at - onset if diagnosis.issued_at <= onset + limit + 1e-9 else None
        # The verdict "waiting" neither raises nor ends an alarm.
        if diagnosis.verdict != WAITING:
            current = diagnosis.verdict
    return None


def _answer(diagnoses: Sequence[ReceivedDiagnosis]) -> str:
    """Return the most frequent verdict, the later one of a tie; "waiting" only if there is no other."""
    counts = Counter(diagnosis.verdict for diagnosis in diagnoses if diagnosis.verdict != WAITING)
    if not counts:
        return WAITING if diagnoses else NO_ANSWER
    latest = {diagnosis.verdict: diagnosis.time for diagnosis in diagnoses}
    return max(counts, key=lambda verdict: (counts[verdict], latest[verdict]))


def _silence(expectation: Expectation, diagnoses: Sequence[ReceivedDiagnosis], criteria: Criteria) -> str:
    """Return a sentence on the first gap between diagnoses longer than `Criteria.silence`; empty if there is none."""
    times = [expectation.begin, *(diagnosis.time for diagnosis in diagnoses), expectation.end]
    for begin, end in pairwise(times):
        if end - begin > criteria.silence:
            return f"no diagnosis from {begin:.1f} s to {end:.1f} s" if diagnoses else "no diagnosis"
    return ""


def _answered(expectation: Expectation, answer: str) -> bool:
    """Return whether an answer is a verdict; of a healthy bearing that hardly turns, "waiting" is the right one."""
    hopeless = not expectation.faulty and not expectation.judgeable(expectation.begin, expectation.end)
    return answer != NO_ANSWER and (answer != WAITING or hopeless)


def _flaw(expectation: Expectation, answer: str, delay: float | None, limit: float, alarms: Sequence[FalseAlarm]) -> str:
    if alarms:
        more = f" and {len(alarms) - 1} more" if len(alarms) > 1 else ""
        return f"false alarm at {alarms[0].time:.1f} s ({alarms[0].verdict}){more}"
    if answer != expectation.verdict and not (answer == WAITING and _answered(expectation, answer)):
        return f"diagnosed as {answer}"
    if expectation.faulty and delay is None:
        return f"not detected within {limit:g} s"
    return ""
