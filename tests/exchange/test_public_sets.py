"""The shipped descriptions of public data sets: complete where the publishers are, and usable on files of their form."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import savemat
from separate_process import dcrb

from dcrb_ros.bearing.order_check import order_mistake
from dcrb_ros.exchange.importing import WaveformImport
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.shipped import find_shipped, shipped
from dcrb_ros.text.yaml import read_yaml

TO_ADD = {"hit": "channels", "saarland": "channels", "uestc": "orders", "ottawa-constant-speed": "orders"}
"""What the publishers leave to the user, by set."""
NOISE = np.random.default_rng(2).normal(size=20_000)


@pytest.mark.parametrize("name", list(shipped("description")))
def test_a_description_names_its_origin(name: str) -> None:
    source = read_yaml(find_shipped("description", name))["source"]
    assert {"title", "bearing", "labels", "licence", "where"} <= set(source)


def paderborn() -> dict[str, Any]:
    names = ("force", "phase_current_1", "phase_current_2", "speed", "temp_2_bearing_module", "torque", "vibration_1")
    speeds = {"speed": np.full(1251, 900.0), "vibration_1": NOISE}
    series = np.array([{"Name": name, "Data": speeds.get(name, np.zeros(3))} for name in names], dtype=object)
    return {"N09_M07_F10_KA01_1": {"Y": series}}


def encoder() -> dict[str, Any]:
    turns = 12.0 * np.arange(len(NOISE)) / 200_000 + 40.0 * (np.arange(len(NOISE)) / 200_000) ** 2
    return {"Channel_1": NOISE, "Channel_2": 5.0 * (np.mod(1024.0 * turns, 1.0) < 0.5)}


FILES: dict[str, tuple[dict[str, Any], list[str]]] = {
    "cwru-12k": ({"X105_DE_time": NOISE, "X105_FE_time": NOISE, "X105RPM": 1797.0}, []),
    "cwru-48k": ({"X097_DE_time": NOISE, "X097_FE_time": NOISE, "X097RPM": 1796.0}, []),
    "cwru-fan-12k": ({"X278_DE_time": NOISE, "X278_FE_time": NOISE, "X278RPM": 1796.0}, []),
    "hit": ({"a": NOISE}, ["channels={ax: a}", "unit=relative", "orders={FTF: 0.4, BPFO: 6.0, BPFI: 9.0, BSF: 2.4}"]),
    "ims": ({}, []),
    "mfpt": ({"bearing": {"gs": NOISE, "sr": 48828.0, "rate": 25.0}}, []),
    "ottawa-constant-speed": ({}, ["orders={FTF: 0.38, BPFO: 3.04, BPFI: 4.96, BSF: 1.96}"]),
    "ottawa-variable-speed": (encoder(), []),
    "paderborn": (paderborn(), []),
    "saarland": ({"a": NOISE}, ["channels={ax: a}", "unit=g", "orders={FTF: 0.4, BPFO: 5.2, BPFI: 7.8, BSF: 2.4}"]),
    "uestc": ({"Data": NOISE, "Datacount": 20000.0}, ["orders={FTF: 0.38, BPFO: 3.04, BPFI: 4.96, BSF: 1.96}", "speed_rpm=1000"]),
    "upm": ({"Fs": 40000.0, "Rod_1": NOISE, "Rod_2": NOISE}, ["speed_rpm=500"]),
    "xjtu-sy": ({}, ["speed_rpm=2100"]),
}
"""Variables as in a file of each set, and the settings that the user adds; sets of text files have none."""
TEXTS = {
    "ims": "\t".join(["0.1"] * 8),
    "ottawa-constant-speed": ",".join(["0.1"] * 5),
    "xjtu-sy": "Horizontal_vibration_signals,Vertical_vibration_signals\r\n-0.4,-0.04",
}


def made_up(folder: Path, name: str) -> Path:
    variables, _ = FILES[name]
    if variables:
        savemat(folder / "x.mat", variables)
        return folder / "x.mat"
    text = folder / "x.csv"
    text.write_text(TEXTS[name] + "\n" + "\n".join([TEXTS[name].splitlines()[-1]] * 99) + "\n", encoding="utf-8")
    return text


@pytest.mark.parametrize("name", list(shipped("description")))
def test_a_file_of_its_form_is_imported(name: str, tmp_path: Path) -> None:
    file, settings = made_up(tmp_path, name), FILES[name][1]
    found = WaveformImport(file, find_shipped("description", name), settings)
    assert order_mistake(found.orders) == ""
    unknown = name in ("hit", "saarland")  # whose speed is left open here
    assert np.isfinite(found.angle).all() != unknown
    if name in TO_ADD:
        with pytest.raises(Refusal, match=TO_ADD[name]):
            WaveformImport(file, find_shipped("description", name))


def test_the_speed_of_an_encoder_is_followed(tmp_path: Path) -> None:
    found = WaveformImport(made_up(tmp_path, "ottawa-variable-speed"), find_shipped("description", "ottawa-variable-speed"))
    turns = np.unwrap(found.angle.astype(float)) / (2.0 * np.pi)
    time = np.arange(len(turns)) / 200_000
    assert np.ptp(turns - 12.0 * time - 40.0 * time**2) < 1.0 / 1024
    assert found.irregular_pulses == 0


def test_the_speed_of_a_slower_channel_is_followed(tmp_path: Path) -> None:
    found = WaveformImport(made_up(tmp_path, "paderborn"), find_shipped("description", "paderborn"))
    turns = np.unwrap(found.angle.astype(float)) / (2.0 * np.pi)
    assert turns[-1] - turns[0] == pytest.approx(15.0 * 19_999 / 64_000, rel=1e-5)


def test_names_are_listed_shown_and_corrected() -> None:
    assert shipped("description").keys() == FILES.keys()
    done = dcrb("import", "--list")
    for (name, path), line in zip(shipped("description").items(), done.stdout.splitlines(), strict=True):
        source = read_yaml(path)["source"]
        assert line.split() == [name, *f"{source['title']}; {source['where']}".split()]
    assert dcrb("import", "--show", "cwru-48k").stdout == find_shipped("description", "cwru-48k").read_text(encoding="utf-8")
    wrong = dcrb("import", "--show", "cwru48")
    assert (wrong.returncode, wrong.stderr.count("\n")) == (2, 1)
    assert "did you mean 'cwru-48k'?" in wrong.stderr
