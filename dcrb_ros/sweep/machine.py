"""A sweep around a calibrated machine: its configuration as the base, its intervals as axes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from dcrb_ros.calibration.files import intervals_of
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.sweep.sweep_file import KEPT_BASE
from dcrb_ros.text.files import checked_path, is_file
from dcrb_ros.text.yaml import yaml_text

MACHINE, BASE, VARY = "machine", "base", "vary"


def around_machine(tree: Mapping[str, Any], source: str, folder: Path) -> tuple[dict[str, Any], str]:
    """Return a sweep's tree with the base and the intervals of its ``machine``, and its text without that key.

    Axes of the sweep itself replace intervals of the same parameters. The text takes the base from `KEPT_BASE` beside it, as a data set
    keeps it.

    Raises:
        Refusal: a base is given as well, the machine does not exist, or it has no intervals beside it.
    """
    name = tree[MACHINE]
    if BASE in tree:
        raise Refusal(f"{source}: base = {tree[BASE]!r} and machine = {name!r} are both a configuration for all runs: give one of them")
    if not isinstance(name, str) or not name:
        raise Refusal(f"{source}: machine = {name!r} is not a file: give what dcrb calibrate wrote, such as my_machine.yaml")
    relative, given = checked_path(folder / name), checked_path(name)
    path = relative if is_file(relative) else given
    if not is_file(path):
        raise Refusal(f"{source}: there is no machine {name}: make it from healthy recordings, dcrb calibrate HEALTHY -o {Path(name).name}")
    axes = tree.get(VARY) or {}
    vary = intervals_of(path) | (dict(flatten_axes(axes)) if isinstance(axes, Mapping) else {})
    keys = {key: value for key, value in tree.items() if key != MACHINE}
    text = f"# The intervals are those of {path.name}.\n" + yaml_text(keys | {BASE: KEPT_BASE, VARY: vary})
    return keys | {BASE: str(path), VARY: vary}, text


def flatten_axes(tree: Mapping[str, Any], prefix: str = "") -> Mapping[str, Any]:
    """Return axes by their dotted keys; a range stays one value, and so does an empty one, which no parameter accepts.

    Raises:
        Refusal: a key occurs twice, in its group and with a dotted name.
    """
    flat: dict[str, Any] = {}
    for name, value in tree.items():
        group = isinstance(value, Mapping) and value and not {"low", "high"} & set(value)
        for key, axis in (flatten_axes(value, f"{prefix}{name}.") if group else {f"{prefix}{name}": value}).items():
            if key in flat:
                raise Refusal(f"{key} occurs twice, in its group and with a dotted name: remove one")
            flat[key] = axis
    return flat
