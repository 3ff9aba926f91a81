"""Signals that ask a process to end."""

from __future__ import annotations

import signal

TERMINATION = tuple(signal.Signals[name] for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
"""Ctrl-C, a cancelled CI job, a closed terminal."""
