"""Which signals ask a process to end."""

from __future__ import annotations

import signal

ENDING = tuple(signal.Signals[name] for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
"""Ctrl-C, a CI that cancels, a terminal that is closed."""
