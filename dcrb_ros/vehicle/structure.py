"""The vertical motion of bogie and track up to 1 kHz: one linear system from all wheel-rail contacts and bearings to all boxes.

Each wheelset is a free Euler-Bernoulli beam with wheels, discs and boxes on their bearings, of which rigid motion and bending modes below
`HIGHEST` are kept. Frame and rail points join the wheelsets. Values that no file has are of Iwnicki 1998 and Zhai et al. 2004.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from dcrb_ros.schema.arrays import Complexes, Floats
from dcrb_ros.settings.parameters import STEEL_DENSITY
from dcrb_ros.vehicle.description import JOURNAL_DISTANCE, WHEEL_DISTANCE, Vehicle

ELASTICITY = 2.06e11
"""Of steel [Pa]."""
BODY_DIAMETER, SEAT_DIAMETER, SEAT = 0.17, 0.13, 0.85
"""Diameters of the axle within and beyond the distance `SEAT` from its middle [m]."""
WHEEL_MASS, WHEEL_INERTIA, DISC_MASS, DISC_INERTIA, BOX_MASS = 450.0, 25.0, 145.0, 3.0, 60.0
"""[kg], [kg m^2]"""
DISCS = (0.35, 0.0, -0.35)
"""Places of the brake discs [m]."""
BEARING_STIFFNESS, BEARING_LOSS, AXLE_LOSS = 1.0e9, 0.03, 0.002
"""Stiffness of a bearing [N/m] and loss factors [-]."""
CONTACT_STIFFNESS = 1.2e9
"""Linearized stiffness of a wheel-rail contact [N/m]."""
RAIL_BENDING = 2.059e11 * 3.217e-5
"""Bending stiffness of a rail [N m^2]."""
RAIL_FOUNDATION = 1.0 / (0.6 / 65e6 + 0.6 / 137.75e6)
"""Stiffness of pads and ballast for each metre of a rail [N/m^2]."""
RAIL_DECAY = 2.0
"""Decay of the motion along a rail beside that of the beam [dB/m] (an assumption)."""
RAIL_DAMPING, RAIL_POINT_MASS = 5.0e4, 29.0
"""Damping and mass of the rail point under a wheel [N s/m], [kg]."""
BESIDE_STIFFNESS, BESIDE_DAMPING, BESIDE_MASS = 1.8e8, 1.1e5, 36.0
"""Spring, damper and mass beside it, in place of the waves that an endless rail radiates [N/m], [N s/m], [kg].

