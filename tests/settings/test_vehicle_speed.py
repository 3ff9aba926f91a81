"""The two forms of the speed: in one file one of them, in a later layer either."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.files import flatten, load_configuration, overlaid, validated
from dcrb_ros.settings.parameters import Operating

BOTH = r"operating.speed = 100.0 rad/s and operating.speed_kmh = 72.0 km/h are two forms of one parameter: give one of them"


def configured(folder: Path, operating: str, *settings: str) -> float:
    """Return the speed [rad/s] of a file with a group ``operating`` and settings on top of it."""
    path = folder / "mine.yaml"
    path.write_text(f"operating: {{{operating}, wheel_diameter: 1.0}}", encoding="utf-8")
    found = load_configuration(path, settings)
    assert found.operating.speed_kmh == 0.0
    return found.operating.speed


def test_both_forms_in_one_layer_are_refused(tmp_path: Path) -> None:
    with pytest.raises(Refusal, match=BOTH):
        configured(tmp_path, "speed: 100.0, speed_kmh: 72.0")
    with pytest.raises(Refusal, match=BOTH):
        load_configuration("dry", ["operating.speed=100", "operating.speed_kmh=72"])
    with pytest.raises(Refusal, match=BOTH):
        load_configuration(Configuration(), ["operating.speed=100", "operating.speed_kmh=72"])
    with pytest.raises(Refusal, match=BOTH):
        Operating(speed=100.0, speed_kmh=72.0)


@pytest.mark.parametrize(
    ("operating", "settings", "speed"),
    [
        ("speed_kmh: 72.0", (), 40.0),
        ("speed_kmh: 72", (), 40.0),
        ("speed: 100.0, speed_kmh: 0.0", (), 100.0),
        ("speed: 100.0", ("operating.speed_kmh=72",), 40.0),
        ("speed_kmh: 72.0", ("operating.speed=100",), 100.0),
        ("speed_kmh: 72.0", ("operating.wheel_diameter=2",), 20.0),
        ("speed: 100.0", ("operating.speed_kmh=0",), 100.0),
    ],
)
def test_a_later_layer_replaces_either_form(tmp_path: Path, operating: str, settings: tuple[str, ...], speed: float) -> None:
    assert configured(tmp_path, operating, *settings) == speed


@pytest.mark.parametrize(("changes", "speed"), [({"operating.speed_kmh": 72.0}, 40.0), ({"operating.speed": 90.0}, 90.0)])
def test_a_whole_configuration_with_changes_shows_the_speed_that_runs(changes: dict[str, Any], speed: float) -> None:
    whole = flatten(Configuration().model_dump()) | {"operating.wheel_diameter": 1.0}
    found = overlaid(whole, changes)
    assert (found["operating.speed"], found["operating.speed_kmh"]) == (speed, 0.0)
    assert validated(found, Configuration, "test").operating.speed == speed
    with pytest.raises(Refusal, match=r"operating.speed_kmh = 5000.0 km/h is outside -1000"):
        validated(overlaid(whole, {"operating.speed_kmh": 5000.0}), Configuration, "test")
