"""The comparing detector of a vehicle: blocks of all axle boxes in, one diagnosis of the vehicle for every hop out.

Each box has a fault detector of its own. What they suspect is compared among the boxes before it becomes a verdict.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from dcrb_ros.diagnosis.detector import DEFAULTS, check_parameters
from dcrb_ros.diagnosis.hysteresis import Hysteresis, Suspicion, confidence, least_evidence, shortfall, strongest_of
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.rule import LEAST_EXCESS
from dcrb_ros.diagnosis.thermal_detector import with_trouble
from dcrb_ros.diagnosis.vehicle.box_watch import BoxHop, BoxWatch, boxes_apart
from dcrb_ros.diagnosis.vehicle.causes import (
    OTHERS,
    SAME_RAIL,
    Lag,
    backward_sides,
    crossed_rails,
    flats,
    kinks_of,
    lags,
    silent_boxes,
    track,
    wheelsets,
)
from dcrb_ros.diagnosis.vehicle.clocks import clock_differences, clocks
from dcrb_ros.diagnosis.vehicle.comparison import UNOPPOSED, Compared, Judgement, compare
from dcrb_ros.diagnosis.vehicle.contact import Contact
from dcrb_ros.diagnosis.vehicle.parameters import VehicleDetectorParameters
from dcrb_ros.diagnosis.vehicle.rolling_lines import corrugation, motor
from dcrb_ros.diagnosis.vehicle.turn_lines import gears, meshes, polygons
from dcrb_ros.schema.arguments import checked_arguments, of_type
from dcrb_ros.schema.refusal import Refusal, nearest
from dcrb_ros.schema.verdicts import Component, is_alarm
from dcrb_ros.stream.vehicle_description import VehicleDescription
from dcrb_ros.stream.vehicle_diagnosis import UNDECIDED, Status, VehicleDiagnosis

Samples: TypeAlias = tuple[int, npt.NDArray[Any], npt.NDArray[Any] | None]
"""Index of the first sample, accelerations and angles."""

RELATED: tuple[Component, ...] = ("roller", "cage")
"""Components whose faint lines are taken for one another: the cage modulates those of a damaged roller."""
VEHICLE_DEFAULTS = VehicleDetectorParameters()


@dataclass(frozen=True)
class BoxBlock:
    """Consecutive samples of one box; a `dcrb_ros.Block` serves as well."""

    index: int
    """Index of the first sample since the start."""
    acceleration: npt.NDArray[Any]
    """Shape (samples, axes) [m/s^2]."""
    shaft_angle: npt.NDArray[Any] | None = None
    """Rotation of the shaft, shape (samples,) [rad]; None without a tachometer."""


class BlockLike(Protocol):
    """What the detector reads of a block."""

    @property
    def index(self) -> int:
        """Index of the first sample since the start."""

    @property
    def acceleration(self) -> npt.NDArray[Any]:
        """Shape (samples, axes) [m/s^2]."""

    @property
    def shaft_angle(self) -> npt.NDArray[Any] | None:
        """Shape (samples,) [rad]."""


def check_box_parameters(parameters: DetectorParameters) -> None:
    """Check the parameters of the boxes without a description.

    Raises
    ------
    Refusal
        They do not fit each other, or name a baseline, which is that of a single bearing.
    """
    if parameters.baseline:
        raise Refusal(f"baseline = {parameters.baseline} is the baseline of a single bearing: leave it out for a vehicle")
    check_parameters(parameters)


class VehicleDetector:
    """Diagnoses the bearings, wheels and sensors of a vehicle from the blocks of its axle boxes, hop by hop.

    The memory is bounded by one window of every box. The diagnoses do not depend on the length of the blocks, except that `add` returns
    only the last one of blocks that are longer than a hop.

    Examples
    --------
    >>> import dcrb_ros
    >>> from dcrb_ros.vehicle.description import described
    >>> from dcrb_ros.vehicle.file import read_vehicle
    >>> vehicle = read_vehicle("bogie")
    >>> detector = dcrb_ros.VehicleDetector(described(vehicle))
    """

    @checked_arguments(
        description=of_type(VehicleDescription), parameters=of_type(VehicleDetectorParameters), box_parameters=of_type(DetectorParameters)
    )
    def __init__(
        self,
        description: VehicleDescription,
        parameters: VehicleDetectorParameters = VEHICLE_DEFAULTS,
        box_parameters: DetectorParameters = DEFAULTS,
    ) -> None:
        """Prepare for the boxes of a ``description``; ``box_parameters`` are those of the fault detector of each box.

        Raises
        ------
        Refusal
            The parameters do not fit each other or the sampling rate, or those of the boxes name a baseline.
        """
        check_box_parameters(box_parameters)
        self.description, self.parameters, self.box_parameters = description, parameters, box_parameters
        self._boxes = {box.name: BoxWatch(box, description.sampling_rate, parameters, box_parameters) for box in description.boxes}
        self._partners = description.partners
        p = box_parameters
        self._decided, self._undecided = (
            {name: Hysteresis(p.confirm, p.release, p.release_margin, p.persist, RELATED) for name in self._boxes} for _ in range(2)
        )
        self._hop = p.hop_samples(description.sampling_rate)
        self._patience = round(parameters.patience * description.sampling_rate)
        self._aligned = False
        self._confirmed: dict[tuple[str, str], Suspicion] = {}
        """How long each wheel or gear has had a verdict, by both."""

    def add(self, blocks: Mapping[str, BlockLike]) -> VehicleDiagnosis | None:
        """Take a block of some or all boxes, by name such as ``axle_1/left``; return a diagnosis if they complete a hop of all boxes.

        A box whose signal is behind or ahead of most others by more than `VehicleDetectorParameters.patience` is left out.

        Raises
        ------
        Refusal
            A box is unknown, what is given is no block, or it has arrays of another shape or type; the detector continues with the next
            blocks.
        """
        of_type(Mapping)("blocks", blocks)
        for name, block in blocks.items():
            self._known(name)
            if not all(hasattr(block, field) for field in BoxBlock.__annotations__):
                raise Refusal(f"{block!r} is not a block of {name}: give a BoxBlock with {', '.join(BoxBlock.__annotations__)}")
            if np.ndim(block.acceleration) == 0 or (block.shaft_angle is not None and np.ndim(block.shaft_angle) == 0):
                raise Refusal(
                    f"a block of {name} has an array without dimensions: give acceleration (samples, axes), shaft_angle (samples,)"
                )
        if blocks and not self._aligned:
            self._aligned, origin = True, min(int(block.index) for block in blocks.values())
            for watch in self._boxes.values():
                watch.align(origin)
        diagnosis = None
        for pieces in _divided(blocks, self._hop):
            restarted = [self._boxes[name].take(*piece) for name, piece in pieces.items()]
            if any(restarted):
                self._confirmed.clear()
            for watch in self._boxes.values():
                if any(restarted) and watch.name not in pieces:  # it restarts as well, or has fallen silent
                    watch.forget()
                watch.missed.update({name: len(samples) for name, (_, samples, _) in pieces.items()})
            for name in pieces:
                self._boxes[name].missed.clear()
            diagnosis = [diagnosis, *self._compared()][-1]
        return diagnosis

    def finish(self) -> tuple[VehicleDiagnosis, ...]:
        """Return the diagnoses of the last hops, which wait for boxes that are missing, at the end of the signals."""
        return tuple(self._compared(final=True))

    def take_temperature(self, box: str, time: float, temperature: float, ambient: float) -> None:
        """Take a reading at the outer ring of a box and one of the air at a time [s], both [deg C].

        Raises
        ------
        Refusal
            The box is unknown.
        """
        self._known(box).detector.take_temperature(time, temperature, ambient)

    def take_range(self, box: str, sensor_range: float) -> None:
        """Take the range of the sensor of a box [m/s^2] from the next samples on; 0, if it is not known, keeps the previous one.

        Raises
        ------
        Refusal
            The box is unknown.
        """
        detector = self._known(box).detector
        detector.sensor_range = sensor_range or detector.sensor_range

    def _known(self, name: str) -> BoxWatch:
        """Return the watch of a box."""
        if name not in self._boxes:
            raise Refusal(f"there is no box '{name}'{nearest(name, self._boxes)} (known: {', '.join(self._boxes)})")
        return self._boxes[name]

    def _compared(self, *, final: bool = False) -> Iterator[VehicleDiagnosis]:
        """Yield the diagnoses of the hops that all boxes, but those that are too late or apart, have reached; of all hops at the end."""
        apart = boxes_apart(self._boxes, self._patience, self.description.sampling_rate)
        for name in apart:
            self._boxes[name].hops.clear()
        together = [watch for name, watch in self._boxes.items() if name not in apart]
        newest = max(watch.reached for watch in together)
        while ready := [watch for watch in together if watch.hops]:
            first = min(watch.hops[0].index for watch in ready)
            if len(ready) < len(together) and newest - first <= self._patience and not final:
                return
            hops = {watch.name: watch.hops.popleft() for watch in ready if watch.hops[0].index == first}
            yield self._diagnosed(first, hops, apart)

    def _diagnosed(self, index: int, hops: Mapping[str, BoxHop], apart: Mapping[str, str]) -> VehicleDiagnosis:
        """Return the diagnosis of the vehicle from the hops of its boxes, and the reasons of those that are ``apart``."""
        q = self.parameters
        contacts = {name: hop.contact for name, hop in hops.items() if hop.contact is not None}
        measured = {name: contact for name, contact in contacts.items() if not hops[name].flaw}
        quiet, levels = silent_boxes(contacts, q), sum(contact.median > 0.0 for contact in contacts.values())
        rolling = {name: contact for name, contact in measured.items() if name not in quiet}
        struck = flats(rolling, q, self._partners_without("flat"))
        wheels = self._wheels(struck, polygons(rolling, q, self._partners_without("polygon")))
        sides = lags(self.description, measured, q.lag_tolerance)
        sensors = self._sensors(contacts, measured, sides)
        kinks = kinks_of(self.description, measured, struck, q.lag_tolerance)
        times = kinks.times if kinks is not None else np.zeros(0)
        judged = {
            name: self._boxes[name].detector.judgement(hop.own, times)
            for name, hop in hops.items()
            if hop.own is not None and name not in quiet
        }
        # Evidence for one of the related components keeps an alarm on the other.
        kept = {
            name: {*decided.confirmed, *(RELATED if set(decided.confirmed) & set(RELATED) else ())}
            for name, decided in self._decided.items()
        }
        compared = compare(judged, q, self._partners, kept)
        statuses: dict[str, Status] = {}
        indicators: dict[str, float] = {}
        for name in self._boxes:
            hop = hops.get(name)
            missing, expected = self._missing(name, index, apart)
            bearing = self._bearing(name, hop, judged.get(name), compared.get(name), quiet, missing)
            for finding in hop.troubles if hop is not None else ():
                bearing = dataclasses.replace(with_trouble(bearing, finding), score=max(bearing.score, finding.excess))
            statuses[f"{name}/bearing"] = bearing
            sensor = _sensor(hop, quiet.get(name), sensors.get(name), missing, levels=levels)
            unknown = sensor.reason if sensor.verdict == "sensor" else "no turn of the wheel is known yet"
            statuses[f"{name}/wheel"] = wheels.get(name, Status("waiting", unknown))
            statuses[f"{name}/sensor"] = Status("waiting", missing) if expected and hop is None else sensor
            if hop is not None:
                indicators |= {f"{name}/{line}": level for line, level in hop.diagnosis.levels.items()}
            for component, evidence in compared.get(name, {}).items():
                if evidence.rival and evidence.excess > LEAST_EXCESS:
                    indicators[f"{name}/{component}/contrast"] = evidence.contrast
            if name in contacts:
                indicators[f"{name}/wheel/level"] = contacts[name].level
        rails = track(kinks)
        found = meshes(self.description, rolling)
        for axle_name, status in gears(self.description, found, q).items():
            # Joints at equal distances make lines at fractions of a turn, as a motor does.
            line = motor(self.description.axle(axle_name), rolling, q) if rails.verdict == "healthy" else None
            meshing = self._lasting(f"{axle_name}/gear", status, "gear")
            turning = self._lasting(f"{axle_name}/gear", line or status, "motor")
            statuses[f"{axle_name}/gear"] = turning if turning.verdict == "motor" and meshing.verdict != "gear" else meshing
        indicators |= {f"{axle_name}/gear/level": mesh.level for axle_name, mesh in found.items()}
        waves = corrugation(self.description, rolling, q)
        if waves is not None:
            indicators |= waves[1]
        if rails.verdict == "healthy" and waves is not None and waves[0].verdict == "waiting":
            statuses["track"] = waves[0]
        else:
            along = self._lasting("track", waves[0] if waves is not None and rails.verdict == "healthy" else rails, "corrugation")
            statuses["track"] = along if rails.verdict == "healthy" else rails
        indicators |= {f"{axle}/clock": difference for axle, difference in clock_differences(self.description, contacts).items()}
        for side, lag in sides.items():
            indicators |= {f"{side}/lag": lag.found, f"{side}/lag/correlation": lag.forward}
        diagnoses = {name: hop.diagnosis for name, hop in hops.items()}
        return VehicleDiagnosis(index, index / self.description.sampling_rate, statuses, indicators, diagnoses)

    def _missing(self, name: str, index: int, apart: Mapping[str, str]) -> tuple[str, bool]:
        """Return why a box may have no hop that ends at a sample, and whether a sound sensor has none there, either."""
        watch, newest = self._boxes[name], max(other.reached for key, other in self._boxes.items() if key not in apart)
        if name in apart:
            return apart[name], False
        if watch.reached >= index:
            begins = index - watch.since <= self._patience + 2 * self._hop
            return ("its signal began anew", True) if begins else ("its signal has gaps", False)
        ends = watch.reached >= 0 and newest - watch.reached <= self._patience
        return ("its signal has ended", True) if ends else ("no signal arrives", False)

    def _sensors(self, contacts: Mapping[str, Contact], measured: Mapping[str, Contact], sides: Mapping[str, Lag]) -> dict[str, Status]:
        """Return the status of each sensor that measures the rail, but another one or at another time.

        The leading and the trailing wheelset are compared. Nothing is known of the sensors between them.
        """
        q, statuses = self.parameters, clocks(self.description, contacts, self.parameters)
        backward = backward_sides(sides)
        known = any(lag.forward >= SAME_RAIL for side, lag in sides.items() if side not in backward)
        crossed = not backward and crossed_rails(self.description, measured, q.lag_tolerance)
        for box in (box for box in self.description.boxes if box.axle in wheelsets(self.description)):
            if box.side in backward and known:
                reason = "the trailing wheelset follows the rail first: the sensors of this side are swapped"
                statuses[box.name] = Status("swapped", reason, 0.9)
            elif box.side in backward:
                reason = (
                    "the trailing wheelset follows the rail first on each side that can be judged: the vehicle runs backwards and its "
                    "angle has no sign, or all sensors are swapped"
                )
                statuses[box.name] = Status(UNDECIDED, reason)
            elif crossed:
                reason = (
                    "boxes follow those across: left and right sensors of one wheelset are swapped, but the signals do not say of which"
                )
                statuses[box.name] = Status(UNDECIDED, reason)
        return statuses

    def _wheels(self, struck: Mapping[str, Status], uneven: Mapping[str, Status]) -> dict[str, Status]:
        """Return the status of each wheel: that by flats unless it is healthy, else that by polygons.

        A flat makes lines at all orders, so that orders count only without one.
        """
        wheels = {}
        for name, status in struck.items():
            flat = self._lasting(name, status, "flat")
            polygon = self._lasting(name, uneven.get(name, status), "polygon")
            wheels[name] = flat if status.verdict != "healthy" or polygon.verdict == "healthy" else polygon
        return wheels

    def _partners_without(self, verdict: str) -> dict[str, str]:
        """Return the partners of the boxes whose wheels have no confirmed ``verdict``, which was confirmed beside the partner."""
        confirmed = {name for (name, kind), suspicion in self._confirmed.items() if kind == verdict and suspicion.confirmed}
        return {name: partner for name, partner in self._partners.items() if name not in confirmed}

    def _lasting(self, name: str, status: Status, verdict: str) -> Status:
        """Return the status of a part; a ``verdict`` on it must be present in consecutive hops."""
        p, present = self.box_parameters, status.verdict == verdict
        suspicion = self._confirmed.setdefault((name, verdict), Suspicion())
        if not suspicion.count(present=present, absent=not present, confirm=p.confirm, release=p.release) and present:
            return Status("waiting", f"to be confirmed by the next hop: {status.reason}", 0.0, status.score)
        return status

    def _bearing(
        self,
        name: str,
        hop: BoxHop | None,
        judgement: Judgement | None,
        compared: Mapping[Component, Compared] | None,
        quiet: Mapping[str, float],
        missing: str,
    ) -> Status:
        """Return the status of a bearing by its lines; ``missing`` says why it has no hop."""
        if hop is None:
            return Status("waiting", missing)
        diagnosis = hop.diagnosis
        if hop.own is None or compared is None or judgement is None:
            self._decided[name].reset()
            self._undecided[name].reset()
            if name in quiet:
                return Status("waiting", f"the sensor is {quiet[name]:.0f} dB quieter than the others")
            return Status("waiting", diagnosis.reason)
        p, scores = self.box_parameters, {component: finding.excess for component, finding in judgement.findings.items()}
        usual = least_evidence(p.confirm, hop.own.seconds, p.alarm_evidence)
        least = {component: max(usual, item.healthy) for component, item in compared.items()}
        own = {component: item.excess for component, item in compared.items()}
        open_ = {component: item.undecided for component, item in compared.items()}
        verdict, doubtful = self._decided[name].verdict(own, least), self._undecided[name].verdict(open_, least)
        if is_alarm(verdict):
            confirmed = self._decided[name].confirmed
            reasons = "; ".join(_reason(component, compared[component]) for component in confirmed)
            return Status(verdict, reasons, confidence(verdict, confirmed, own), max(own.values()))
        if is_alarm(doubtful):
            doubted = self._undecided[name].confirmed
            rivals = ", ".join(sorted({compared[component].rival for component in doubted}))
            reason = f"its lines are within {self.parameters.contrast:g} dB of those in {rivals}"
            if any(compared[component].unopposed for component in doubted):
                reason = f"it has lines of the {', '.join(doubted)}, but {UNOPPOSED}"
            return Status(UNDECIDED, reason, 0.0, max(open_.values()))
        others = {c: item for c, item in compared.items() if scores[c] >= 0.0 and item.contrast < 0.0}
        if others and verdict == "healthy":
            component, item = max(others.items(), key=lambda pair: scores[pair[0]])
            earlier = f", which measures the impacts {-item.lead * 1e3:.1f} ms earlier" if item.lead else ""
            reason = f"the lines of its {component} are {-item.contrast:.1f} dB weaker than in {item.rival}{earlier}"
            return Status(verdict, reason, confidence(verdict, [], own), max(own.values()))
        strongest = strongest_of(own, least)
        lacking = shortfall(own[strongest], least[strongest]) if own[strongest] >= 0.0 else "no lines of its own exceed all limits"
        reason = "to be confirmed by the next hop" if verdict == "waiting" else lacking
        return Status(verdict, reason, confidence(verdict, [], own) if verdict == "healthy" else 0.0, max(own.values()))


def _reason(component: Component, item: Compared) -> str:
    """Return the evidence for a fault of a component in words."""
    lines = item.finding.lines
    depth = f"at {lines.order:.3f} orders, depth {lines.depth:.2f}" if lines.order > 0.0 else "found"
    larger = f", {item.contrast:.1f} dB more than in {item.rival}" if item.rival else ""
    later = f", which measures the impacts {item.lead * 1e3:.1f} ms later" if item.lead else ""
    return f"lines of the {component} {depth}{larger}{later}"


def _sensor(hop: BoxHop | None, below: float | None, found: Status | None, missing: str, *, levels: int) -> Status:
    """Return the status of a sensor.

    ``found`` says if it measures another rail, or at another time, ``missing`` why it has no hop. ``levels`` boxes have a level to compare.
    """
    if hop is None:
        return Status("sensor", missing, 0.99)
    if hop.flaw:
        return Status("sensor", hop.flaw, 0.99)
    if below is not None:
        return Status("sensor", f"it measures the rail {below:.0f} dB weaker than the others", 0.99, below)
    alike = "it measures the rail as the others do" if levels > OTHERS else "three boxes are needed to compare its level"
    return found or Status("healthy", alike)


def _divided(blocks: Mapping[str, BlockLike], most: int) -> Iterator[dict[str, Samples]]:
    """Yield the samples of blocks in pieces of at most ``most`` samples, in the order of time."""
    pieces: dict[int, dict[str, Samples]] = {}
    for name, block in blocks.items():
        for number, first in enumerate(range(0, len(block.acceleration), most)):
            last = first + most
            angle = None if block.shaft_angle is None else block.shaft_angle[first:last]
            pieces.setdefault(number, {})[name] = block.index + first, block.acceleration[first:last], angle
    yield from (pieces[number] for number in sorted(pieces))
