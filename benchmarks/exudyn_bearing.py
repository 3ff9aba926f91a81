"""The bearing in Exudyn, a general multibody code in C++ (Gerstmayr 2023), compared with the production solver.

The Exudyn model has planar rigid bodies, contacts of circles by a power law with linear damping, and Coulomb friction that is
proportional to the slip below a limit. Rollers are pinned to the cages by joints or, for explicit integrators, which do not support
constraints, by stiff springs. The production solver runs with the same power law and pins; in addition it has LuGre bristles and the
lands. Johnson's law, defects and free rollers would require Python functions in Exudyn, which would make every step slow.

The load is reduced by a quarter at the start, and the velocity of the outer ring is compared 2 ms later.
"""

from __future__ import annotations

import importlib.util
import math
import sys
import time
from typing import Any, NamedTuple

import numpy as np

from dcrb_ros.bearing.observation import place_pinned_rollers
from dcrb_ros.bearing.payload import build_payload, initial_state, pocket_azimuths
from dcrb_ros.core.layout.workspace import workspace
from dcrb_ros.core.solver.step import advance
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.settings.files import load_configuration

SETTINGS = [
    "cage.joint=revolute",
    "contact.law=power",
    "contact.loss_time=0.0",
    "contact.damping=2000.0",
    "friction.static_coefficient=0.05",
]
CONFIGURATION = load_configuration("dry", SETTINGS)
SHARE = 0.75
"""Load from the start on, as a share of the initial load [-]."""
DURATION = 2e-3
"""[s]."""
DRIVEN = 1e6
"""Inertia of a ring whose rotation is prescribed, so large that torques have no effect [kg m^2]."""
STICK_SPEED = 0.01
"""Slip below which friction is proportional to it, equal to the Stribeck velocity of the production solver [m/s]."""
PIN_STIFFNESS, PIN_DAMPING = 1e11, 1e4
"""Springs that replace joints [N/m, N s/m]; fifty times as stiff as a contact, since softer ones would affect the rings."""
JOINED, SPRUNG = "GeneralizedAlpha", "VelocityVerlet"
"""Integrators of Exudyn: an implicit one for joints, an explicit one for springs."""
RUNS = ((JOINED, 1e-5), (JOINED, 2e-6), (SPRUNG, 5e-7))
"""Integrators and their steps [s]; at twice its step, the explicit one has an error of 10 %."""
EXACT_STEP = 2.5e-7
"""Step of the Exudyn run with which the others are compared [s]."""
FINE = 20
"""Number of steps of the exact production run in a default step [-]."""


class Found(NamedTuple):
    """Cost and result of a run."""

    seconds: float
    """Processor time [s]."""
    velocity: Floats
    """Velocity of the outer ring at the end, shape (2,) [m/s]."""


