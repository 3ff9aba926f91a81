"""The plots of films and friction: what is drawn, and only of lubricated benches."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from dcrb_ros.messages.joints import encode_joints
from dcrb_ros.messages.topics.lubrication_state import arrays_of, names_of
from dcrb_ros.stream.states import FRICTION_SOURCES
from dcrb_ros.viewer import blueprint, series
from dcrb_ros.viewer.reader import series_of

NAMES = names_of(2)


def received() -> list[bytes]:
    """Return two messages with numbers of their own, one of them with a row that has no loaded contact."""
    values = np.arange(2.0 * len(NAMES)).reshape(2, -1)
    values[0, :6] = np.nan
    empty = np.zeros(0)
    return [encode_joints(10_000_000 * k, NAMES, row, empty, empty) for k, row in enumerate(values)]


def test_films_are_drawn_in_micrometres_and_power_as_the_sum_of_the_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: dict[str, tuple[Any, Any]] = {}
    monkeypatch.setattr(series, "log_lines", lambda path, time_ns, values, names, *_, **__: drawn.update({path: (values, names)}))
    found = series_of(received())
    assert found is not None
    series.log_lubrication(found)
    arrays = arrays_of(found.names, found.values)
    assert arrays is not None
    films, names = drawn["films"]
    assert names[0] == "row 1, inner [um]"
    assert names[-1] == "row 2, Lambda"
    assert films[1, 0] == pytest.approx(1e6 * arrays["least_film"][1, 0, 0])
    assert films[1, 3] == pytest.approx(1e6 * arrays["least_film"][1, 1, 1])
    assert films[1, 5] == pytest.approx(arrays["least_film_ratio"][1, 1, 0])
    assert np.isnan(films[0, 0])
    powers, sources = drawn["friction"]
    assert tuple(sources) == FRICTION_SOURCES
    assert powers == pytest.approx(arrays["friction_power"].sum(axis=1))


def test_a_dry_bench_has_no_plots_of_films() -> None:
    axis = blueprint.close_up(-0.1, 0.1)
    named = [{str(view.name) for view in blueprint.motion(axis, None, lubricated=oil).contents} for oil in (False, True)]
    assert {name.split()[0] for name in named[1] - named[0]} == {"Oil", "Friction"}
    assert named[0] < named[1]
