"""The growth of a fault."""

from __future__ import annotations

from collections import deque

import numpy as np

from dcrb_ros.schema.verdicts import Verdict

FEWEST_POINTS = 4
"""Fewest judgements to which a trend is fitted."""


class Trend:
    """Slope of a straight line through the severity of a fault in decibels."""

    def __init__(self, seconds: float, interval: float) -> None:
        """Fit the last ``seconds``, with a judgement every ``interval`` [s]."""
        self._points: deque[tuple[float, float]] = deque(maxlen=max(FEWEST_POINTS, round(seconds / interval)))
        self._oldest = max(seconds, FEWEST_POINTS * interval)
        """Age of the oldest judgement that counts [s]."""
        self._verdict: Verdict = "waiting"

    def slope(self, time: float, verdict: Verdict, severity: float) -> float:
        """Take the severity [m/s^2] at a time [s]; return its growth since the verdict was first made [dB/min].

        A time that is not after that of the call before begins a new signal.
        """
        restarted = bool(self._points) and time <= self._points[-1][0]
        if verdict != self._verdict or severity <= 0.0 or restarted:
            self._points.clear()
            self._verdict = verdict
        while self._points and time - self._points[0][0] > self._oldest:
            self._points.popleft()
        if severity > 0.0:
            self._points.append((time, 20.0 * float(np.log10(severity))))
        if len(self._points) < FEWEST_POINTS:
            return 0.0
        times, levels = np.array(self._points).T
        centred = times - times.mean()
        return float(60.0 * (centred @ levels) / (centred @ centred))
