"""A simulated double-row cylindrical roller bearing for condition monitoring, as a ROS 2 package.

Every name of `__all__` is imported on first use, so that ``import dcrb_ros`` takes no time and needs neither numba nor ROS.
"""

from __future__ import annotations

from importlib import import_module

from dcrb_ros.runtime.version import __version__

TYPE_CHECKING = False  # programs of this package import nothing before they handle signals
if TYPE_CHECKING:
    from dcrb_ros.bearing.frequencies import characteristic_frequencies
    from dcrb_ros.bearing.history import StateHistory
    from dcrb_ros.bearing.kinematics import Orders
    from dcrb_ros.bearing.tacho import TachoPulses
    from dcrb_ros.bearing.temperature_readings import TemperatureReadings
    from dcrb_ros.bearing.waveform import Waveform
    from dcrb_ros.calibration.calibration import Calibration, calibrate
    from dcrb_ros.calibration.comparison import RecordingComparison, compare
    from dcrb_ros.diagnosis.detection import DetectionResult, detect
    from dcrb_ros.diagnosis.detector import FaultDetector
    from dcrb_ros.diagnosis.envelope_spectrum import EnvelopeSpectrum, envelope_spectrum
    from dcrb_ros.diagnosis.features.extraction import FeatureExtractor, FeatureTable, extract_features
    from dcrb_ros.diagnosis.features.spectral_coherence import SpectralCoherence, spectral_coherence
    from dcrb_ros.diagnosis.parameters import DetectorParameters
    from dcrb_ros.diagnosis.thermal_detector import ThermalFaultDetector
    from dcrb_ros.exam.in_process import score
    from dcrb_ros.exam.report import Report
    from dcrb_ros.plots.envelope_spectrum import plot_envelope_spectrum
    from dcrb_ros.plots.load_zone import plot_load_zone
    from dcrb_ros.plots.waveform import plot_waveform
    from dcrb_ros.prognosis.rating_life import dynamic_load_rating, rating_life
    from dcrb_ros.prognosis.remaining_life import RemainingLife, estimate_remaining_life
    from dcrb_ros.prognosis.scores import phm_2008_score, phm_2012_score
    from dcrb_ros.recordings.reader import Recording
    from dcrb_ros.schema.refusal import Refusal
    from dcrb_ros.settings.configuration import Configuration
    from dcrb_ros.settings.files import load_configuration
    from dcrb_ros.settings.parameters import Bearing
    from dcrb_ros.simulation.ground_truth import GroundTruth
    from dcrb_ros.simulation.loop import Simulation
    from dcrb_ros.simulation.run import Run, simulate
    from dcrb_ros.stream.block import Block
    from dcrb_ros.stream.diagnosis import Diagnosis

__all__ = [
    "Bearing",
    "Block",
    "Calibration",
    "Configuration",
    "DetectionResult",
    "DetectorParameters",
    "Diagnosis",
    "EnvelopeSpectrum",
    "FaultDetector",
    "FeatureExtractor",
    "FeatureTable",
    "GroundTruth",
    "Orders",
    "Recording",
    "RecordingComparison",
    "Refusal",
    "RemainingLife",
    "Report",
    "Run",
    "Simulation",
    "SpectralCoherence",
    "StateHistory",
    "TachoPulses",
    "TemperatureReadings",
    "ThermalFaultDetector",
    "Waveform",
    "__version__",
    "calibrate",
    "characteristic_frequencies",
    "compare",
    "detect",
    "dynamic_load_rating",
    "envelope_spectrum",
    "estimate_remaining_life",
    "extract_features",
    "load_configuration",
    "phm_2008_score",
    "phm_2012_score",
    "plot_envelope_spectrum",
    "plot_load_zone",
    "plot_waveform",
    "rating_life",
    "score",
    "simulate",
    "spectral_coherence",
]

_MODULES = {
    "Bearing": "settings.parameters",
    "Block": "stream.block",
    "Calibration": "calibration.calibration",
    "Configuration": "settings.configuration",
    "DetectionResult": "diagnosis.detection",
    "DetectorParameters": "diagnosis.parameters",
    "Diagnosis": "stream.diagnosis",
    "EnvelopeSpectrum": "diagnosis.envelope_spectrum",
    "FaultDetector": "diagnosis.detector",
    "FeatureExtractor": "diagnosis.features.extraction",
    "FeatureTable": "diagnosis.features.extraction",
    "GroundTruth": "simulation.ground_truth",
    "Orders": "bearing.kinematics",
    "Recording": "recordings.reader",
    "RecordingComparison": "calibration.comparison",
    "Refusal": "schema.refusal",
    "RemainingLife": "prognosis.remaining_life",
    "Report": "exam.report",
    "Run": "simulation.run",
    "Simulation": "simulation.loop",
    "SpectralCoherence": "diagnosis.features.spectral_coherence",
    "StateHistory": "bearing.history",
    "TachoPulses": "bearing.tacho",
    "TemperatureReadings": "bearing.temperature_readings",
    "ThermalFaultDetector": "diagnosis.thermal_detector",
    "Waveform": "bearing.waveform",
    "calibrate": "calibration.calibration",
    "characteristic_frequencies": "bearing.frequencies",
    "compare": "calibration.comparison",
    "detect": "diagnosis.detection",
    "dynamic_load_rating": "prognosis.rating_life",
    "envelope_spectrum": "diagnosis.envelope_spectrum",
    "estimate_remaining_life": "prognosis.remaining_life",
    "extract_features": "diagnosis.features.extraction",
    "load_configuration": "settings.files",
    "phm_2008_score": "prognosis.scores",
    "phm_2012_score": "prognosis.scores",
    "plot_envelope_spectrum": "plots.envelope_spectrum",
    "plot_load_zone": "plots.load_zone",
    "plot_waveform": "plots.waveform",
    "rating_life": "prognosis.rating_life",
    "score": "exam.in_process",
    "simulate": "simulation.run",
    "spectral_coherence": "diagnosis.features.spectral_coherence",
}
"""The module of each public name, below this package."""


if not TYPE_CHECKING:  # a type checker would take every misspelt name for one that this function knows

    def __getattr__(name: str) -> object:
        """Import a public name on its first use (PEP 562)."""
        if name not in _MODULES:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        value = getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
