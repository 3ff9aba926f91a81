"""The kinds of sweeps, each with its plan."""

from __future__ import annotations

from dcrb_ros.sweep.lives.plan import LifePlan
from dcrb_ros.sweep.lives.sweep import LifeSweep
from dcrb_ros.sweep.plan import Plan
from dcrb_ros.sweep.sweep_file import Sweep
from dcrb_ros.sweep.vehicles.plan import VehiclePlan
from dcrb_ros.sweep.vehicles.sweep import VehicleSweep


def plan_of(sweep: Sweep) -> Plan:
    """Return the plan of a sweep of any kind."""
    if isinstance(sweep, VehicleSweep):
        return VehiclePlan(sweep)
    return LifePlan(sweep) if isinstance(sweep, LifeSweep) else Plan(sweep)
