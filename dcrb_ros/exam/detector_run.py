"""A detector under evaluation, run in this process on the blocks of a recording."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any, TypeAlias

from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.thermal_detector import TemperatureFeed, ThermalFaultDetector
from dcrb_ros.exam.evaluation import Outcome
from dcrb_ros.exam.running_detector import DetectorBlock, DetectorFactory, RunningDetector, checked_output
from dcrb_ros.messages.received_diagnosis import ReceivedDiagnosis, decode_diagnosis
from dcrb_ros.messages.topics.diagnosis import encode_diagnosis
from dcrb_ros.schema.refusal import Refusal

if TYPE_CHECKING:
    from dcrb_ros.exam.led_signal import LedSignal
    from dcrb_ros.recordings.reader import Recording

SHIPPED = "the shipped detector"
ROUNDING = 1e-3
"""Largest rounding error of a stamp [s], of one in single precision or in whole milliseconds."""
Signal: TypeAlias = "Recording | LedSignal[Any]"
"""The signal of a scenario: a recording, alone or after a healthy one."""


def detector_blocks(signal: Signal) -> Iterator[DetectorBlock]:
    """Yield the blocks of a signal with the temperatures that are read during each."""
    feed = TemperatureFeed(signal.temperatures())
    for piece in signal.pieces():
        readings: list[tuple[float, float, float]] = []
        feed.give(lambda *reading: readings.append(reading), piece.end_index / signal.sampling_rate)  # noqa: B023
        yield DetectorBlock(*piece, tuple(readings))


def arrived(diagnosis: ReceivedDiagnosis, before: int, end: int, rate: int) -> ReceivedDiagnosis:
    """Return a diagnosis that a detector returned with the samples from ``before`` to ``end`` at a rate [Hz].

    One that is stamped before them counts as issued at their end.

    Raises:
        Refusal: it is stamped after them.
    """
    if diagnosis.time > end / rate + ROUNDING:
        raise Refusal(
            f"update returned a diagnosis stamped {diagnosis.time:.3f} s after {end / rate:.3f} s of the signal: give the time of the last "
            "sample that was judged"
        )
    return replace(diagnosis, signal_received=(end - 1) / rate) if diagnosis.time < before / rate - ROUNDING else diagnosis


@dataclass(frozen=True)
class PythonDetector:
    """A detector written in Python as a candidate; a new one is made for every scenario."""

    name: str
    factory: DetectorFactory
    parallel: bool = True
    """Whether scenarios are evaluated in processes of their own, to which the factory is pickled."""

    def diagnose(self, signal: Signal) -> Outcome:
        """Return its diagnoses of a signal, decoded from the messages that a node would publish.

        Raises:
            Refusal: the signal cannot be read, or the detector has no ``update`` or returns something invalid.
            RuntimeError: the detector raised an exception.
        """
        rate, outcome, before = signal.sampling_rate, Outcome(), 0
        detector = RunningDetector(self.factory, signal.orders, rate, lambda: signal.bearing)
        for block in detector_blocks(signal):
            output = checked_output(detector.take(block))
            if isinstance(output, str):
                outcome.received.append(ReceivedDiagnosis((block.end - 1) / rate, output))
            elif output is not None:
                outcome.received.append(arrived(decode_diagnosis(encode_diagnosis(output)), before, block.end, rate))
            before = block.end
        return outcome


def shipped_detector(parameters: DetectorParameters, name: str = SHIPPED) -> PythonDetector:
    """Return the shipped detector as a candidate."""
    return PythonDetector(name, partial(ThermalFaultDetector, parameters=parameters))
