"""`dcrb info`: what is in a recording."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def info(bag: Annotated[Path, typer.Argument(help="Folder of a recording or an .mcap file.")]) -> None:
    """Print the manifest and the contents of a recording."""
    from rich.console import Console
    from rich.table import Table

    from dcrb_ros.configuration import Configuration
    from dcrb_ros.configuration_file import flatten
    from dcrb_ros.recording import Recording

    recording = Recording(bag)
    counts = recording.counts()
    console = Console()
    changed = Table("parameter", "value", title="configuration, where it differs from the default")
    default = flatten(Configuration().model_dump())
    for key, value in flatten(recording.configuration.model_dump()).items():
        if value != default[key]:
            changed.add_row(key, f"{value}")
    contents = Table("topic", "messages", title=str(bag))
    for topic, count in counts.items():
        contents.add_row(topic, str(count))
    manifest = recording.manifest
    console.print(
        f"dcrb_ros {manifest['dcrb_ros']}, seed {manifest['seed']}, {manifest['sampling_rate']} Hz, recorded {manifest['recorded']}"
    )
    console.print(contents)
    console.print(changed)
    if not recording.complete:
        console.print("the recording is cut off; everything up to the damage is counted")
