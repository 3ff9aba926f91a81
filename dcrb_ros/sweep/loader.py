"""Loading of a sweep file: every key and value is checked, and an invalid one is refused in one sentence."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from dcrb_ros.schema.parameter_field import ParameterField
from dcrb_ros.schema.refusal import Refusal, nearest, repeated
from dcrb_ros.settings.files import fields_by_key, flatten, load_configuration, overlaid, unknown_parameter
from dcrb_ros.settings.shipped import find_configuration, find_shipped
from dcrb_ros.settings.vehicle_speed import SPEED, SPEED_KMH
from dcrb_ros.simulation.scenario import read_scenario_file
from dcrb_ros.stream.late_scenario import refuse_late
from dcrb_ros.sweep.axes import GAP_PARAMETERS, axes_of, refuse_fixed, value_of
from dcrb_ros.sweep.design import GRID, Axes, Choice, Span
from dcrb_ros.sweep.lives.loader import common_keys, life_sweep_of
from dcrb_ros.sweep.lives.recipe import LIFE
from dcrb_ros.sweep.machine import BASE, MACHINE, around_machine
from dcrb_ros.sweep.sweep_file import (
    ABOUT,
    COPY,
    KEPT_BASE,
    LONGEST_RUN,
    MOST_RUNS,
    NO_FAULTS,
    SCENARIO,
    Shares,
    Sweep,
    SweepFile,
    Windows,
)
from dcrb_ros.sweep.vehicles.loader import vehicle_keys, vehicle_sweep_of
from dcrb_ros.sweep.vehicles.sweep import VEHICLE, VehicleSweep
from dcrb_ros.text.files import checked_path, is_file, read_text
from dcrb_ros.text.json import LARGEST, parsed_json
from dcrb_ros.text.yaml import read_yaml

CASE_GROUPS = ("faults", "background", "sensor")
"""Groups of parameters that a case may set: the faults and their measurement. All others are conditions of the bearing."""
FIXED = "set"
HEALTHY = "healthy"
SHORTEST_SETTLE = 0.005
"""Shortest time between a branch and the first recorded sample [s]; it exceeds the impulse response of the filters."""


def read_sweep(source: str | Path, machine: str | None = None) -> Sweep:
    """Return the sweep given by a file or by a shipped name, around a calibrated ``machine`` instead of its base and path if one is given.

    Raises:
        Refusal: an unknown key, a value out of range, an empty design, or values that contradict each other.
    """
    path = find_shipped("sweep", source)
    tree = read_yaml(path)
    if not isinstance(tree, Mapping):
        raise Refusal(f"{path} is not a sweep: it must have keys such as 'base', 'vary', 'cases' and 'duration'")
    keys = {str(key): value for key, value in tree.items()}
    if machine is not None:
        fixed = keys.get(FIXED, {})
        if isinstance(fixed, Mapping):  # the path of the machine replaces that of the sweep, as its configuration replaces the base
            keys[FIXED] = {key: value for key, value in flatten(fixed).items() if not key.startswith("structure.")}
        if VEHICLE in keys:
            raise Refusal(f"{path} is a sweep over vehicles, which has no machine of a single bearing: leave out --machine")
        keys = {key: value for key, value in keys.items() if key != BASE} | {MACHINE: str(Path(machine).absolute())}
    kept, name = kept_inputs(path) if path.name == COPY and machine is None else {}, VEHICLE if VEHICLE in keys else BASE
    if kept and keys.get(name, SweepFile.model_fields[BASE].default) == kept["sweep"].get(name):
        if keys.get(FIXED, {}) != kept["sweep"].get(FIXED, {}):
            raise Refusal(
                f"{path}: '{FIXED}' was changed, but {KEPT_BASE} beside it has the former values, also of a removed key: restore it, or "
                f"copy {COPY} to a new folder beside its own base"
            )
        return kept_sweep(keys, path, kept["scenarios"])
    return sweep_of(keys, str(path), path.parent, read_text(path))


def kept_inputs(path: Path) -> Mapping[str, Any]:
    """Return the inputs that a data set keeps beside its sweep file, with ``sweep`` and ``scenarios``; empty for another sweep file."""
    about = path.with_name(ABOUT)
    inputs = parsed_json(read_text(about, LARGEST), str(about)) if is_file(about) and is_file(path.with_name(KEPT_BASE)) else None
    if isinstance(inputs, dict) and all(isinstance(inputs.get(part), dict) for part in ("sweep", "scenarios")):
        return inputs
    return {}


def kept_sweep(tree: Mapping[str, Any], path: Path, scenarios: Mapping[str, Any]) -> Sweep:
    """Return the sweep of a data set with the base and the scenarios that it keeps, whose files may be elsewhere or changed."""
    name = VEHICLE if VEHICLE in tree else BASE
    sweep = sweep_of({**tree, name: KEPT_BASE}, str(path), path.parent, read_text(path), scenarios)
    written = str(tree.get(name, SweepFile.model_fields[BASE].default))
    if isinstance(sweep, VehicleSweep):
        return replace(sweep, source=written)
    return replace(sweep, file=sweep.file.model_copy(update={BASE: written}))


def sweep_of(
    tree: Mapping[str, Any], source: str, folder: Path = Path(), text: str = "", scenarios: Mapping[str, Any] | None = None
) -> Sweep:
    """Return the sweep described by a tree read from YAML.

    Other files are also looked for relative to ``folder``, apart from those of known ``scenarios``.
    """
    if VEHICLE in tree:
        file = _file(vehicle_keys(tree, source), source)
        fleet = vehicle_sweep_of(tree[VEHICLE], file, source, folder, text)
        _check_design(fleet, source)
        _check_windows(fleet, source)
        return fleet
    if tree.get("kind", "") == LIFE:
        return life_sweep_of(tree, source, sweep_of(common_keys(tree, source), source, folder, text))
    if MACHINE in tree:
        around, resolved = around_machine(tree, source, folder)
        sweep = sweep_of(around, source, folder, resolved)
        return replace(sweep, file=sweep.file.model_copy(update={"base": KEPT_BASE}))
    if "kind" in tree:
        raise Refusal(f"{source}: kind = {tree['kind']!r} is not {LIFE}: give {LIFE}, or leave it out for a design of single runs")
    file = _file(tree, source)
    fields = fields_by_key()
    fixed = {
        key: value_of(key, value, _known(key, fields, f"{source}: set"), f"{source}: set") for key, value in flatten(file.fixed).items()
    }
    base = overlaid(flatten(load_configuration(_beside(file.base, folder)).model_dump()), fixed)
    vary = _axes(file.vary, file.design, fields, f"{source}: vary")
    refuse_fixed(vary, fixed, source)
    cases = {name: _axes(case, file.design, fields, f"{source}: cases.{name}") for name, case in file.cases.items()} or {"base": {}}
    if file.twins:
        if cases.get(HEALTHY):
            raise Refusal(f"{source}: with twins, the case '{HEALTHY}' is the twin of all others and must be empty: rename this case")
        cases = {HEALTHY: {key: Choice((value,)) for key, value in NO_FAULTS.items()}, **{k: v for k, v in cases.items() if k != HEALTHY}}
    sweep = Sweep(file, text, base, vary, cases, _scenarios([vary, *cases.values()], folder, scenarios or {}))
    _consistent(sweep, fields, source)
    return sweep


def _file(tree: Mapping[str, Any], source: str) -> SweepFile:
    known = [*(info.alias or name for name, info in SweepFile.model_fields.items()), MACHINE, VEHICLE]
    for key in tree:
        if key not in known:
            raise Refusal(f"{source}: unknown key '{key}'{nearest(key, known)}; a sweep has {', '.join(known)}")
    try:
        return SweepFile.model_validate(tree)
    except ValidationError as error:
        raise Refusal(f"{source}: {_sentence(error.errors()[0])}") from None


def _sentence(problem: ErrorDetails) -> str:
    key = ".".join(str(part) for part in problem["loc"] if part not in ("int", "list[int]"))
    if problem["type"] == "missing":
        return f"'{key}' is missing" + (": give the recorded time of each run in seconds" if key == "duration" else "")
    if problem["type"] == "extra_forbidden":
        known = list(Windows.model_fields if problem["loc"][0] == "windows" else Shares.model_fields)
        return f"unknown key '{key}'{nearest(str(problem['loc'][-1]), known)}; known are {', '.join(known)}"
    reason = problem["msg"].removeprefix("Value error, ").removeprefix("Input ").lower()
    return f"{key}: {reason}" if problem["type"] == "value_error" else f"{key} = {problem['input']!r}: it {reason}"


def _known(key: str, fields: Mapping[str, ParameterField], source: str) -> ParameterField:
    if key not in fields:
        raise Refusal(f"{source}: {unknown_parameter(key)}")
    if key == "simulation.seed":
        raise Refusal(f"{source}: simulation.seed cannot be set here: use 'seeds', a count or a list such as [1, 2]")
    return fields[key]


def _axes(tree: Mapping[str, Any], design: str, fields: Mapping[str, ParameterField], source: str) -> Axes:
    return axes_of(tree, design, source, lambda key, _: None if key == SCENARIO else _known(key, fields, source))


def _beside(name: str, folder: Path) -> Path:
    """Return the path of a sweep's configuration: in the folder of the sweep file, or as for any other command."""
    path = checked_path(folder / name)
    return path if is_file(path) else find_configuration(name)


