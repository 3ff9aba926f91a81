"""Substitutes for the messages and services of `simulation_interfaces` that the simulator uses: the same fields and constants."""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from types import ModuleType
from typing import ClassVar

import pytest


@dataclass
class Result:
    RESULT_FEATURE_UNSUPPORTED: ClassVar[int] = 0
    RESULT_OK: ClassVar[int] = 1
    RESULT_NOT_FOUND: ClassVar[int] = 2
    RESULT_INCORRECT_STATE: ClassVar[int] = 3
    RESULT_OPERATION_FAILED: ClassVar[int] = 4
    result: int = 0
    error_message: str = ""


@dataclass
class SimulationState:
    STATE_STOPPED: ClassVar[int] = 0
    STATE_PLAYING: ClassVar[int] = 1
    STATE_PAUSED: ClassVar[int] = 2
    STATE_QUITTING: ClassVar[int] = 3
    STATE_NO_WORLD: ClassVar[int] = 4
    STATE_LOADING_WORLD: ClassVar[int] = 5
    state: int = 0


@dataclass
class SimulatorFeatures:
    SPAWNING: ClassVar[int] = 0
    DELETING: ClassVar[int] = 1
    NAMED_POSES: ClassVar[int] = 2
    POSE_BOUNDS: ClassVar[int] = 3
    SIMULATION_RESET: ClassVar[int] = 20
    SIMULATION_RESET_TIME: ClassVar[int] = 21
    SIMULATION_RESET_STATE: ClassVar[int] = 22
    SIMULATION_RESET_SPAWNED: ClassVar[int] = 23
    SIMULATION_STATE_GETTING: ClassVar[int] = 24
    SIMULATION_STATE_SETTING: ClassVar[int] = 25
    SIMULATION_STATE_PAUSE: ClassVar[int] = 26
    STEP_SIMULATION_SINGLE: ClassVar[int] = 31
    STEP_SIMULATION_MULTIPLE: ClassVar[int] = 32
    STEP_SIMULATION_ACTION: ClassVar[int] = 33
    features: list[int] = field(default_factory=list)
    spawn_formats: list[str] = field(default_factory=list)
    custom_info: str = ""


@dataclass
class Empty:
    """A request without fields."""


@dataclass
class OnlyResult:
    result: Result = field(default_factory=Result)


class GetSimulatorFeatures:
    Request = Empty

    @dataclass
    class Response:
        features: SimulatorFeatures = field(default_factory=SimulatorFeatures)


class GetSimulationState:
    Request = Empty

    @dataclass
    class Response:
        state: SimulationState = field(default_factory=SimulationState)
        result: Result = field(default_factory=Result)


class SetSimulationState:
    @dataclass
    class Request:
        state: SimulationState = field(default_factory=SimulationState)

    @dataclass
    class Response:
        ALREADY_IN_TARGET_STATE: ClassVar[int] = 101
        STATE_TRANSITION_ERROR: ClassVar[int] = 102
        INCORRECT_TRANSITION: ClassVar[int] = 103
        result: Result = field(default_factory=Result)


class StepSimulation:
    Response = OnlyResult

    @dataclass
    class Request:
        steps: int = 1


class ResetSimulation:
    Response = OnlyResult

    @dataclass
    class Request:
        SCOPE_DEFAULT: ClassVar[int] = 0
        SCOPE_TIME: ClassVar[int] = 1
        SCOPE_STATE: ClassVar[int] = 2
        SCOPE_SPAWNED: ClassVar[int] = 4
        SCOPE_ALL: ClassVar[int] = 255
        scope: int = 0


class SimulateSteps:
    @dataclass
    class Goal:
        steps: int = 0

    Result = OnlyResult

    @dataclass
    class Feedback:
        completed_steps: int = 0
        remaining_steps: int = 0


def install(patch: pytest.MonkeyPatch) -> None:
    """Let the messages, services and actions of `simulation_interfaces` be imported."""
    contents = {
        "simulation_interfaces": (),
        "simulation_interfaces.msg": (Result, SimulationState, SimulatorFeatures),
        "simulation_interfaces.srv": (GetSimulatorFeatures, GetSimulationState, SetSimulationState, StepSimulation, ResetSimulation),
        "simulation_interfaces.action": (SimulateSteps,),
    }
    for name, kinds in contents.items():
        module = ModuleType(name)
        vars(module).update({kind.__name__: kind for kind in kinds})
        patch.setitem(sys.modules, name, module)
