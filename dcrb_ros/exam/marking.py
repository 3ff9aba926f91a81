"""Marks: one scenario's opinions against its truth."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from dcrb_ros.exam.criteria import Criteria
from dcrb_ros.exam.opinion import BEARING, WAITING, Opinion
from dcrb_ros.exam.question import Question

NOTHING = "nothing"
"""The answer of a detector that said nothing."""


@dataclass(frozen=True)
class FalseAlarm:
    """An alarm raised where there is nothing of the kind; it counts once, however long it stands."""

    time: float
    """When it was raised [s]."""
    verdict: str
    reason: str = ""
    """What the detector said for it."""


@dataclass(frozen=True)
class Mark:
    """What a scenario brought."""

    question: Question
    answer: str
    """The verdict said most often once it must be right: from the end of the delay limit on, of a healthy run throughout."""
    delay: float | None
    """From the onset to the right verdict [s]; none where it was not given in time, or nothing is to be found."""
    alarm_delay: float | None
    """From the onset to the first alarm of any name [s]."""
    false_alarms: tuple[FalseAlarm, ...]
    healthy_time: float
    """Time in which an alarm is a false one [s]; 0 before the onset where the twin has the same samples."""
    score: float | None
    """Largest evidence for a fault, from the onset on."""
    opinions: int
    flaw: str
    """Why it is not passed; empty where it is."""
    broken: bool = False
    """Whether the detector failed, fell silent or had no verdict at all."""

    @property
    def passed(self) -> bool:
        """Whether the scenario went as it should."""
        return not self.flaw

    @property
    def counted_alarms(self) -> int:
        """False alarms that count for the rate: those before the onset are the twin's, which has the same samples."""
        return sum(alarm.time >= self.question.onset or not self.question.twin for alarm in self.false_alarms)

    @property
    def found(self) -> bool:
        """Whether the fault was found in time and named right."""
        return self.delay is not None and self.answer == self.question.verdict


def mark(question: Question, opinions: Sequence[Opinion], criteria: Criteria, *, failure: str = "") -> Mark:
    """Return the mark of a scenario; ``failure`` is why there are no more opinions, if something broke."""
    said = sorted(opinions, key=lambda opinion: opinion.time)
    onset = question.onset if question.faulty else question.end
    limit = criteria.delay.of(question.verdict) if question.faulty else 0.0
    alarms = tuple(_false_alarms(question, said))
    right = _right(question, criteria)
    delay = _first(said, right, onset, limit) if question.faulty else None
    last = [o for o in said if not question.faulty or o.time >= onset + limit] or said[-1:]
    # Names that are all right are one answer: together they outvote what is wrong.
    answer = _answer([replace(o, verdict=question.verdict) if o.verdict in right else o for o in last])
    scores = [o.score for o in said if o.score is not None and (o.time >= onset or not question.faulty)]
    broken = failure or _silence(question, said, criteria)
    flaw = broken or _flaw(question, answer, delay, limit, alarms)
    return Mark(
        question,
        answer,
        delay,
        _first(said, frozenset(BEARING) | {"sensor"}, onset, question.duration) if question.faulty else None,
        alarms,
        _innocent_time(question),
        max(scores, default=None),
        len(said),
        flaw,
        bool(broken) or answer in (NOTHING, WAITING),
    )


def _right(question: Question, criteria: Criteria) -> frozenset[str]:
    """Return the verdicts that count as right."""
    anything = not criteria.name_right and question.verdict in BEARING
    return frozenset(BEARING) if anything else frozenset({question.verdict})


def _false_alarms(question: Question, said: Sequence[Opinion]) -> Iterator[FalseAlarm]:
    """Yield the alarms raised before the onset, and those on the bearing where only the sensor is at fault."""
    standing = ""
    for opinion in said:
        clean_until = question.bearing_clean_until if opinion.verdict in BEARING else question.clean_until
        innocent = opinion.time < clean_until or clean_until >= question.end
        if innocent and opinion.alarm and opinion.verdict != standing:
            yield FalseAlarm(opinion.time, opinion.verdict, opinion.reason)
        if opinion.verdict != WAITING:
            standing = opinion.verdict if opinion.alarm else ""


def _innocent_time(question: Question) -> float:
    """Return the time in which an alarm on the bearing is a false one, without what the twin has as well [s]."""
    return question.bearing_clean_until - (question.onset if question.twin else question.begin)


def _first(said: Sequence[Opinion], wanted: frozenset[str], onset: float, limit: float) -> float | None:
    """Return how long after the onset a wanted verdict was first raised [s]; one that stood already knows nothing of it."""
    standing = ""
    for opinion in said:
        if opinion.time >= onset and opinion.verdict in wanted and standing not in wanted:
            return opinion.given - onset if opinion.given <= onset + limit + 1e-9 else None
        # Waiting neither raises nor ends an alarm.
        if opinion.verdict != WAITING:
            standing = opinion.verdict
    return None


def _answer(said: Sequence[Opinion]) -> str:
    """Return the verdict said most often, the later one of equals; waiting only where there is nothing else."""
    counts = Counter(opinion.verdict for opinion in said if opinion.verdict != WAITING)
    if not counts:
        return WAITING if said else NOTHING
    latest = {opinion.verdict: opinion.time for opinion in said}
    return max(counts, key=lambda verdict: (counts[verdict], latest[verdict]))


def _silence(question: Question, said: Sequence[Opinion], criteria: Criteria) -> str:
    """Return where the detector said nothing for too long, in words, or nothing."""
    times = [question.begin, *(opinion.time for opinion in said), question.end]
    for begin, end in pairwise(times):
        if end - begin > criteria.silence:
            return f"silent from {begin:.1f} s to {end:.1f} s" if said else "nothing was said"
    return ""


def _flaw(question: Question, answer: str, delay: float | None, limit: float, alarms: Sequence[FalseAlarm]) -> str:
    if alarms:
        more = f" and {len(alarms) - 1} more" if len(alarms) > 1 else ""
        return f"false alarm at {alarms[0].time:.1f} s ({alarms[0].verdict}){more}"
    if answer != question.verdict:
        return f"called {answer}"
    if question.faulty and delay is None:
        return f"not found within {limit:g} s"
    return ""
