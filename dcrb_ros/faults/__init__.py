"""The faults that a bearing can have: one file per kind, listed in `KINDS`."""

from __future__ import annotations

from pkgutil import resolve_name
from typing import TYPE_CHECKING

from dcrb_ros.faults.fault import Fault
from dcrb_ros.faults.group import FaultGroup, fault_group

KINDS = (
    "dcrb_ros.faults.raceway_defect:OuterRacewayDefect",
    "dcrb_ros.faults.raceway_defect:InnerRacewayDefect",
    "dcrb_ros.faults.roller_defect:RollerDefect",
    "dcrb_ros.faults.broken_bars:BrokenBars",
    "dcrb_ros.faults.lubricant_loss:LubricantLoss",
    "dcrb_ros.faults.overfilled_grease:OverfilledGrease",
    "dcrb_ros.faults.seal_rub:SealRub",
    "dcrb_ros.faults.lost_clearance:LostClearance",
)
"""Every kind of fault as module and class, in the order of the parameters."""

if TYPE_CHECKING:
    Faults = FaultGroup
else:
    Faults = fault_group([resolve_name(kind) for kind in KINDS])
    """The group ``faults`` of the configuration."""

__all__ = ["KINDS", "Fault", "Faults"]
