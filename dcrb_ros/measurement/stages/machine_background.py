"""Background of the machine: broadband noise behind a housing of its own, lines, and a floor that rises with damage."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from dcrb_ros.measurement.convolution import Convolution
from dcrb_ros.measurement.filters import Filter
from dcrb_ros.measurement.following_noise import FollowingNoise
from dcrb_ros.measurement.housing import dense_modes, impulse_response, unit_impulse
from dcrb_ros.measurement.machine_lines import MachineLines
from dcrb_ros.measurement.random_streams import random_stream
from dcrb_ros.measurement.stage import Parameters, Setup, Span, Stage
from dcrb_ros.measurement.stages.machine_noise import MachineNoiseParameters
from dcrb_ros.measurement.stages.structure import StructureParameters
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.fields import Group, quantity
from dcrb_ros.schema.refusal import Refusal

STREAM = "machine background"
"""Name of the random numbers of the background."""
FLOOR_STREAM = "floor of damage"
"""Name of the random numbers of the floor."""
CORNER = 2900.0
"""Corner of the first-order low-pass of the noise before its housing [Hz]."""
HIGHEST = 20000.0
"""Frequency up to which levels are defined [Hz]."""
TINY = 1e-30
"""Power below which the bearing is at rest [(m/s^2)^2]."""
SMOOTHING_TIME = 0.5
"""Time constant of the power and the spectrum from which the floor follows [s]."""


class MachineBackgroundParameters(Group):
    """Level of the background, its share in lines, and the floor."""

    healthy_level: float = quantity(
        0.0,
        "m/s^2",
        "Rms of the healthy bearing at the sensor up to 20 kHz, to which background and floor refer; 0 for neither",
        0.0,
        1e6,
    )
    healthy_speed: float = quantity(
        0.0,
        "rad/s",
        "Speed of the shaft at which healthy_level holds; 0 for operating.speed of the bench, also where a scenario starts at another",
        0.0,
        1000.0,
        remedy="give it without a sign",
    )
    background: float = quantity(0.0, "dB", "Level of the background of the machine over healthy_level", -60.0, 60.0)
    background_lines: float = quantity(0.0, "-", "Share of this background's power in lines", 0.0, 1.0, remedy="give a share, not per cent")
    floor: float = quantity(
        0.0,
        "-",
        "Power of noise between impacts over the power that damage adds at the sensor, of the same spectrum; 0 for none",
        0.0,
        10.0,
    )


def speed_of_level(background: MachineBackgroundParameters, speed: float) -> float:
    """Return the speed at which the level of the healthy bearing holds, for a bench that starts at ``speed`` [rad/s].

    Raises:
        Refusal: none is given, and the bench starts at rest.
    """
    if background.healthy_speed == speed == 0.0:  # the shaft may stop later
        raise Refusal(
            f"structure.healthy_level = {background.healthy_level:g} m/s^2 is a level at operating.speed, which is 0: give the speed "
            "at which it was measured as structure.healthy_speed, or a level of 0"
        )
    return background.healthy_speed or abs(speed)


class MachineBackground(Stage):
    r"""Adds noise and lines to the acceleration a behind the path.

    With the healthy level h, the background's level :math:`b = h \, 10^{B/20}`, its share s in lines, the speed r over that of the level,
    noise n and shaft lines, mains and slot lines l of mean square 1, the slow mean square P of a in both axes, and noise m with the slow
    mean of the power spectrum of a in each axis,

    .. math:: a' = a + \sqrt{1 - s} \, b \, r \, n + \sqrt{s} \, b \, l + \sqrt{c \max(0, 1 - h^2 r^2 / P)} \, m .

    The noise n passes a housing of its own with the distributions of structure.housing, drawn by structure.seed and structure.mounting.
    The floor m comes from the damage, so it has the path of the bearing.
    """

    group, parameters = "structure", MachineBackgroundParameters

    def __init__(self, setup: Setup, rate: float) -> None:
        super().__init__(setup, rate)
        structure, background = setup.parameters[StructureParameters], setup.parameters[MachineBackgroundParameters]
        self._active = background.healthy_level > 0.0 and structure.housing != "none"
        if not self._active:
            return
        self._speed = speed_of_level(background, setup.speed)
        level = background.healthy_level * 10.0 ** (background.background / 20.0)
        self._healthy, self._floor = background.healthy_level, background.floor
        self._noise_level = math.sqrt((1.0 - background.background_lines) * level**2)
        self._line_level = math.sqrt(background.background_lines) * level
        self._random = random_stream(setup.seed, STREAM)
        self._following = FollowingNoise(random_stream(setup.seed, FLOOR_STREAM), rate, SMOOTHING_TIME)
        pole = math.exp(-2.0 * math.pi * CORNER / rate)
        coloured = Filter(np.array([[1.0 - pole, 0.0, 0.0, 1.0, -pole, 0.0]])).process(unit_impulse(rate).T).T
        modes = dense_modes(structure.housing, STREAM, structure.seed, mounting=structure.mounting)
        response = impulse_response(modes, rate, unit_impulse(rate))
        self._noise = Convolution(_of_unit_power(_product(response, coloured), rate))
        share = -math.expm1(-1.0 / (SMOOTHING_TIME * rate))
        self._power = Filter(np.array([[share, 0.0, 0.0, 1.0, share - 1.0, 0.0]]))
        self._lines = MachineLines(structure.housing, structure.seed)

    @classmethod
    def problems(cls, parameters: Parameters, step_rate: int) -> Iterator[str]:
        structure, background = parameters[StructureParameters], parameters[MachineBackgroundParameters]
        if background.healthy_level == 0.0:
            for key in ("healthy_speed", "background", "background_lines", "floor"):
                if (value := getattr(background, key)) != 0.0:
                    yield f"structure.{key} = {value:g} needs structure.healthy_level, the rms of the healthy bearing: give a level above 0"
            return
        if structure.housing == "none":
            yield (
                f"structure.healthy_level = {background.healthy_level:g} m/s^2 needs a housing of the background: give structure.housing = "
                "laboratory or axle_box"
            )
        if (share := parameters[MachineNoiseParameters].bearing_share) < 1.0:
            yield (
                f"structure.healthy_level = {background.healthy_level:g} m/s^2 and structure.bearing_share = {share:g} both add noise of "
                "the machine: give a level of 0 or a share of 1"
            )

    @property
    def active(self) -> bool:
        return self._active

    def process(self, acceleration: Floats, span: Span) -> Floats:
        ratio = np.abs(np.diff(span.angle)) * (self.rate / self._speed)
        noise = self._noise.process(self._random.standard_normal(acceleration.shape))
        noise *= self._noise_level * ratio[:, None]
        if self._floor > 0.0:
            ticks = np.arange(span.first + 1, span.first + 1 + len(acceleration))
            weights = -np.expm1(-ticks / (SMOOTHING_TIME * self.rate))  # of all ticks since the start; 1 after some seconds
            mean = np.maximum(self._power.process(acceleration**2).mean(axis=1) / weights, TINY)
            added = np.maximum(1.0 - (self._healthy * ratio) ** 2 / mean, 0.0)  # its share in either axis
            noise += np.sqrt(self._floor * added)[:, None] * self._following.process(acceleration)
        if self._line_level > 0.0:
            noise += self._line_level * self._lines.at(span, ratio, self.rate)
        return acceleration + noise


def _product(first: Floats, second: Floats) -> Floats:
    """Return the convolution of two responses, shape (2, taps), cut to the length of the first."""
    size = 2 * first.shape[1]
    product: Floats = np.fft.irfft(np.fft.rfft(first, size) * np.fft.rfft(second, size), size)[:, : first.shape[1]]
    return product


def _of_unit_power(response: Floats, rate: float) -> Floats:
    """Return responses, shape (2, taps), that turn white noise of rms 1 into noise of rms 1 up to 20 kHz."""
    spectrum = np.abs(np.fft.rfft(response)) ** 2
    low = np.fft.rfftfreq(response.shape[1], 1.0 / rate) <= HIGHEST
    scaled: Floats = response / np.sqrt(spectrum[:, low].sum(axis=1, keepdims=True) / spectrum.shape[1])
    return scaled
