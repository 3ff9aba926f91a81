"""Warnings of notches that are taken for spalls."""

from __future__ import annotations

import pytest

from dcrb_ros.bearing.plausibility import implausible_notches
from dcrb_ros.settings.files import load_configuration
from dcrb_ros.settings.shipped import shipped


def warnings(bench: str, *settings: str) -> list[str]:
    return list(implausible_notches(load_configuration(bench, settings)))


def test_a_width_alone_is_said_to_be_a_notch() -> None:
    (sentence,) = warnings("healthy", "faults.inner_1.width=0.002")
    assert sentence.startswith("faults.inner_1.kind = notch is a groove 0.3 mm deep across the whole raceway")
    assert warnings("healthy", "faults.inner_1.width=0.002", "faults.inner_1.kind=spall") == []
    assert warnings("paper", "faults.outer_1.width=0.002") == []


@pytest.mark.parametrize("name", [name for name in shipped("configuration") if name != "detector"])
def test_shipped_benches_give_no_warning(name: str) -> None:
    assert warnings(name) == []
