"""The thermal network of a bearing in its axle box: nodes of one temperature each, conductances between them, implicit steps.

The nodes are, of each row, the inner ring with its share of the journal, the rollers with their cage, and the outer ring, then the axle
box; the surroundings have a prescribed temperature T_a. With the heat capacities C, the heat q and the conductances G,

    C_i dT_i/dt = a (q_i + sum_j G_ij (T_j - T_i) + G_ia (T_a - T_i))

where a is the time lapse. A step of implicit Euler is exact in its balance of heat, and no temperature leaves the range of its neighbours
and of what the heat explains. All arithmetic is plain, so that every processor gets the same bits.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from dcrb_ros.settings.parameters import STEEL_DENSITY, Bearing
from dcrb_ros.settings.thermal import Thermal

STEEL_HEAT, CAST_HEAT = 465.0, 480.0
"""Specific heat of rings, rollers and journal, and of the axle box [J/(kg K)]."""
CONDUCTIVITY, DIFFUSIVITY = 45.0, 1.25e-5
"""Of bearing steel [W/(m K)], [m^2/s]."""
WIDTH_OVER_ROLLERS = 5.0 / 3.0
"""Width of the bearing over the lengths of a roller of each row [-]: 160 mm of NJ(P)3226X1."""
JOURNAL_OVER_WIDTH = 1.25
"""Length of the journal that warms up with the inner ring, over the width [-] (a choice)."""
SEAT_EXCHANGE = 800.0
"""Conductance of the loose fit of outer ring and box over its area [W/(m^2 K)] (a choice; 500 to 1500)."""
AXLE, AXLE_OVER_SPEED = 6.0, 0.05
"""Conductance from the journal through axle and wheel to the air [W/K], and its part over the speed of the vehicle [J/(m K)] (a choice)."""
CALM_EXCHANGE = 12.0
"""Conductance of the box to calm air and by radiation over its surface [W/(m^2 K)] (a choice)."""
AIR_CONDUCTIVITY, AIR_VISCOSITY = 0.026, 1.6e-5
"""Of air [W/(m K)], kinematic [m^2/s]."""
HILPERT, HILPERT_EXPONENT = 0.027, 0.805
"""Nusselt number of a cylinder across the air, C Re^m for Re of 4e4 to 4e5 (Hilpert 1933) [-]."""
STILL = 0.02
"""Least speed at which a contact moves over a body [m/s]: below it the conductances stay as they are."""
GREASE_EXCHANGE = 2.0
"""Conductance of each raceway of a row through grease, air and cage [W/K] (a choice)."""
OIL_CONDUCTIVITY, IDLE_WIDTH, IDLE_FILM = 0.14, 0.2e-3, 3e-6
"""Of the film between an idle roller and a raceway: conductivity [W/(m K)], width and thickness [m] (a choice)."""

Vector = list[float]
Matrix = list[Vector]


@dataclass(frozen=True)
class Conductances:
    """How heat flows at a speed of shaft and air [W/K]."""

    matrix: Matrix
    """Sum of a node's conductances, the one to the surroundings included, on the diagonal, and minus those between nodes."""
    ambient: Vector
    """From each node to the surroundings."""


@dataclass(frozen=True)
class HeatNetwork:
    """The nodes of a bearing and what does not change: capacities, and conductances through metal."""

    rows: int
    capacity: Vector
    """Of each node, in the order of `names` [J/K]."""
    along_inner: float
    """Between the inner rings of two rows [W/K]."""
    along_outer: float
    """Between the outer rings of two rows [W/K]."""
    seat: float
    """Between the outer ring of a row and the box [W/K]."""
    box_area: float
    """[m^2]"""
    box_size: float
    """[m]"""

    @property
    def names(self) -> list[str]:
        """Names of the nodes: inner rings, rollers and outer rings row by row, then the box."""
        parts = ("inner_ring", "rollers", "outer_ring")
        return [*(f"row{row + 1}/{part}" for part in parts for row in range(self.rows)), "box"]

    def inner(self, row: int) -> int:
        """Return the node of a row's inner ring."""
        return row

    def rollers(self, row: int) -> int:
        """Return the node of a row's rollers."""
        return self.rows + row

    def outer(self, row: int) -> int:
        """Return the node of a row's outer ring."""
        return 2 * self.rows + row

    @property
    def box(self) -> int:
        """The node of the box, the last one."""
        return 3 * self.rows

    def conductances(self, raceways: Sequence[tuple[float, float]], vehicle: float, air: float) -> Conductances:
        """Return the conductances, given those of each row's inner and outer raceway [W/K].

        ``vehicle`` is the speed of the vehicle and ``air`` that of the air at the box [m/s].
        """
        nodes = self.box + 1
        matrix, ambient = [[0.0] * nodes for _ in range(nodes)], [0.0] * nodes

        def link(node: int, other: int, conductance: float) -> None:
            matrix[node][node] += conductance
            matrix[other][other] += conductance
            matrix[node][other] -= conductance
            matrix[other][node] -= conductance

        axle = (AXLE + AXLE_OVER_SPEED * abs(vehicle)) / self.rows
        for row in range(self.rows):
            link(self.inner(row), self.rollers(row), raceways[row][0])
            link(self.rollers(row), self.outer(row), raceways[row][1])
            link(self.outer(row), self.box, self.seat)
            ambient[self.inner(row)] = axle
        for row in range(self.rows - 1):
            link(self.inner(row), self.inner(row + 1), self.along_inner)
            link(self.outer(row), self.outer(row + 1), self.along_outer)
        ambient[self.box] = self.box_area * surface_exchange(air, self.box_size)
        for node in range(nodes):
            matrix[node][node] += ambient[node]
        return Conductances(matrix, ambient)

    def heat(self, rows: Sequence[Sequence[float]], sun: float) -> Vector:
        """Return the heat of each node [W] from that of each row's inner raceway, outer raceway and the rest (cage, oil, seals).

        Half of the heat of a raceway goes to its ring and half to the rollers, the rest to rollers and outer ring (a choice); the box gets
        ``sun`` [W].
        """
        sources = [0.0] * (self.box + 1)
        for row, (inner, outer, rest) in enumerate(rows):
            sources[self.inner(row)] += 0.5 * inner
            sources[self.rollers(row)] += 0.5 * (inner + outer + rest)
            sources[self.outer(row)] += 0.5 * (outer + rest)
        sources[self.box] += sun
        return sources

    def after(self, temperatures: Sequence[float], flow: Conductances, heat: Sequence[float], ambient: float, duration: float) -> Vector:
        """Return the temperatures after a step of implicit Euler over a duration [s] of heat; an infinite one gives the steady state."""
        nodes = range(self.box + 1)
        stored = [capacity / duration for capacity in self.capacity]
        matrix = [[flow.matrix[i][j] + (stored[i] if i == j else 0.0) for j in nodes] for i in nodes]
        # Relative to the surroundings: a network at rest stays there exactly.
        above = solved(matrix, [stored[i] * (temperatures[i] - ambient) + heat[i] for i in nodes])
        return [ambient + rise for rise in above]

    def steady(self, flow: Conductances, heat: Sequence[float], ambient: float) -> Vector:
        """Return the temperatures at which each node loses the heat that it gets."""
        return self.after([ambient] * (self.box + 1), flow, heat, ambient, math.inf)


