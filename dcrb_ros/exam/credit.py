"""What one scenario contributes to the exam score: the credit for its fault, and its healthy periods."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from dcrb_ros.exam.criteria import Criteria
from dcrb_ros.exam.expectation import FEWEST_REVOLUTIONS, Expectation
from dcrb_ros.exam.profile import PROFILES, Profile
from dcrb_ros.messages.received_diagnosis import ReceivedDiagnosis
from dcrb_ros.schema.verdicts import BEARING_FAULTS, is_alarm

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
    spoiled: int = 0
    """Healthy periods in which a false alarm stood or no verdict was given [-]."""
    silent: float = 0.0
    """Time without a verdict [s]."""


@dataclass(frozen=True)
class _Standing:
    """A verdict and the time during which it stands."""

    verdict: str
    time: float
    """Stamp [s]."""
    issued: float
    """Time from which it is credited [s]."""
    until: float
    """Stamp of the next verdict, but at most one period after its own [s]."""


def period_of(criteria: Criteria) -> float:
    """Return the length of a healthy period, which is also the time for which a verdict stands [s]."""
    return max(criteria.silence, SHORTEST_PERIOD)


def credit(expectation: Expectation, diagnoses: Sequence[ReceivedDiagnosis], criteria: Criteria) -> Credit:
    """Return what a scenario contributes to the exam score."""
    period = period_of(criteria)
    standing = _standing(expectation, diagnoses, period)
    periods, spoiled = _healthy_periods(expectation, standing, period)
    detection = (
        {profile.name: _detection(expectation, standing, diagnoses, profile, period) for profile in PROFILES} if expectation.faulty else {}
    )
    spoken = math.fsum(max(0.0, one.until - max(one.issued, expectation.begin)) for one in standing)
    return Credit(detection, periods, spoiled, max(0.0, expectation.duration - spoken))


def _standing(
    expectation: Expectation, diagnoses: Sequence[ReceivedDiagnosis], period: float, counted: Sequence[str] = ()
) -> list[_Standing]:
    """Return the verdicts with the times during which they stand; "waiting" is no verdict.

    A verdict ends at the stamp of the next one, though that may arrive later. Between verdicts that are both ``counted`` there is no such
    gap, or a correct verdict that arrives late would be worth less than none.
    """
    given = sorted((d for d in diagnoses if d.verdict != "waiting"), key=lambda diagnosis: diagnosis.time)
    found = []
    for number, one in enumerate(given):
        until = min(one.time + period, expectation.end)
        for later in itertools.islice(given, number + 1, None):
            if later.time >= until:
                break
            until = min(until, later.issued_at if {one.verdict, later.verdict} <= set(counted) else later.time)
        found.append(_Standing(one.verdict, one.time, one.issued_at, until))
    return found


def _detection(
    expectation: Expectation, standing: Sequence[_Standing], diagnoses: Sequence[ReceivedDiagnosis], profile: Profile, period: float
) -> float:
    """Return the credit for a fault: the weighted time during which an alarm, and the correct name, stands [-].

    A detection after n revolutions that stands to the end is worth h(n) = 2^(-(n - n0)/N) with the grace n0 and the half-life N.
    """
    first = expectation.clean_until
    if any(one.time < first <= one.time + period and one.until >= first and is_alarm(one.verdict) for one in standing):
        return 0.0
    alarms = BEARING_FAULTS if expectation.verdict in BEARING_FAULTS else (expectation.verdict,)
    alarm, name = (
        _weight(expectation, [one for one in _standing(expectation, diagnoses, period, counted) if one.verdict in counted], profile)
        for counted in (alarms, (expectation.verdict,))
    )
    return (1.0 - profile.naming) * alarm + profile.naming * name


def _weight(expectation: Expectation, standing: Sequence[_Standing], profile: Profile) -> float:
    """Return the weight of the time during which verdicts stand; all the time after the onset weighs 1 [-]."""
    onset, end = expectation.onset, expectation.end
    final = end - FINAL * (end - onset)

    def worth(time: float) -> float:
        beyond = expectation.revolutions(onset, time) - GRACE
        return 1.0 if beyond <= 0.0 else 2.0 ** (-beyond / profile.half_life)

    weights = []
    for one in standing:
        begin, until = max(one.issued, onset), one.until
        if begin < min(until, final):
            weights.append(worth(begin) - worth(min(until, final)))
        if max(begin, final) < until:
            weights.append(worth(final) * (until - max(begin, final)) / (end - final))
    return min(1.0, math.fsum(weights))


def _healthy_periods(expectation: Expectation, standing: Sequence[_Standing], period: float) -> tuple[int, int]:
    """Return the number of healthy periods and of those that are spoiled.

    The time before the onset is left out if the twin contains the same samples.
    """
    begin, end = expectation.healthy_span
    if end <= begin:
        return 0, 0
    count = max(1, math.floor((end - begin) / period + 1e-9))
    edges = [*(begin + number * period for number in range(count)), end]
    spoiled = sum(_spoiled(expectation, standing, edges[k], edges[k + 1], period, first=k == 0) for k in range(count))
    return count, spoiled


def _spoiled(expectation: Expectation, standing: Sequence[_Standing], begin: float, end: float, period: float, *, first: bool) -> bool:
    """Return whether a false alarm stands in a period, or no verdict is given in it and issued in time although the shaft turns."""
    for one in standing:
        clean = expectation.bearing_clean_until if one.verdict in BEARING_FAULTS else expectation.clean_until
        false = is_alarm(one.verdict) and (one.time < clean or clean >= expectation.end)
        # A verdict is overruled by one with the same stamp, but an alarm was raised all the same.
        if false and one.time <= end and min(one.until, clean) > begin:
            return True
    if not expectation.judgeable(begin, end):
        return False
    in_time = (one for one in standing if one.issued <= one.time + period)
    return not any((begin <= one.time if first else begin < one.time) and one.time <= end for one in in_time)
