"""The vehicle around its bearings: what drives and loads them, and what track, wheels and other bearings do to each box.

Time goes in frames of `FRAME` steps that are counted from the start, so that no result depends on blocks. The structure's modes carry track
and wheels to the boxes up to 1 kHz, and other bearings up to 200 Hz, at every eighth step: ticks. Paths of drawn resonances carry the rest.
"""

from __future__ import annotations

import itertools
import math

import numpy as np

from dcrb_ros.measurement.filter_cache import cached_on_disk
from dcrb_ros.measurement.kernels import filtered
from dcrb_ros.schema.arrays import Complexes, Floats
from dcrb_ros.vehicle.description import Vehicle, Wheel
from dcrb_ros.vehicle.frame import FRAME, TICK, TICKS, Plan, Rolling, TrackEvent
from dcrb_ros.vehicle.kernels import add_motion_of_others, along_lines, between_ticks, modal_outputs, ramped
from dcrb_ros.vehicle.loads import quasi_static
from dcrb_ros.vehicle.paths import BANDS, Paths, bearing_paths, contact_paths
from dcrb_ros.vehicle.structure import BOX_MASS, Structure
from dcrb_ros.vehicle.track import Rails
from dcrb_ros.vehicle.traction import TractionForce
from dcrb_ros.vehicle.wheels import WheelSurface, positions

LOAD_CUTOFF = 20.0
"""Frequency above which dynamic loads do not reach the bearings [Hz]: above it, they resonate with the model's own housing."""
FORCE_CUTOFF = 200.0
"""Frequency above which the vibration of other bearings takes the drawn paths instead of the structure [Hz]."""
SETTLING = 2.0
"""Time for which the vehicle rolls before the start [s]."""
SLIDING = 10.0
"""Rate at which the speed of the circumference of a sliding wheel changes [m/s^2] (an assumption): half of a braking force of 9 kN, which
the rail no longer takes, on the 470 kg by which a wheelset resists turning."""
BEFORE, AHEAD = 3, 4
"""Ticks before and after a step from which the motion by track and wheels is interpolated [-]."""
SHAPE = 8.0
"""Shape of the Kaiser window of this interpolation [-]: the images of a tone up to 2 kHz are 75 dB below it."""


def tick_weights() -> Floats:
    """Return the weights of the ticks for every step between two of them, shape (TICK, BEFORE + 1 + AHEAD).

    They are a sinc function in a Kaiser window, rounded so that every processor has the same bits.
    """
    distance = np.arange(-BEFORE, AHEAD + 1) - np.arange(TICK)[:, None] / TICK
    window = np.i0(SHAPE * np.sqrt(np.maximum(1.0 - (distance / AHEAD) ** 2, 0.0)))
    weights = np.sinc(distance) * window
    return np.ascontiguousarray(np.round(weights / weights.sum(axis=1, keepdims=True), 9))


