"""The ball bearing: published orders and stiffness, what is refused, and lines where its defects strike."""

from __future__ import annotations

import numpy as np
import pytest

from dcrb_ros.bearing.frequencies import characteristic_orders
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.simulation.loop import Simulation
from dcrb_ros.validation.balls import ball_rows
from dcrb_ros.validation.realism import squared_envelope
from dcrb_ros.validation.report_row import ReportRow

pytestmark = pytest.mark.slow

BENCH = "ball_bearing_6205"
LINES = {
    "outer_1": lambda orders: orders.bpfo,
    "inner_1": lambda orders: orders.bpfi,
    "roller_1": lambda orders: 2.0 * orders.bsf,
}


@pytest.mark.parametrize("comparison", list(ball_rows()), ids=lambda comparison: comparison.quantity)
def test_published_numbers_hold(comparison: ReportRow) -> None:
    assert comparison.holds, f"{comparison.found}, expected {comparison.accepted}"


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (["contact.hertz_inner_groove=0.5"], "0.501 .. 0.6"),
        (["bearing.contact_angle=15.0"], "give radians"),
        (["bearing.roller_radius=0.0041"], "radial gap"),
        (["bearing.rollers_per_row=16"], "at most 15"),
    ],
)
def test_impossible_geometry_is_refused(settings: list[str], words: str) -> None:
    with pytest.raises(Refusal, match=words):
        load_configuration(BENCH, settings)


@pytest.mark.parametrize("fault", LINES)
def test_a_defect_strikes_at_its_kinematic_order(fault: str) -> None:
    settings = [f"faults.{fault}.width=0.0004", f"faults.{fault}.depth=3.0e-5", "operating.speed_fluctuation=0.0"]
    configuration = load_configuration(BENCH, settings)
    samples = np.concatenate([block.clean for block in Simulation(configuration, waveform_only=True).blocks(1.2)])
    sampling_rate = configuration.sensor.sampling_rate
    envelope, rate = squared_envelope(samples[round(0.2 * sampling_rate) :, 1].astype(np.float64), sampling_rate)
    spectrum = np.abs(np.fft.rfft((envelope - envelope.mean()) * np.hanning(len(envelope))))
    spacing = configuration.operating.speed / (2.0 * np.pi)
    order = LINES[fault](characteristic_orders(configuration.bearing))
    at = np.arange(len(spectrum)) * (rate / len(envelope)) / spacing
    near = np.abs(at - order) < 0.02 * order
    beside = (np.abs(at - order) < 0.45) & (np.abs(at - order) > 0.03 * order)
    assert spectrum[near].max() > 3.0 * np.median(spectrum[beside])
