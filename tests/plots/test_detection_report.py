"""The page on recordings: complete, self-contained, equal for equal recordings, and safe against names from outside."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import re
import shutil
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from same_process import dcrb

from dcrb_ros.diagnosis.detection import detect
from dcrb_ros.diagnosis.parameters import DetectorParameters
from dcrb_ros.plots import detection_report as report_module
from dcrb_ros.plots.detection_report import LIMITS, DiagnosedRecording, Samples, detection_report, read_content
from dcrb_ros.recordings.reader import Recording

BAGS = Path(__file__).parents[2] / "bags"


class Page(HTMLParser):
    """Addresses, cells and text of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.addresses: list[str] = []
        self.tags: list[str] = []
        self.texts: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.addresses += [value or "" for name, value in attributes if name in ("src", "href", "srcset", "data")]

    def handle_data(self, data: str) -> None:
        self.texts.append(data)

    @property
    def text(self) -> str:
        return " ".join(" ".join(self.texts).split())


def diagnosed(name: str, path: Path | None = None) -> DiagnosedRecording:
    recording = Recording(path or BAGS / name)
    return DiagnosedRecording(name, recording, detect(recording), DetectorParameters())


def test_the_page_is_self_contained_and_equal_for_equal_recordings() -> None:
    text = detection_report([diagnosed("outer_ring_defect")])
    page = Page(text)
    assert page.addresses
    assert all(address.startswith("data:image/png;base64,") for address in page.addresses)
    assert "url(" not in text
    assert "script" not in page.tags
    assert text == detection_report([diagnosed("outer_ring_defect")])


def test_the_page_states_verdict_reason_conditions_limits_and_versions() -> None:
    entry = diagnosed("outer_ring_defect")
    text = Page(detection_report([entry])).text
    last = entry.result.last
    for part in ("outer ring defect", last.reason, "51200 Hz", "BPFO 6.72", "numpy", "dcrb_ros", *LIMITS):
        assert part in text
    assert Recording(BAGS / "outer_ring_defect").manifest["recorded"] in text


def test_the_only_band_of_a_squared_envelope_spectrum_is_that_of_the_figure() -> None:
    entry = diagnosed("healthy")
    *remarks, other = entry.result.last.remarks
    assert other == entry.result.last.spectrum_remark == "the squared envelope spectrum is that of the band from 6.32 to 11.2 kHz"
    text = Page(detection_report([entry])).text
    assert re.findall(r"squared envelope spectrum [^.]*?band (?:from )?(\S+ to \S+)", text, re.IGNORECASE) == ["2000 to 20000"]
    assert remarks
    assert all(remark in text for remark in remarks)


def test_rms_and_peak_are_those_of_the_samples_and_the_digest_is_that_of_the_manifest() -> None:
    recording = Recording(BAGS / "inner_ring_defect")
    content, waveform = read_content(recording, Samples(0, 2047)), recording.waveform()
    acceleration = waveform.acceleration.astype(float)
    assert content.rms == pytest.approx(float((acceleration.var(axis=0)).sum() ** 0.5), rel=1e-9)
    assert content.peak == pytest.approx(float(abs(acceleration).max()))
    assert abs(acceleration[list(waveform.index).index(content.largest_sample)]).max() == pytest.approx(content.peak)
    assert [piece.first_index for piece in content.judged] == [0, 1024]
    assert recording.outcome is not None
    assert recording.outcome["sha256"] in Page(detection_report([diagnosed("inner_ring_defect")])).text


def test_every_number_belongs_to_samples_of_the_recording() -> None:
    entry = diagnosed("compound")
    count = entry.recording.digests().read.count
    text = Page(detection_report([entry])).text
    ranges = [(int(first), int(last)) for first, last in re.findall(r"samples (\d+) to (\d+)", text)]
    assert len(ranges) >= 5
    assert all(0 <= first <= last < count for first, last in ranges)
    assert (entry.judged.first, entry.judged.last) in ranges


