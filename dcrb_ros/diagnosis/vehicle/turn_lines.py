"""What lines at multiples of a wheelset's turn show of its wheels and of its gear.

The roughness of a wheel makes a line at every order, and the structure has resonances. A cause is therefore judged by the prominence of its
line, which is its amplitude over that of the noise beside it, compared with the prominence of neighbouring orders and of other boxes. That
removes the gain of the sensor and most of the response of the structure.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dcrb_ros.diagnosis.hysteresis import probability
from dcrb_ros.diagnosis.order_spectrum import OrderSpectrum, medians
from dcrb_ros.diagnosis.vehicle.comparison import UNOPPOSED, unopposed
from dcrb_ros.diagnosis.vehicle.contact import Contact
from dcrb_ros.diagnosis.vehicle.parameters import VehicleDetectorParameters
from dcrb_ros.diagnosis.vehicle.turn_spectrum import HIGHEST
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.stream.vehicle_description import SIDES, VehicleDescription
from dcrb_ros.stream.vehicle_diagnosis import UNDECIDED, Status

BESIDE = 0.45
"""Orders on either side of a line in which the noise is taken [-]."""
POLYGONS = range(2, 25)
"""Orders of polygons that are judged [-]; an unbalance and an eccentric wheel both have order 1."""
NEIGHBOURS = 4
"""Neighbouring orders on either side with which the order of a polygon is compared [-]."""
MESH_NEIGHBOURS = np.array([-7.0, -6.0, -5.0, -4.0, -3.0, -2.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0])
"""Orders with which the mesh is compared, relative to it [-]; its sidebands by the run-out of the gear are left out."""
SIDEBANDS = np.array([-1.0, 1.0])
"""Sidebands of the mesh, relative to it [-]."""
WEAKER = 6.0
"""By how much the line of a polygon must be less prominent at every other box [dB]; a round wheel had 4.6 dB."""
AHEAD = 3.0
"""By how much a mesh must be more prominent than in every other wheelset [dB]."""
ALIKE = 12.0
"""Difference of the two boxes of a wheelset up to which both measure its gear alike [dB]; 3 to 7 dB were computed."""


class OrderLevel(NamedTuple):
    """An order that stands out of its neighbours."""

    order: float
    """Multiple of the wheelset's turn [-]."""
    level: float
    """Prominence over the median of neighbouring orders [dB]."""
    prominence: float
    """Amplitude over that of the noise beside it [dB]."""


def prominences(spectrum: OrderSpectrum, orders: npt.ArrayLike) -> Floats:
    """Return the amplitude of the line at each order over the median of the amplitudes beside it, shape of ``orders`` [dB].

    It is 0 dB outside the spectrum.
    """
    wanted = np.asarray(orders, np.float64)
    first, last = (np.searchsorted(spectrum.orders, wanted + side * BESIDE) for side in (-1.0, 1.0))
    found = np.zeros(len(wanted))
    for place, (line, begin, end) in enumerate(zip(spectrum.lines(np.nan_to_num(wanted)), first, last, strict=True)):
        if end > begin:
            noise = float(medians(spectrum.amplitude[begin:end]))
            found[place] = 20.0 * math.log10(max(float(line), 1e-12) / max(noise, 1e-12))
    return found


def levels(spectrum: OrderSpectrum) -> list[OrderLevel]:
    """Return the orders of `POLYGONS`, the most prominent over its neighbours first."""
    known = np.arange(1, POLYGONS[-1] + NEIGHBOURS + 1)
    found = dict(zip(known.tolist(), prominences(spectrum, known).tolist(), strict=True))

    def level(order: int) -> float:
        beside = [found[other] for other in range(order - NEIGHBOURS, order + NEIGHBOURS + 1) if other != order and other in found]
        return float(found[order] - medians(np.array(beside)))

    return sorted((OrderLevel(float(order), level(order), found[order]) for order in POLYGONS), key=lambda one: -one.level)


def polygons(contacts: Mapping[str, Contact], parameters: VehicleDetectorParameters, partners: Mapping[str, str]) -> dict[str, Status]:
    """Return the status of each wheel whose spectrum is known: ``polygon`` if an order stands out, and more than at any other box.

    ``partners`` are the other boxes of the wheelsets. If that of a box is not judged, a line may be that of its wheel. Where other boxes
    have the line as well, it is no wheel's: resonances and the rail make such lines, too.
    """
    spectra = spectra_of(contacts)
    turns = {name: abs(contacts[name].shaft_frequency) for name in spectra}
    statuses, alone = {}, unopposed(spectra, partners)
    for name, spectrum in spectra.items():
        status = Status("healthy", f"no order of the wheel is {parameters.polygon:g} dB above its neighbours")
        for one in levels(spectrum):
            if one.level < parameters.polygon:
                break
            # The other wheelset may turn faster or more slowly: the line is at its frequency there, that of the other wheel at its order.
            places = {other: (one.order, one.order * turns[name] / turns[other]) for other in spectra if other != name}
            rivals = {other: float(prominences(spectra[other], orders).max()) for other, orders in places.items()}
            rival = max(rivals, key=lambda other: rivals[other], default="")
            reason, score = f"order {one.order:g} of the wheel is {one.level:.1f} dB above its neighbours", one.level - parameters.polygon
            if not rival:
                status = Status(UNDECIDED, f"{reason}, but no other box can be compared", 0.0, score)
                break
            ahead = one.prominence - rivals[rival]
            if ahead >= WEAKER and name in alone:
                status = Status(UNDECIDED, f"{reason}, but {UNOPPOSED}", 0.0, score)
                break
            if ahead >= WEAKER:
                status = Status("polygon", f"{reason}, {ahead:.1f} dB more than at {rival}", probability(score), score)
                break
            status = Status("healthy", f"{reason}, but not {WEAKER:g} dB more than at {rival}")
        statuses[name] = status
    return statuses


