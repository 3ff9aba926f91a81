"""Distances of two recordings."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from synthetic_bearing import ORDERS, synthetic

from dcrb_ros import Refusal, Waveform, compare
from dcrb_ros.calibration.comparison import STEPS
from dcrb_ros.exchange.importing import WaveformImport
from dcrb_ros.plots.comparison import comparison_figure
from dcrb_ros.recordings.reader import Recording


def signal(*, gain: float = 1.0, outer: float = 0.0, rate: int = 25600, seed: int = 1, speed: bool = True) -> Waveform:
    """Return a synthetic recording of 4 s."""
    acceleration, angle = synthetic(outer=outer, seconds=4.0, rate=rate, seed=seed)
    return Waveform.from_arrays(gain * acceleration, rate, bearing=ORDERS, shaft_angle=angle if speed else None)


def test_a_gain_is_a_difference_of_levels_and_of_nothing_else() -> None:
    for one in compare(signal(), signal(gain=2.0)).axes:
        assert one.difference == pytest.approx(20.0 * np.log10(2.0), abs=1e-3)
        assert one.level_distance == pytest.approx(6.02, abs=0.01)
        assert one.shape_distance == pytest.approx(0.0, abs=1e-3)
        assert one.envelope_distance == pytest.approx(0.0, abs=1e-5)
        assert one.kurtosis_distance == pytest.approx(0.0, abs=1e-6)


def test_a_defect_is_far_in_envelope_and_kurtosis() -> None:
    other, faulty = compare(signal(), signal(seed=2)).axes[1], compare(signal(), signal(outer=60.0)).axes[1]
    assert faulty.envelope_distance > 1.5 * other.envelope_distance
    assert faulty.kurtosis_distance > 5.0 * other.kurtosis_distance
    found = compare(signal(), signal(outer=60.0)).features["y_wide_BPFO_depth"]
    assert found[1] > 5.0 * found[0]


def test_distances_are_the_same_in_either_direction() -> None:
    healthy, faulty = signal(), signal(outer=60.0)
    for there, back in zip(compare(healthy, faulty).axes, compare(faulty, healthy).axes, strict=True):
        for name in ("level_distance", "shape_distance", "envelope_distance", "kurtosis_distance"):
            assert getattr(there, name) == pytest.approx(getattr(back, name), rel=1e-9), name
        assert 0.5 < there.envelope_distance <= 1.0  # hardly a line in common


def test_other_rates_are_compared_in_the_bands_of_both() -> None:
    found = compare(signal(), signal(rate=12800))
    assert found.axes[0].frequency[-1] < 6400.0
    assert any("12800 and 25600 Hz" in remark for remark in found.remarks)


def test_without_a_speed_levels_and_kurtosis_are_compared() -> None:
    found = compare(signal(speed=False), signal())
    assert np.isnan(found.axes[0].envelope_distance)
    assert found.features == {}
    assert found.as_dict()["axes"]["x"]["envelope_distance"] is None
    assert any("no speed" in remark for remark in found.remarks)


@pytest.mark.filterwarnings("error")
def test_low_rates_have_no_octave_and_an_unknown_kurtosis() -> None:
    random = np.random.default_rng(1)
    one, other = (Waveform.from_arrays(random.standard_normal((1600, 2)), 390) for _ in range(2))
    comparison = compare(one, other)
    assert math.isnan(comparison.axes[0].kurtosis_distance)
    assert comparison.as_dict()["axes"]["x"]["kurtosis_distance"] is None
    assert math.isfinite(comparison.axes[0].level_distance)
    comparison_figure(comparison)


def test_relative_units_are_remarked(tmp_path: Path) -> None:
    acceleration, _ = synthetic(seconds=1.0, rate=25600)
    np.savez(tmp_path / "raw.npz", a=acceleration[:, 1])
    orders = {name.upper(): value for name, value in ORDERS.as_dict().items()}
    about = {"channels": {"ax": "a"}, "sampling_rate": 25600, "unit": "relative", "speed_rpm": 1200, "orders": orders}
    (tmp_path / "about.yaml").write_text(yaml.safe_dump(about), encoding="utf-8")
    WaveformImport(tmp_path / "raw.npz", tmp_path / "about.yaml").write(tmp_path / "bag")
    assert any("relative units" in remark for remark in compare(Recording(tmp_path / "bag"), signal()).remarks)
    assert not any("relative units" in remark for remark in compare(signal(), signal(gain=2.0)).remarks)


def test_one_axis_is_compared_with_y() -> None:
    whole = signal()
    single = Waveform.from_arrays(whole.acceleration[:, 1], 25600, bearing=ORDERS, shaft_angle=whole.shaft_angle)
    found = compare(single, whole)
    assert [one.axis for one in found.axes] == ["y"]
    assert found.axes[0].level_distance == pytest.approx(0.0, abs=1e-9)


def test_of_three_axes_the_first_two_are_compared() -> None:
    two, other = signal(), signal(seed=2)
    three = replace(two, acceleration=np.column_stack([two.acceleration, other.acceleration[:, 0]]))
    assert compare(three, other).as_dict() == compare(two, other).as_dict()


@pytest.mark.filterwarnings("error")
def test_rates_without_a_third_octave_are_refused() -> None:
    low, lowest = (Waveform.from_arrays(np.random.default_rng(1).standard_normal((400, 2)), rate) for rate in (70, 71))
    with pytest.raises(Refusal, match=r"^B has a sampling rate of 70 Hz, and third octaves need 71 Hz: give one with a higher rate$"):
        compare(lowest, low)
    assert compare(lowest, lowest).axes[0].level_distance == 0.0


def test_recordings_that_cannot_be_compared_are_refused() -> None:
    noise = np.random.default_rng(1).standard_normal(5000)
    with pytest.raises(Refusal, match=r"A is too short to be compared: 0.195 s"):
        compare(Waveform.from_arrays(noise, 25600), signal())
    with pytest.raises(Refusal, match="B is empty: an axis is constant"):
        compare(signal(), Waveform.from_arrays(np.ones(25600), 25600))
    with pytest.raises(Refusal, match="B is not a recording"):
        compare(signal(), "recording")  # type: ignore[arg-type]


def test_without_a_bearing_the_missing_fault_lines_are_remarked() -> None:
    acceleration, angle = synthetic(seconds=2.0, rate=25600)
    unknown = Waveform.from_arrays(acceleration, 25600, shaft_angle=angle)
    comparison = compare(unknown, unknown)
    assert comparison.features == {}
    assert "a recording has no bearing: fault lines and features are left out" in comparison.remarks


def test_progress_names_every_step() -> None:
    steps: list[str] = []
    compare(signal(), signal(), progress=steps.append)
    assert steps == ["reading the recordings", "comparing axis x", "comparing axis y", "comparing features"]
    assert len(steps) == STEPS


@pytest.mark.parametrize("names", ["AB", ("A",), ["A", "B", "C"]])
def test_other_than_two_names_are_refused(names: Any) -> None:
    with pytest.raises(Refusal, match="are not those of two recordings"):
        compare(signal(), signal(), names=names)


@pytest.mark.parametrize("name", [r"a$\frac$", "_hidden", "new\nline\x1b[31m", "depot_in_the_north/bogie_4711/" * 6])
@pytest.mark.filterwarnings("error")
def test_a_figure_shows_any_name(name: str) -> None:
    figure = comparison_figure(compare(signal(), signal(seed=2), names=(name, "other")))
    figure.draw_without_rendering()
    legends = [ax.get_legend() for ax in figure.axes]
    assert [len(legend.get_texts()) for legend in legends if legend is not None] == [4, 2, 4, 2]
    width = figure.get_window_extent().width
    for artist in (*figure.texts, *(ax.get_legend() for ax in figure.axes)):
        extent = artist.get_window_extent()
        assert extent.x0 >= 0.0
        assert extent.x1 <= width


@pytest.mark.filterwarnings("error")
def test_octaves_without_a_signal_are_left_out_of_the_distance() -> None:
    random = np.random.default_rng(2)
    noise, impulse = random.standard_normal((51200, 2)), np.zeros((51200, 2))
    impulse[0] = 1.0  # its response in the octaves above 1 kHz has decayed to 0 after 0.05 s
    comparison = compare(Waveform.from_arrays(noise, 25600), Waveform.from_arrays(impulse, 25600))
    axis = comparison.axes[0]
    known = np.isfinite(axis.kurtosis[1])
    assert known[:2].all()
    assert not known[-2:].any()
    assert axis.kurtosis_distance == pytest.approx(np.sqrt(np.mean(np.log(axis.kurtosis[1][known] / axis.kurtosis[0][known]) ** 2)))
    comparison_figure(comparison)
