"""Calibration: from healthy recordings of a machine to a bench that measures like it, with an interval for each value.

What can be identified from acceleration at the sensor is the product of source and path. By convention the source is the simulated bench,
so that the path holds every difference between its bearing and the machine's, too. How much of the power is the bearing's follows from the
lines in the squared envelope. `docs/explanation/calibration.md` has the formulas.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from dcrb_ros.bearing.waveform import Signal, Waveform
from dcrb_ros.calibration.bearing_share import bearing_share_of, divide_noise
from dcrb_ros.calibration.estimate import LEVEL, EstimatedParameter, PathLevel
from dcrb_ros.calibration.healthy_recording import LEAST_SECONDS, HealthyRecording, check_one_machine, checked_recording
from dcrb_ros.calibration.identified_path import identified_path
from dcrb_ros.calibration.simulated_bearing import bench_of, individuals_of
from dcrb_ros.calibration.speed_and_background import background_of, hum_of, modulation_of, speed_of, tones_of, unbalance_of
from dcrb_ros.schema.arguments import checked_arguments, texts
from dcrb_ros.schema.numbers import duration_within
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import fields_by_key, load_configuration
from dcrb_ros.text.counts import counted

LONGEST_SOURCE = 60.0
"""Longest simulated source [s]."""
STEPS = 5
"""Steps of a calibration that report progress [-]."""
RANGE_OVER_PEAK = 10.0
"""Range of the simulated sensor over the measured peak where the range is unknown [-]."""
NOT_IDENTIFIED = (
    "the load, the lubrication and the surfaces cannot be identified from a healthy recording; the base values are kept",
    "the phase of the path and a delay cannot be identified; a minimum phase is assumed",
    "the range and the converter of the sensor are unknown unless the signal is clipped: the range is ten times the peak",
)


@dataclass(frozen=True, eq=False, repr=False)
class Calibration:
    """A bench calibrated to a machine."""

    configuration: Configuration
    """The bench, to be simulated like any other."""
    estimates: tuple[EstimatedParameter, ...]
    """The estimated parameters with their intervals."""
    gains: Mapping[str, EstimatedParameter]
    """By axis, the root of the power behind the path over that before it, from 200 Hz to the upper end of the band: what can be identified
    of a gain, while ``structure.gain_y`` is the gain at rest, where the noise covers the bearing."""
    path: tuple[PathLevel, ...]
    """Gain of the path in third octaves, which is what the sections in the configuration amount to."""
    unidentified: tuple[str, ...]
    """What could not be identified, and why, in a sentence each."""
    recordings: tuple[str, ...]
    """Names of the recordings."""
    measured: Waveform
    """The first recording, with which a simulation of the configuration can be compared."""
    residual: tuple[tuple[str, np.ndarray[Any, Any], np.ndarray[Any, Any]], ...]
    """By axis: frequencies [Hz] and measured over modelled density in narrow bins [dB]."""
    level: float = LEVEL
    """Probability of the intervals [-]."""

    def __repr__(self) -> str:
        return f"<Calibration: {len(self.estimates)} values from {', '.join(self.recordings)}>"

    @property
    def intervals(self) -> dict[str, tuple[float, float]]:
        """Return the interval of each estimated parameter by its key."""
        return {estimate.key: (estimate.low, estimate.high) for estimate in self.estimates}

    def __getitem__(self, key: str) -> EstimatedParameter:
        """Return the estimate of a parameter.

        Raises
        ------
        KeyError
            It was not estimated.
        """
        return {estimate.key: estimate for estimate in self.estimates}[key]

    def draw(self, seed: int) -> dict[str, float | int]:
        """Return parameters of a machine drawn within the intervals, as changes of `configuration`; equal seeds give equal machines.

        `load_configuration(calibration.configuration, calibration.draw(3))` is the third machine.

        Raises
        ------
        Refusal
            The seed is not a whole number from 0 on.
        """
        if not isinstance(seed, (int, np.integer)) or isinstance(seed, bool) or seed < 0:
            raise Refusal(f"seed = {seed!r} is not a whole number from 0 on: give the number of the machine")
        random = np.random.default_rng([seed, 21])
        drawn: dict[str, float | int] = {}
        for estimate in self.estimates:
            share = float(random.random())
            drawn[estimate.key] = (
                estimate.low * (estimate.high / estimate.low) ** share
                if estimate.log and estimate.low > 0.0
                else estimate.low + share * (estimate.high - estimate.low)
            )
        return drawn | {"structure.seed": int(random.integers(1, 2**31 - 1)), "structure.path_spread": self.path_spread}

    @property
    def path_spread(self) -> float:
        """Standard deviation of the level of the path in its third octaves, for `structure.path_spread` [dB].

        It is that for one individual of the bearing: `surfaces.seed` draws others.
        """
        deviations = [level.chance for level in self.path if level.identified]
        return round(float(np.median(deviations)), 3) if deviations else 0.0


@checked_arguments(names=texts)
def calibrate(
    recordings: Signal | Sequence[Signal],
    *,
    base: Configuration | str | Path | None = None,
    settings: Mapping[str, Any] | Sequence[str] = (),
    source_seconds: float = 4.0,
    trust: bool = False,
    names: Sequence[str] = (),
    progress: Callable[[str], None] = lambda step: None,
) -> Calibration:
    """Return a bench fitted to healthy recordings of a machine.

    Parameters
    ----------
    recordings
        A `Recording`, `SimulationResult` or `Waveform`, or several of one machine, with a speed or an angle of the shaft; accelerations in
        m/s^2 or in relative units, at a rate of 1000 to 204800 Hz that has a divisor between 10 and 1000 Hz.
    base
        The bench whose bearing is the source: a configuration or its name. By default the one that made the recording; for imported data
        ``healthy`` with the number and size of rollers that give the recording's orders.
    settings
        Parameters to change in the base, such as ``{"operating.load": 5000.0}``. Those that the recording determines are rejected.
    source_seconds
        Simulated time of the source at the speed of each recording, 2 to 60 [s].
    trust
        Take the recordings as healthy although the fault detector finds a fault.
    names
        Names of the recordings in messages; their paths by default.
    progress
        Called with the description of each of the `STEPS` steps as it begins.

    Returns
    -------
    Calibration
        The configuration, the estimates with their intervals, the path in third octaves and what could not be identified.

    Raises
    ------
    Refusal
        A recording that is empty, shorter than 2 s or 20 turns, clipped, without speed, at a varying speed, of an unknown bearing or
        faulty; recordings of different machines or sampling rates; a base with another bearing.

    Examples
    --------
    >>> import dcrb_ros
    >>> machine = dcrb_ros.simulate("healthy", 3.0, settings={"structure.gain_y": 0.5, "structure.gain_x": 0.5})
    >>> calibration = dcrb_ros.calibrate(machine)
    >>> twin = dcrb_ros.simulate(calibration.configuration, 3.0)
    """
    duration_within("source_seconds =", source_seconds, LONGEST_SOURCE, "4 s give spectra within 0.5 dB")
    if source_seconds < LEAST_SECONDS:
        raise Refusal(f"source_seconds = {source_seconds:g} is below {LEAST_SECONDS:g} s: 4 s give spectra within 0.5 dB")
    if not isinstance(recordings, (Signal, list, tuple)):
        raise Refusal(f"recordings is a {type(recordings).__name__}: give a recording of the healthy machine, or a list of them")
    given = [recordings] if isinstance(recordings, Signal) else list(recordings)
    stated = [names] if isinstance(names, str) and names else list(names)
    called = stated or [_name(signal, number) for number, signal in enumerate(given, 1)]
    if len(called) != len(given):
        raise Refusal(f"{counted(len(called), 'name')} given for {counted(len(given), 'recording')}: give one for each, or none")
    progress("checking the recordings")
    machines = [checked_recording(signal, name, trust=trust) for signal, name in zip(given, called, strict=True)]
    check_one_machine(machines)
    benches = [bench_of(machine, base, settings) for machine in machines]
    progress("simulating the bearing")
    individuals, step_rate = individuals_of(machines, benches, source_seconds), float(benches[0].step_rate)
    machine, source = machines[0], individuals[0][0]
    progress("identifying the path")
    path = identified_path(machines, individuals, step_rate)
    modulation = modulation_of(machine, source, path)
    progress("estimating the bearing's share")
    share = bearing_share_of(machines, individuals, path, step_rate)
    added = math.sqrt(1.0 + 0.5 * modulation.parameters.get("structure.modulation", 0.0) ** 2)
    path.divide_gains(added)
    divide_noise(share, added)
    progress("estimating noise, speed and unbalance")
    estimates, unidentified, parameters = list[EstimatedParameter](), list[str](), dict[str, Any]()
    hum = hum_of(machine)
    for part in (
        path,
        share,
        modulation,
        speed_of(machines),
        hum,
        unbalance_of(machine, source, path),
        background_of(machine, path, benches[0], hum.parameters.get("background.hum_frequency", 0.0)),
        tones_of(machine, path),
    ):
        estimates += part.estimates
        unidentified += part.remarks
        parameters |= part.parameters
    try:
        configuration = load_configuration(benches[0], parameters | _range(machines))
    except Refusal as refusal:
        reason = str(refusal).removeprefix("settings: ")
        raise Refusal(f"no bench is like {called[0]}: {reason}; check the unit and the sensitivity of the recording") from None
    kept, left_out = accepted(estimates, configuration)
    return Calibration(
        configuration,
        tuple(kept),
        path.gains,
        tuple(path.levels),
        (*unidentified, *left_out, *NOT_IDENTIFIED),
        tuple(called),
        machine.waveform,
        tuple(path.residuals),
    )


def _range(machines: Sequence[HealthyRecording]) -> dict[str, float]:
    """Return a range of the sensor that the machine does not reach."""
    known = machines[0].waveform.sensor_range
    peak = max(float(np.abs(machine.acceleration).max()) for machine in machines)
    return {"sensor.range": known if known > peak else min(1e6, max(1.0, RANGE_OVER_PEAK * peak))}


def accepted(estimates: Sequence[EstimatedParameter], configuration: Configuration) -> tuple[list[EstimatedParameter], list[str]]:
    """Return the estimates within the ranges of their parameters, and a sentence for each whose interval the bench does not accept."""
    kept, left_out = list[EstimatedParameter](), list[str]()
    for estimate in estimates:
        field = fields_by_key()[estimate.key]
        low, high = np.clip((estimate.low, estimate.high), field.low, field.high).tolist()
        try:
            for value in (low, high):
                load_configuration(configuration, {estimate.key: value})
        except Refusal as refusal:
            left_out.append(f"{estimate.key} has no interval, {low:.4g} to {high:.4g}: {str(refusal).removeprefix('settings: ')}")
        else:
            kept.append(replace(estimate, low=low, high=high))
    return kept, left_out


def _name(signal: Signal, number: int) -> str:
    path = getattr(signal, "path", None)
    return str(path) if path is not None else f"recording {number}"
