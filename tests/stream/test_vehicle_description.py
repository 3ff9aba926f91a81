"""The description of a vehicle: it survives JSON, and nonsense is refused in one sentence."""

import json
from typing import Any

import pytest

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.stream.vehicle_description import VehicleDescription
from dcrb_ros.vehicle.description import described
from dcrb_ros.vehicle.file import read_vehicle

BOGIE = described(read_vehicle("bogie"))


def changed(**changes: Any) -> str:
    """Return the bogie's description with entries of the first wheelset or box, or others, changed."""
    about = json.loads(BOGIE.to_json())
    for key, value in changes.items():
        part, _, name = key.partition("__")
        if name:
            about[part][0][name] = value
        else:
            about[part] = value
    return json.dumps(about)


def test_survives_json() -> None:
    assert VehicleDescription.from_json(BOGIE.to_json()) == BOGIE


def test_names_boxes_wheels_and_gear_but_no_fault() -> None:
    assert [box.name for box in BOGIE.boxes] == ["axle_1/left", "axle_1/right", "axle_2/left", "axle_2/right"]
    assert [(axle.x, axle.wheel_radius, axle.driven) for axle in BOGIE.axles] == [(1.28, 0.46, True), (-1.28, 0.459, False)]
    assert not any(word in BOGIE.to_json() for word in ("fault", "flat", "polygon", "outer_1", "seed", "creep"))


def test_ignores_unknown_keys() -> None:
    assert VehicleDescription.from_json(changed(colour="red")) == BOGIE


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("[", "is not JSON"),
        ("[" * 90_000, "is not JSON"),
        ("x" * 200_000, "characters"),
        (changed(format="other"), "is not JSON with format"),
        (changed(sampling_rate=51200.5), "sampling_rate"),
        (changed(sampling_rate=True), "sampling_rate"),
        (changed(boxes=[]), "0 boxes"),
        (changed(boxes=3), "cannot be decoded"),
        (changed(boxes__axle="axle_9"), "is unknown"),
        (changed(boxes__side="up"), "left or right"),
        (changed(boxes__name="axle_1/right"), "must be called 'axle_1/left'"),
        (changed(boxes__orders={"FTF": 0.4}), "lacks 'BPFO'"),
        (changed(boxes__orders={"FTF": 0.4, "BPFO": 0.0, "BPFI": 9.0, "BSF": 3.0}), "BPFO = 0.0 is outside"),
        (changed(boxes__sensor_range=-1.0), "sensor_range"),
        (changed(axles__x=1e9), "x = 1000000000.0 is outside"),
        (changed(axles__x=-1.28), "at one x"),
        (changed(axles__name="axle 1"), "has no name of letters"),
        (changed(axles__wheel_radius="wide"), "cannot be decoded"),
        (changed(axles__x=10**400), "cannot be decoded"),
        (changed(axles__gear_teeth=-3), "gear_teeth"),
    ],
)
def test_refuses_nonsense_in_one_sentence(text: str, sentence: str) -> None:
    with pytest.raises(Refusal, match=sentence):
        VehicleDescription.from_json(text)


def test_infinite_numbers_are_refused() -> None:
    with pytest.raises(Refusal, match="outside"):
        VehicleDescription.from_json(BOGIE.to_json().replace("1.28", "Infinity"))
