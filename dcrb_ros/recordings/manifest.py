"""The manifest: two metadata records of a recording, from which it can be understood and reproduced.

The first, at the beginning of each file, describes what is simulated. The second, the outcome, at the end of each file, describes what was
produced; it is missing if the recording was cut off.
"""

from __future__ import annotations

import functools
import hashlib
import importlib.metadata
import json
import math
import platform
import time
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from dcrb_ros.bearing.frequencies import characteristic_orders
from dcrb_ros.messages.description import sensor_text
from dcrb_ros.messages.points import Vibration, decode_vibration
from dcrb_ros.messages.statuses import decode_truth
from dcrb_ros.messages.topics import GROUND_TRUTH, MANIFEST, VIBRATION, Message
from dcrb_ros.recordings.mathematics import function_results
from dcrb_ros.recordings.processor import processor
from dcrb_ros.runtime.version import __version__
from dcrb_ros.schema.parameter_field import first_problem
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.settings.parameters import Bearing
from dcrb_ros.simulation.ground_truth import commands_in
from dcrb_ros.stream.event_text import encode_command
from dcrb_ros.stream.events import TimedCommand
from dcrb_ros.stream.states import BodyNames
from dcrb_ros.text.json import digest_of

if TYPE_CHECKING:
    from dcrb_ros.settings.configuration import Configuration

FORMAT = 2
"""Format of the manifest; the first had no second record."""
OUTCOME = f"{MANIFEST}_outcome"
"""Name of the second record."""
MAX_RECORD = 16 * 1024 * 1024
"""Largest record of the manifest [bytes], some 200000 commands; more commands are only counted there, and read from the ground truth."""
UNITS = {
    "acceleration": "m/s^2",
    "angle": "rad",
    "speed": "rad/s",
    "force": "N",
    "temperature": "deg C",
    "time": "s, simulated, from zero",
}
MEASURED_UNITS = UNITS | {"time": "s, index of the sample over the sampling rate"}
"""Units of imported data and of recordings without a manifest, whose time need not be simulated."""
MODEL = ("bearing", "core", "faults", "measurement", "schema", "settings", "simulation")
"""Packages on whose sources the samples depend."""

DAMAGE = (ValueError, KeyError, TypeError, RecursionError)
"""Exceptions that a damaged manifest may raise."""
SAME_ORDER = 1e-9
"""Relative difference of orders in one manifest that are the same [-]."""
DIGEST = "record_sha256"
"""Entry with the digest of the others."""
TYPES: dict[str, type] = {
    **dict.fromkeys(("units", "software", "processor", "orders", "faults", "imported", "sensor", "configuration"), dict),
    **dict.fromkeys(("format", "first_index", "samples", "sampling_rate"), int),
    **dict.fromkeys(("namespace", "sha256", "dcrb_ros", "model"), str),
}
"""Types of entries of the manifest; a manifest with another type counts as damaged."""


def well_formed(content: Any) -> bool:
    """Return whether the content of a record is an object whose entries have their types and its digest; any other is damaged.

    Records of earlier versions have no digest.
    """
    if not isinstance(content, dict) or not all(isinstance(content.get(name, kind()), kind) for name, kind in TYPES.items()):
        return False
    return content.get(DIGEST) in (None, digest_of(content, DIGEST))


def stated_range(manifest: Mapping[str, Any]) -> float:
    """Return the sensor's range at the start of a recording [m/s^2]; 0 if it is unknown."""
    about = manifest.get("sensor") or manifest.get("configuration", {}).get("sensor")
    sensor_range = about.get("range") if isinstance(about, Mapping) else None
    return float(sensor_range) if isinstance(sensor_range, int | float) and sensor_range > 0.0 else 0.0


def stated_bearing(manifest: Mapping[str, Any], path: Path) -> Bearing:
    """Return the bearing in the configuration of the bench in the recording at a path; the other groups are not read.

    Raises:
        Refusal: this version does not understand the bearing, or the orders in the manifest do not follow from it.
    """
    try:
        bearing = Bearing.model_validate(manifest["configuration"]["bearing"])
        stated = {name: float(order) for name, order in manifest.get("orders", {}).items()}
    except DAMAGE as error:
        raise not_understood(error, manifest, path, "bearing.") from None
    for name, order in characteristic_orders(bearing).as_dict().items():
        if not math.isclose(stated.get(name, order), order, rel_tol=SAME_ORDER):
            raise Refusal(
                f"the manifest of {path} was changed: its {name} is {stated[name]:.6g}, but {order:.6g} follows from its bearing; "
                "get the recording again"
            )
    return bearing


