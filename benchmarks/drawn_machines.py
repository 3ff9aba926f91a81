"""Simulated machines with a bearing and its defects, drawn as `dcrb exam replica` draws the counterparts of measured recordings."""

from __future__ import annotations

import csv
import functools
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.exam.measured import COLUMNS, KNOWN
from dcrb_ros.exam.replica import ReplicaPlan, replica_tree

TRUTHS = {"healthy": "healthy", "outer": "outer_ring", "inner": "inner_ring", "ball": "roller"}
"""Class by kind of defect."""

Machine = Mapping[tuple[str, int], Mapping[str, Any]]
"""Settings of one machine by kind of defect and number of the speed; each kind is another bearing on it."""


@functools.cache
def drawn_machines(
    bench: str,
    orders: Orders,
    rate: int,
    speeds: tuple[float, ...],
    machines: int,
    *,
    load: float | None = None,
    without: tuple[str, ...] = (),
) -> list[Machine]:
    """Return machines with a bearing of some orders at some speeds [rpm], sampled at a ``rate`` [Hz] with one gain.

    The ``load`` [N] is drawn unless it is given. Parts ``without`` which machines are drawn change nothing else of them.
    """
    plan = ReplicaPlan(machines=machines, counterparts=machines, bench=bench, without=without)
    common = {"rig": "laboratory", "sampling_rate": rate, "unit": "m/s^2", "gain": KNOWN, "load": load or "", **orders.as_dict()}
    found: list[dict[tuple[str, int], Mapping[str, Any]]] = [{} for _ in range(machines)]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "recordings.csv"
        with path.open("w", newline="", encoding="utf-8") as stream:
            rows = csv.DictWriter(stream, (*COLUMNS, "gain", "load"))
            rows.writeheader()
            for kind, truth in TRUTHS.items():
                for number, speed in enumerate(speeds):
                    rows.writerow({**common, "name": f"{kind}_{number}", "truth": truth, "speed_rpm_documented": speed})
        for scenario in replica_tree(path, plan, "documented")["scenarios"]:
            recording, machine = scenario["name"].split("/")
            kind, number = recording.split("_")
            found[int(machine) - 1][kind, int(number)] = {**scenario["set"], "simulation.seed": scenario["seeds"][0]}
    return list(found)
