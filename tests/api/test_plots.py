"""The plots, read back from their axes."""

from __future__ import annotations

import shutil
import warnings
from pathlib import Path
from typing import Any, Literal

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
import yaml
from dry_benches import dry_bench
from made_up_blocks import BODIES, blocks
from separate_process import dcrb, fresh_dcrb

from dcrb_ros import (
    Recording,
    Refusal,
    SimulationResult,
    Waveform,
    characteristic_frequencies,
    envelope_spectrum,
    plot_envelope_spectrum,
    plot_load_zone,
    plot_waveform,
    simulate,
)
from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.recordings.vehicle_folder import title_of
from dcrb_ros.settings.configuration import Configuration

mpl.use("Agg")
BAGS = Path(__file__).parents[2] / "bags"


@pytest.fixture(scope="module")
def run() -> SimulationResult:
    return simulate(dry_bench("outer_ring_defect"), 1.0)


@pytest.fixture(autouse=True)
def _closed() -> Any:
    plt.close("all")
    yield
    plt.close("all")


def test_plots_draw_into_given_axes_and_return_them(run: SimulationResult) -> None:
    upper, lower = plt.figure().subplots(2, 1)
    assert plot_waveform(run, ax=upper) is upper
    assert plot_envelope_spectrum(run, ax=lower) is lower
    polar = plt.figure().add_subplot(projection="polar")
    assert plot_load_zone(run, ax=polar) is polar
    assert len(plt.get_fignums()) == 2  # and no other was opened


def test_waveform_is_drawn_sample_by_sample(run: SimulationResult) -> None:
    ax = plot_waveform(run, start=0.1, stop=0.2)
    (line,) = ax.lines
    assert np.array_equal(line.get_ydata(), run.between(0.1, 0.2).acceleration[:, 1])
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time [s]", "acceleration Y [m/s²]")
    both = plot_waveform(run, stop=0.1, axis="both")
    assert [text.get_text() for text in both.get_legend().get_texts()] == ["Y", "X"]


def test_a_single_sample_is_drawn_without_a_warning() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(plot_waveform(np.ones(1), 51_200).lines[0].get_xdata()) == 1


def test_a_long_waveform_keeps_its_extremes() -> None:
    noise = np.random.default_rng(1).standard_normal(200_000)
    (line,) = plot_waveform(noise, 10_000).lines
    drawn = np.asarray(line.get_ydata())
    assert len(drawn) < len(noise)
    assert (drawn.min(), drawn.max()) == pytest.approx((noise.min(), noise.max()))


