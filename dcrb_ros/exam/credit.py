"""The contribution of one scenario to the exam score: the credit for its fault, and its healthy periods."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

from dcrb_ros.exam.criteria import Criteria
from dcrb_ros.exam.expectation import FEWEST_REVOLUTIONS, Expectation
from dcrb_ros.exam.profile import PROFILES, Profile
from dcrb_ros.messages.received_diagnosis import ReceivedDiagnosis
from dcrb_ros.schema.verdicts import BEARING_FAULTS, VERDICTS, is_alarm

GRACE = FEWEST_REVOLUTIONS
"""Revolutions after the onset that cost nothing [-]."""
FINAL = 0.25
"""Share of the time after the onset, at its end, on which the rest of the credit depends [-]."""
SHORTEST_PERIOD = 1.0
"""Shortest healthy period [s], for exams with a smaller `Criteria.silence`."""


@dataclass(frozen=True)
class Credit:
    """The contribution of a scenario to the exam score."""

    detection: Mapping[str, float] = field(default_factory=dict)
    """Credit for the fault by profile, 0 .. 1 [-]; empty without a fault."""
    periods: int = 0
    """Healthy periods [-]."""
    failed: int = 0
    """Healthy periods in which a false alarm was current or no verdict was given [-]."""
    silent: float = 0.0
    """Time without a verdict [s]."""


@dataclass(frozen=True)
class _CurrentVerdict:
    """A verdict and the time during which it is current."""

    verdict: str
    time: float
    """Stamp [s]."""
    issued: float
    """Time from which it is credited [s]."""
    until: float
    """Stamp of the next verdict, but at most one period after its own [s]."""


def period_of(criteria: Criteria) -> float:
    """Return the length of a healthy period, which is also the time for which a verdict is current [s]."""
    return max(criteria.silence, SHORTEST_PERIOD)


def credit(expectation: Expectation, diagnoses: Sequence[ReceivedDiagnosis], criteria: Criteria) -> Credit:
    """Return what a scenario contributes to the exam score."""
    period = period_of(criteria)
    verdicts = _current_verdicts(expectation, diagnoses, period)
    periods, failed = _healthy_periods(expectation, verdicts, period)
    detection = (
        {profile.name: _detection(expectation, verdicts, diagnoses, profile, period) for profile in PROFILES} if expectation.faulty else {}
    )
    lasting = _current_verdicts(expectation, diagnoses, period, VERDICTS)
    judged = math.fsum(max(0.0, current.until - max(current.issued, expectation.begin)) for current in lasting)
    return Credit(detection, periods, failed, max(0.0, expectation.duration - judged))


def _current_verdicts(
    expectation: Expectation, diagnoses: Sequence[ReceivedDiagnosis], period: float, counted: Sequence[str] = ()
) -> list[_CurrentVerdict]:
    """Return the verdicts with the times during which they are current; "waiting" is no verdict.

    A verdict ends at the stamp of the next one, though that may arrive later. Between verdicts that are both ``counted`` there is no such
    gap, or a correct verdict that arrives late would be worth less than none.
    """
    given = sorted((d for d in diagnoses if d.verdict != "waiting"), key=lambda diagnosis: diagnosis.time)
    verdicts = []
    for number, diagnosis in enumerate(given):
        until = min(diagnosis.time + period, expectation.end)
        for later in map(given.__getitem__, range(number + 1, len(given))):
            if later.time >= until:
                break
            until = min(until, later.issued_at if {diagnosis.verdict, later.verdict} <= set(counted) else later.time)
        verdicts.append(_CurrentVerdict(diagnosis.verdict, diagnosis.time, diagnosis.issued_at, until))
    return verdicts


def _detection(
    expectation: Expectation, verdicts: Sequence[_CurrentVerdict], diagnoses: Sequence[ReceivedDiagnosis], profile: Profile, period: float
) -> float:
    """Return the credit for a fault: the weighted time during which an alarm, and the correct name, is current [-].

    A detection after n revolutions that lasts to the end is worth h(n) = 2^(-(n - n0)/N) with the grace n0 and the half-life N.
    """
    first = expectation.clean_until
    if any(current.time < first <= current.time + period and current.until >= first and is_alarm(current.verdict) for current in verdicts):
        return 0.0
    alarms = BEARING_FAULTS if expectation.verdict in BEARING_FAULTS else (expectation.verdict,)
    alarm, name = (_weight(expectation, diagnoses, counted, profile, period) for counted in (alarms, (expectation.verdict,)))
    return (1.0 - profile.naming) * alarm + profile.naming * name


def vehicle_detection(
    expectation: Expectation, own: Sequence[ReceivedDiagnosis], boxes: Sequence[Sequence[ReceivedDiagnosis]], criteria: Criteria
) -> dict[str, float]:
    """Return the credit by profile for a damaged box of a vehicle [-].

    ``own`` are the diagnoses of that box, ``boxes`` those of every box. The alarm may be on any box. Of the share of the name, half needs
    an alarm on the damaged box, and half its component on any box.
    """
    period = period_of(criteria)
    alarms = BEARING_FAULTS if expectation.verdict in BEARING_FAULTS else (expectation.verdict,)
    credits = {}
    for profile in PROFILES:
        alarm = max((_weight(expectation, box, alarms, profile, period) for box in boxes), default=0.0)
        named = max((_weight(expectation, box, (expectation.verdict,), profile, period) for box in boxes), default=0.0)
        place = _weight(expectation, own, alarms, profile, period)
        credits[profile.name] = (1.0 - profile.naming) * alarm + profile.naming * 0.5 * (place + named)
    return credits


def _weight(
    expectation: Expectation, diagnoses: Sequence[ReceivedDiagnosis], counted: Sequence[str], profile: Profile, period: float
) -> float:
    """Return the weight of the time during which one of the ``counted`` verdicts is current; all time after the onset weighs 1 [-]."""
    onset, end = expectation.onset, expectation.end
    final = end - FINAL * (end - onset)

    def worth(time: float) -> float:
        beyond = expectation.revolutions(onset, time) - GRACE
        return 1.0 if beyond <= 0.0 else 2.0 ** (-beyond / profile.half_life)

    weights = []
    for current in _current_verdicts(expectation, diagnoses, period, counted):
        if current.verdict not in counted:
            continue
        begin, until = max(current.issued, onset), current.until
        if begin < min(until, final):
            weights.append(worth(begin) - worth(min(until, final)))
        if max(begin, final) < until:
            weights.append(worth(final) * (until - max(begin, final)) / (end - final))
    return min(1.0, math.fsum(weights))


def _healthy_periods(expectation: Expectation, verdicts: Sequence[_CurrentVerdict], period: float) -> tuple[int, int]:
    """Return the number of healthy periods and of failed ones.

    The time before the onset is left out if the twin contains the same samples.
    """
    begin, end = expectation.healthy_span
    if end <= begin:
        return 0, 0
    count = max(1, math.floor((end - begin) / period + 1e-9))
    edges = [*(begin + number * period for number in range(count)), end]
    times = [current.time for current in verdicts]
    failed = 0
    for number, (start, until) in enumerate(pairwise(edges)):
        # A verdict is current for at most one period; twice that, so that rounding leaves none out.
        near = verdicts[bisect_left(times, start - 2.0 * period) : bisect_right(times, until)]
        failed += _failed(expectation, near, start, until, period, first=number == 0)
    return count, failed


def _failed(expectation: Expectation, verdicts: Sequence[_CurrentVerdict], begin: float, end: float, period: float, *, first: bool) -> bool:
    """Return whether a false alarm is current in a period, or no verdict is given in it and issued in time although the shaft turns."""
    for current in verdicts:
        clean = expectation.bearing_clean_until if current.verdict in BEARING_FAULTS else expectation.clean_until
        false = is_alarm(current.verdict) and (current.time < clean or clean >= expectation.end)
        # A verdict is overruled by one with the same stamp, but an alarm was raised all the same.
        if false and current.time <= end and min(current.until, clean) > begin:
            return True
    if not expectation.judgeable(begin, end):
        return False
    in_time = (current for current in verdicts if current.issued <= current.time + period)
    return not any((begin <= current.time if first else begin < current.time) and current.time <= end for current in in_time)
