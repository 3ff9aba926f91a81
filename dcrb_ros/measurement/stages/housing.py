"""The housing: many overlapping modes between outer ring and accelerometer, which no calibration finds one by one."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from dcrb_ros.measurement.convolution import Convolution
from dcrb_ros.measurement.filters import Filter
from dcrb_ros.measurement.housing import (
    LEAST_STEP_RATE,
    dense_modes,
    flattened,
    impulse_response,
    seat_sections,
    unit_impulse,
)
from dcrb_ros.measurement.stage import Parameters, Setup, Span, Stage
from dcrb_ros.measurement.stages.path import PathParameters
from dcrb_ros.measurement.stages.structure import StructureParameters, has_modes, modes, sections
from dcrb_ros.schema.arrays import Floats

STREAM = "housing"
"""Name of the random numbers of the housing."""


class Housing(Stage):
    """Acceleration through a housing drawn by structure.seed, and changed by structure.mounting.

    * Given or drawn modes of the axle box take the place of the rigid mass line, and the dense modes begin above the highest of them.
    * With a calibrated path, which has the magnitude of its housing, an axis keeps the fine structure and the decay of the response: it is
      divided by its third-octave envelope of minimum phase.
    """

    group = "structure"

    def __init__(self, setup: Setup, rate: float) -> None:
        super().__init__(setup, rate)
        structure, path = setup.parameters[StructureParameters], setup.parameters[PathParameters]
        self._convolution: Convolution | None = None
        self._boxes: list[Filter | None] = [None, None]
        if structure.housing == "none":
            return
        calibrated = [bool(text.strip()) for text in (path.path_x, path.path_y)]
        highest, direct = 0.0, unit_impulse(rate)
        if has_modes(structure):
            highest = max(mode.frequency for mode in modes(structure))
            for axis, box in enumerate(sections(structure.model_copy(update={"coupling": 1.0}), rate)):
                if calibrated[axis]:
                    direct[axis] = Filter(box, columns=1).process(direct[axis][:, None])[:, 0]
                else:
                    # A mode with little damping outlasts the impulse response.
                    self._boxes[axis], direct[axis] = Filter(box, columns=1), 0.0
        dense = dense_modes(structure.housing, STREAM, structure.seed, highest, structure.mounting)
        self._seat = Filter(seat_sections(dense, rate))
        response = impulse_response(dense, rate, direct)
        self._convolution = Convolution(np.stack([flattened(x) if known else x for x, known in zip(response, calibrated, strict=True)]))

    @classmethod
    def problems(cls, parameters: Parameters, step_rate: int) -> Iterator[str]:
        structure, path = parameters[StructureParameters], parameters[PathParameters]
        if structure.housing == "none":
            return
        usual = StructureParameters.model_fields["coupling"].default
        if step_rate < LEAST_STEP_RATE:
            yield (
                f"structure.housing = {structure.housing} needs at least {LEAST_STEP_RATE} steps per second, and simulation.step gives "
                f"{step_rate}: give a shorter step"
            )
        if has_modes(structure) and structure.coupling not in (usual, 1.0):
            yield (
                f"structure.coupling = {structure.coupling:g} does not apply with structure.housing = {structure.housing}, where it is 1: "
                "give 1, or structure.housing = none"
            )
        if path.path_spread > 0.0:
            yield (
                f"structure.path_spread = {path.path_spread:g} dB does not apply with structure.housing = {structure.housing}, "
                "which differs between machines: give 0, or structure.housing = none"
            )

    @property
    def active(self) -> bool:
        return self._convolution is not None

    def process(self, acceleration: Floats, span: Span) -> Floats:
        assert self._convolution is not None
        transmitted = self._convolution.process(acceleration)
        if any(self._boxes):
            through = np.zeros_like(acceleration)
            for axis, box in enumerate(self._boxes):
                if box is not None:
                    through[:, axis : axis + 1] = box.process(acceleration[:, axis : axis + 1])
            transmitted += self._seat.process(through)
        return transmitted