def test_samples_before_a_long_gap_are_not_judged() -> None:
    waveform = Recording(BAGS / "outer_ring_defect").waveform()
    kept = np.ones(len(waveform.index), bool)
    kept[-90_000:-70_000] = False
    cut = dataclasses.replace(
        waveform, acceleration=waveform.acceleration[kept], shaft_angle=waveform.shaft_angle[kept], index=waveform.index[kept]
    )
    entry = DiagnosedRecording("cut", cut, detect(cut), DetectorParameters())  # type: ignore[arg-type]
    assert entry.judged.first == waveform.index[-70_000]
    assert entry.judged.last == entry.result.last.index


def test_several_recordings_have_a_table_and_a_trend_in_their_order() -> None:
    page = Page(detection_report([diagnosed(name) for name in ("healthy", "outer_ring_defect")]))
    assert page.text.index("1. healthy") < page.text.index("2. outer_ring_defect")
    assert len(page.addresses) == 7


def test_a_name_from_outside_is_text(tmp_path: Path) -> None:
    hostile = "<script>alert(1)</script>\x1b[31m"
    text = detection_report([diagnosed(hostile, BAGS / "healthy")])
    assert "script" not in Page(text).tags
    assert "\x1b" not in text


def test_the_command_writes_the_page_beside_its_answer(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "bearing.html"
    bags = [str(BAGS / "healthy"), str(BAGS / "cage_fracture")]
    assert dcrb("detect", *bags, "--json", "--report", str(file)) == 0
    answers = json.loads(capsys.readouterr().out)
    assert [answer["recording"] for answer in answers] == bags
    assert [answer["verdict"] for answer in answers] == ["healthy", "cage"]
    assert "cage fault" in Page(file.read_text(encoding="utf-8")).text
    assert dcrb("detect", *bags, "--report", str(file)) == 2
    out, err = capsys.readouterr()
    assert "exists: give another name, or --force" in err
    assert out == "", "it must be refused before the detection"


def test_the_picture_of_the_levels_begins_with_the_first_judgement(monkeypatch: pytest.MonkeyPatch) -> None:
    figures: list[Figure] = []
    monkeypatch.setattr(report_module, "_picture", lambda figure: figures.append(figure) or "")
    entry = diagnosed("outer_ring_defect")
    report_module._history(entry)
    judged = [bool(diagnosis.scores) for diagnosis in entry.result.history]
    assert judged[0] is False
    for line in figures[0].axes[0].lines:
        assert np.isfinite(np.asarray(line.get_ydata(), float)).tolist() == judged


@pytest.mark.slow
def test_two_runs_of_the_command_write_the_same_bytes(tmp_path: Path) -> None:
    bags = [str(BAGS / "outer_ring_defect"), str(BAGS / "run_up")]
    pages = []
    for seed in ("1", "2"):
        page = tmp_path / f"{seed}.html"
        command = [sys.executable, "-m", "dcrb_ros.cli.program", "detect", *bags, "--report", str(page)]
        subprocess.run(command, env={**os.environ, "PYTHONHASHSEED": seed}, capture_output=True, timeout=600.0, check=True)
        pages.append(page.read_bytes())
    assert pages[0] == pages[1]


def test_another_file_type_is_refused_before_the_work(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert dcrb("detect", str(tmp_path / "missing"), "--report", str(tmp_path / "page.pdf")) == 2
    assert "must end in one of .html, .htm" in capsys.readouterr().err


def test_a_recording_that_was_cut_off_says_so(tmp_path: Path) -> None:
    shutil.copytree(BAGS / "outer_ring_defect", tmp_path / "cut")
    file = next((tmp_path / "cut").glob("*.mcap"))
    file.write_bytes(file.read_bytes()[: int(0.9 * file.stat().st_size)])
    assert "cut off" in Page(detection_report([diagnosed("cut", tmp_path / "cut")])).text


ABOUT = "channels: {ax: a}\nsampling_rate: 12000\nunit: m/s^2\norders: {FTF: 0.3817, BPFO: 3.053, BPFI: 4.9469, BSF: 1.9937}\n"


@pytest.fixture
def measured(tmp_path: Path) -> Path:
    """Return an imported recording of one axis without a speed, 3 s of impacts at 107 Hz in noise."""
    time = np.arange(36_000) / 12e3
    phase = time % (1.0 / 107.0)
    impacts = 8.0 * np.exp(-600.0 * phase) * np.sin(2.0 * np.pi * 3000.0 * phase)
    samples = impacts + np.random.default_rng(1).standard_normal(len(time))
    np.savetxt(tmp_path / "measured.csv", samples, header="a", comments="", fmt="%.5f")
    (tmp_path / "about.yaml").write_text(ABOUT, encoding="utf-8")
    bag = tmp_path / "measured"
    assert dcrb("import", str(tmp_path / "measured.csv"), "--about", str(tmp_path / "about.yaml"), "-o", str(bag)) == 0
    return bag


def test_a_measured_recording_of_one_axis_without_speed_has_a_section(measured: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = measured.parent / "page.html"
    assert dcrb("detect", str(BAGS / "outer_ring_defect"), str(measured), "--report", str(file)) == 0
    assert f"{measured}: waiting" in "".join(line.strip() for line in capsys.readouterr().out.splitlines())
    text = Page(file.read_text(encoding="utf-8")).text
    assert "the speed cannot be estimated from the signal" in text
    assert "axes one" in text


def test_one_axis_counts_once_in_the_rms(measured: Path) -> None:
    content = read_content(Recording(measured), Samples(0, 0))
    samples = np.loadtxt(measured.parent / "measured.csv", skiprows=1)
    assert content.rms == pytest.approx(float(samples.std()), rel=1e-6)
    assert content.axes == "y"


@pytest.mark.parametrize(("unit", "unknown"), [("m/s^2", False), ("relative", True)])
def test_a_recording_in_an_unknown_unit_says_so(measured: Path, unit: str, unknown: bool) -> None:
    source, bag = measured.parent, measured.parent / "again"
    options = ["--about", str(source / "about.yaml"), "--set", f"unit={unit}", "--set", "speed_rpm=2103", "-o", str(bag)]
    assert dcrb("import", str(source / "measured.csv"), *options) == 0
    text = Page(detection_report([diagnosed("again", bag)])).text
    assert ("unit unknown: levels in m/s² are relative" in text) == unknown


def test_of_three_axes_the_page_has_the_first_two(tmp_path: Path) -> None:
    samples = np.random.default_rng(1).standard_normal((2400, 3)).round(5)
    np.savetxt(tmp_path / "three.csv", samples, header="a,b,c", comments="", delimiter=",", fmt="%.5f")
    (tmp_path / "about.yaml").write_text(ABOUT, encoding="utf-8")
    axes, bag = ["--set", "channels.ay=b", "--set", "channels.az=c"], tmp_path / "three"
    assert dcrb("import", str(tmp_path / "three.csv"), "--about", str(tmp_path / "about.yaml"), *axes, "-o", str(bag)) == 0
    content = read_content(Recording(bag), Samples(0, 0))
    assert content.axes == "both"
    assert content.rms == pytest.approx(math.sqrt(float(samples[:, :2].var(axis=0).sum())), rel=1e-6)
    assert content.peak == pytest.approx(float(np.abs(samples[:, :2]).max()))


def test_a_file_without_its_folder_has_a_page(tmp_path: Path) -> None:
    file = tmp_path / "single.mcap"
    shutil.copy(next((BAGS / "outer_ring_defect").glob("*.mcap")), file)
    assert "outer ring defect" in Page(detection_report([diagnosed("single", file)])).text


@pytest.mark.parametrize("value", [0.3, 9.81])
def test_a_constant_signal_has_an_rms_of_zero(value: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its mean square less the square of its mean may be below zero by rounding."""
    recording = Recording(BAGS / "outer_ring_defect")
    pieces = [piece._replace(acceleration=np.full_like(piece.acceleration, value)) for piece in recording.pieces()]
    monkeypatch.setattr(recording, "pieces", lambda: iter(pieces))
    assert read_content(recording, Samples(0, 0)).rms < 1e-6 * value