def not_understood(error: Exception, manifest: Mapping[str, Any], path: Path, group: str = "") -> Refusal:
    """Return the refusal of the configuration in the recording at a path."""
    problem = first_problem(error) if isinstance(error, ValidationError) else None
    reason = f"{group}{problem.key}: {problem.reason}" if problem else str(error) or type(error).__name__
    return Refusal(
        f"the configuration in {path} (dcrb_ros {manifest.get('dcrb_ros', 'unknown')}) is damaged or not understood by dcrb_ros "
        f"{__version__} ({reason}): read it with the version that wrote it"
    )


def record_text(entries: Mapping[str, Any]) -> str:
    """Return the text of a record with its digest."""
    about = json.loads(json.dumps(entries, default=str))
    return json.dumps(about | {DIGEST: digest_of(about, DIGEST)})


@functools.cache
def model_fingerprint() -> str:
    """Return a short hash of the model's sources.

    Equal sources produce equal samples with equal software on processors of one kind.
    """
    return _fingerprint(*MODEL)


@functools.cache
def vehicle_fingerprint() -> str:
    """Return a short hash of the sources of the vehicle's model, without those of the bearings."""
    return _fingerprint("vehicle")


def _fingerprint(*folders: str) -> str:
    package, digest = Path(__file__).parents[1], hashlib.sha256()
    for folder in folders:
        for source in sorted((package / folder).rglob("*.py")):
            digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def software() -> dict[str, str]:
    """Return the versions of the software, and the results of its functions, on which the last bits of the samples may depend."""
    versions = {name: importlib.metadata.version(name) for name in ("numpy", "numba", "scipy")}
    machine = f"{platform.system()} {platform.machine()}"
    return {"python": platform.python_version(), **versions, "machine": machine, **function_results()}


def now() -> str:
    """Return the present date and time (UTC)."""
    return time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())


def opening(
    configuration: Configuration, bodies: BodyNames, namespace: str, *, scenario: Mapping[str, Any] | None = None
) -> dict[str, dict[str, str]]:
    """Return the metadata records at the beginning of a recording."""
    orders = characteristic_orders(configuration.bearing)
    about = {
        "format": FORMAT,
        "dcrb_ros": __version__,
        "model": model_fingerprint(),
        "software": software(),
        "processor": processor(),
        "configuration": configuration.model_dump(),
        "scenario": scenario,
        "seed": configuration.simulation.seed,
        "namespace": namespace,
        "bodies": bodies.names,
        "bearing": {**configuration.bearing.model_dump(), "radial_gap": configuration.bearing.radial_gap},
        "orders": orders.as_dict(),
        "faults": configuration.described_faults(),
        "sampling_rate": configuration.sensor.sampling_rate,
        "sensor": json.loads(sensor_text(configuration)),
        "units": UNITS,
        "recorded": now(),
    }
    return {MANIFEST: {"manifest": record_text(about)}}


class Outcome:
    """The outcome of a run so far: hash and range of its samples, and its commands."""

    def __init__(self, rate: int, commands: Iterable[TimedCommand] = ()) -> None:
        """Start without samples, with the sampling ``rate`` [Hz] and the ``commands`` that took effect before."""
        self._rate, self._digest = rate, hashlib.sha256()
        self.first_index: int | None = None
        """Index of the first sample; None without samples."""
        self.samples = 0
        """Number of samples."""
        self.end_index = 0
        """Index after the last sample; blocks before it may be lost in transmission."""
        self.commands = list(commands)

    def add(self, message: Message) -> None:
        """Include a message."""
        if message.topic == VIBRATION:
            self.add_block(decode_vibration(message.data))
        elif message.topic == GROUND_TRUTH:
            self.commands += commands_in([decode_truth(message.data)])

    def add_block(self, block: Vibration) -> None:
        """Include a block of samples."""
        first = block.first_index(self._rate)
        self._digest.update(block.packed())
        self.first_index = first if self.first_index is None else self.first_index
        self.samples += len(block.shaft_angle)
        self.end_index = first + len(block.shaft_angle)

    @property
    def sha256(self) -> str:
        """SHA-256 of ax, ay and shaft angle of every sample as little-endian single-precision numbers, independent of the block size."""
        return self._digest.hexdigest()

    def records(self) -> dict[str, dict[str, str]]:
        """Return the metadata records at the end of a file."""
        about: dict[str, Any] = {
            "first_index": self.first_index or 0,
            "samples": self.samples,
            "end_index": self.end_index,
            "sha256": self.sha256,
            "hashed": "ax, ay, shaft_angle of every sample as little-endian float32",
            "commands": [encode_command(command) for command in self.commands],
            "command_count": len(self.commands),
            "ended": now(),
        }
        text = record_text(about)
        return {OUTCOME: {"outcome": text if len(text) <= MAX_RECORD else record_text(about | {"commands": None})}}