def heat_network(bearing: Bearing, thermal: Thermal) -> HeatNetwork:
    """Return the network of a bearing: capacities and sections follow from its masses and raceways."""
    b, rows = bearing, bearing.rows
    width = WIDTH_OVER_ROLLERS * rows * b.roller_length
    per_square = STEEL_DENSITY * math.pi * width
    # Bore and outside radius of rings of these masses; a ring as light as none still has a bore.
    bore = math.sqrt(max(b.inner_raceway_radius**2 - b.inner_ring_mass / per_square, 0.25 * b.inner_raceway_radius**2))
    outside = math.sqrt(b.outer_raceway_radius**2 + b.outer_ring_mass / per_square)
    journal = STEEL_DENSITY * math.pi * bore**2 * JOURNAL_OVER_WIDTH * width
    inner = STEEL_HEAT * (b.inner_ring_mass + journal) / rows
    rollers = STEEL_HEAT * (b.rollers_per_row * b.roller_mass + b.cage_mass)
    outer = STEEL_HEAT * b.outer_ring_mass / rows
    apart = width / max(rows, 2)
    return HeatNetwork(
        rows=rows,
        capacity=[inner] * rows + [rollers] * rows + [outer] * rows + [CAST_HEAT * thermal.box_mass],
        along_inner=CONDUCTIVITY * math.pi * (b.inner_raceway_radius**2 - bore**2) / apart,
        along_outer=CONDUCTIVITY * math.pi * (outside**2 - b.outer_raceway_radius**2) / apart,
        seat=SEAT_EXCHANGE * 2.0 * math.pi * outside * width / rows,
        box_area=thermal.box_area,
        box_size=thermal.box_size,
    )


def surface_exchange(air: float, size: float) -> float:
    """Return the conductance over the surface [W/(m^2 K)] of a body of a size [m] in air that flows at a speed [m/s]."""
    reynolds = abs(air) * size / AIR_VISCOSITY
    if reynolds < 1.0:
        return CALM_EXCHANGE
    return CALM_EXCHANGE + AIR_CONDUCTIVITY / size * HILPERT * math.exp(HILPERT_EXPONENT * math.log(reynolds))


def contact_conductance(half_width: float, length: float, speed: float) -> float:
    """Return the conductance [W/K] of a rolling contact of a half-width b and a length L [m] at a speed u over both bodies [m/s].

    Two half-spaces in series, each fed by a moving band (Jaeger 1942, Blok 1937): 0.75 k L sqrt(pi u b/(2 kappa)).
    """
    return 0.75 * CONDUCTIVITY * length * math.sqrt(math.pi * max(abs(speed), STILL) * half_width / (2.0 * DIFFUSIVITY))


def idle_conductance(length: float) -> float:
    """Return the conductance [W/K] of a contact of a length [m] that touches through its film alone."""
    return OIL_CONDUCTIVITY * length * IDLE_WIDTH / IDLE_FILM


def solved(matrix: Matrix, right: Vector) -> Vector:
    """Return the solution of linear equations by elimination without pivoting, which an M-matrix never needs; both are used up."""
    size = len(right)
    for k in range(size):
        pivot = matrix[k]
        for i in range(k + 1, size):
            row = matrix[i]
            if row[k] != 0.0:
                factor = row[k] / pivot[k]
                for j in range(k + 1, size):
                    row[j] -= factor * pivot[j]
                right[i] -= factor * right[k]
    for k in reversed(range(size)):
        for j in range(k + 1, size):
            right[k] -= matrix[k][j] * right[j]
        right[k] /= matrix[k][k]
    return right