@pytest.mark.parametrize("samples", [1000, 100_000])
def test_the_line_is_broken_where_samples_are_lost(samples: int) -> None:
    whole = Waveform.from_arrays(np.ones(samples), 1000)
    lossy = Waveform(
        acceleration=whole.acceleration,
        shaft_angle=whole.shaft_angle,
        sampling_rate=1000,
        index=np.where(whole.index < samples // 2, whole.index, whole.index + 500),
        orders=whole.orders,
    )
    (line,) = plot_waveform(lossy).lines
    assert np.count_nonzero(np.isnan(np.asarray(line.get_ydata(), float))) == 1


def test_fault_lines_stand_at_the_orders_of_the_bearing(run: SimulationResult) -> None:
    ax = plot_envelope_spectrum(run, lines=["BPFI"], highest=20.0)
    upright = [line.get_xdata()[0] for line in ax.lines if len(line.get_xdata()) == 2]
    assert upright == pytest.approx([run.orders.bpfi, 2.0 * run.orders.bpfi])
    assert ax.get_xlabel() == "order [multiples of the shaft frequency]"


@pytest.mark.timeout(60)  # a line for each harmonic up to there would fill the memory
@pytest.mark.parametrize("x", ["order", "frequency"])
def test_no_fault_line_lies_beyond_the_spectrum(x: Literal["order", "frequency"], run: SimulationResult) -> None:
    end = envelope_spectrum(run).order[-1]
    ax = plot_envelope_spectrum(run, lines=["BPFI"], x=x, highest=1e12)
    assert len([line for line in ax.lines if len(line.get_xdata()) == 2]) == int(end / run.orders.bpfi)


def test_a_defect_is_marked_at_its_own_lines(run: SimulationResult) -> None:
    ax = plot_envelope_spectrum(run)
    marked = [float(line.get_xdata()[0]) for line in ax.lines if len(line.get_xdata()) == 1]
    assert marked == pytest.approx(run.orders.bpfo * np.arange(1, 5), rel=0.004)
    assert [text.get_text().split()[0] for text in ax.get_legend().get_texts()] == ["BPFO", "BPFI", "2BSF", "FTF"]


def test_a_sideband_of_another_fault_is_not_marked() -> None:
    run = simulate(dry_bench("inner_ring_defect"), 1.0)
    ax = plot_envelope_spectrum(run)
    marked = np.array([float(line.get_xdata()[0]) for line in ax.lines if len(line.get_xdata()) == 1])
    assert len(marked) >= 3
    assert marked == pytest.approx(np.round(marked / run.orders.bpfi) * run.orders.bpfi, rel=0.004)


def test_one_line_may_be_given_as_text(run: SimulationResult) -> None:
    labels = [text.get_text() for text in plot_envelope_spectrum(run, lines="BPFO").get_legend().get_texts()]
    assert labels == ["BPFO 6.72"]


@pytest.mark.parametrize("x", ["order", "frequency"])
def test_the_legend_leaves_the_title_free(x: Any, run: SimulationResult) -> None:
    ax = plot_envelope_spectrum(run, x=x)
    ax.figure.draw_without_rendering()
    title = next(text for text in ax.get_children() if isinstance(text, mpl.text.Text) and text.get_text().startswith("squared"))
    assert not title.get_window_extent().overlaps(ax.get_legend().get_window_extent())


def test_frequency_axis_is_in_hertz(run: SimulationResult) -> None:
    ax = plot_envelope_spectrum(run, x="frequency", lines=["BPFO"])
    expected = characteristic_frequencies(run.configuration, run.configuration.operating.speed)["BPFO"]
    upright = [line.get_xdata()[0] for line in ax.lines if len(line.get_xdata()) == 2]
    assert upright[0] == pytest.approx(expected, rel=1e-4)
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["BPFO 134.5 Hz"]


def test_a_spectrum_that_is_there_already_is_drawn(run: SimulationResult) -> None:
    spectrum = envelope_spectrum(run, band=(4000.0, 8000.0))
    assert plot_envelope_spectrum(spectrum).get_title(loc="left") == "squared envelope, 4 to 8 kHz, order-tracked"


def test_an_unknown_bearing_has_no_fault_lines() -> None:
    ax = plot_envelope_spectrum(np.random.default_rng(1).standard_normal(51200), 51200)
    assert ax.get_legend() is None
    assert ax.get_xlim() == (0.0, 600.0)


def test_load_zone_lies_below_the_shaft() -> None:
    ax = plot_load_zone(Recording(BAGS / "healthy"))
    assert [line.get_label() for line in ax.lines] == ["row 1", "row 2"]
    for line in ax.lines:
        azimuth, force = line.get_data()
        assert np.abs(np.asarray(azimuth)[np.asarray(force) > 1.0]).max() < 0.5 * np.pi
        assert 20.0 < np.max(force) < 40.0  # kN, of 100 kN on two rows


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda run: plot_waveform(run, axis="z"), "axis = 'z' is not one of x, y, both"),
        (lambda run: plot_waveform(run, start=5.0), "no sample from 5 s on"),
        (lambda run: plot_envelope_spectrum(run, lines=["BFPO"]), "there is no fault line 'BFPO'.*did you mean 'BPFO'"),
        (lambda run: plot_envelope_spectrum(run, lines="BFPO"), "there is no fault line 'BFPO'.*did you mean 'BPFO'"),
        (lambda run: plot_envelope_spectrum(run, x="freq"), "x = 'freq' is not one of order, frequency; did you mean 'frequency'"),
        (lambda run: plot_envelope_spectrum(run, highest=-1), "highest = -1 is not above 0"),
        (lambda run: plot_envelope_spectrum(envelope_spectrum(run), band=(4e3, 8e3)), "band is given beside <EnvelopeSpectrum"),
        (lambda run: plot_envelope_spectrum(envelope_spectrum(run), 51200), "sampling_rate is given beside <EnvelopeSpectrum"),
        (lambda run: plot_waveform("bags/healthy"), r"use dcrb_ros.Recording\('bags/healthy'\)"),
        (lambda run: plot_load_zone(run.waveform().waveform), "has no states: give a SimulationResult, a Recording or a StateHistory"),
        (lambda run: plot_envelope_spectrum(np.ones(51200), 51200, x="order"), "the speed is unknown"),
        (lambda run: plot_load_zone(run, ax=plt.figure().add_subplot()), "needs polar axes"),
        (lambda run: plot_load_zone(simulate("dry", 0.005)), "has no states"),
    ],
)
def test_refusals(call: Any, sentence: str, run: SimulationResult) -> None:
    with pytest.raises(Refusal, match=sentence):
        call(run)


