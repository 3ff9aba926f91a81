"""The plan of a sweep over vehicles: one run for each box of each vehicle, in one task."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.sweep.design import Point
from dcrb_ros.sweep.division import in_several, splits, warnings_of
from dcrb_ros.sweep.identity import BEARING_ID, MACHINE
from dcrb_ros.sweep.identity import TRUTH as IDENTITY
from dcrb_ros.sweep.plan import Plan, PlannedRun, Task, digest
from dcrb_ros.sweep.vehicles.sweep import BOX, VEHICLE_SEED, VehicleSweep, placed
from dcrb_ros.vehicle.track import is_smooth

TOGETHER, DAMAGED = "together", "damaged"
"""Columns of the labels of boxes, beside `BOX`."""
TRUTH: Mapping[str, tuple[type, str]] = {
    **IDENTITY,
    MACHINE: (str, "the vehicle: shared by its boxes on all rides; never in two splits"),
    TOGETHER: (str, "shared by the boxes of one vehicle on one ride with one case, whose samples have one clock"),
    BOX: (str, "the axle box, such as axle_1.left"),
    DAMAGED: (str, "boxes with a damaged bearing and their faults, such as 'axle_1.left outer_ring'; empty if there are none"),
}


class VehiclePlan(Plan):
    """The runs of a sweep over vehicles; a vehicle is in one split with all its boxes."""

    unit, unit_column, remedy = "vehicle", MACHINE, "vary vehicle.seed"
    truth = TRUTH

    def __init__(self, sweep: VehicleSweep) -> None:
        super().__init__(sweep)
        self._seed = sweep.vehicle.journey.seed
        self._boxes = [box.name for box in sweep.vehicle.boxes]
        self._splits = {}
        for points in self._point_batches():
            vehicles = {self._vehicle(point) for point in points}
            self._splits |= splits(vehicles - self._splits.keys(), sweep.file.split)
        shares = sweep.file.split.model_dump(exclude={"apart"})
        empty = [name for name, share in shares.items() if share > 0.0 and name not in self._splits.values()]
        if empty:
            raise Refusal(
                f"the sweep has too few vehicles ({len(self._splits)}) for the split '{empty[0]}': vary vehicle.seed, or set "
                f"split.{empty[0]} to 0"
            )
        self.conditions = len(self._splits)
        # Rails and wheels follow from one seed, cross-talk from the other; vehicles may share both.
        seeds = {"track.seed": sweep.vehicle.track.seed, "paths.seed": sweep.vehicle.paths.seed}
        varied = {key for axes in (sweep.vary, *sweep.cases.values()) for key in axes}
        if is_smooth(sweep.vehicle.track) and not any(key.startswith("track.") or ".wheel." in key for key in varied):
            del seeds["track.seed"]  # nothing is drawn from it
        self.shared = {key: count for key, seed in seeds.items() if (count := in_several(self._rides(key, seed)))}

    @property
    def split_text(self) -> str:
        """How the vehicles are divided, for the data card."""
        warned = [f"\n* {sentence}" for sentence in warnings_of(self.shared).values()]
        return "\n".join(["All boxes of a vehicle, on all its rides, are in one split.", *warned])

    def groups(self) -> Iterator[Task]:
        """Yield the boxes of each vehicle with each case as a group."""
        known: set[str] = set()
        for point, cases in zip(self._points(), self._cases(), strict=False):
            # What the runs of a box have in common, whatever the case, is computed once.
            vehicle, condition, healthy = self._vehicle(point), self._condition(point), [self._common, self._difference(point)]
            boxes = [(box, digest([*healthy, box]), digest([condition, box]), digest([vehicle, box])) for box in self._boxes]
            for case, values in cases:
                changes = {**point, **placed(values)}
                together = digest([self._common, self._difference(changes)])
                if together in known:
                    continue
                first, seed = len(known) * len(boxes), int(changes.get(VEHICLE_SEED, self._seed))
                known.add(together)
                yield tuple(
                    PlannedRun(
                        first + k,
                        digest([together, box]),
                        case,
                        twin,
                        place,
                        self._splits[vehicle],
                        changes,
                        point,
                        "",
                        seed,
                        {BEARING_ID: bearing, MACHINE: vehicle, TOGETHER: together, BOX: box},
                    )
                    for k, (box, twin, place, bearing) in enumerate(boxes)
                )

    def _vehicle(self, point: Point) -> str:
        """Return the hash of the seed of the vehicle: points with one seed share the individuals of their bearings."""
        return digest(point.get(VEHICLE_SEED, self._seed))

    def _rides(self, key: str, default: int) -> Iterator[tuple[str, str]]:
        """Yield the value of a seed of the vehicle and the split of every ride."""
        for point, cases in zip(self._points(), self._cases(), strict=False):
            for _, values in cases:
                yield str({**point, **values}.get(key, default)), self._splits[self._vehicle(point)]
