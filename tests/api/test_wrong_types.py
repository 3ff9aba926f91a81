"""Arguments of wrong types and shapes are refused in one sentence by every public function and class that takes input."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest

import dcrb_ros
from dcrb_ros import Refusal, Waveform
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.vehicle.file import read_vehicle
from dcrb_ros.vehicle.simulation import VehicleSimulation

plt.switch_backend("Agg")
RATE, SAMPLES = 6400, 6400
SIGNAL = np.random.default_rng(1).normal(size=SAMPLES)
TURNS = 20.0 * np.arange(SAMPLES) / RATE
ANGLE = np.mod(2.0 * np.pi * TURNS, 2.0 * np.pi)
ORDERS = dcrb_ros.Orders(0.4, 3.6, 5.4, 2.4)
WAVEFORM = Waveform.from_arrays(SIGNAL, RATE, shaft_angle=ANGLE, bearing=ORDERS)
READING = {"time": 0.0, "bearing": 40.0, "ambient": 20.0, "load": 1e5}
HOURS = np.arange(20.0)
TREND = {"hours": HOURS, "severity": np.exp(HOURS / 20.0), "coverage": 0.9}
MEASURED = {"signal": SIGNAL, "sampling_rate": float(RATE), "shaft_angle": ANGLE, "bearing": ORDERS}
DETECTOR = {"orders": ORDERS, "rate": RATE, "parameters": dcrb_ros.DetectorParameters(), "sensor_range": 0.0, "baseline": None}
WRONG = {
    "nothing": None,
    "text": "text",
    "number": 3,
    "nan": float("nan"),
    "huge": 10**400,
    "empty": np.array([]),
    "nested": [[1], [2, 3]],
    "texts": ["a", "b"],
    "mapping": {"a": 1},
    "object": object(),
    "cube": np.zeros((2, 2, 2)),
    "complex": np.array([1j]),
    "objects": np.array([None, "a"], dtype=object),
    "masked": np.ma.masked_greater(np.linspace(0.0, 1.0, SAMPLES), 0.5),
    "dates": np.array(["2026-01-01"] * SAMPLES, "datetime64[ns]"),
    "digits": np.array(["1.5"] * SAMPLES),
    "type": int,
}
CALLS: dict[str, Mapping[str, Any]] = {
    "characteristic_frequencies": {"bearing": "healthy", "speed": 100.0},
    "dynamic_load_rating": {"bearing": dcrb_ros.Bearing()},
    "rating_life": {"rating": 1e5, "load": 1e4},
    "phm_2008_score": {"true": [1.0, 2.0], "estimated": [1.0, 2.0], "unit": 1.0},
    "phm_2012_score": {"true": [1.0, 2.0], "estimated": [1.0, 2.0]},
    "estimate_remaining_life": {**TREND, "limit": 10.0, "growth": "exponential", "limit_deviation": 0.0},
    "update_remaining_life": {**TREND, "failed": [(2.0 * HOURS, np.exp(HOURS / 20.0))] * 3},
    "load_configuration": {"source": "healthy", "settings": ()},
    "simulate": {"configuration": "nowhere", "duration": 0.002, "settings": (), "scenario": None, "seed": None},
    "healthy_level": {"configuration": "nowhere", "duration": 0.002, "settings": ()},
    "Simulation": {"configuration": None, "scenario": (), "waveform_only": False, "drive": None},
    "spectral_coherence": {"signal": SIGNAL, "sampling_rate": float(RATE), "turns": TURNS, "highest_order": 6.0, "resolution": None},
    "envelope_spectrum": {**MEASURED, "band": None, "order_tracking": None},
    "plot_envelope_spectrum": {**MEASURED, "band": None, "order_tracking": None, "x": None, "highest": None, "lines": "BPFO", "ax": None},
    "plot_waveform": {"signal": SIGNAL, "sampling_rate": float(RATE), "start": None, "stop": None, "axis": "y", "ax": None},
    "plot_load_zone": {"source": None, "ax": None},
    "extract_features": {**MEASURED, "window": 1.0, "hop": 0.5, "families": ["statistics"], "axes": ("x",)},
    "detect": {**MEASURED, "parameters": None, "baseline": None, "temperatures": None},
    "detect_vehicle": {"signals": None, "parameters": None, "box_parameters": None},
    "compare": {"first": WAVEFORM, "second": WAVEFORM, "names": ("a", "b")},
    "calibrate": {"recordings": WAVEFORM, "base": None, "settings": (), "source_seconds": 4.0, "trust": False, "names": ()},
    "score": {"detector": None, "exam": "nowhere", "recordings": None, "workers": 1},
    "DataSet": {"folder": "nowhere"},
    "Recording": {"path": "nowhere"},
    "VehicleRecording": {"path": "nowhere"},
    "Orders": ORDERS.__dict__,
    "FaultDetector": DETECTOR,
    "ThermalFaultDetector": DETECTOR,
    "FeatureExtractor": {"orders": ORDERS, "sampling_rate": RATE, "window": 1.0, "hop": 0.5, "families": None, "axes": ("x", "y")},
    "VehicleDetector": {"description": None},
    "DetectorParameters": {"window": 4.0, "baseline": "", "band": "kurtogram"},
    "Bearing": {"rows": 2},
    "Configuration": {"bearing": {}},
    "Waveform": {
        "acceleration": np.zeros((SAMPLES, 2), np.float32),
        "shaft_angle": ANGLE.astype(np.float32),
        "sampling_rate": RATE,
        "index": np.arange(SAMPLES),
        "orders": ORDERS,
        "sensor_range": 0.0,
    },
}
"""Arguments of each public name that takes input, most of them valid."""
OUTPUTS = {
    "AlteredSamples",
    *("Block", "Calibration", "DetectionResult", "Diagnosis", "EnvelopeSpectrum", "FeatureTable", "GroundTruth", "RecordingComparison"),
    *("Refusal", "RemainingLife", "Report", "SimulationResult", "SpectralCoherence", "StateHistory", "TachoPulses"),
    *("TemperatureReadings", "VehicleDetectionResult", "__version__"),
}
"""Public names that users do not call."""


def outcome(function: Callable[..., Any], arguments: Mapping[str, Any]) -> str:
    """Return what is wrong with the answer to arguments; the empty string if they are taken or refused."""
    try:
        function(**arguments)
    except Refusal as refusal:
        return "" if len(str(refusal).splitlines()) == 1 else f"not one sentence: {refusal}"
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return ""


def test_every_public_name_is_tried_or_an_output() -> None:
    assert CALLS.keys() | OUTPUTS == set(dcrb_ros.__all__)
    assert not CALLS.keys() & OUTPUTS


@pytest.mark.parametrize("name", CALLS)
def test_arguments_of_wrong_types_are_refused_in_one_sentence(name: str) -> None:
    answers = {
        (argument, label): outcome(getattr(dcrb_ros, name), {**CALLS[name], argument: value})
        for argument in CALLS[name]
        for label, value in WRONG.items()
    }
    plt.close("all")
    assert {place: answer for place, answer in answers.items() if answer} == {}


@pytest.mark.parametrize(
    "name", ["extract_features", "detect", "envelope_spectrum", "spectral_coherence", "compare", "update_remaining_life"]
)
def test_the_other_arguments_are_taken(name: str) -> None:
    # A call that is refused for another argument would tell nothing about the one of a wrong type.
    getattr(dcrb_ros, name)(**CALLS[name])


@pytest.mark.parametrize("name", ["plot_waveform", "extract_features", "detect", "envelope_spectrum", "spectral_coherence"])
@pytest.mark.parametrize("label", ["masked", "dates", "digits"])
def test_a_signal_that_is_no_numbers_is_refused(name: str, label: str) -> None:
    """A mask would be ignored, and texts and dates would become numbers."""
    with pytest.raises(Refusal, match=r"masked|not an array of real numbers|are not a waveform"):
        getattr(dcrb_ros, name)(**{**CALLS[name], "signal": WRONG[label]})


@pytest.mark.parametrize("kind", [np.asanyarray, list])
@pytest.mark.parametrize("label", ["dates", "digits"])
def test_a_trend_that_is_no_numbers_is_refused(label: str, kind: Callable[[Any], Any]) -> None:
    with pytest.raises(Refusal, match="severity is not an array of real numbers"):
        dcrb_ros.estimate_remaining_life(HOURS, kind(WRONG[label][: len(HOURS)]), 10.0)


def test_a_masked_trend_is_refused() -> None:
    with pytest.raises(Refusal, match="severity has masked values: leave these samples out"):
        dcrb_ros.estimate_remaining_life(HOURS, np.ma.masked_less(HOURS, 5.0), 10.0)


def test_arguments_of_methods_are_refused_in_one_sentence(tmp_path: Path) -> None:
    configuration = dcrb_ros.load_configuration("dry")
    simulation = dcrb_ros.Simulation(configuration)
    with Recorder(tmp_path / "bag", configuration, simulation.bodies) as recorder:
        recorder.write(next(simulation.blocks()))
    recording = dcrb_ros.Recording(tmp_path / "bag")
    zeros = np.zeros((2, 3))
    states = dcrb_ros.StateHistory(
        time=np.arange(2.0), names=("row1/roller01", "cage1", "inner_ring"), azimuth=zeros, speed=zeros, inner_force=zeros
    )
    pulses = dcrb_ros.TachoPulses(time=np.arange(3.0), number=np.arange(3), pulses_per_turn=1)
    none = np.zeros(0)
    readings = dcrb_ros.TemperatureReadings(time=none, outer_ring=none, box=none, ambient=none)
    vehicle = VehicleSimulation(read_vehicle("bogie"))
    calls: dict[str, tuple[Callable[..., Any], Mapping[str, Any]]] = {
        "command_speed": (simulation.command_speed, {"speed": 100.0}),
        "command_load": (simulation.command_load, {"x": 0.0, "y": -1000.0}),
        "change": (simulation.change, {"changes": {}}),
        "check_change": (simulation.check_change, {"changes": {}}),
        "Simulation": (dcrb_ros.Simulation, {"configuration": configuration, "surroundings": None}),
        "column": (states.column, {"name": "cage1"}),
        "turns": (pulses.turns, {"time": 0.5}),
        "between": (readings.between, {"start": 0.0, "stop": 1.0}),
        "messages": (recording.messages, {"topics": (), "namespace": "/dcrb"}),
        "read_vehicle": (read_vehicle, {"source": "bogie", "settings": ()}),
        "vehicle.change": (vehicle.change, {"changes": {}}),
        "vehicle.command": (vehicle.command, {"speed_kmh": 100.0}),
    }
    wrong = {**WRONG, "key": {1: 1.0}, "no key": {None: 1.0}}
    answers = {
        (name, argument, label): outcome(function, {**arguments, argument: value})
        for name, (function, arguments) in calls.items()
        for argument in arguments
        for label, value in wrong.items()
    }
    assert {place: answer for place, answer in answers.items() if answer} == {}


def test_a_vehicle_takes_one_setting_as_a_text() -> None:
    assert read_vehicle("bogie", "vehicle.speed_kmh=77") == read_vehicle("bogie", ["vehicle.speed_kmh=77"])


def test_a_truth_value_is_no_commanded_speed() -> None:
    with pytest.raises(Refusal, match=r"command/speed = True rad/s is refused"):
        dcrb_ros.Simulation(dcrb_ros.load_configuration("dry")).command_speed(True)


def test_blocks_and_names_of_wrong_types_are_refused_in_one_sentence() -> None:
    extractor = dcrb_ros.FeatureExtractor(ORDERS, RATE, families=["statistics"])
    block = {"index": 0, "acceleration": np.zeros((8, 2)), "shaft_angle": np.zeros(8)}
    answers: dict[tuple[str, ...], str] = {
        (argument, label): outcome(extractor.update, {**block, argument: value}) for argument in block for label, value in WRONG.items()
    }
    detector = dcrb_ros.ThermalFaultDetector(ORDERS, RATE)
    answers |= {
        ("detector", argument, label): outcome(detector.update, {**block, argument: v}) for argument in block for label, v in WRONG.items()
    }
    detector.update(**block)
    answers |= {
        (argument, label): outcome(detector.take_temperature, {**READING, argument: value})
        for argument in READING
        for label, value in WRONG.items()
    }
    coherence = dcrb_ros.spectral_coherence(**CALLS["spectral_coherence"])
    answers |= {("low", label): outcome(coherence.enhanced_envelope_spectrum, {"low": value}) for label, value in WRONG.items()}
    table = dcrb_ros.extract_features(WAVEFORM, families=["statistics"])
    answers |= {("name", label): outcome(table.__getitem__, {"name": value}) for label, value in WRONG.items()}
    assert {place: answer for place, answer in answers.items() if answer} == {}
