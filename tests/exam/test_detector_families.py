"""Every member of every family of example detectors: noise, impacts, broken signals, lost blocks, and what the gain changes."""

from __future__ import annotations

import importlib
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from dcrb_ros import Orders, Refusal

pytestmark = pytest.mark.slow

FOLDER = Path(__file__).parents[2] / "examples" / "detectors"
RATE, TURNS = 12_800, 25.0
"""Sampling rate and shaft frequency [Hz]."""
ORDERS = Orders(ftf=0.42, bpfo=6.72, bpfi=9.28, bsf=3.05)
ONSET, END, BLOCK = 3.0, 5.5, 640
"""Start of the defect and end [s], samples of a block [-]."""
VERDICTS = {"waiting", "healthy", "outer_ring", "inner_ring", "roller", "cage"}
FEWEST = 20
"""Families that the folder must have [-]."""

sys.path.insert(0, str(FOLDER))
FAMILIES = importlib.import_module("compare").families()
MEMBERS = [(place, name) for place in FAMILIES.values() for name in importlib.import_module(place.partition(".")[0]).VARIANTS]
sys.path.remove(str(FOLDER))
for module in [name for name, value in sys.modules.items() if str(getattr(value, "__file__", "")).startswith(str(FOLDER))]:
    del sys.modules[module]

DEAF = {
    *("zero rule", "ISO 20816 band alarm", "ISO 20816 band alarm, class I", "ISO 20816 band alarm, class IV"),
    "shock pulse, maximum over carpet",
}
"""Members that do not report impacts at 4 kHz: no impacts at all, below 1 kHz only, or rare ones only: frequent ones raise the carpet."""
NAMELESS = {"rms_kurtosis", "iso_band", "naive_bpfo", "shock_pulse", "time_indicators", "spectral_entropy", "zero_rule"} | {
    *("octave_bands", "pca_residual", "isolation_forest", "wavelet_packet")
}
"""Families that report the most frequent fault, whatever part has a defect."""
AMPLITUDE_BASED = {
    *("rms and kurtosis", "rms and kurtosis, factor 1.5", "rms and kurtosis, factor 4"),
    *("squared envelope, fixed band", "squared envelope above 1 kHz", "squared envelope, factor 2", "squared envelope, half a second"),
    *("ISO 20816 band alarm", "ISO 20816 band alarm, class I", "ISO 20816 band alarm, class IV"),
    *("shock pulse", "shock pulse, 10 dB", "octave bands", "octave bands, factor 10"),
}
"""Members whose verdict changes with the gain of the sensor, as their documentation says."""


