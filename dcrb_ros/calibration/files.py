"""The files of a calibration: the configuration, and beside it the intervals of its values."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.files import to_described_yaml
from dcrb_ros.text.files import LARGEST_TEXT, read_bytes
from dcrb_ros.text.json import digest_of
from dcrb_ros.text.writing import whole_files
from dcrb_ros.text.yaml import read_yaml, yaml_text

if TYPE_CHECKING:
    from dcrb_ros.calibration.calibration import Calibration
    from dcrb_ros.calibration.estimate import EstimatedParameter

SUFFIX = ".intervals.yaml"
DIGEST, CONFIGURATION_DIGEST = "sha256", "configuration_sha256"
"""Entries of a file of intervals: the digest of its other entries, and that of the file of the configuration."""
SIGNIFICANT = 6
"""Digits of the numbers in the file of the intervals."""


def intervals_beside(configuration: Path) -> Path:
    """Return the file of the intervals of a calibrated configuration: ``my_machine.intervals.yaml`` beside ``my_machine.yaml``."""
    return configuration.with_name(configuration.stem + SUFFIX)


def write_calibration(calibration: Calibration, file: Path) -> Path:
    """Write the configuration to ``file`` and the intervals beside it; return the latter's path.

    Raises:
        Refusal: a file cannot be written.
    """
    beside = intervals_beside(file)
    named = ", ".join(Path(name).name for name in calibration.recordings)
    head = f"# A bench calibrated to {named}; the intervals are in {beside.name}.\n"
    content = (head + to_described_yaml(calibration.configuration)).encode()
    tree = _tree(calibration, file.name) | {CONFIGURATION_DIGEST: hashlib.sha256(content).hexdigest()}
    about = yaml_text(tree | {DIGEST: digest_of(tree, DIGEST)}, width=120)
    remarks = "".join(f"# Not identified: {sentence}.\n" for sentence in calibration.unidentified)
    with whole_files(file, beside) as (configuration, intervals):
        configuration.write_bytes(content)  # without other line ends on Windows
        intervals.write_bytes(f"# Intervals of {file.name}: 'vary' can stand in a sweep file.\n{remarks}{about}".encode())
    return beside


def intervals_of(machine: Path) -> dict[str, Any]:
    """Return the axes in the file of intervals beside a calibrated configuration, ``my_machine.intervals.yaml`` beside ``my_machine.yaml``.

    Raises:
        Refusal: there is none, or it has another form; or it or the configuration was changed.
    """
    intervals = intervals_beside(machine)
    tree = read_yaml(intervals)
    axes = tree.get("vary") if isinstance(tree, Mapping) else None
    if not isinstance(axes, Mapping):
        raise Refusal(f"{intervals} has no ranges below 'vary': dcrb calibrate writes the intervals of {machine.name} there")
    calibrate = "calibrate again, or give base and vary in the sweep instead of machine"
    if tree.get(DIGEST) != digest_of(tree, DIGEST):
        raise Refusal(f"{intervals} was changed: its digest does not match; {calibrate}")
    if hashlib.sha256(read_bytes(machine, LARGEST_TEXT)).hexdigest() != tree.get(CONFIGURATION_DIGEST):
        raise Refusal(f"{machine} was changed after its calibration, or {intervals.name} is that of another machine: {calibrate}")
    return {str(key): axis for key, axis in axes.items()}


def _tree(calibration: Calibration, name: str) -> dict[str, Any]:
    path = [
        {
            "axis": level.axis,
            "hz": _short(level.frequency),
            "db": [_short(level.level), _short(level.low), _short(level.high)],
            "share": _short(level.share),
        }
        for level in calibration.path
    ]
    return {
        "configuration": name,
        "recordings": [Path(recording).name for recording in calibration.recordings],
        "level": calibration.level,
        "vary": vary(calibration),
        "estimates": {
            estimate.key: {name: _short(getattr(estimate, name)) for name in ("value", "low", "high")} | {"unit": estimate.unit}
            for estimate in calibration.estimates
        },
        "path": path,
        "unidentified": list(calibration.unidentified),
    }


def vary(calibration: Calibration) -> dict[str, dict[str, float | int | str]]:
    """Return the intervals as the section ``vary`` of a sweep, with a seed that draws deviations of the path."""
    # Two recordings at nearly one speed have an interval that vanishes when it is rounded, which is no range.
    axes = {estimate.key: _axis(estimate) for estimate in calibration.estimates if _short(estimate.high) > _short(estimate.low)}
    if calibration.path_spread > 0.0:
        axes["structure.path_spread"] = {"low": 0.0, "high": calibration.path_spread}
    return axes | {"structure.seed": {"low": 1, "high": 2**31 - 1}}


def _axis(estimate: EstimatedParameter) -> dict[str, float | int | str]:
    axis: dict[str, float | int | str] = {"low": _short(estimate.low), "high": _short(estimate.high)}
    return axis | ({"scale": "log"} if estimate.log and estimate.low > 0.0 else {})


def _short(value: float) -> float:
    return float(f"{value:.{SIGNIFICANT}g}") if math.isfinite(value) else value