class Assembly:
    """The bodies and their connectors in the initial state of the production solver."""

    def __init__(self, joints: bool) -> None:
        sys.exudynFast = True  # type: ignore[attr-defined]  # its build without range checks
        import exudyn
        from exudyn import itemInterface

        self.exudyn, self.items, self._joints = exudyn, itemInterface, joints
        self.system = exudyn.SystemContainer().AddSystem()
        payload = build_payload(CONFIGURATION)
        self._state = initial_state(CONFIGURATION, payload)
        place_pinned_rollers(payload, self._state)
        self._assemble()
        self.system.Assemble()

    def _assemble(self) -> None:
        b, state = CONFIGURATION.bearing, self._state
        operating, housing = CONFIGURATION.operating, CONFIGURATION.housing
        inner = self._body(b.inner_ring_mass, DRIVEN, state.inner_position, state.inner_velocity, 0.0, state.shaft[1])
        self._ring = self._body(b.outer_ring_mass, DRIVEN, state.outer_position, state.outer_velocity, 0.0, 0.0)
        self.system.AddLoad(
            self.items.Force(markerNumber=self._marker(inner), loadVector=[operating.lateral_load, -SHARE * operating.load, 0.0])
        )
        ground = self.system.AddMarker(self.items.MarkerBodyPosition(bodyNumber=self.system.AddObject(self.items.ObjectGround())))
        self._spring(ground, self._marker(self._ring), housing.stiffness, housing.damping)
        rings = (self._marker(inner), b.inner_raceway_radius, False), (self._marker(self._ring), b.outer_raceway_radius, True)
        for row, azimuths in enumerate(pocket_azimuths(b)):
            (x, y, angle), (vx, vy, rate) = state.cage_position[row], state.cage_velocity[row]
            cage = self._body(b.cage_mass, b.cage_inertia, (x, y), (vx, vy), angle, rate)
            for i, azimuth in enumerate(azimuths):
                *velocity, spin = state.roller_velocity[row, i]
                roller = self._marker(self._body(b.roller_mass, b.roller_inertia, state.roller_position[row, i], velocity, 0.0, spin))
                self._pin(self._marker(cage, b.pitch_radius * np.array([np.sin(azimuth), -np.cos(azimuth)])), roller)
                for marker, radius, hollow in rings:
                    self._contact(roller, marker, radius, hollow)

    def _body(self, mass: float, inertia: float, position: Any, velocity: Any, angle: float, rate: float) -> int:
        """Add a body with its weight; return its index."""
        node = self.items.NodeRigidBody2D(initialCoordinates=[*position, angle], initialVelocities=[*velocity, rate])
        number = self.system.AddNode(node)
        body = self.system.AddObject(self.items.ObjectRigidBody2D(physicsMass=mass, physicsInertia=inertia, nodeNumber=number))
        weight = [0.0, -mass * CONFIGURATION.operating.gravity, 0.0]
        self.system.AddLoad(self.items.Force(markerNumber=self._marker(body), loadVector=weight))
        return int(body)

    def _marker(self, body: int, place: Any = (0.0, 0.0)) -> int:
        return int(self.system.AddMarker(self.items.MarkerBodyRigid(bodyNumber=body, localPosition=[*place, 0.0])))

    def _spring(self, one: int, other: int, stiffness: float, damping: float) -> None:
        plane = {"stiffness": [stiffness, stiffness, 0.0], "damping": [damping, damping, 0.0]}
        self.system.AddObject(self.items.ObjectConnectorCartesianSpringDamper(markerNumbers=[one, other], **plane))

    def _pin(self, pocket: int, roller: int) -> None:
        if self._joints:
            self.system.AddObject(self.items.ObjectJointRevolute2D(markerNumbers=[pocket, roller]))
        else:
            self._spring(pocket, roller, PIN_STIFFNESS, PIN_DAMPING)

    def _contact(self, roller: int, ring: int, radius: float, hollow: bool) -> None:
        contact, friction = CONFIGURATION.contact, CONFIGURATION.friction
        memory = self.system.AddNode(self.items.NodeGenericData(initialCoordinates=[0.0] * 4, numberOfDataCoordinates=4))
        self.system.AddObject(
            self.items.ObjectContactSphereSphere(
                markerNumbers=[roller, ring],
                nodeNumber=memory,
                spheresRadii=[CONFIGURATION.bearing.roller_radius, radius],
                isHollowSphere1=hollow,
                dynamicFriction=friction.kinetic_coefficient,
                frictionProportionalZone=STICK_SPEED,
                contactStiffness=contact.power_coefficient,
                contactStiffnessExponent=contact.power_exponent,
                contactDamping=contact.damping,
            )
        )

    def run(self, step: float, method: str) -> Found:
        """Return cost and result with a step [s]."""
        settings = self.exudyn.SimulationSettings()
        settings.timeIntegration.numberOfSteps, settings.timeIntegration.endTime = round(DURATION / step), DURATION
        settings.timeIntegration.newton.useModifiedNewton = True
        settings.timeIntegration.explicit.computeMassMatrixInversePerBody = True
        settings.linearSolverType = self.exudyn.LinearSolverType.EigenSparse
        settings.solutionSettings.writeSolutionToFile = False
        settings.parallel.numberOfThreads = 1
        begin = time.process_time()
        self.system.SolveDynamic(settings, solverType=getattr(self.exudyn.DynamicSolverType, method))
        seconds = time.process_time() - begin
        velocity = self.system.GetObjectOutputBody(self._ring, self.exudyn.OutputVariableType.Velocity, [0.0, 0.0, 0.0])
        return Found(seconds, np.array(velocity[:2]))


def exudyn_run(step: float, method: str) -> Found:
    """Return the run of one of Exudyn's integrators with a step [s]."""
    return Assembly(joints=method == JOINED).run(step, method)


def production_run(part: int) -> Found:
    """Return the run of the production solver at 1 / ``part`` of the default step, with the time of the fastest of several runs."""
    seconds = math.inf
    for _ in range(10):
        payload = build_payload(CONFIGURATION)
        payload = payload._replace(step=payload.step / part)
        state, work, steps = initial_state(CONFIGURATION, payload), workspace(payload), round(DURATION / payload.step)
        state.load[1] = state.target[2] = -SHARE * CONFIGURATION.operating.load
        acceleration, angles = np.empty((steps, 2)), np.empty(steps)
        begin = time.process_time()
        advance(payload, state, work, acceleration, angles)
        seconds = min(seconds, time.process_time() - begin)
    return Found(seconds, state.outer_velocity.copy())


def distance(found: Found, other: Found) -> str:
    """Return the difference of two velocities relative to the second, in percent."""
    return f"{100.0 * np.linalg.norm(found.velocity - other.velocity) / np.linalg.norm(other.velocity):.2f} %"


def main() -> None:
    """Print a table, or a note if Exudyn is not installed."""
    if importlib.util.find_spec("exudyn") is None:
        print("\nExudyn is not installed: `pip install '.[bench]'` adds it to the comparison.")
        return
    ours, exact, limit = production_run(1), production_run(FINE), exudyn_run(EXACT_STEP, JOINED)
    print("\n| smooth raceways, power law | x real time | production is faster by | from own limit | from it |\n|---|---|---|---|---|")
    print(f"| production, default step | {DURATION / ours.seconds:.3g} | 1 | {distance(ours, exact)} | |")
    for method, step in RUNS:
        found = exudyn_run(step, method)
        factors = f"{DURATION / found.seconds:.3g} | {found.seconds / ours.seconds:.3g}"
        print(f"| Exudyn {method}, {1e6 * step:g} us | {factors} | {distance(found, limit)} | {distance(found, exact)} |", flush=True)


if __name__ == "__main__":
    main()