@pytest.fixture(autouse=True)
def examples(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Make the folder importable, as `dcrb score --python` does."""
    monkeypatch.syspath_prepend(str(FOLDER))
    yield
    for name, value in list(sys.modules.items()):
        if str(getattr(value, "__file__", "")).startswith(str(FOLDER)):
            del sys.modules[name]


def made(place: str, member: str, **settings: object) -> Any:
    name, _, kind = place.partition(".py:")
    module = importlib.import_module(name)
    return getattr(module, kind)(ORDERS, RATE, **{**module.VARIANTS[member], **settings})


def noise(duration: float = END, seed: int = 1) -> np.ndarray[Any, Any]:
    return np.random.default_rng(seed).normal(0.0, 1.0, int(duration * RATE))


def defective(order: float, level: float = 12.0, *, modulated: bool = False) -> np.ndarray[Any, Any]:
    """Return noise with ringing impacts from the onset on; their period varies by 1 % (McFadden and Smith 1984)."""
    random, signal, time = np.random.default_rng(2), noise(), ONSET
    burst = np.arange(int(0.004 * RATE)) / RATE
    while time < END - 0.01:
        first = int(time * RATE)
        strength = level * (1.0 + np.cos(2.0 * np.pi * TURNS * time) if modulated else 1.0)
        signal[first : first + len(burst)] += strength * np.exp(-burst / 0.0008) * np.sin(2.0 * np.pi * 4000.0 * burst)
        time += (1.0 + 0.01 * random.normal()) / (order * TURNS)
    return signal


def verdicts(detector: Any, signal: np.ndarray[Any, Any], first: int = 0) -> list[str]:
    """Return the verdicts on a signal whose first sample has an index, in the order of the blocks."""
    angle = np.mod(2.0 * np.pi * TURNS * (first + np.arange(len(signal))) / RATE, 2.0 * np.pi).astype(np.float32)
    both = np.stack([0.1 * signal, signal], axis=1).astype(np.float32)
    found = []
    for k in range(0, len(signal), BLOCK):
        diagnosis = detector.update(first + k, both[k : k + BLOCK], angle[k : k + BLOCK])
        if diagnosis is not None:
            found.append(diagnosis if isinstance(diagnosis, str) else diagnosis.verdict)
            assert isinstance(diagnosis, str) or np.isfinite(list(diagnosis.scores.values())).all()
    assert set(found) <= VERDICTS
    return found


def test_there_are_twenty_families_with_members_of_different_names() -> None:
    assert len(FAMILIES) >= FEWEST
    assert len({name for _, name in MEMBERS}) == len(MEMBERS)
    for place in FAMILIES.values():
        published = next(iter(importlib.import_module(place.partition(".")[0]).VARIANTS.values()))
        assert published == {}, f"the defaults of {place} must be the published settings"


def test_the_table_of_families_is_complete() -> None:
    table = (FOLDER / "README.md").read_text(encoding="utf-8")
    assert sorted(re.findall(r"^\| `(\w+\.py)`", table, re.M)) == sorted(place.partition(":")[0] for place in FAMILIES.values())
    assert [name for _, name in MEMBERS if name not in table] == []


@pytest.mark.parametrize(("place", "member"), MEMBERS)
def test_noise_is_healthy(place: str, member: str) -> None:
    found = verdicts(made(place, member), noise())
    assert set(found) <= {"waiting", "healthy"}
    assert found[-1] == "healthy"


@pytest.mark.parametrize(("place", "member"), [member for member in MEMBERS if member[1] not in DEAF])
def test_strong_impacts_of_an_outer_ring_defect_are_reported_in_the_same_way_twice(place: str, member: str) -> None:
    signal = defective(ORDERS.bpfo, 100.0 if "shock pulse" in member else 30.0)  # 20 dB above the largest pulse of noise
    found = verdicts(made(place, member), signal)
    assert set(found[: int(ONSET)]) <= {"waiting", "healthy"}
    assert found[-1] == "outer_ring"
    assert verdicts(made(place, member), signal) == found


@pytest.mark.parametrize("place", [place for place in FAMILIES.values() if place.partition(".")[0] not in NAMELESS])
@pytest.mark.parametrize(("part", "order"), [("inner_ring", ORDERS.bpfi), ("roller", 2.0 * ORDERS.bsf)])
def test_published_members_name_the_defective_part(place: str, part: str, order: float) -> None:
    member = next(name for found, name in MEMBERS if found == place)
    # The classifier was trained on rollers of the simulation, whose impacts differ.
    expected = "healthy" if (place, part) == ("classifier.py:Classifier", "roller") else part
    assert verdicts(made(place, member), defective(order, modulated=part == "inner_ring"))[-1] == expected


@pytest.mark.parametrize(("place", "member"), MEMBERS)
def test_zeros_constants_and_short_signals_are_no_fault(place: str, member: str) -> None:
    for signal in (np.zeros(3 * RATE), np.full(3 * RATE, 7.0), noise(0.2)):
        assert set(verdicts(made(place, member), signal)) <= {"waiting", "healthy"}


@pytest.mark.parametrize(("place", "member"), MEMBERS)
def test_the_gain_of_a_second_recording_matters_to_amplitude_based_members_only(place: str, member: str) -> None:
    """Blocks are lost between the healthy recording and the second one, which is 40 dB louder."""
    detector = made(place, member)
    verdicts(detector, noise(ONSET))
    last = verdicts(detector, 100.0 * noise(2.0, seed=2), first=int(10.0 * RATE))[-1]
    assert (last != "healthy") == (member in AMPLITUDE_BASED)


def test_an_unknown_setting_is_refused() -> None:
    with pytest.raises(Refusal, match=r"Kurtogram has no setting 'level'\. Choose among factor, .*levels"):
        made("kurtogram.py:Kurtogram", "fast kurtogram", level=3)
    with pytest.raises(Refusal, match=r"reference = 'new' is unknown\. Choose among healthy, noise"):
        made("infogram.py:Infogram", "infogram", reference="new")
