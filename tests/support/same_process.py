"""The command line in this process."""

from __future__ import annotations

import pytest

from dcrb_ros.cli.app import main


def dcrb(*arguments: str) -> int:
    """Run the command line in this process and return its exit status."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sys.argv", ["dcrb", *arguments])
        with pytest.raises(SystemExit) as end:
            main()
    return int(end.value.code or 0)