@pytest.mark.parametrize("suffix", [".png", ".svg", ".pdf", ".PNG"])
def test_command_writes_a_picture(suffix: str, tmp_path: Path) -> None:
    file = tmp_path / f"picture{suffix}"
    done = dcrb("plot", str(BAGS / "run_up"), "-o", str(file), "--start", "0.5", "--duration", "2")
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == f"{file}: 2.00 s of {BAGS / 'run_up'} from 0.50 s on"
    assert file.read_bytes()[:4] in (b"\x89PNG", b"<?xm", b"%PDF")


def test_the_title_of_the_picture_is_the_name_of_the_recording(tmp_path: Path) -> None:
    bag, file = tmp_path / "run.v1", tmp_path / "picture.svg"
    shutil.copytree(BAGS / "healthy", bag)
    done = dcrb("plot", str(bag), "-o", str(file), "--duration", "0.5")
    assert done.returncode == 0, done.stderr
    assert "<!-- run.v1, mean shaft frequency" in file.read_text()
    assert [title_of(path) for path in (bag / "axle_1.left", bag / "healthy_0.mcap")] == ["axle_1.left", "healthy_0"]


def test_command_proposes_the_longest_stretch_without_lost_samples(tmp_path: Path) -> None:
    with Recorder(tmp_path / "bag", Configuration(), BODIES) as recorder:
        for number, block in enumerate(blocks(80)):
            if number not in (20, 70):
                recorder.write(block)
    command = ["plot", str(tmp_path / "bag"), "-o", str(tmp_path / "picture.png")]
    refused = dcrb(*command)
    proposed = refused.stderr.split("such as ")[1].split()
    assert refused.returncode == 2
    assert proposed == ["--start", "0.420000", "--duration", "0.980000"]
    done = fresh_dcrb(*command, *proposed)
    assert done.returncode == 0, done.stderr
    assert "0.98 s of" in done.stdout


@pytest.mark.parametrize("choice", ["--order", "--frequency"])
def test_command_plots_a_signal_that_is_too_short_for_orders(choice: str, tmp_path: Path) -> None:
    # 0.15 s at 20 revolutions per second are 3 turns, and order tracking needs 4
    done = dcrb("plot", str(BAGS / "healthy"), "-o", str(tmp_path / "short.png"), "--duration", "0.15", choice)
    assert done.returncode == 0, done.stderr
    assert ("the spectrum is over frequency" in done.stderr) == (choice == "--order")


def test_command_says_that_a_recording_without_speed_has_no_orders(tmp_path: Path) -> None:
    orders = {"FTF": 0.42, "BPFO": 6.72, "BPFI": 9.28, "BSF": 3.05}
    about = {"channels": {"ax": "a"}, "sampling_rate": 25600, "unit": "m/s^2", "orders": orders}
    (tmp_path / "about.yaml").write_text(yaml.safe_dump(about))
    np.savez(tmp_path / "still.npz", a=np.random.default_rng(1).standard_normal(25600))
    imported = dcrb("import", str(tmp_path / "still.npz"), "--about", str(tmp_path / "about.yaml"), "-o", str(tmp_path / "bag"))
    assert imported.returncode == 0, imported.stderr
    done = dcrb("plot", str(tmp_path / "bag"), "-o", str(tmp_path / "still.png"))
    assert done.returncode == 0, done.stderr
    assert done.stderr == "the spectrum is over frequency, because the recording has no speed\n"


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ((str(BAGS / "healthy"),), "Missing option '-o'"),
        (
            (str(BAGS / "healthy"), "-o", "picture.jpg"),
            "-o picture.jpg has an unknown file type: the name must end in one of .png, .svg, .pdf",
        ),
        ((str(BAGS / "healthy"), "-o", "nowhere/picture.png"), "there is no folder nowhere"),
        (
            (str(BAGS / "healthy"), "-o", "picture.png", "--duration", "0"),
            "--duration 0 s is out of range: it must be above 0 and at most 60 s",
        ),
        (
            (str(BAGS / "healthy"), "-o", "picture.png", "--start", "-1"),
            "--start -1 s is out of range: give a simulated time of 0 s or later",
        ),
        ((str(BAGS / "healthy"), "-o", "picture.png", "--start", "9"), "has no sample from 9 to 19 s: it has samples from 0 to 3 s"),
        (("nothing", "-o", "picture.png"), "there is no recording nothing"),
    ],
)
def test_command_refuses_in_one_sentence(
    arguments: tuple[str, ...], sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    done = dcrb("plot", *arguments)
    assert done.returncode == 2
    assert sentence in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    assert list(tmp_path.iterdir()) == []
