"""`dcrb recover`: repair of a cut-off or damaged recording."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def recover(
    bag: Annotated[Path, typer.Argument(help="Folder of a recording or an .mcap file.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder of the repaired recording.")],
) -> None:
    """Write what can be read of a damaged recording to a new one that plays and opens like any other."""
    from dcrb_ros.recordings.recovery import recover as recovered

    salvage = recovered(bag, output)
    for words in salvage.damage:
        typer.echo(f"dcrb: {words}", err=True)
    print(f"{output}: {salvage.messages} messages, the last at {salvage.last_ns * 1e-9:.3f} s")
