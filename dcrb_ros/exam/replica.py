"""The replica of a set of measured recordings: an exam of simulated machines with the same bearings, speeds, rates, lengths and faults.

Only the table is read. No recording is opened, so that no sample of a faulty bearing can enter a replica.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from dcrb_ros.exam.criteria import UNLIMITED
from dcrb_ros.exam.exam_file import GAIN_TAG, MACHINE_TAG, MOST_CASES, exam_of
from dcrb_ros.exam.led_signal import LEAD, form_of
from dcrb_ros.exam.measured import FOUND, KNOWN, LEAST_TURNS, SHORTEST, MeasuredRecording, read_table
from dcrb_ros.exam.replica_geometry import bearing_settings, geometry_of, longest_step
from dcrb_ros.exam.replica_priors import (
    AXLE,
    AZIMUTH,
    BACKGROUND,
    BOX,
    DEPTH,
    FLOOR,
    GAIN,
    HOUSINGS,
    LINES,
    LOAD,
    PARTS,
    SEEDS,
    SHARE,
    WIDTH,
    drawn,
    generator_of,
)
from dcrb_ros.runtime.version import __version__
from dcrb_ros.schema.refusal import Refusal, nearest
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import changed, fields_by_key, load_configuration
from dcrb_ros.settings.measured_rate import rates
from dcrb_ros.settings.parameters import rpm
from dcrb_ros.simulation.healthy_level import healthy_level
from dcrb_ros.text.counts import counted
from dcrb_ros.text.files import read_bytes
from dcrb_ros.text.tables import LARGEST_TABLE

BENCH = "ball_bearing_6205"
BALLS = "hertz"
"""Contact law of a bench with balls."""
LEVEL_TIME = 0.3
"""Time over which the level of a healthy machine is simulated, to which its background refers [s]."""
FAULTS = {"outer_ring": "outer_1", "inner_ring": "inner_1", "roller": "roller_1"}
"""Defect of the bench for each verdict that a replica can have."""
RANGE = 1e4
"""Range of the sensor at a gain of 1 [m/s^2]."""


@dataclass(frozen=True)
class ReplicaPlan:
    """How a replica is made."""

    seed: int = 1
    machines: int = 6
    """Simulated machines for each measured one; each has a counterpart of every healthy recording [-]."""
    counterparts: int = 3
    """Counterparts of a faulty recording, on different machines [-]."""
    longest: float = 2.5
    """Longest part of a recording that is simulated and compared [s]."""
    bench: str = BENCH
    """Configuration on which the bearings are scaled."""
    without: tuple[str, ...] = ()
    """Parts that are left out, of `PARTS`."""

    def check(self) -> None:
        """Refuse values out of range."""
        if not 0 <= self.seed < SEEDS:
            raise Refusal(f"seed = {self.seed} is outside 0 .. {SEEDS - 1}: give a whole number in this range")
        if not 1 <= self.counterparts <= self.machines <= 64:
            raise Refusal(
                f"{self.counterparts} counterparts on {self.machines} machines are not possible: give 1 .. 64 machines and at most one "
                "counterpart of a faulty recording on each"
            )
        if not 1.0 <= self.longest <= 60.0:
            raise Refusal(f"longest = {self.longest:g} s is outside 1 .. 60 s: give the longest part of a recording to compare")
        unknown = next((part for part in self.without if part not in PARTS), None)
        if unknown is not None:
            raise Refusal(f"the part '{unknown}' is unknown: leave out one of {', '.join(PARTS)}{nearest(unknown, PARTS)}")

    @property
    def left_out(self) -> frozenset[str]:
        """Parts that are left out; a background needs a path."""
        return frozenset(self.without) | ({"background"} if "path" in self.without else set())


def replica_tree(table: Path, plan: ReplicaPlan, speed: str = "lines") -> dict[str, Any]:
    """Return the exam file of a replica as a tree for YAML; equal tables and plans give equal trees.

    Each machine of the table has `ReplicaPlan.machines` counterparts, drawn from `replica_priors.PRIORS`. Each of these has every healthy
    recording of the machine and its share of the faulty ones. A healthy run of `LEAD` precedes each; see `exam_scenarios`.

    Raises:
        Refusal: the table is invalid, a bearing has impossible orders, the bench cannot make a recording, or the plan is out of range.
    """
    plan.check()
    recordings, bench = read_table(table, speed), load_configuration(plan.bench)
    strange = next((recording for recording in recordings if recording.truth not in (*FAULTS, "healthy")), None)
    if strange is not None:
        raise Refusal(
            f"{table}: {strange.name} is {strange.truth}, which has no replica: leave it out (known: healthy, {', '.join(FAULTS)})"
        )
    count = sum(plan.machines if recording.truth == "healthy" else plan.counterparts for recording in recordings)
    if count > MOST_CASES:  # before healthy machines are simulated
        raise Refusal(
            f"{table}: {counted(len(recordings), 'recording')} would have {count} counterparts, but an exam has at most {MOST_CASES}: "
            "give fewer --machines or --counterparts, or leave recordings out of the table"
        )
    levels = _HealthyLevels(bench)
    scenarios = [scenario for recording in recordings for scenario in _counterparts(table, recording, recordings, bench, plan, levels)]
    tree = {
        "exam": f"replica of {table.resolve().parent.name}",
        "about": "Counterparts of measured recordings, made by dcrb exam replica; dcrb exam predictivity compares them",
        "base": plan.bench,
        "onset": 0.0,
        "criteria": {"delay": dict.fromkeys(FAULTS, UNLIMITED), "found": FOUND, "smallest_width": 0.0, "silence": UNLIMITED},
        "replica": {
            "table_sha256": table_digest(table),
            "speed": speed,
            "seed": plan.seed,
            "machines": plan.machines,
            "counterparts": plan.counterparts,
            "longest": plan.longest,
            "lead": LEAD,
            "without": list(plan.without),
            "dcrb_ros": __version__,
        },
        "scenarios": scenarios,
    }
    exam_of(tree, f"the replica of {table}")
    return tree


def table_digest(table: Path) -> str:
    """Return the SHA-256 of a table.

    Raises:
        Refusal: it cannot be read.
    """
    return hashlib.sha256(read_bytes(table, LARGEST_TABLE)).hexdigest()


def _counterparts(
    table: Path,
    recording: MeasuredRecording,
    recordings: Sequence[MeasuredRecording],
    bench: Configuration,
    plan: ReplicaPlan,
    levels: _HealthyLevels,
) -> Iterator[dict[str, Any]]:
    """Yield the scenarios of a recording."""
    fastest = fields_by_key()["operating.speed"].high
    if fastest is not None and 2.0 * math.pi * recording.speed > fastest:
        raise Refusal(
            f"{table}, {recording.name}: a speed of {60.0 * recording.speed:g} rpm is outside 0 .. {rpm(fastest):.0f} rpm of the bench: "
            "check the column of speeds, or leave it out of the table"
        )
    form = form_of(recording, {one.name: one.seconds for one in recordings}, recordings, plan.longest)
    if form.judged < SHORTEST:
        raise Refusal(
            f"{table}, {recording.name}: {form.judged:g} s are compared, since half of a healthy recording precedes the other, but a "
            f"verdict needs {SHORTEST:g} s: give a healthy recording of at least {2.0 * SHORTEST:g} s, or leave it out of the table"
        )
    turns = form.judged * recording.speed
    if turns < LEAST_TURNS:
        raise Refusal(
            f"{table}, {recording.name}: at {60.0 * recording.speed:g} rpm the shaft makes {turns:.2g} revolutions in the "
            f"{form.judged:g} s that are compared, but a verdict needs {LEAST_TURNS:g}: check the column of "
            "speeds, compare a longer part with --longest, or leave the recording out of the table"
        )
    sampled = fields_by_key()["sensor.sampling_rate"]
    low, high = sampled.low or 0.0, sampled.high or math.inf
    if not low <= recording.rate <= high:
        raise Refusal(
            f"{table}, {recording.name}: sampling_rate = {recording.rate} Hz is outside {low:g} .. {high:g} Hz of the bench: resample the "
            "recording, or leave it out of the table"
        )
    try:
        bearing = bearing_settings(geometry_of(recording.orders), bench, recording.pitch_radius)
        fixed = {**bearing, **rates(form.rate, longest_step(bearing, bench, recording.load))}
        changed(bench, fixed, "its bearing")
    except Refusal as refusal:
        raise Refusal(f"{table}, {recording.name}: {refusal}") from None
    if recording.truth == "healthy":
        numbers = range(plan.machines)
    else:
        # Faulty recordings of a machine are dealt out to its counterparts one after another.
        faulty = [other.name for other in recordings if other.machine == recording.machine and other.truth != "healthy"]
        first = faulty.index(recording.name) * plan.counterparts
        numbers = sorted((first + k) % plan.machines for k in range(plan.counterparts))  # type: ignore[assignment]
    for number in numbers:
        machine = f"{recording.machine}#{number + 1}"
        try:
            settings = _drawn_settings(recording, machine, bearing, bench, plan, partial(levels.level, machine, fixed))
            changed(bench, {**fixed, **settings}, "the bench")
        except Refusal as refusal:
            raise Refusal(f"{table}, {recording.name}: {refusal}") from None
        yield {
            "name": f"{recording.name}/{number + 1}",
            "verdict": recording.truth,
            "duration": form.judged,
            "seeds": [int(generator_of(plan.seed, machine, recording.name, "run").integers(1, SEEDS))],
            "twin": False,
            "required": recording.truth != "roller",
            "tags": {
                "rig": recording.rig,
                "recording": recording.name,
                MACHINE_TAG: machine,
                **({GAIN_TAG: KNOWN} if recording.gain_known else {}),
            },
            "set": {**fixed, **settings},
        }


def _drawn_settings(
    recording: MeasuredRecording,
    machine: str,
    bearing: Mapping[str, Any],
    bench: Configuration,
    plan: ReplicaPlan,
    levels: Callable[[float, Mapping[str, Any]], float],
) -> dict[str, Any]:
    """Return what is drawn for a recording of a simulated machine with a ``bearing``, whose load grows with the square of its pitch radius.

    ``levels`` returns its healthy level at a speed, for its parameters.
    """
    truth, kind = recording.truth, "balls" if bench.contact.law == BALLS else "rollers"
    of_machine = drawn("machine", truth, kind, generator_of(plan.seed, machine), plan.left_out)
    of_bearing = drawn("bearing", truth, kind, generator_of(plan.seed, machine, recording.bearing), plan.left_out)
    scale = bearing["bearing.pitch_radius"] / bench.bearing.pitch_radius
    gain, load = of_bearing.pop(GAIN), of_machine.pop(LOAD) * bench.operating.load * scale**2
    gain = 1.0 if recording.gain_known else gain
    housing = {"box_mass": BOX, "axle_mass": AXLE}
    masses = {f"housing.{key}": of_machine.pop(name) * getattr(bench.housing, key) for key, name in housing.items() if name in of_machine}
    fault = {name: of_bearing.pop(name) for name in (WIDTH, DEPTH, SHARE, AZIMUTH) if name in of_bearing}
    speed = 2.0 * math.pi * recording.speed
    settings = {
        "operating.speed": speed,
        "operating.load": load if recording.load is None else recording.load,
        **({} if "path" in plan.left_out else {"structure.housing": HOUSINGS[kind]}),
        **masses,
        **of_machine,
        **of_bearing,
    }
    if "background" not in plan.left_out:
        settings["structure.healthy_level"] = gain * levels(speed, settings)
        if bench.model_dump()["structure"]["healthy_speed"]:
            settings["structure.healthy_speed"] = 0.0  # the level is that at the speed of the recording
    return {
        **settings,
        "structure.gain_x": gain,
        "structure.gain_y": gain,
        "sensor.range": max(1.0, RANGE * gain),
        "sensor.adc_bits": 0,
        "sensor.noise_density": of_machine["sensor.noise_density"] * gain,
        **dict(_fault_settings(truth, fault, bearing)),
    }


class _HealthyLevels:
    """The levels of healthy simulated machines, each simulated once at the speed of its first recording and proportional to the speed."""

    def __init__(self, bench: Configuration) -> None:
        self._bench, self._known = bench, dict[str, float]()

    def level(self, machine: str, fixed: Mapping[str, Any], speed: float, settings: Mapping[str, Any]) -> float:
        """Return the level of a machine at a speed [rad/s], [m/s^2]; ``settings`` are those of its first recording."""
        if machine not in self._known:
            healthy = {key: value for key, value in {**fixed, **settings}.items() if key not in (BACKGROUND, LINES, FLOOR)}
            self._known[machine] = healthy_level(self._bench, LEVEL_TIME, settings=healthy) / abs(speed)
        return self._known[machine] * abs(speed)


def _fault_settings(truth: str, fault: Mapping[str, float], bearing: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield the parameters of the defect."""
    if truth == "healthy":
        return
    diameter = 2.0 * bearing["bearing.roller_radius"] / math.cos(bearing.get("bearing.contact_angle", 0.0))
    key = f"faults.{FAULTS[truth]}"
    yield f"{key}.width", fault[WIDTH] * diameter
    yield f"{key}.depth", fault[DEPTH]
    yield f"{key}.row", 1
    if truth == "roller":
        yield f"{key}.roller", 1
        return
    yield f"{key}.kind", "spall"
    yield f"{key}.share", fault[SHARE]
    if AZIMUTH in fault:
        yield f"{key}.azimuth", fault[AZIMUTH]
