"""The stages of the measurement chain in their order. A new stage needs its own file and one line here."""

from __future__ import annotations

from collections.abc import Iterator
from pkgutil import resolve_name

from dcrb_ros.measurement.sample_clock import ClockParameters
from dcrb_ros.measurement.stage import Stage
from dcrb_ros.schema.fields import Group


def _stages(*names: str) -> tuple[type[Stage], ...]:
    """Return stages by module and class below ``dcrb_ros.measurement.stages``."""
    return tuple(resolve_name(f"dcrb_ros.measurement.stages.{name}") for name in names)


PER_STEP = _stages(
    "modulation:ShaftModulation",
    "background:Background",
    "traction_drive:TractionDrive",
    "structure:AxleBox",
    "housing:Housing",
    "path:MeasuredPath",
    "machine_noise:MachineNoise",
    "machine_background:MachineBackground",
    "mount:Mount",
    "bandwidth:Bandwidth",
    "rattle:Rattle",
)
"""Stages that run at every time step, before the anti-alias filter."""

PER_SAMPLE = _stages(
    "gravity:Gravity",
    "cross_axis:CrossAxis",
    "mains_hum:MainsHum",
    "bias:Bias",
    "ac_coupling:AcCoupling",
)
"""Stages that run at every sample, after the anti-alias filter."""

PER_CONVERSION = _stages(
    "signal_fault:SignalFault",
    "white_noise:WhiteNoise",
    "pink_noise:PinkNoise",
    "measuring_range:MeasuringRange",
    "adc:Adc",
    "stuck:Stuck",
)
"""Stages that run at every sample as the clock of the ADC takes it."""

STAGES = (*PER_STEP, *PER_SAMPLE, *PER_CONVERSION)


def parameters_of(group: str) -> Iterator[type[Group]]:
    """Yield the fields that the chain adds to a group of the configuration, in the order of the stages."""
    yield from (stage.parameters for stage in STAGES if stage.group == group)
    if group == "sensor":
        yield ClockParameters