The five values are fitted to the dynamic stiffness of an endless beam with a loss factor of 0.25 in its foundation, up to 1 kHz. From 20 Hz
to 1 kHz the level of a box above a contact is within 2 dB of that on such a rail.
"""
HIGHEST = 1500.0
"""Highest bending mode that is kept [Hz]."""
ELEMENTS = 40
"""Elements of an axle [-]."""
APART = np.array([[1.0, -1.0], [-1.0, 1.0]])
"""Matrix of a spring or damper of 1 between two coordinates."""
DIGITS = 10
"""Significant digits of the modes: the last ones depend on the processor."""


@dataclass(frozen=True)
class Wheelset:
    """Free modes of a wheelset with its boxes, normalized to a mass of 1."""

    frequency: Floats
    """[rad/s]"""
    loss: Floats
    """Loss factor [-]."""
    box: Floats
    """Motion of both boxes in each mode, left first, shape (2, modes)."""
    journal: Floats
    contact: Floats
    places: Floats
    """Places along the axle, left of its middle, shape (places,) [m]."""
    axle: Floats
    """Motion of the axle at these places, shape (places, modes)."""

    def at(self, place: float) -> Floats:
        """Return the motion of the axle at a place, left of its middle [m], shape (modes,)."""
        return np.array([np.interp(place, self.places, shape) for shape in self.axle.T])


def wheelset() -> Wheelset:
    """Return the modes of a wheelset."""
    from scipy.linalg import eigh

    nodes = np.linspace(-0.5 * JOURNAL_DISTANCE, 0.5 * JOURNAL_DISTANCE, ELEMENTS + 1)
    size = 2 * len(nodes) + 2
    stiffness, mass = np.zeros((size, size)), np.zeros((size, size))
    for e, (a, b) in enumerate(itertools.pairwise(nodes)):
        h, diameter = b - a, SEAT_DIAMETER if abs(a + b) / 2 > SEAT else BODY_DIAMETER
        bending, whole = ELASTICITY * math.pi * diameter**4 / 64, STEEL_DENSITY * math.pi * diameter**2 / 4 * h
        part = slice(2 * e, 2 * e + 4)
        stiffness[part, part] += (
            bending
            / h**3
            * np.array(
                [
                    [12, 6 * h, -12, 6 * h],
                    [6 * h, 4 * h * h, -6 * h, 2 * h * h],
                    [-12, -6 * h, 12, -6 * h],
                    [6 * h, 2 * h * h, -6 * h, 4 * h * h],
                ]
            )
        )
        mass[part, part] += (
            whole
            / 420
            * np.array(
                [
                    [156, 22 * h, 54, -13 * h],
                    [22 * h, 4 * h * h, 13 * h, -3 * h * h],
                    [54, 13 * h, 156, -22 * h],
                    [-13 * h, -3 * h * h, -22 * h, 4 * h * h],
                ]
            )
        )

    def at(place: float) -> int:
        return 2 * int(np.argmin(abs(nodes - place)))

    lumped = [(0.5 * WHEEL_DISTANCE, WHEEL_MASS, WHEEL_INERTIA), (-0.5 * WHEEL_DISTANCE, WHEEL_MASS, WHEEL_INERTIA)]
    for place, weight, inertia in [*lumped, *((place, DISC_MASS, DISC_INERTIA) for place in DISCS)]:
        mass[at(place), at(place)] += weight
        mass[at(place) + 1, at(place) + 1] += inertia
    springs = np.zeros((size, size))
    for box, place in ((size - 2, 0.5 * JOURNAL_DISTANCE), (size - 1, -0.5 * JOURNAL_DISTANCE)):
        mass[box, box] = BOX_MASS
        pair = np.ix_([box, at(place)], [box, at(place)])
        springs[pair] += BEARING_STIFFNESS * APART
    squares, shapes = eigh(stiffness + springs, mass)
    frequency = np.sqrt(np.maximum(squares, 0.0))
    kept = np.flatnonzero(frequency < 2.0 * math.pi * HIGHEST)
    frequency, shapes = frequency[kept], shapes[:, kept]
    frequency[:2] = 0.0  # free motion
    energy = [np.einsum("ik,ij,jk->k", shapes, part, shapes) for part in (stiffness, springs)]
    loss = (AXLE_LOSS * energy[0] + BEARING_LOSS * energy[1]) / np.maximum(energy[0] + energy[1], 1e-3)
    half_wheels, half_journals = 0.5 * WHEEL_DISTANCE, 0.5 * JOURNAL_DISTANCE
    return Wheelset(
        frequency,
        loss,
        shapes[[size - 2, size - 1]],
        shapes[[at(half_journals), at(-half_journals)]],
        shapes[[at(half_wheels), at(-half_wheels)]],
        nodes,
        shapes[0 : 2 * len(nodes) : 2],
    )


def rail_compliance(distance: float) -> Floats:
    """Return the static compliance of two points of a rail at a distance [m], shape (2, 2) [m/N].

    That of an endless beam on an elastic foundation k, with beta = (k / 4 EI)^(1/4): exp(-beta x) (cos beta x + sin beta x) / 8 EI beta^3.
    """
    beta = (RAIL_FOUNDATION / (4.0 * RAIL_BENDING)) ** 0.25
    angle = beta * distance
    here = 1.0 / (8.0 * RAIL_BENDING * beta**3)
    there = here * math.exp(-angle) * (math.cos(angle) + math.sin(angle)) * 10.0 ** (-RAIL_DECAY * distance / 20.0)
    return np.array([[here, there], [there, here]])


class Structure:
    """Mass, damping and stiffness of bogie and track, and its modes.

    The coordinates are the modes of each wheelset, bounce, roll and pitch of the frame, and for each wheel a point of the rail and the
    mass beside it. Inputs are the roughness under each wheel [m], the force pairs in the bearings, box against journal, a force at the
    gear of each axle, and one on each wheel [N].
    """

    def __init__(self, vehicle: Vehicle) -> None:
        self._vehicle = vehicle
        modes, boxes = wheelset(), vehicle.boxes
        count, wheels = len(modes.frequency), len(boxes)
        first_frame = count * len(vehicle.axles)
        self.size = first_frame + 3 + 2 * wheels
        mass, damping, stiffness = np.eye(self.size), np.zeros((self.size, self.size)), np.zeros((self.size, self.size))
        for axle in range(len(vehicle.axles)):
            for k in range(count):
                n = axle * count + k
                stiffness[n, n] = modes.frequency[k] ** 2
                damping[n, n] = modes.loss[k] * modes.frequency[k]

        def of_axle(axle: int, shape: Floats) -> Floats:
            row = np.zeros(self.size)
            row[axle * count : (axle + 1) * count] = shape
            return row

        lateral = [0 if box.side > 0 else 1 for box in boxes]
        self.box = np.array([of_axle(box.axle, modes.box[lateral[j]]) for j, box in enumerate(boxes)])
        """Motion of each box, shape (boxes, coordinates)."""
        journal = np.array([of_axle(box.axle, modes.journal[lateral[j]]) for j, box in enumerate(boxes)])
        contact = np.array([of_axle(box.axle, modes.contact[lateral[j]]) for j, box in enumerate(boxes)])
        gear = np.array([of_axle(number, modes.at(axle.gear.position)) for number, axle in enumerate(vehicle.axles)])
        frame, suspension = vehicle.frame, vehicle.suspension
        mass[first_frame, first_frame] = frame.mass
        mass[first_frame + 1, first_frame + 1] = frame.roll
        mass[first_frame + 2, first_frame + 2] = frame.pitch
        for n in (first_frame, first_frame + 1):  # springs of the body at 1 m on either side
            stiffness[n, n] += 2.0 * suspension.secondary
            damping[n, n] += 2.0 * suspension.secondary_damping
        self.compression = self.box.copy()
        """Compression of each primary suspension, shape (boxes, coordinates)."""
        for j, box in enumerate(boxes):
            row = self.compression[j]
            row[first_frame], row[first_frame + 1] = -1.0, -0.5 * JOURNAL_DISTANCE * box.side
            row[first_frame + 2] = -vehicle.axles[box.axle].x
            stiffness += suspension.primary * np.outer(row, row)
            damping += suspension.primary_damping * np.outer(row, row)
        pitch = first_frame + 2
        if not self.compression[:, pitch].any():  # a wheelset at x = 0 alone: the pitch moves nothing, and is made regular
            stiffness[pitch, pitch], damping[pitch, pitch] = mass[pitch, pitch], mass[pitch, pitch]
        rail, beside = first_frame + 3, first_frame + 3 + wheels
        for side in (1, -1):
            points = [rail + j for j, box in enumerate(boxes) if box.side == side]
            if not points:
                continue
            xs = [vehicle.axles[boxes[n - rail].axle].x for n in points]
            compliance = rail_compliance(abs(xs[0] - xs[-1])) if len(points) == 2 else rail_compliance(1.0)[:1, :1]
            bed = np.linalg.inv(compliance)
            at = np.ix_(points, points)
            stiffness[at] += bed
            damping[at] += RAIL_DAMPING * compliance[0, 0] * bed
        squeezed = contact.copy()
        for j in range(wheels):
            squeezed[j, rail + j] = -1.0
            stiffness += CONTACT_STIFFNESS * np.outer(squeezed[j], squeezed[j])
            mass[rail + j, rail + j], mass[beside + j, beside + j] = RAIL_POINT_MASS, BESIDE_MASS
            between = np.ix_([rail + j, beside + j], [rail + j, beside + j])
            stiffness[between] += BESIDE_STIFFNESS * APART
            damping[between] += BESIDE_DAMPING * APART
        self.mass, self.damping, self.stiffness = mass, damping, stiffness
        self.inputs = np.vstack([CONTACT_STIFFNESS * squeezed, self.box - journal, gear, contact]).T
        """Forces of the inputs on the coordinates, shape (coordinates, inputs)."""

    def response(self, frequency: float) -> Complexes:
        """Return the displacement of the boxes for each input at a frequency [Hz], shape (boxes, inputs)."""
        w = 2.0 * math.pi * frequency
        dynamic = self.stiffness + 1j * w * self.damping - w * w * self.mass
        return np.asarray(self.box @ np.linalg.solve(dynamic, self.inputs), np.complex128)

    @cached_property
    def _eigen(self) -> tuple[Complexes, Complexes, Complexes]:
        """Eigenvalues, eigenvectors and their inverse of the equations of first order."""
        n = self.size
        inverse = np.linalg.inv(self.mass)
        matrix = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ self.stiffness, -inverse @ self.damping]])
        values, vectors = np.linalg.eig(matrix)
        return values.astype(np.complex128), vectors.astype(np.complex128), np.linalg.inv(vectors).astype(np.complex128)

    def modal(self, interval: float) -> tuple[Complexes, Complexes, Complexes, Complexes, Floats]:
        """Return growth, before, after, read and direct of `kernels.modal_outputs` for ticks at an interval [s].

        The outputs are the accelerations of the boxes [m/s^2] and then the dynamic loads of their bearings [N],
        k_p d + c_p d' + m_box u'' with the compression d and the box's motion u.
        """
        values, vectors, inverse = self._eigen
        n, suspension = self.size, self._vehicle.suspension
        forced = inverse[:, n:] @ np.linalg.inv(self.mass) @ self.inputs
        growth = np.exp(values * interval)
        whole, ramp = _held(values * interval)
        before, after = (whole - ramp)[:, None] * forced * interval, ramp[:, None] * forced * interval
        acceleration = self.box @ vectors[n:] * values
        load = self.compression @ (suspension.primary * vectors[:n] + suspension.primary_damping * vectors[n:]) + BOX_MASS * acceleration
        direct = self.box @ np.linalg.inv(self.mass) @ self.inputs
        # The scale of a mode is free: its largest output is 1.
        read = np.vstack([acceleration, load])
        scale = read[np.argmax(abs(read), axis=0), np.arange(read.shape[1])]
        return (
            growth,
            _rounded_inputs(before * scale[:, None]),
            _rounded_inputs(after * scale[:, None]),
            _rounded(read / scale),
            np.vstack([direct, BOX_MASS * direct]),
        )


def _held(z: Complexes) -> tuple[Complexes, Complexes]:
    """Return (e^z - 1) / z and its part (e^z - 1 - z) / z^2 of an input that rises along a straight line."""
    small = abs(z) < 1e-3
    safe = np.where(small, 1.0, z)
    whole = np.where(small, 1.0 + z / 2.0 + z * z / 6.0 + z**3 / 24.0, (np.exp(safe) - 1.0) / safe)
    ramp = np.where(small, 0.5 + z / 6.0 + z * z / 24.0 + z**3 / 120.0, (np.exp(safe) - 1.0 - safe) / safe**2)
    return whole, ramp


def _rounded_inputs(values: Complexes) -> Complexes:
    """Return the effect of inputs on modes, rounded; inputs in metres have effects 1e9 times those of forces."""
    unit = 10.0 ** np.floor(np.log10(np.maximum(abs(values).max(axis=0), 1e-300)))
    return np.asarray(_rounded(np.asarray(values / unit, np.complex128)) * unit, np.complex128)


def _rounded(values: Complexes) -> Complexes:
    """Return values with `DIGITS` significant digits of the largest of their row."""
    size = 10.0 ** np.floor(np.log10(np.maximum(abs(values).max(axis=1, keepdims=True), 1e-300)))
    unit = size * 10.0 ** (1 - DIGITS)
    return np.asarray((np.round(values.real / unit) + 1j * np.round(values.imag / unit)) * unit, np.complex128)
