"""The program that imports a family of detectors, in a process of its own."""

from __future__ import annotations

import inspect
import json
from typing import Any

from dcrb_ros.exam.detector_process import READY, connected, imported
from dcrb_ros.exam.packets import send_packet
from dcrb_ros.exam.plugin import load_module, variants_of
from dcrb_ros.schema.refusal import Refusal


def main() -> None:
    """Send class and variants of the file in the arguments, which are those of `dcrb_ros.exam.detector_process`."""
    channel = connected()
    about = imported(channel, class_and_variants)
    if about is not None:
        send_packet(channel, READY + json.dumps(about).encode())


def class_and_variants(name: str) -> dict[str, Any]:
    """Return the name of the detector class of a module, or None, and the settings of its members as text.

    Raises:
        Refusal: it cannot be imported, has several detectors, or its `VARIANTS` are invalid.
    """
    module = load_module(name, name)
    detectors = [
        value.__name__
        for value in vars(module).values()
        if inspect.isclass(value)
        and value.__module__ == module.__name__
        and callable(getattr(value, "update", None))
        and not inspect.isabstract(value)
    ]
    if len(detectors) > 1:
        raise Refusal(f"{name} has {len(detectors)} detectors ({', '.join(detectors)}): give every family a file of its own")
    variants = variants_of(name, module) if detectors else {}
    return {"class": detectors[0] if detectors else None, "variants": {key: repr(settings) for key, settings in variants.items()}}
