"""The manifest: what makes a recording explain and reproduce itself, as two records of its files.

The first stands at the beginning and says what was simulated; the second stands at the end and says what came of it. Of a
recording that was cut off the second is missing.
"""

from __future__ import annotations

import functools
import hashlib
import importlib.metadata
import json
import platform
import time
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from dcrb_ros import __version__
from dcrb_ros.bearing.kinematics import characteristic_orders
from dcrb_ros.bearing.states import BodyNames
from dcrb_ros.messages.description import sensor_text
from dcrb_ros.messages.event_text import encode_command
from dcrb_ros.messages.points import decode_vibration, decode_waveform, packed
from dcrb_ros.messages.statuses import decode_truth
from dcrb_ros.messages.topics import GROUND_TRUTH, MANIFEST, VIBRATION, Message
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.simulation.events import TimedCommand, commands_in

FORMAT = 2
"""Format of the manifest; the first had no second record."""
OUTCOME = f"{MANIFEST}_outcome"
"""Name of the second record."""
GATHERED = 1 << 20
"""Bytes of blocks that wait before they are read and hashed together."""
LARGEST = 16 * 1024 * 1024
"""Largest record of the manifest [bytes], some 200000 commands; beyond it they are counted, and read from the ground truth."""
UNITS = {"acceleration": "m/s^2", "angle": "rad", "speed": "rad/s", "force": "N", "time": "s, simulated, from zero"}
MODEL = ("bearing", "core", "faults", "measurement", "schema", "settings", "simulation")
"""Folders of the sources on which the samples depend."""


@functools.cache
def model_fingerprint() -> str:
    """Return a short name of the model's sources: equal sources make equal samples on one kind of machine."""
    package, digest = Path(__file__).parents[1], hashlib.sha256()
    for folder in MODEL:
        for source in sorted((package / folder).rglob("*.py")):
            digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def software() -> dict[str, str]:
    """Return what else the last bits of the samples may depend on."""
    versions = {name: importlib.metadata.version(name) for name in ("numpy", "numba", "scipy")}
    return {"python": platform.python_version(), **versions, "machine": f"{platform.system()} {platform.machine()}"}


def now() -> str:
    """Return the wall time, which is kept beside the simulated one."""
    return time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())


def opening(
    configuration: Configuration, bodies: BodyNames, namespace: str, *, scenario: Mapping[str, Any] | None = None
) -> dict[str, dict[str, str]]:
    """Return the records with which a recording of the bench begins."""
    orders = characteristic_orders(configuration.bearing)
    about = {
        "format": FORMAT,
        "dcrb_ros": __version__,
        "model": model_fingerprint(),
        "software": software(),
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
    return {MANIFEST: {"manifest": json.dumps(about)}}


class Outcome:
    """What has come of a run so far: a hash of its samples, and its commands."""

    def __init__(self, rate: int, commands: Iterable[TimedCommand] = ()) -> None:
        """Begin with no sample of a waveform of ``rate`` [Hz]; ``commands`` came before."""
        self._rate, self._digest = rate, hashlib.sha256()
        self._waiting: list[bytes] = []
        self._size = 0
        self._first_index: int | None = None
        self._samples = self._end_index = 0
        self.commands = list(commands)

    def note(self, message: Message) -> None:
        """Take account of a message."""
        if message.topic == VIBRATION:
            self._waiting.append(message.data)
            self._size += len(message.data)
            if self._size > GATHERED:
                self._take()
        elif message.topic == GROUND_TRUTH:
            self.commands += commands_in([decode_truth(message.data)])

    def _take(self) -> None:
        """Take account of the samples that wait: many blocks together are read in a fifth of the time."""
        if not self._waiting:
            return
        waiting, self._waiting, self._size = self._waiting, [], 0
        _, acceleration, angle = decode_waveform(waiting)
        first, last = decode_vibration(waiting[0]), decode_vibration(waiting[-1])
        if self._first_index is None:
            self._first_index = first.first_index(self._rate)
        self._digest.update(packed(acceleration, angle))
        self._samples += len(angle)
        self._end_index = last.first_index(self._rate) + len(last.shaft_angle)

    @property
    def first_index(self) -> int | None:
        """Index of the first sample; none without any."""
        self._take()
        return self._first_index

    @property
    def samples(self) -> int:
        """Count of the samples."""
        self._take()
        return self._samples

    @property
    def end_index(self) -> int:
        """Index after the last sample; blocks before it may be missing where the configuration loses some."""
        self._take()
        return self._end_index

    @property
    def sha256(self) -> str:
        """Hash of ax, ay and shaft angle of every sample, as little-endian single floats; the blocks do not matter."""
        self._take()
        return self._digest.hexdigest()

    def records(self) -> dict[str, dict[str, str]]:
        """Return the records with which a file ends."""
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
        if len(json.dumps(about)) > LARGEST:
            about["commands"] = None
        return {OUTCOME: {"outcome": json.dumps(about)}}
