"""Settings that all tests share."""

from __future__ import annotations

import gc
import signal

from hypothesis import settings

# A shell lets tests in the background ignore Ctrl-C, and the programs that they start would inherit that.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

settings.register_profile("bench", deadline=None, max_examples=60)
settings.load_profile("bench")


def pytest_collection_finish() -> None:
    """Keep the collector from searching all that has been imported again and again."""
    gc.collect()
    gc.freeze()
