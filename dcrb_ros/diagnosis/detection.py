"""The fault detector over a whole signal in one call."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from dcrb_ros.bearing.fault_lines import BearingLike
from dcrb_ros.bearing.temperature_readings import TemperatureReadings
from dcrb_ros.bearing.waveform import Piece, Signal, signal_of
from dcrb_ros.diagnosis.baseline_learning import BaselineLearner
from dcrb_ros.diagnosis.detector import NO_SPEED
from dcrb_ros.diagnosis.healthy_baseline import HealthyBaseline, axes, learned_with, rules_hash
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.diagnosis.thermal_detector import TemperatureFeed, ThermalFaultDetector, temperatures_of
from dcrb_ros.runtime.frames import pandas
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.schema.verdicts import Verdict
from dcrb_ros.stream.axes import AXES
from dcrb_ros.stream.diagnosis import Diagnosis

if TYPE_CHECKING:
    import pandas as pd

SHORT = 1.0
"""Length of signal from which there is a verdict, if necessary without the usual confirmation [s]."""
SHORT_WINDOW, FEWEST_TURNS = 0.5, 4.0
"""Length of signal [s] and revolutions that such a verdict needs at least."""


@dataclass(frozen=True, repr=False)
class DetectionResult:
    """Diagnoses of a signal by the fault detector, one per hop."""

    history: tuple[Diagnosis, ...]
    """The diagnoses in the order of time; `last` alone has its spectrum, since those of an hour take 0.8 GB."""
    duration: float
    """Length of the signal [s]."""
    begin: int = 0
    """Index of the first sample on which `last` may depend: the detector discards what precedes a long gap."""

    def __repr__(self) -> str:
        return f"<DetectionResult: {self.verdict} with confidence {self.confidence:.2f} since {self.since:.2f} s: {self.reason}>"

    @property
    def last(self) -> Diagnosis:
        """The last diagnosis with a verdict, or the last one if none has a verdict."""
        return next((diagnosis for diagnosis in reversed(self.history) if diagnosis.verdict != "waiting"), self.history[-1])

    @property
    def verdict(self) -> Verdict:
        """The last verdict: healthy, outer_ring, inner_ring, roller, cage, lubrication, overheating, compound or sensor."""
        return self.last.verdict

    @property
    def confidence(self) -> float:
        """Confidence in the last verdict, up to 0.99 and 0.5 at a threshold [-]; 0 for a sensor fault and for ``waiting``."""
        return self.last.confidence

    @property
    def reason(self) -> str:
        """The evidence in one sentence."""
        return self.last.reason

    @property
    def since(self) -> float:
        """Time of the first diagnosis with that verdict [s]."""
        return next(diagnosis.time for diagnosis in self.history if diagnosis.verdict == self.verdict)

    def to_pandas(self) -> pd.DataFrame:
        """Return a DataFrame over time [s]: verdict, confidence, shaft frequency [Hz], levels [dB] and severity [m/s^2].

        Raises
        ------
        Refusal
            pandas is not installed.
        """
        rows = [
            {
                "verdict": diagnosis.verdict,
                "confidence": diagnosis.confidence,
                "shaft_frequency": diagnosis.shaft_frequency,
                **diagnosis.levels,
                "severity": diagnosis.severity,
            }
            for diagnosis in self.history
        ]
        return pandas().DataFrame(rows, index=pandas().Index([diagnosis.time for diagnosis in self.history], name="time"))


def detect(
    signal: Signal | npt.ArrayLike,
    sampling_rate: float | None = None,
    *,
    shaft_angle: npt.ArrayLike | None = None,
    bearing: BearingLike | None = None,
    parameters: DetectorParameters | None = None,
    baseline: HealthyBaseline | None = None,
    temperatures: TemperatureReadings | None = None,
) -> DetectionResult:
    """Run the fault detector over a run, a recording or plain arrays.

    Parameters
    ----------
    signal
        A `SimulationResult`, `Recording` or `Waveform`, or accelerations of shape (samples, 2), (samples, 3) or (samples,) [m/s^2].
    sampling_rate, bearing
        Sampling rate [Hz] and geometry or orders of the bearing; needed with plain arrays, and with these only. For the geometry of
        ``Bearing()``, that of the benches ``dry`` and ``paper``, the limits of BPFO lines of this simulated bearing apply. Describe a
        measured bearing with this geometry by its orders.
    shaft_angle
        Rotation of the inner ring beside plain arrays, shape (samples,) [rad]. Without it the speed is estimated from the signal.
    parameters
        Window, bands and thresholds of the detector; the defaults otherwise.
    baseline
        Lines of the healthy bearing, as `learn_baseline` returns them; none are needed.
    temperatures
        Readings at the outer ring and in the air over the time of the signal; by default those of the run or recording, if it has any.

    Returns
    -------
    DetectionResult
        The last verdict, its evidence and the history.

    Raises
    ------
    Refusal
        A signal that is too short for a verdict, or arrays that are not a waveform.

    Examples
    --------
    >>> import dcrb_ros
    >>> run = dcrb_ros.simulate("outer_ring_defect", 3.0)
    >>> dcrb_ros.detect(run).verdict
    'outer_ring'

    Block by block, as a node does it:

    >>> detector = dcrb_ros.FaultDetector(run.orders, run.sampling_rate)
    >>> for piece in run.pieces():
    ...     diagnosis = detector.update(piece.first_index, piece.acceleration, piece.shaft_angle)
    """
    source = _signal(signal, sampling_rate, shaft_angle, bearing)
    result = watch(source, parameters=parameters, baseline=baseline, temperatures=temperatures, bearing=bearing)
    check_verdict(result, "the signal")
    return result


def check_verdict(result: DetectionResult, name: str) -> None:
    """Refuse a signal on which there is no verdict; ``name`` is its name in the message.

    Raises:
        Refusal: all diagnoses are ``waiting``.
    """
    if result.verdict != "waiting":
        return
    if result.duration < SHORT:
        raise Refusal(f"{name} holds {result.duration:.2f} s of waveform, too little for a verdict: give at least {SHORT:g} s")
    unknown = NO_SPEED in result.reason
    remedy = "; give the speed (speed_rpm in the description, shaft_angle in Python)" if unknown else ""
    raise Refusal(f"{name} has no verdict: {result.reason}{remedy}")


def watch(
    signal: Signal,
    *,
    parameters: DetectorParameters | None = None,
    baseline: HealthyBaseline | None = None,
    temperatures: TemperatureReadings | None = None,
    bearing: BearingLike | None = None,
) -> DetectionResult:
    """Return the diagnoses of a signal as `detect` does, also if all of them are ``waiting``."""
    chosen, described = _checked(signal, parameters), _described(signal if bearing is None else bearing)
    readings = temperatures_of(signal) if temperatures is None else temperatures
    if not isinstance(readings, TemperatureReadings):
        raise Refusal(f"temperatures = {readings!r} are not readings: give TemperatureReadings, such as those of a run or recording")
    history, samples, begin = _diagnoses(_detector(signal, chosen, described, baseline), signal.pieces(), readings)
    duration = samples / signal.sampling_rate
    waiting = all(diagnosis.verdict == "waiting" for diagnosis in history)
    if duration >= SHORT and waiting:
        # A short signal is judged by a shorter window; the confidence is lower accordingly.
        history, _, begin = _diagnoses(_detector(signal, brief(chosen), described, baseline), signal.pieces(), readings)
    if not history or (duration < SHORT and waiting):
        # Its detector would ask for the signal of a usual verdict.
        reason = f"{duration:.2f} s have arrived, but a verdict needs {SHORT:g} s"
        history = [replace(d, reason=reason) for d in history] or [Diagnosis(max(0, samples - 1), duration, "waiting", reason)]
    return DetectionResult(tuple(history), duration, begin)


def learn_baseline(
    signal: Signal | npt.ArrayLike,
    sampling_rate: float | None = None,
    *,
    name: str = "the healthy signal",
    shaft_angle: npt.ArrayLike | None = None,
    bearing: BearingLike | None = None,
    parameters: DetectorParameters | None = None,
) -> HealthyBaseline:
    """Return the lines of a bearing that is stated to be healthy, from a signal given as for `detect`.

    Nothing is learned while the sensor is faulty, nor after an alarm that follows a healthy verdict.

    Parameters
    ----------
    name
        Name of the recording, by which a diagnosis says which baseline it used.

    Returns
    -------
    HealthyBaseline
        To be given to `detect`, or saved with its method ``save``.

    Raises
    ------
    Refusal
        The signal gives no verdict on the bearing, because it is too short or the sensor is faulty.
    """
    source = _signal(signal, sampling_rate, shaft_angle, bearing)
    unlimited = {"baseline": "", "outer_limit": 0.0, "outer_limit_high": 0.0, "learn": 0.0}
    chosen = _checked(source, parameters).model_copy(update=unlimited)
    described, first, samples, most = _described(signal if bearing is None else bearing), 0, 0, 1
    for piece in source.pieces():
        first = first if samples else piece.first_index
        samples += len(piece.acceleration)
        most = max(most, axes(piece.acceleration))
    duration = samples / source.sampling_rate
    learner = BaselineLearner(min(chosen.window, duration), first / source.sampling_rate)
    for tried in (chosen, brief(chosen)):
        detector = _detector(source, tried, described, None)
        detector.learner = learner
        history, *_ = _diagnoses(detector, source.pieces(), TemperatureReadings.none())
        if learner.judgements:
            break
    if not learner.judgements:
        reason = history[-1].reason if history else f"{duration:.2f} s are too few"
        raise Refusal(f"{name} gives no baseline: {reason}; give a longer recording of a healthy bearing with a sound sensor")
    about = {
        "source": name,
        "rules": rules_hash(),
        "sampling_rate": source.sampling_rate,
        "axes": most,
        "orders": source.orders.as_dict(),
        "parameters": learned_with(chosen),
        "seconds": learner.seconds or duration,
    }
    return learner.baseline(about)


def _checked(source: Signal, parameters: DetectorParameters | None) -> DetectorParameters:
    """Return the parameters of a detector that can judge a signal, the defaults if none are given.

    Raises:
        Refusal: the orders of the bearing are unknown, or no verdict follows from the parameters.
    """
    if math.isnan(source.orders.bpfo):
        raise Refusal("the orders of the bearing are unknown: give its geometry or orders as bearing")
    if not isinstance(parameters, (DetectorParameters, type(None))):
        raise Refusal(f"parameters = {parameters!r} are not those of the detector: give DetectorParameters(...)")
    chosen = parameters or DetectorParameters()
    if chosen.window < chosen.least_window:
        # Such a detector publishes spectra, as in the viewer, but no verdict.
        raise Refusal(
            f"window = {chosen.window:g} s is below least_window = {chosen.least_window:g} s, so that no verdict follows: "
            "make the window longer"
        )
    return chosen


def _signal(signal: Signal | npt.ArrayLike, rate: float | None, shaft_angle: npt.ArrayLike | None, bearing: BearingLike | None) -> Signal:
    """Return a run or a recording as it is, plain arrays of one to three axes as a `Waveform`."""
    if not isinstance(signal, np.ndarray) or signal.ndim != 2 or signal.shape[1] != len(AXES) or not len(signal):
        return signal_of(signal, rate, shaft_angle=shaft_angle, bearing=bearing)
    first, last = (signal_of(pair, rate, shaft_angle=shaft_angle, bearing=bearing).waveform() for pair in (signal[:, :2], signal[:, 1:]))
    return replace(first, acceleration=np.column_stack([first.acceleration, last.acceleration[:, 1]]))


def brief(parameters: DetectorParameters) -> DetectorParameters:
    """Return parameters by which little signal gives a verdict."""
    return parameters.model_copy(update={"least_window": SHORT_WINDOW, "confirm": 1, "least_turns": FEWEST_TURNS})


def _detector(source: Signal, parameters: DetectorParameters, described: object, baseline: HealthyBaseline | None) -> ThermalFaultDetector:
    """Return a detector for a signal whose bearing is described."""
    detector = ThermalFaultDetector(source.orders, source.sampling_rate, parameters, baseline=baseline)
    detector.take_bearing(described)
    return detector


def _described(source: object) -> object:
    """Return the geometry in a run, a recording, a configuration or a bearing; anything else unchanged."""
    if hasattr(source, "bearing"):
        return source.bearing
    return getattr(getattr(source, "configuration", None), "bearing", source)


def _diagnoses(detector: ThermalFaultDetector, pieces: Iterable[Piece], readings: TemperatureReadings) -> tuple[list[Diagnosis], int, int]:
    """Return the diagnoses, of which `DetectionResult.last` alone has its spectrum, the number of samples, and `DetectionResult.begin`."""
    history, last, samples, begin, feed = list[Diagnosis](), 0, 0, 0, TemperatureFeed(readings)
    for piece in pieces:
        detector.sensor_range = piece.sensor_range
        diagnosis = detector.update(piece.first_index, piece.acceleration, piece.shaft_angle)
        samples += len(piece.shaft_angle)
        feed.give(detector.take_temperature, piece.end_index / detector.rate)
        if diagnosis is None:
            continue
        history.append(diagnosis)
        former = len(history) - 1
        if diagnosis.verdict != "waiting" or history[last].verdict == "waiting":
            former, last, begin = last, former, detector.begin
        if former != last:
            history[former] = history[former].without_spectrum()
    return history, samples, begin
