"""What lines that roll along but are no whole orders of a wheelset show: a corrugated rail, and the motor of a driven wheelset.

A corrugation of wavelength w strikes all wheels of a rail with v / w, whatever their radii. A motor turns faster than its wheelset by the
ratio of the gear, and its field faster than that by the slip. Wheels and meshes have whole orders.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping

import numpy as np
from scipy.ndimage import maximum_filter1d

from dcrb_ros.diagnosis.hysteresis import probability
from dcrb_ros.diagnosis.order_spectrum import OrderSpectrum, medians
from dcrb_ros.diagnosis.vehicle.contact import Contact
from dcrb_ros.diagnosis.vehicle.parameters import VehicleDetectorParameters
from dcrb_ros.diagnosis.vehicle.turn_lines import AHEAD, ALIKE, BESIDE, at_frequency, of_axle, spectra_of
from dcrb_ros.stream.vehicle_description import SIDES, AxleDescription, VehicleDescription
from dcrb_ros.stream.vehicle_diagnosis import Status

WAVELENGTHS = (0.02, 0.3)
"""Wavelengths of corrugations [m]."""
OTHER_RAIL = 3.0
"""By how much the line of a corrugated rail must be less prominent at the other box of each wheelset [dB]; 3.6 to 30 dB were computed."""
MOTOR_ORDERS = (2.0, 60.0)
"""Orders of a wheelset at which a motor is looked for [-]: twice the pairs of poles times the ratio, and the ratio."""
WHOLE = 0.03
"""Distance from a whole order up to which a line is a wheel's [-]: half the width of a line in 3 s at 100 km/h."""


def prominent(spectrum: OrderSpectrum, orders: tuple[float, float], least: float) -> Iterator[float]:
    """Yield the orders of lines between two orders that are ``least`` or more [dB] above the median around them, the most prominent first.

    A line is the largest value within `BESIDE` orders, so that the leakage of a large one is no other.
    """
    first, last = np.searchsorted(spectrum.orders, orders)
    width = max(3, round(1.0 / float(spectrum.orders[1])))
    count = (last - first) // width
    if count < 1:
        return
    amplitude = np.maximum(spectrum.amplitude[first : first + count * width].astype(np.float64), 1e-12)
    level = 20.0 * np.log10(amplitude / np.repeat(medians(amplitude.reshape(count, width)), width))
    highest = level == maximum_filter1d(level, 2 * round(BESIDE / float(spectrum.orders[1])) + 1)
    top = 1 + np.flatnonzero((level >= least)[1:-1] & highest[1:-1])
    for k in top[np.argsort(-level[top], kind="stable")]:
        before, here, after = level[k - 1 : k + 2]
        offset = 0.5 * (before - after) / min(before - 2.0 * here + after, -1e-9)
        yield (first + k + float(offset)) * float(spectrum.orders[1])


def is_whole(frequency: float, contacts: Iterable[Contact]) -> bool:
    """Return whether a frequency [Hz] is a whole order of any of the wheelsets: a line of a wheel, which the others measure, too."""
    orders = [frequency / abs(contact.shaft_frequency) for contact in contacts]
    return any(abs(order - round(order)) <= WHOLE for order in orders)


def corrugation(
    description: VehicleDescription, contacts: Mapping[str, Contact], parameters: VehicleDetectorParameters
) -> tuple[Status, dict[str, float]] | None:
    """Return the status of the track by a corrugated rail, and its indicators; None without a corrugation.

    All boxes of one side have the line, at one frequency that is a whole order of no wheelset, and each has more of it than the other box
    of its wheelset. Two wheelsets with both boxes are needed; if only some of their boxes are missing, the status is ``waiting``.
    """
    spectra = spectra_of(contacts)
    both = [axle.name for axle in description.axles if all(f"{axle.name}/{side}" in spectra for side in SIDES)]
    if len(both) < 2:
        missing = [box.name for box in description.boxes if box.name not in spectra]
        if len(description.axles) < 2 or len(missing) == len(description.boxes):
            return None
        return Status("waiting", f"a corrugated rail cannot be recognised without a spectrum of {', '.join(missing)}"), {}
    for side, other_side in itertools.permutations(SIDES):
        pairs = [(f"{axle}/{side}", f"{axle}/{other_side}") for axle in both]
        first = pairs[0][0]
        turn, around = abs(contacts[first].shaft_frequency), 2.0 * math.pi * description.axle(both[0]).wheel_radius
        for order in prominent(spectra[first], (around / WAVELENGTHS[1], around / WAVELENGTHS[0]), parameters.corrugation):
            frequency = order * turn
            if is_whole(frequency, (contacts[name] for name in spectra)):
                continue
            level = {name: at_frequency(contacts[name], spectra[name], frequency) for name, _ in pairs}
            here = min(level.values())
            if here < parameters.corrugation:
                continue
            ahead = min(level[name] - at_frequency(contacts[other], spectra[other], frequency) for name, other in pairs)
            if ahead < OTHER_RAIL:
                continue
            wavelength, score = around / order, here - parameters.corrugation
            reason = (
                f"waves of {wavelength * 1e3:.1f} mm make a line of {here:.1f} dB or more in all boxes over the {side} rail, "
                f"{ahead:.1f} dB more than over the other one"
            )
            return Status("corrugation", reason, probability(score), score), {"track/corrugation": wavelength}
    return None


def motor(axle: AxleDescription, contacts: Mapping[str, Contact], parameters: VehicleDetectorParameters) -> Status | None:
    """Return the status of the drive of a wheelset by its motor; None without a line of it.

    Both boxes of the wheelset have the line alike, and the other wheelsets less of it.
    """
    own, spectra = spectra_of(of_axle(contacts, axle.name)), spectra_of(contacts)
    if not axle.driven or len(own) < len(SIDES):
        return None
    first, second = own
    turn = abs(contacts[first].shaft_frequency)
    for order in prominent(own[first], MOTOR_ORDERS, parameters.motor):
        frequency = order * turn
        if is_whole(frequency, (contacts[name] for name in spectra)):
            continue
        levels = [at_frequency(contacts[name], own[name], frequency) for name in (first, second)]
        elsewhere = max((at_frequency(contacts[name], spectra[name], frequency) for name in spectra if name not in own), default=0.0)
        alike = min(levels) >= parameters.motor and abs(levels[0] - levels[1]) <= ALIKE
        if not alike or min(levels) - elsewhere < AHEAD:
            continue
        score = min(levels) - parameters.motor
        reason = (
            f"order {order:.2f} of the wheelset is {min(levels):.1f} and {max(levels):.1f} dB above the noise beside it, "
            f"{min(levels) - elsewhere:.1f} dB more than in the other wheelset, and no whole order"
        )
        return Status("motor", reason, probability(score), score)
    return None