class Mesh(NamedTuple):
    """The mesh of a gear, as the boxes of its wheelset measure it."""

    levels: Mapping[str, float]
    """Prominence over the median of neighbouring orders by box [dB]."""
    sidebands: float
    """Amplitude of the larger sideband over that of the mesh, in the box that has more [dB]."""
    ahead: float
    """Mean prominence over the largest one in another wheelset [dB]."""
    rival: str
    """Name of that wheelset; empty without one."""

    @property
    def level(self) -> float:
        """The smaller of the levels of both boxes [dB]."""
        return min(self.levels.values())


def meshes(description: VehicleDescription, contacts: Mapping[str, Contact]) -> dict[str, Mesh]:
    """Return the mesh of each driven wheelset whose boxes both have a spectrum that reaches it."""
    found = {}
    for axle in description.axles:
        own = spectra_of(of_axle(contacts, axle.name))
        if not axle.driven or len(own) < len(SIDES) or not axle.gear_teeth <= HIGHEST - 1.0 - MESH_NEIGHBOURS[-1]:
            continue
        teeth = float(axle.gear_teeth)
        here = {name: float(prominences(spectrum, [teeth])[0]) for name, spectrum in own.items()}
        levels = {name: here[name] - float(np.median(prominences(own[name], teeth + MESH_NEIGHBOURS))) for name in own}
        sidebands = max(
            20.0 * np.log10(max(float(s.lines(teeth + SIDEBANDS).max()), 1e-12) / max(float(s.lines([teeth])[0]), 1e-12))
            for s in own.values()
        )
        turn = abs(contacts[next(iter(own))].shaft_frequency)
        elsewhere = {
            other.name: np.mean([at_frequency(contacts[name], spectrum, teeth * turn) for name, spectrum in spectra.items()])
            for other in description.axles
            if other.name != axle.name and (spectra := spectra_of(of_axle(contacts, other.name)))
        }
        rival = max(elsewhere, key=lambda name: elsewhere[name], default="")
        ahead = float(np.mean(list(here.values())) - elsewhere[rival]) if rival else 0.0
        found[axle.name] = Mesh(levels, float(sidebands), ahead, rival)
    return found


def spectra_of(contacts: Mapping[str, Contact]) -> dict[str, OrderSpectrum]:
    """Return the spectra of boxes whose wheelset turned throughout the window."""
    return {
        name: contact.spectrum
        for name, contact in contacts.items()
        if contact.spectrum is not None and math.isfinite(contact.shaft_frequency) and contact.shaft_frequency != 0.0
    }


def of_axle(contacts: Mapping[str, Contact], axle: str) -> dict[str, Contact]:
    """Return the boxes of a wheelset."""
    return {name: contact for name, contact in contacts.items() if name.rpartition("/")[0] == axle}


def at_frequency(contact: Contact, spectrum: OrderSpectrum, frequency: float) -> float:
    """Return the prominence of the line at a frequency [Hz] in a box [dB]."""
    return float(prominences(spectrum, [frequency / abs(contact.shaft_frequency)])[0])


def gears(description: VehicleDescription, found: Mapping[str, Mesh], parameters: VehicleDetectorParameters) -> dict[str, Status]:
    """Return the status of the gear of each driven wheelset; ``gear`` says that its mesh is measured, which is no fault.

    Motors are not judged: the description has neither the pairs of poles nor the ratio of the gear.
    """
    return {axle.name: _gear(found.get(axle.name), axle.gear_teeth, parameters) for axle in description.axles if axle.driven}


def _gear(mesh: Mesh | None, teeth: int, parameters: VehicleDetectorParameters) -> Status:
    """Return the status of a gear from what both boxes measured of its mesh; None if they did not measure it."""
    if mesh is None:
        too_high = teeth > HIGHEST - 1.0 - MESH_NEIGHBOURS[-1]
        reason = f"the order of the mesh, {teeth}, is too high to be judged" if too_high else ""
        return Status("waiting", reason or "both boxes of the wheelset need enough turns of its angle")
    score = mesh.level - parameters.gear
    if score < 0.0:
        return Status("healthy", f"the mesh, order {teeth}, is not {parameters.gear:g} dB above its neighbours in both boxes")
    low, high = sorted(mesh.levels.values())
    at_mesh = f"the mesh, order {teeth}, is {low:.1f} and {high:.1f} dB above its neighbours, with sidebands of {mesh.sidebands:.1f} dB"
    if high - low > ALIKE:
        return Status("healthy", f"{at_mesh}; the boxes do not measure it alike, as they would a gear")
    if mesh.rival and mesh.ahead <= -AHEAD:
        return Status("healthy", f"{at_mesh}, {-mesh.ahead:.1f} dB less than in {mesh.rival}")
    if mesh.rival and mesh.ahead < AHEAD:
        return Status(UNDECIDED, f"{at_mesh}, but {mesh.rival} has it within {AHEAD:g} dB", 0.0, score)
    than = f", {mesh.ahead:.1f} dB more than in {mesh.rival}" if mesh.rival else ""
    return Status("gear", f"{at_mesh}{than}", probability(score), score)
