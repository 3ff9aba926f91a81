"""A baseline: the lines of a healthy bearing in every band, learned from a recording, saved and loaded.

A fault is judged by the depth of its lines, which needs no baseline. With one, lines must also be larger than those of the healthy
bearing, which raises a limit where the healthy bearing modulates deeply; and they may be shallower than the usual limit, which lowers it
where the healthy bearing is quiet.
"""

from __future__ import annotations

import functools
import hashlib
import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import numpy.typing as npt
from pydantic import Field, ValidationError

from dcrb_ros.bearing.frequencies import Orders
from dcrb_ros.diagnosis.demodulation import Band
from dcrb_ros.schema.fields import Group
from dcrb_ros.schema.parameter_field import first_problem
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.schema.verdicts import Component
from dcrb_ros.stream.axes import AXES
from dcrb_ros.text.json import digest_of
from dcrb_ros.text.writing import write_whole
from dcrb_ros.text.yaml import read_yaml, yaml_text

LEAST_DEPTH = 0.05
"""Modulation depth to which a baseline may lower a limit [-]: impacts with a thirtieth of the power in the band."""
DIGEST = "sha256"
"""Entry of a file with the digest of the others."""
SAME_ORDER = 1e-4
"""Relative difference of orders that are still those of one bearing [-]: four digits are usually given."""
OTHER_SPEED = 1.3
"""Ratio to the learned speeds from which the sizes of lines can no longer be compared well [-]."""
SOURCES = (
    *("segments", "demodulation", "order_tracking", "window", "order_spectrum", "line_search", "wandering_lines", "cage_lines"),
    *("evidence", "rule", "rules/outer_ring", "rules/inner_ring", "rules/roller", "rules/cage"),
)
"""Modules on which the sizes of lines depend."""
LEARNED_WITH = ("band_low", "band_high", "band", "whitening", "slip", "window", "speed_exponent")
"""Parameters of the detector on which sizes and depths of lines depend."""


class HealthyLines(Group):
    """The largest lines of one fault in one band of a healthy bearing."""

    component: Component
    band: tuple[float, float] = Field(strict=False)
    """Edges of the band [Hz]."""
    size: float = Field(ge=0.0)
    """Square root of their amplitude at 20 Hz of shaft frequency [m/s^2]."""
    depth: float = Field(ge=0.0)
    """Modulation depth [-]."""


