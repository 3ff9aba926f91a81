"""Features of whole signals and of blocks, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import dcrb_ros
from dcrb_ros import FeatureExtractor, FeatureTable, Orders, Refusal, extract_features

RATE, SPEED = 12800, 25.0
ORDERS = Orders(0.42, 6.72, 9.28, 3.06)


def signal(seconds: float = 3.0, speed: float = SPEED) -> dict[str, Any]:
    samples = round(seconds * RATE)
    return {
        "signal": np.random.default_rng(1).normal(size=(samples, 2)),
        "sampling_rate": RATE,
        "shaft_angle": 2.0 * np.pi * speed * np.arange(samples) / RATE,
        "bearing": ORDERS,
    }


def test_windows_and_names() -> None:
    table = extract_features(**signal())
    assert table.time.tolist() == pytest.approx([1.0, 1.5, 2.0, 2.5, 3.0])
    assert table.values.shape == (5, len(set(table.names)))
    assert np.isfinite(table.values).all()
    assert table["y_rms"] == pytest.approx(np.ones(5), abs=0.03)
    assert table.to_pandas()["x_kurtosis"].to_numpy() == pytest.approx(table["x_kurtosis"])
    with pytest.raises(Refusal, match="no feature 'y_rsm'; did you mean 'y_rms'"):
        table["y_rsm"]


@pytest.mark.parametrize("block", [100, 997, 12800, 30000])
def test_blocks_of_any_size_give_the_same_features(block: int) -> None:
    given = signal()
    extractor = FeatureExtractor(ORDERS, RATE, families=["statistics", "kurtogram", "envelope_lines"])
    whole = extract_features(**given, families=["envelope_lines", "statistics", "kurtogram"])
    tables: list[FeatureTable] = []
    wrapped = np.mod(given["shaft_angle"], 2.0 * np.pi).astype(np.float32)
    samples = given["signal"].astype(np.float32)
    for begin in range(0, len(wrapped), block):
        tables.append(extractor.update(begin, samples[begin : begin + block], wrapped[begin : begin + block]))
    assert np.concatenate([table.time for table in tables]) == pytest.approx(whole.time)
    assert np.array_equal(np.concatenate([table.values for table in tables]), whole.values)
    assert extractor.names == whole.names


def test_lost_samples_begin_a_new_window() -> None:
    given = signal()
    extractor = FeatureExtractor(ORDERS, RATE, families=["statistics"], hop=1.0)
    first = extractor.update(0, given["signal"][:20000], given["shaft_angle"][:20000])
    second = extractor.update(20001, given["signal"][20001:], given["shaft_angle"][20001:])
    assert [len(first), len(second)] == [1, 1]
    assert second.time[0] == pytest.approx((20001 + RATE) / RATE)


def test_a_shaft_that_stands_or_turns_back_gives_no_number() -> None:
    given = signal()
    standing = given | {"shaft_angle": np.where(np.arange(len(given["signal"])) < RATE, given["shaft_angle"], 0.0)}
    table = extract_features(**standing, families=["statistics"], hop=1.0)
    assert np.isfinite(table.values).all(axis=1).tolist() == [True, False, False]
    back = given | {"shaft_angle": np.abs(given["shaft_angle"] - given["shaft_angle"][RATE // 2])}
    assert np.isnan(extract_features(**back, families=["statistics"], hop=1.0).values[0]).all()


def test_one_axis_and_a_run_are_taken_as_they_are() -> None:
    run = dcrb_ros.simulate("paper", 1.2)
    table = extract_features(run, axes=["y"], families=["statistics"])
    assert (table.names[0], len(table)) == ("y_rms", 1)
    assert table["y_rms"][0] == pytest.approx(run.acceleration[: run.sampling_rate, 1].astype(float).std(), rel=1e-4)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"families": ["kurtogramm"]}, "no family of features 'kurtogramm'; did you mean 'kurtogram'"),
        ({"families": []}, "no family of features ''"),
        ({"axes": ["z"]}, "give x, y or both"),
        ({"window": 0.1}, "window = 0.1 s is outside 0.2 .. 60 s"),
        ({"window": float("nan")}, "window = nan"),
        ({"hop": 2.0}, "hop = 2 s is outside"),
        ({"window": 5.0}, "3 s without a window of 5 s: give a longer signal"),
        ({"bearing": None}, "the bearing is unknown: give its geometry or its orders"),
        ({"shaft_angle": None}, "the signal has no shaft angle"),
    ],
)
def test_what_has_no_features_is_refused(changes: dict[str, Any], sentence: str) -> None:
    with pytest.raises(Refusal, match=sentence):
        extract_features(**(signal() | changes))


def test_a_block_of_another_shape_is_refused() -> None:
    with pytest.raises(Refusal, match=r"shapes \(5, 3\) and \(5,\) does not fit"):
        FeatureExtractor(ORDERS, RATE).update(0, np.zeros((5, 3)), np.zeros(5))
