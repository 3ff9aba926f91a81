"""The program `dcrb`: termination signals are handled before anything else is imported."""

from __future__ import annotations

from dcrb_ros.runtime.linear_algebra import one_thread_each
from dcrb_ros.runtime.memory import collect_rarely, keep_freed_memory
from dcrb_ros.runtime.signals import STOPPED, end_at_once, interrupt, leave


def main() -> None:
    """Run the command line, and exit."""
    end_at_once(STOPPED, "dcrb: stopped")
    one_thread_each()
    keep_freed_memory()
    collect_rarely()
    from dcrb_ros.cli.app import run

    try:
        interrupt()
        status = run()
    except KeyboardInterrupt:  # a second one, while the first is being reported
        status = STOPPED
    leave(status)


if __name__ == "__main__":
    main()
