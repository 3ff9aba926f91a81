"""The drawn machines and the tables of docs/results/signals.md."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[2] / "benchmarks"))

import signal_draws
import signal_machines
import signal_page
from signal_statistics import SignalStatistics

from dcrb_ros.settings.files import load_configuration


@pytest.mark.parametrize("bearing", list(signal_machines.BENCHES))
def test_drawn_machines_are_valid_and_differ_in_the_floor_alone_between_defects(bearing: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(signal_draws, "healthy_level", lambda *_, **__: 2.0)
    bench, spreads = signal_machines.BENCHES[bearing][0], []
    for seed in range(1, 41):
        healthy = signal_machines.settings_of(bearing, "healthy", seed, "drawn")
        faulty = signal_machines.settings_of(bearing, "outer", seed, "drawn")
        assert {key for key in faulty if faulty[key] != healthy.get(key) and not key.startswith("faults.")} == {"structure.floor"}
        load_configuration(bench, faulty)
        spreads.append(healthy["impacts.spread"])
    prior = signal_draws.IMPACTS[signal_machines.BENCHES[bearing][1]]
    assert max(spreads) <= prior.spread.most
    assert np.median(spreads) == pytest.approx(prior.spread.median, rel=0.35)


def row(name: str, verdict: str = "", **values: float) -> signal_machines.Row:
    statistics = SignalStatistics(*[values.get(field, 0.0) for field in SignalStatistics._fields])
    return signal_machines.Row(name, statistics, 4.0, float("nan"), verdict)


def test_an_aim_is_reached_where_the_median_is_within_its_range() -> None:
    outer = [row("a", ratio=20.0, element=-0.1), row("b", ratio=30.0, element=0.1), row("c", ratio=90.0, element=0.6)]
    sound = [row("a", "healthy", kurtosis=3.0), row("b", "outer_ring", kurtosis=9.0)]
    text = list(signal_page.aims_table(lambda _, kind: {"outer": outer, "healthy": sound}.get(kind, []), ("all",)))
    assert "| T5 | outer | R | 25 to 60 | 30 yes |" in text
    assert "| T5 | outer | growth of R, kurtogram | 1.8 to 4.5 |  |" in text
    assert "| T10 | healthy | kurtosis | 2.7 to 3.5 | 6.0 **no** |" in text
    assert "| T6 | outer | quartiles of the correlation at lag Z | enclose 0 to 0.25 | 0.00 to 0.35 yes |" in text
    assert "| T10 | healthy | false alarms of the shipped detector | 0 | 1 of 2 **no** |" in text


def test_rows_are_read_as_they_were_written(tmp_path: Path) -> None:
    rows = {"6205: all: outer": [row("a", "healthy", ratio=20.0)]}
    signal_machines.write_rows(tmp_path / "rows.json", rows)
    read = signal_machines.read_rows(tmp_path / "rows.json")
    assert list(read) == list(rows)
    assert np.isnan(read["6205: all: outer"][0].kurtogram_growth)
    assert read["6205: all: outer"][0]._replace(kurtogram_growth=0.0) == rows["6205: all: outer"][0]._replace(kurtogram_growth=0.0)