def _scenarios(all_axes: list[Axes], folder: Path, known: Mapping[str, Any]) -> dict[str, Any]:
    """Return the scenarios named by axes, as read from YAML, or as ``known``."""
    names = {str(name) for axes in all_axes if SCENARIO in axes for name in axes[SCENARIO].grid() if name}
    beside = {name: folder / name for name in sorted(names)}
    return {
        name: known[name] if name in known else read_scenario_file(path if is_file(checked_path(path)) else Path(name))
        for name, path in beside.items()
    }


def _consistent(sweep: Sweep, fields: Mapping[str, ParameterField], source: str) -> None:
    """Refuse values that contradict each other."""
    _check_design(sweep, source)
    for name, axes in sweep.cases.items():
        for key in axes:
            if key != SCENARIO and key.split(".")[0] not in CASE_GROUPS:
                raise Refusal(f"{source}: cases.{name}: {key} is a condition of the bearing, not a fault: move it to 'vary'")
    if sweep.file.twins and SCENARIO in sweep.vary:
        _twins(sweep, source)
    if sweep.file.branch_at:
        _branching(sweep, fields, source)
    _check_scenarios(sweep, source)
    _check_output(sweep, source)


def _check_design(sweep: Sweep, source: str) -> None:
    """Refuse a design without runs, or with too many."""
    file = sweep.file
    if file.design == GRID and file.points:
        raise Refusal(
            f"{source}: points = {file.points} applies to the designs random and latin_hypercube only: remove it, "
            "the values of a grid determine its points"
        )
    if file.design == GRID and "seed" in file.model_fields_set:
        raise Refusal(
            f"{source}: seed = {file.seed} is that of the designs random and latin_hypercube: remove it, or give 'seeds' of the noise"
        )
    if file.design != GRID and not file.points:
        raise Refusal(f"{source}: a {file.design} design needs 'points': give the number of conditions, above 0")
    seeds = [file.seeds] if isinstance(file.seeds, int) else file.seeds
    if not seeds or min(seeds) < (1 if isinstance(file.seeds, int) else 0) or max(seeds) > 2**31 - 1:
        raise Refusal(
            f"{source}: seeds = {file.seeds!r} is invalid: give the number of seeds per condition, at least 1, or a list of seeds within "
            f"0 .. {2**31 - 1}"
        )
    if (twice := repeated(seeds)) is not None:
        raise Refusal(f"{source}: seeds has {twice} twice, which gives the same runs: give every seed once")
    if sweep.count > MOST_RUNS:
        raise Refusal(f"{source} defines {sweep.count} runs; a sweep has at most {MOST_RUNS}: give fewer points, values, seeds or cases")


