"""The drawn machines and the tables of docs/results/signals.md."""

from __future__ import annotations

from pathlib import Path

import drawn_machines
import numpy as np
import pytest
import signal_machines
import signal_page
from signal_statistics import SignalStatistics

from dcrb_ros.exam import replica
from dcrb_ros.settings.files import load_configuration


@pytest.mark.parametrize("bearing", list(signal_machines.BENCHES))
def test_drawn_machines_are_valid_and_keep_what_a_part_left_out_does_not_concern(bearing: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(replica, "healthy_level", lambda *_, **__: 2.0)
    equal, whole = (signal_machines.machines_of(bearing, drawing, 8) for drawing in ("equal", "drawn"))
    for all_parts, fewer in zip(whole, equal, strict=True):
        assert {kind for kind, _ in all_parts} == set(drawn_machines.TRUTHS)
        for kind, settings in all_parts.items():
            load_configuration(signal_machines.BENCHES[bearing], settings)
            assert {key: settings[key] for key in fewer[kind]} == fewer[kind]
            assert all(key.startswith(("impacts.", "structure.")) for key in settings.keys() - fewer[kind].keys())
        mountings = [settings["structure.mounting"] for settings in all_parts.values()]
        assert len(set(mountings)) == len(mountings), "each kind of defect is on another bearing"
        assert len({settings["structure.seed"] for settings in all_parts.values()}) == 1


def row(name: str, verdict: str = "", **values: float) -> signal_machines.Row:
    statistics = SignalStatistics(*[values.get(field, 0.0) for field in SignalStatistics._fields])
    return signal_machines.Row(name, statistics, 4.0, float("nan"), verdict)


def test_an_aim_is_reached_where_the_median_is_within_its_range() -> None:
    outer = [row("a", ratio=20.0, element=-0.1), row("b", ratio=30.0, element=0.1), row("c", ratio=90.0, element=0.6)]
    sound = [row("a", "healthy", kurtosis=3.0), row("b", "outer_ring", kurtosis=9.0)]
    text = signal_page.aims_table(lambda _, kind: {"outer": outer, "healthy": sound}.get(kind, []), ("all",)).splitlines()
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