class VehicleModel:
    """Steps the vehicle: first `plan` of a frame, then, with the accelerations of its bearings, `mix`."""

    def __init__(self, vehicle: Vehicle) -> None:
        """Roll the vehicle until it is settled at time zero.

        Raises:
            Refusal: a parameter of the vehicle is invalid.
        """
        self.vehicle = vehicle
        self.rate = vehicle.boxes[0].configuration.step_rate
        self._interval = TICK / self.rate
        self._weights = tick_weights()
        self._rails = Rails(vehicle.track)
        self._sides = sorted({box.side for box in vehicle.boxes})
        self._behind = np.array([[axle.x] for axle in vehicle.axles])
        """Place of each wheelset from the middle of the bogie, shape (axles, 1) [m]."""
        self._radius = np.array([[axle.radius] for axle in vehicle.axles])
        self._creep = np.array([[axle.creep] for axle in vehicle.axles])
        self._wheels = [WheelSurface(vehicle, box) for box in vehicle.boxes]
        structure = Structure(vehicle)
        self._growth, before, after, read, direct = structure.modal(self._interval)
        count = len(vehicle.boxes)
        self._system = before, after, direct
        self._connect()
        self._traction = [TractionForce(axle, vehicle.journey.seed) for axle in vehicle.axles]
        self._read = np.ascontiguousarray(read)
        self._box_read = np.ascontiguousarray(read[:count])
        self._bearing_systems = [np.ascontiguousarray(part[:, count : 2 * count].T[:, :, None]) for part in (before, after, direct[:count])]
        self._track_state: Complexes = np.zeros(len(self._growth), np.complex128)
        self._bearing_states = np.zeros((count, len(self._growth)), np.complex128)
        self._load_memory = np.zeros((1, 2, count))
        self._load_sections = _lowpass(2, LOAD_CUTOFF, 1.0 / self._interval)
        self._force_sections = _lowpass(4, FORCE_CUTOFF, 1.0 / self._interval)
        self._force_memory = np.zeros((len(self._force_sections), 2, count))
        grids = [np.geomspace(low, high, 40) for low, high in itertools.pairwise(BANDS[:3])]
        gains = [math.sqrt(float(np.mean([abs(structure.response(f)[0, 0]) ** 2 for f in grid]))) for grid in grids]
        self._bearing_paths = Paths(bearing_paths(vehicle, self.rate), count, 2)
        self._contact_paths = Paths(contact_paths(vehicle, self.rate, gains), count, 1)
        self._next_jump = np.zeros(count)
        """Share of jumps in the last step of a frame that belongs to the first step of the next one, shape (boxes,) [m/s^2]."""
        self._ring_force = np.zeros(count)
        self._ring_motion = np.zeros((count, count))
        journey = vehicle.journey
        self.targets = {
            "speed": journey.speed_kmh / 3.6,
            "ramp": journey.ramp,
            "curvature": journey.curvature,
            "cant": journey.cant,
            "wind": journey.wind,
            "brake": journey.brake,
        }
        """What was commanded: speed [m/s] and its ramp [m/s^2], curvature [1/m], cant [m], wind [N], brake [m/s^2]."""
        self.slides = np.array([axle.slide for axle in vehicle.axles])
        """Share by which each wheelset is to slide, shape (axles,) [-]."""
        self._slide, self._slid = self.slides.copy(), np.zeros(len(vehicle.axles))
        """Share by which each wheelset slides now [-], and the largest speed at which it was to slide since it began [m/s]."""
        settled = int(SETTLING / (self._interval * TICKS)) + 1
        behind = settled * TICKS * self._interval * self.targets["speed"]
        self._speed, self._place = self.targets["speed"], -behind
        self._angle = np.array([-behind * (1.0 + axle.creep - axle.slide) / axle.radius for axle in vehicle.axles])
        self._rolled = -settled
        """Frame that the next call of `_roll` gives."""
        self._next = self._roll()
        for _ in range(settled):
            self._before, self._next = self._next.outputs[-BEFORE:], self._roll()
        self._jerked, self._kinks = self._contacts(self._next)

    def _connect(self) -> None:
        """Choose the inputs of the structure: contacts and gears, and the wheels if one has an unbalance."""
        count, axles = len(self.vehicle.boxes), len(self.vehicle.axles)
        self._unbalanced = any(wheel.unbalanced for wheel in self._wheels)
        on_wheels = range(2 * count + axles, 3 * count + axles) if self._unbalanced else ()
        self._track_system = _columns(*self._system, [*range(count), *range(2 * count, 2 * count + axles), *on_wheels])

    def wear(self, box: int, wheel: Wheel) -> None:
        """Give the wheel under a box other defects, from the frame after the planned one on.

        Raises:
            Refusal: the orders of the polygon cannot be read; nothing is changed.
        """
        self._wheels[box].wear(wheel)
        self._connect()

    @property
    def speed(self) -> float:
        """Speed at the end of the last planned frame [m/s]."""
        return float(self._next.speed[0])

    def shaft_speed(self) -> Floats:
        """Return the speed of each wheelset at the end of the last planned frame, shape (axles,) [rad/s]."""
        speed, creep = self._next.speed[0], self._next.creep[:, 0]
        return np.array([speed * (1.0 + creep[p]) / axle.radius for p, axle in enumerate(self.vehicle.axles)])

    def load(self) -> Floats:
        """Return the force on each inner ring at the end of the last planned frame, shape (boxes, 2) [N]."""
        asked = self.targets
        loads = quasi_static(self.vehicle, self._next.speed[0], asked["curvature"], asked["cant"], asked["wind"], asked["brake"])
        loads[:, 1] -= self._next.loads
        return loads

    def plan(self) -> Plan:
        """Return the next frame; commands given before act from its end on."""
        now, jerked, kinks = self._next, self._jerked, self._kinks
        self._next = self._roll()
        self._jerked, self._kinks = self._contacts(self._next)
        motion = between_ticks(np.vstack([self._before, now.outputs, self._next.outputs[:AHEAD]]), self._weights)
        self._before = now.outputs[-BEFORE:]
        self._contact_paths.add(jerked, motion[:, None])
        events = sorted([*now.slides, *kinks], key=lambda event: (event.time, event.box))
        speed, place = float(now.speed[0]), float(now.place[0])
        return Plan(self.shaft_speed(), self.load(), motion, speed, place, now.creep[:, 0].copy(), tuple(events))

    def mix(self, ring: Floats, plan: Plan) -> tuple[Floats, Floats]:
        """Return what the boxes do in a frame, and the parts of it.

        Parameters
        ----------
        ring
            Accelerations of the bearings' outer rings, shape (boxes, `FRAME`, 2) [m/s^2].
        plan
            The frame.

        Returns
        -------
        boxes, parts
            Accelerations, shape (boxes, `FRAME`, 2) [m/s^2]; and the rms of the own bearing, of the others and of track and wheels in it,
            shape (boxes, 3) [m/s^2].
        """
        others = self._bearing_motion(ring)
        columns = np.ascontiguousarray(ring.transpose(0, 2, 1))
        self._bearing_paths.add(columns, others)
        mixed = columns + others
        mixed[:, 1] += plan.motion
        parts = np.column_stack([np.sqrt((part**2).mean(axis=(1, 2))) for part in (columns, others, plan.motion[:, None] * 0.5**0.5)])
        return np.ascontiguousarray(mixed.transpose(0, 2, 1)), parts

    def _bearing_motion(self, ring: Floats) -> Floats:
        """Return what the structure makes of the other bearings' forces, shape (boxes, 2, FRAME); it moves vertically only."""
        count = len(self.vehicle.boxes)
        sampled = BOX_MASS * ring[:, :, 1].reshape(count, TICKS, TICK).mean(axis=2)
        force = filtered(self._force_sections, self._force_memory, np.ascontiguousarray(sampled.T)).T
        motion, inputs = np.zeros((count, 2, FRAME)), np.concatenate([self._ring_force[:, None], force], axis=1)[:, :, None]
        before, after, direct = self._bearing_systems
        add_motion_of_others(
            self._growth, before, after, self._box_read, direct, self._bearing_states, inputs, self._ring_motion, motion[:, 1]
        )
        self._ring_force = force[:, -1].copy()
        return motion

    def _roll(self) -> Rolling:
        """Return the next frame of rolling and the motion by track and wheels."""
        vehicle, dt = self.vehicle, self._interval
        speed = ramped(self._speed, self.targets["speed"], self.targets["ramp"] * dt, TICKS)
        forward = 0.5 * (speed[:-1] + speed[1:]) * dt
        place = np.cumsum(np.concatenate([[self._place], forward]))
        slides, creep = self._slip(speed, float(place[0]))
        turned = forward * (0.5 * (2.0 + creep[:, :-1] + creep[:, 1:]) / self._radius)
        angle = np.cumsum(np.concatenate([self._angle[:, None], turned], axis=1), axis=1)
        self._speed, self._place, self._angle = float(speed[-1]), float(place[-1]), angle[:, -1].copy()
        self._rolled += 1
        inputs = np.zeros((TICKS + 1, self._track_system[0].shape[1]))
        rails = self._rails.displacements((place + self._behind).ravel(), self._sides)
        turning, at = speed * (1.0 + creep), positions(angle)
        for j, box in enumerate(vehicle.boxes):
            p, wheel = box.axle, self._wheels[j]
            rail = rails[box.side].reshape(angle.shape)[p]
            inputs[:, j] = rail + wheel.displacement(angle[p], at[p], float(turning[p, 0]))
            if self._unbalanced:
                force = wheel.unbalance(angle[p], turning[p] / vehicle.axles[p].radius)
                inputs[:, len(vehicle.boxes) + len(vehicle.axles) + j] = force
        for p, traction in enumerate(self._traction):
            if traction.active:
                inputs[:, len(vehicle.boxes) + p] = traction.at(angle[p])
        before, after, direct = self._track_system
        outputs = modal_outputs(self._growth, before, after, self._read, direct, self._track_state, inputs)
        count = len(vehicle.boxes)
        loads = filtered(self._load_sections, self._load_memory, np.ascontiguousarray(outputs[:, count:]))
        return Rolling(speed, place, creep, angle, np.ascontiguousarray(outputs[:, :count]), loads[0].copy(), slides)

    def _slip(self, speed: Floats, place: float) -> tuple[list[TrackEvent], Floats]:
        """Return the slides that begin or end with the frame to be rolled, and the creep of each wheelset at its ticks."""
        events, time = [], self._rolled * FRAME / self.rate
        for p, axle in enumerate(self.vehicle.axles):
            wanted = float(self.slides[p] * speed[0]) if self._rolled >= 0 else 0.0
            largest = max(wanted, float(self._slid[p]))
            if (wanted > 0.0) != (self._slid[p] > 0.0):
                events.append(TrackEvent(time, place + axle.x, axle.name, "slide" if wanted > 0.0 else "slide_end", largest))
            self._slid[p] = largest if wanted > 0.0 else 0.0
        before, step = self._slide, SLIDING / speed[0] * self._interval * TICKS
        self._slide = before + np.clip(self.slides - before, -step, step)
        return events, self._creep - (before[:, None] + (self._slide - before)[:, None] * (np.arange(TICKS + 1) / TICKS))

    def _contacts(self, now: Rolling) -> tuple[Floats, list[TrackEvent]]:
        """Return the motion of the contacts in the frame that was rolled last, shape (boxes, 1, `FRAME`) [m/s^2], and the kinks in it.

        The structure and the drawn paths carry the same frame on the same wheels, so that it is computed before these change.
        """
        vehicle, ticks, count, first = self.vehicle, np.arange(TICKS + 1), len(self.vehicle.axles), (self._rolled - 1) * FRAME
        speed, place, *each = along_lines(np.vstack([now.speed, now.place, now.angle, now.creep]), TICK)
        at, turning = positions(np.array(each[:count])), speed * (1.0 + np.array(each[count:]))
        places = (place + self._behind).ravel()
        rails = {side: self._rails.curvature(places, side).reshape(at.shape) for side in self._sides}
        events = []
        jerked = np.zeros((len(vehicle.boxes), FRAME + 1))
        jerked[:, 0] = self._next_jump
        for j, box in enumerate(vehicle.boxes):
            p = box.axle
            jerked[j, :FRAME] += speed**2 * rails[box.side][p] + turning[p] ** 2 * self._wheels[j].curvature(at[p])
            x = vehicle.axles[p].x
            kinks = [
                (float(np.interp(kink - x, now.place, ticks)), cause, 2.0 * vehicle.track.joint_angle * float(now.speed[0]), kink)
                for kink, cause in self._rails.kinks(float(now.place[0]) + x, float(now.place[-1]) + x, box.side)
            ]
            rolling = float(now.speed[0] * (1.0 + now.creep[box.axle, 0]))
            for strike in self._wheels[j].strikes(float(now.angle[box.axle][0]), float(now.angle[box.axle][-1])):
                tick = float(np.interp(strike, now.angle[box.axle], ticks))
                kinks.append((tick, "flat", self._wheels[j].jump(rolling), float(np.interp(tick, ticks, now.place)) + x))
            for tick, cause, height, where in kinks:
                step = min(int(tick * TICK), FRAME - 1)
                share = tick * TICK - step
                jerked[j, step] += (1.0 - share) * height * self.rate
                jerked[j, step + 1] += share * height * self.rate
                events.append(TrackEvent((first + tick * TICK) / self.rate, where, box.name, cause, height))
        self._next_jump = jerked[:, FRAME].copy()
        return np.ascontiguousarray(jerked[:, None, :FRAME]), events


def _columns(before: Complexes, after: Complexes, direct: Floats, inputs: list[int]) -> tuple[Complexes, Complexes, Floats]:
    return tuple(np.ascontiguousarray(part[:, inputs]) for part in (before, after, direct))  # type: ignore[return-value]


@cached_on_disk
def _lowpass(order: int, cutoff: float, rate: float) -> Floats:
    from scipy.signal import butter

    return np.asarray(butter(order, cutoff, fs=rate, output="sos"), np.float64)