def _check_output(sweep: Sweep, source: str) -> None:
    """Refuse two forms of the speed, 0 km/h, which changes nothing, and runs that the files of the data set cannot represent."""
    file = sweep.file
    in_memory = file.output != "bag" or file.windows is not None
    if in_memory and file.duration > LONGEST_RUN:
        raise Refusal(
            f"{source}: duration = {file.duration:g} s is above {LONGEST_RUN:g} s, too long for memory: use 'output: bag' without windows"
        )
    if {SPEED, SPEED_KMH} <= {*flatten(file.fixed), *sweep.vary}:
        raise Refusal(f"{source}: {SPEED} and {SPEED_KMH} under 'set' and 'vary' are two forms of one parameter: give one of them")
    if SPEED_KMH in sweep.vary and 0.0 in sweep.vary[SPEED_KMH].grid():
        raise Refusal(f"{source}: vary: {SPEED_KMH} = 0.0 km/h stands for no speed in km/h: vary {SPEED} [rad/s] for runs at standstill")
    gaps = [key for key in GAP_PARAMETERS if sweep.base[key] or key in sweep.vary]
    if in_memory and gaps:
        raise Refusal(
            f"{source}: {gaps[0]} causes gaps, which waveform files and windows cannot represent: use 'output: bag' without windows"
        )
    _check_windows(sweep, source)


