r"""The bearing's share of the healthy power, and the noise of the machine that is the rest.

A spectrum does not separate the bearing from other sources; the squared envelope does. Other sources have no lines at the orders of the
bearing, so that the amplitude of such a line in the squared envelope of a band belongs to the bearing alone (Antoni 2007, "Cyclic spectral
analysis of rolling-element bearing signals", J. Sound Vib. 304(3-5), 497-529). The identified path gives all of the power to the bearing.
Behind it, the bench's bearing has lines of the amplitude A; the machine has lines of the amplitude M. The share of the power is M/A, on
the assumption that the machine's bearing is modulated as deeply as the bench's. With octaves b, families of lines k and the depths
D = A / a of an individual over its own mean squared envelope and m = M / a over that of the source, to which the path gives the power of
the machine,

    s^2 = sum_bk w_bk m_bk^2 / sum_bk w_bk D_bk^2,        w_bk = <D_bk^2> / (n_b^4 + d^4),

where all squares are above those of neighbouring orders, n^2 is the square found in this way at orders without lines, d is a constant, and
<> is the mean over individuals of the bench's bearing, whose lines differ. The interval is that of a bootstrap over windows and over the
orders without lines. The machine's bearing is one more draw from the population: the logarithm of its lower sum is drawn from Student's t
about the mean of the few that are simulated. If the bench has no lines above its own noise, the share is unknown.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.calibration.estimate import LEVEL, EstimatedParameter
from dcrb_ros.calibration.healthy_recording import HealthyRecording
from dcrb_ros.calibration.identified_path import COLUMNS, LOWEST, IdentifiedPath, Part
from dcrb_ros.calibration.path_fit import PathFit, PathSpectra, fit_path
from dcrb_ros.calibration.simulated_bearing import RingAcceleration
from dcrb_ros.calibration.spectra import HIGHEST_SHARE, Binned, binned, power_density
from dcrb_ros.diagnosis.features.envelope_lines import envelope_order_spectrum
from dcrb_ros.diagnosis.features.family import SLIP, fault_orders
from dcrb_ros.diagnosis.line_search import FEWEST_NEIGHBOURS, GUARD, NEIGHBOURHOOD, local_mean
from dcrb_ros.diagnosis.order_spectrum import OrderSpectrum
from dcrb_ros.diagnosis.order_tracking import forward_turns
from dcrb_ros.measurement.stages.path import text_of
from dcrb_ros.schema.arrays import Floats

FIRST_BAND = 500.0
"""Lower edge of the first octave [Hz]: lines of the shaft, the mains and single rollers lie below."""
NARROWEST_BAND = 1.3
"""Smallest ratio of the edges of the last band [-]."""
WIDTH_OVER_LINE = 2.0
"""Smallest width of a band over BPFI [-]: a narrower one has no line at it."""
WINDOW, WINDOW_TURNS = 1.0, 10.0
"""Length of a window, the longer one of both [s, turns]: lines of slipping rollers wander over longer ones."""
HARMONICS = 3
"""Harmonics of a family [-]."""
DECOYS = (0.88, 0.92, 1.08, 1.12)
"""Orders of the decoys over those of the families [-]."""
APART = 0.045
"""Smallest relative distance of a decoy from a harmonic of a family [-]: both searches reach 2 %."""
SHALLOW = 0.05
"""Depth below which the noise of a band makes no difference [-]."""
DRAWS = 500
"""Draws of the bootstrap [-]."""
UNKNOWN = 10.0
"""Upper over lower end of the interval where no line shows a lower one [-], a convention: 10 dB."""


@dataclass(frozen=True, eq=False)
class EnvelopeLines:
    """Squared amplitudes of lines in the squared envelope of each band."""

    families: Floats
    """Shape (windows, bands, families)."""
    decoys: Floats
    """At orders without lines, shape (windows, bands, decoys)."""
    mean: Floats
    """Mean squared envelope, shape (bands,)."""


def bearing_share_of(
    machines: Sequence[HealthyRecording], individuals: Sequence[Sequence[RingAcceleration]], path: IdentifiedPath, step_rate: float
) -> Part:
    """Return the share of the bearing in the healthy power and the noise of the machine, which is the rest.

    ``individuals`` holds individuals of the bench's bearing for each recording.
    """
    pairs: list[tuple[EnvelopeLines, list[EnvelopeLines]]] = []
    for number, machine in enumerate(machines):
        bands = list(_bands(machine))
        for row, axis in enumerate(machine.axes):
            measured = lines_in(machine.acceleration[row], machine.turns, machine.rate, bands, machine.orders)
            simulated = []
            for individual in individuals[number]:
                behind = _behind(individual.acceleration[COLUMNS[axis]], path.fits[axis], number, machine.rate, step_rate)
                simulated.append(lines_in(behind, individual.turns, machine.rate, bands, machine.orders))
            pairs.append((measured, simulated))
    part = _part(_drawn_shares(pairs))
    if part.estimates[0].low < 1.0:
        _add_noise(part, machines, path)
    return part


def lines_in(signal: Floats, turns: Floats, rate: int, bands: Sequence[tuple[float, float]], orders: Orders) -> EnvelopeLines:
    """Return the lines of a signal in bands [Hz], window by window."""
    fundamentals = [fault_orders(orders)[name] for name in ("BPFO", "BPFI", "2BSF")]
    searched = [*fundamentals, *_decoys(fundamentals)]
    forward = forward_turns(turns)
    per_second = float(forward[-1]) * rate / len(forward)
    length = min(len(signal), round(rate * max(WINDOW, WINDOW_TURNS / per_second)))
    powers, means = [], []
    for begin in range(0, len(signal) - length + 1, max(1, length // 2)):
        window = slice(begin, begin + length)
        spectra = [envelope_order_spectrum(signal[window], forward[window] - forward[begin], rate, low, high) for low, high in bands]
        powers.append([_powers(spectrum, searched) for spectrum in spectra])
        means.append([spectrum.mean for spectrum in spectra])
    squares = np.array(powers).reshape(len(powers), len(bands), len(searched))
    count = len(fundamentals)
    return EnvelopeLines(squares[..., :count], squares[..., count:], np.mean(means, axis=0))


def _powers(spectrum: OrderSpectrum, fundamentals: Sequence[float]) -> list[float]:
    """Return the power of three harmonics of each fundamental within 2 % above that of their neighbours, which is zero on average in noise.

    A sum over all orders within 2 % takes a line wherever slip has moved it, without the bias of a search for the largest.
    """
    step = float(spectrum.orders[1])
    power = np.square(np.asarray(spectrum.amplitude, np.float64))
    excess = power - local_mean(power, max(FEWEST_NEIGHBOURS, math.ceil(NEIGHBOURHOOD / step)))
    excess[np.abs(spectrum.orders - np.rint(spectrum.orders)) <= GUARD * step] = 0.0
    total = np.concatenate([[0.0], np.cumsum(excess)])
    ends = len(excess)
    powers = []
    for order in fundamentals:
        lines = order * np.arange(1.0, HARMONICS + 1.0)
        first, last = (np.clip(np.rint(lines * (1.0 + side * SLIP) / step).astype(int) + side, 0, ends - 1) for side in (-1, 1))
        powers.append(float(np.sum(total[last + 1] - total[first])))
    return powers


def _decoys(fundamentals: Sequence[float]) -> list[float]:
    lines = np.outer(fundamentals, (1.0, 2.0, 3.0)).ravel()
    tried = [order * factor for order in fundamentals for factor in DECOYS]
    return [order for order in tried if np.min(np.abs(order / lines - 1.0)) > APART]


def _bands(machine: HealthyRecording) -> Iterator[tuple[float, float]]:
    """Yield the edges of the octaves in which lines up to BPFI can be seen [Hz]."""
    top, line = HIGHEST_SHARE * machine.rate, machine.orders.bpfi * abs(machine.speed) / (2.0 * math.pi)
    low = FIRST_BAND
    while low * NARROWEST_BAND <= top:
        high = min(2.0 * low, top)
        if high - low >= WIDTH_OVER_LINE * line:
            yield low, high
        low *= 2.0


def _behind(signal: Floats, fit: PathFit, recording: int, rate: int, step_rate: float) -> Floats:
    """Return the acceleration of the ring behind the path of a recording."""
    from scipy.signal import sosfreqz

    from dcrb_ros.measurement.stages.path import cascade

    spectrum = np.fft.rfft(signal)
    if fit.pairs:
        spectrum *= sosfreqz(cascade(fit.pairs, step_rate), np.fft.rfftfreq(len(signal), 1.0 / rate), fs=step_rate)[1]
    return np.asarray(fit.gains[recording] * np.fft.irfft(spectrum, len(signal)), np.float64)


def _drawn_shares(pairs: Sequence[tuple[EnvelopeLines, Sequence[EnvelopeLines]]]) -> Floats:
    """Return shares drawn by the bootstrap, shape (draws,) [-]; 0 and infinity where an individual of the bench shows no lines.

    Each pair has the lines of the machine on an axis and those of the individuals behind the path, the first of which is the source.
    """
    count = len(pairs[0][1])
    sums, machines, benches = np.zeros(count), list[_Weighted](), [list[_Weighted]() for _ in range(count)]
    for machine, simulated in pairs:
        scales = np.maximum([lines.mean for lines in simulated], np.finfo(np.float64).tiny)[..., None] ** 2
        depths = np.array([_above_decoys(lines) for lines in simulated]) / scales
        noise = np.mean((machine.decoys.mean(axis=0) / scales[0]) ** 2, axis=1, keepdims=True)
        weight = depths.mean(axis=0) / (noise + SHALLOW**4)
        sums += np.sum(weight * depths, axis=(1, 2))
        machines.append(_Weighted(machine.families, machine.decoys, weight / scales[0]))
        for lines, individual, scale in zip(benches, simulated, scales, strict=True):
            lines.append(_Weighted(individual.families, individual.decoys, weight / scale))
    if not all(_shows_lines(lines) for lines in benches):
        return np.array([0.0, math.inf])
    random = np.random.default_rng(21)
    drawn = np.empty(DRAWS)
    for k in range(DRAWS):
        below = _one_more(sums, random)
        drawn[k] = math.sqrt(max(0.0, _drawn_sum(machines, random) / below))
    return drawn


def _above_decoys(lines: EnvelopeLines) -> Floats:
    """Return the mean squares of the families above those of the decoys, at least 0, shape (bands, families)."""
    above = lines.families.mean(axis=0) - lines.decoys.mean(axis=(0, 2))[:, None]
    return np.asarray(np.maximum(0.0, above), np.float64)


class _Weighted(NamedTuple):
    """Lines of an axis and the weight of each."""

    families: Floats
    decoys: Floats
    weight: Floats


def _drawn_sum(lines: Sequence[_Weighted], random: np.random.Generator) -> float:
    """Return the weighted sum over all axes of lines above orders without lines, windows and such orders drawn with replacement."""
    total = 0.0
    for families, decoys, weight in lines:
        windows = random.integers(len(families), size=(len(families) + 1) // 2)  # they overlap by half
        chosen = random.integers(decoys.shape[2], size=families.shape[2])
        total += float(np.sum(weight * (families[windows] - decoys[windows][..., chosen]).mean(axis=0)))
    return total


def _shows_lines(lines: Sequence[_Weighted]) -> bool:
    """Return whether an individual of the bench has lines that stand out of its noise in 95 % of the draws."""
    random = np.random.default_rng(22)
    return float(np.quantile([_drawn_sum(lines, random) for _ in range(DRAWS)], 0.5 - 0.5 * LEVEL)) > 0.0


def _one_more(sums: Floats, random: np.random.Generator) -> float:
    """Draw the sum of one more individual, whose logarithm is distributed like those of the others.

    (x - mean) / (deviation sqrt(1 + 1/n)) follows Student's t with n - 1 degrees of freedom (Hahn and Meeker 1991, "Statistical
    Intervals", ch. 4).
    """
    logarithms, count = np.log(sums), len(sums)
    deviation = float(np.std(logarithms, ddof=1)) * math.sqrt(1.0 + 1.0 / count)
    return math.exp(float(logarithms.mean()) + deviation * float(random.standard_t(count - 1)))


def _part(drawn: Floats) -> Part:
    """Return the estimate from drawn shares, and what is not identified."""
    part = Part()
    low, middle, high = (float(np.quantile(drawn, at, method="nearest")) for at in (0.5 - 0.5 * LEVEL, 0.5, 0.5 + 0.5 * LEVEL))
    if high <= 0.0:  # its lines are below orders without lines, which excludes no share
        high = math.inf
    shown, top = low > 0.0, min(1.0, high)
    if high < 1.0:
        part.remarks.append(
            f"the bearing has at most {high:.2g} of the power if its lines in the envelope are as deep as the bench's: the rest is noise "
            "of the machine"
        )
        if not shown:
            part.remarks.append(
                f"the lower end of that share is a convention, {UNKNOWN:g} times less: no line of the bearing stands out of the envelope"
            )
    elif not shown:
        part.remarks.append(
            "the bearing's share of the power is unknown, for machine or bench has no clear lines of it in the envelope: "
            f"{1.0 / UNKNOWN:g} to 1, a convention"
        )
    bottom = min(low, top) if shown else top / UNKNOWN
    value = min(top, middle if shown else max(middle, top / math.sqrt(UNKNOWN)))
    part.identify(EstimatedParameter("structure.bearing_share", value, bottom, top, "-", log=True))
    return part


def _add_noise(part: Part, machines: Sequence[HealthyRecording], path: IdentifiedPath) -> None:
    """Add the spectrum of the machine's noise: that of the healthy recording without the white noise."""
    for row, axis in enumerate(machines[0].axes):
        spectra = [binned(power_density(machine.acceleration[row], machine.rate), machine.rate) for machine in machines]
        flat = [Binned(spectrum.frequency, np.zeros_like(spectrum.level), np.zeros_like(spectrum.level)) for spectrum in spectra]
        fit = fit_path(PathSpectra.of(spectra, flat, LOWEST, path.fits[axis].data.step_rate), white=path.white)
        part.parameters |= {f"structure.noise_{axis}": float(fit.gains[0]), f"structure.noise_path_{axis}": text_of(fit.pairs)}
    if machines[0].axes == ("y",):
        for name in ("noise", "noise_path"):
            part.parameters[f"structure.{name}_x"] = part.parameters[f"structure.{name}_y"]


def divide_noise(part: Part, factor: float) -> None:
    """Divide the noise of the machine by a factor [-]: modulation by the shaft adds power."""
    for key in ("structure.noise_x", "structure.noise_y"):
        if key in part.parameters:
            part.parameters[key] /= factor