class HealthyBaseline(Group):
    """What was learned from a healthy bearing, and for which bearing, sensor and rules it holds."""

    source: str
    """Recording from which it was learned."""
    rules: str
    """Hash of the rules by which it was learned."""
    sampling_rate: int = Field(ge=1)
    """[Hz]"""
    axes: int = Field(ge=1, le=len(AXES))
    orders: dict[str, float]
    """FTF, BPFO, BPFI and BSF [-]."""
    parameters: dict[str, float | str]
    """Those of the detector that learned it, as `learned_with`."""
    seconds: float = Field(gt=0.0)
    """Length of signal from which it was learned [s]."""
    judgements: int = Field(ge=1)
    """Windows from which it was learned [-]."""
    speeds: tuple[float, float] = Field(strict=False)
    """Lowest and highest shaft frequency among them [Hz]."""
    remark: str = ""
    """A remark on the recording for the user; empty for none."""
    lines: list[HealthyLines]

    def of(self, component: Component, band: Band) -> HealthyLines | None:
        """Return the healthy lines of a component in a band, none if they were not learned."""
        return self._by_band.get((component, *_rounded(band)))

    @functools.cached_property
    def _by_band(self) -> Mapping[tuple[str, float, float], HealthyLines]:
        return {(lines.component, *_rounded(lines.band)): lines for lines in self.lines}

    def check(self, orders: Orders, rate: int, parameters: Group) -> None:
        """Refuse another bearing, sampling rate, rules or parameters of the detector than those of the baseline.

        Raises:
            Refusal: they differ.
        """
        again = "learn the baseline again from a recording of the healthy bearing"
        if rate != self.sampling_rate:
            raise Refusal(f"the baseline of {self.source} has {self.sampling_rate} Hz, but the signal has {rate} Hz: {again}")
        for name, order in orders.as_dict().items():
            known = self.orders.get(name, math.nan)
            if not math.isclose(order, known, rel_tol=SAME_ORDER):
                raise Refusal(f"the baseline of {self.source} is of a bearing with {name} = {known:g}, not {order:g} orders: {again}")
        for name, value in learned_with(parameters).items():
            learned = self.parameters.get(name, "unknown")
            if value != learned:
                raise Refusal(f"the baseline of {self.source} was learned with {name} = {learned}, but the detector has {value}: {again}")
        if self.rules != rules_hash():
            raise Refusal(f"the baseline of {self.source} was learned by other rules ({self.rules}, now {rules_hash()}): {again}")

    def check_axes(self, acceleration: npt.NDArray[np.floating]) -> None:
        """Refuse a block of shape (samples, axes) with another number of axes; one axis is given as two equal ones.

        Raises:
            Refusal: the number differs.
        """
        count = axes(acceleration)
        if count not in (0, self.axes):
            raise Refusal(f"the baseline of {self.source} has axes: {self.axes}, but the signal has {count}: learn it from the same sensor")

    def sentence(self, frequency: float) -> str:
        """Return what is used, for a diagnosis at a shaft ``frequency`` [Hz]."""
        low, high = self.speeds
        beyond = frequency > 0.0 and not low / OTHER_SPEED <= frequency <= high * OTHER_SPEED
        other = f"; it was learned at {low:.1f} to {high:.1f} Hz, so that sizes are uncertain at this speed" if beyond else ""
        note = f"; {self.remark}" if self.remark else ""
        return f"lines are compared with a baseline of {self.seconds:.1f} s of {self.source}{other}{note}"

    def save(self, path: Path) -> None:
        """Write the baseline to a YAML file.

        Raises:
            Refusal: the file cannot be written.
        """
        tree = self.model_dump(mode="json")
        write_whole(path, yaml_text(tree | {DIGEST: digest_of(tree, DIGEST)}))


def read_baseline(path: Path) -> HealthyBaseline:
    """Return the baseline in a YAML file.

    Raises:
        Refusal: the file cannot be read, is no baseline, was changed, or has no digest.
    """
    tree = read_yaml(path)
    if not isinstance(tree, dict):
        raise Refusal(f"{path} is not a baseline: save one with dcrb detect BAG --healthy BAG --save-baseline {path}")
    try:
        baseline = HealthyBaseline.model_validate({key: value for key, value in tree.items() if key != DIGEST})
    except ValidationError as error:
        problem = first_problem(error)
        raise Refusal(f"{path} is not a baseline: {problem.key}: {problem.reason}; learn it again") from None
    if tree.get(DIGEST) is None:
        raise Refusal(f"{path} has no {DIGEST}, so that a change would not be found: learn the baseline again")
    if tree[DIGEST] != digest_of(tree, DIGEST):
        raise Refusal(f"{path} was changed: its digest does not match; learn the baseline again")
    return baseline


def learned_with(parameters: Group) -> dict[str, float | str]:
    """Return the parameters of a detector on which a baseline depends."""
    return {name: getattr(parameters, name) for name in LEARNED_WITH}


def axes(acceleration: npt.NDArray[np.floating]) -> int:
    """Return the number of different axes, shape (samples, axes); 0 if a signal without vibration does not show it."""
    first = acceleration[:, 0]
    if acceleration.shape[1] > 2 or (acceleration.shape[1] == 2 and not np.array_equal(first, acceleration[:, 1], equal_nan=True)):
        return int(acceleration.shape[1])
    known = first[np.isfinite(first)]
    return 1 if len(known) and np.ptp(known) > 0.0 else 0


def _rounded(band: tuple[float, float] | Band) -> tuple[float, float]:
    return round(band[0], 1), round(band[1], 1)


@functools.cache
def rules_hash() -> str:
    """Return a short hash of the sources on which the sizes of lines depend."""
    digest = hashlib.sha256()
    for name in SOURCES:
        digest.update((Path(__file__).parent / f"{name}.py").read_bytes())
    return digest.hexdigest()[:12]