def _check_windows(sweep: Sweep, source: str) -> None:
    """Refuse runs without a sample, and windows that are longer than a run."""
    file, key = sweep.file, "sensor.sampling_rate"
    axes = [case.get(key) or sweep.vary.get(key) for case in sweep.cases.values()]
    rates = [[sweep.rate] if axis is None else [axis.low] if isinstance(axis, Span) else axis.values for axis in axes]
    lowest = min(float(rate) for values in rates for rate in values)
    if not round(file.duration * lowest):
        raise Refusal(f"{source}: duration = {file.duration:g} s has no sample at {lowest:g} Hz: give at least {1.0 / lowest:.3g} s")
    if file.windows is not None and file.windows.length > round(file.duration * lowest):
        raise Refusal(
            f"{source}: windows.length = {file.windows.length} samples is longer than a run of {file.duration:g} s, "
            f"{round(file.duration * lowest)} samples at {lowest:g} Hz: shorten the windows or lengthen the runs"
        )


def _check_scenarios(sweep: Sweep, source: str) -> None:
    """Refuse scenarios that change nothing in a run; an invalid one is refused with its runs."""
    end = sweep.file.settle + sweep.file.duration
    for name, tree in sweep.scenarios.items():
        refuse_late(tree, end, f"{source}: the scenario '{name}'", "increase duration or settle, or remove the scenario")


def _twins(sweep: Sweep, source: str) -> None:
    """Refuse scenarios of a condition that contain faults, since its healthy twin would be faulty."""
    for name in sweep.vary[SCENARIO].grid():
        if "faults." in json.dumps(sweep.scenarios.get(str(name))) or "'faults'" in str(sweep.scenarios.get(str(name))):
            raise Refusal(f"{source}: vary: the scenario '{name}' contains faults, so a twin would not be healthy: move it to a case")


def _branching(sweep: Sweep, fields: Mapping[str, ParameterField], source: str) -> None:
    if sweep.scenarios:
        raise Refusal(f"{source}: branch_at cannot be combined with a scenario, whose times are relative to the start: remove one")
    if sweep.file.settle < SHORTEST_SETTLE:
        raise Refusal(
            f"{source}: settle = {sweep.file.settle:g} s is below {SHORTEST_SETTLE:g} s, in which the faults appear after branch_at"
        )
    for name, axes in sweep.cases.items():
        for key in axes:
            if key != SCENARIO and not fields[key].run_time:
                raise Refusal(f"{source}: cases.{name}: {key} cannot change while the bearing runs: set branch_at to 0")
