"""Profiles of the exam score: weights of delays, wrong names and false alarms for each kind of user."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Profile:
    """The weights of the exam score for one kind of user."""

    name: str
    about: str
    half_life: float
    """Shaft revolutions after which a detection is worth half [-]; infinite if a delay costs nothing."""
    naming: float
    """Share of a detection's credit that requires the correct name, 0 .. 1 [-]."""
    alarms: float
    """Exponent of the factor for false alarms and silence [-]."""


PROFILES = (
    Profile("safety", "a missed or late alarm costs more than a false one or a wrong name", half_life=50.0, naming=0.2, alarms=0.5),
    Profile("cost", "maintenance is planned in days, and every false alarm stops a machine", half_life=math.inf, naming=0.5, alarms=2.0),
    Profile("research", "detection and naming count alike, with a moderate cost of delay", half_life=100.0, naming=0.5, alarms=1.0),
)
HEADLINE = "research"
"""Name of the profile by which tables are sorted."""
HEADLINE_PROFILE = next(profile for profile in PROFILES if profile.name == HEADLINE)
