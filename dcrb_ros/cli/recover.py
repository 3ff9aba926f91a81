"""`dcrb recover`: repair of a truncated or damaged recording."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from dcrb_ros.cli.options import Bag, Force
from dcrb_ros.cli.output_file import replacing
from dcrb_ros.text.counts import counted


def recover(
    bag: Bag,
    output: Annotated[Path, typer.Option("-o", "--output", help="New folder of the repaired recording.")],
    force: Force = False,
) -> None:
    """Write the readable part of a truncated or damaged recording to a new, complete one.

    Example: dcrb recover broken_recording -o repaired_recording
    """
    from dcrb_ros.recordings.recovery import recover as recovered
    from dcrb_ros.recordings.recovery import time_text

    with replacing("-o", output, force=force, source=bag):
        salvage = recovered(bag, output)
    for damage in salvage.damage:
        typer.echo(f"dcrb: {damage}", err=True)
    print(f"{output}: {counted(salvage.messages, 'message')}, the last at {time_text(salvage.last_ns)}")
