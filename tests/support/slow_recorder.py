"""A recorder on a slow disk."""

from __future__ import annotations

import threading
from pathlib import Path

from made_up_blocks import BODIES

from dcrb_ros.recordings.recorder import Recorder
from dcrb_ros.settings.configuration import Configuration


class SlowRecorder(Recorder):
    """A recorder that writes once it is allowed to."""

    def __init__(self, path: Path) -> None:
        super().__init__(path, Configuration(), BODIES)
        self.allowed = threading.Event()

    def write_messages(self, messages: object) -> None:
        if hasattr(self, "allowed"):
            self.allowed.wait(60.0)
        super().write_messages(messages)  # type: ignore[arg-type]
